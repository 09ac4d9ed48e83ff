"""Other programs on the same GPU, each in a process of its own that ends when its time is over."""

import json
import sys
import tempfile
from pathlib import Path

from program import output_of
from record import Task
from timings import FOREMOST, NETWORKS

HERE = Path(__file__).resolve().parent
# What is to be known when times are compared.
NOTES = {"wnet-fast": "pictures, points and their sums are f16 in PyTorch, f32 in this program"}


def ceilings(bench):
    """What the device can do at best."""
    yield Task({"what": "by PyTorch"}, lambda: ceilings_of(bench))


def ceilings_of(bench):
    """How fast memory is copied and halves are multiplied, or why that is not known."""
    lines, problem = answers(bench, "torch_peer.py", "ceilings")
    if problem:
        raise problem
    found = {name: value for line in lines for name, value in line.items()}
    if "error" in found:
        raise RuntimeError(found["error"])
    # What is left is of one of the lines only.
    return {name: value for name, value in found.items() if name not in ("way", "median_ms", "repeats")}


def foremost(bench):
    """PyTorch with the networks of which most is promised."""
    for name in FOREMOST:
        yield torch_task(bench, name, bench.scale.sizes[0], "PyTorch", 180.0)


def rest(bench):
    """ONNX Runtime, PyTorch with all networks, then compiled with more patience, and larger frames."""
    first, *larger = bench.scale.sizes
    for name in NETWORKS:
        yield onnx_task(bench, name, first)
    for name in NETWORKS:
        yield torch_task(bench, name, first, "PyTorch", 180.0)
    for size in larger:
        for name in FOREMOST:
            yield torch_task(bench, name, size, "PyTorch", 180.0)
    for name in FOREMOST:
        yield torch_task(bench, name, first, "PyTorch, tuned", 240.0)


def torch_task(bench, network, size, peer, limit):
    """The row of a network in PyTorch."""
    key = {"network": network, "size": size, "peer": peer}
    more = ["--tuned"] if peer.endswith("tuned") else []
    return Task(key, lambda: torch_of(bench, network, size, more), limit)


def torch_of(bench, network, size, more):
    """Its times by the way that it runs."""
    missing = torch_missing(bench)
    if missing:
        return {"missing": missing}
    return ways_of(bench, network, *answers(bench, "torch_peer.py", network, "--size", size, *more))


def torch_missing(bench):
    """Why PyTorch cannot be measured, if that is known."""
    rows = bench.record.rows("ceilings")
    return rows[0]["found"].get("missing") if rows else None


def onnx_task(bench, network, size):
    """The row of a network in ONNX Runtime."""
    key = {"network": network, "size": size, "peer": "ONNX Runtime"}
    return Task(key, lambda: onnx_of(bench, network, size))


def onnx_of(bench, network, size):
    """Its times by the way that it runs."""
    with tempfile.TemporaryDirectory(dir=bench.folder) as folder:
        path = Path(folder) / "network.onnx"
        bench.program.does("export", "--random-weights", network, "--onnx", path)
        return ways_of(bench, network, *answers(bench, "onnx_peer.py", path, "--size", size))


def ways_of(bench, network, lines, problem):
    """Times by way, the best of them, and what could not be done."""
    missing = [line["missing"] for line in lines if "missing" in line]
    if missing:
        return {"missing": missing[0]}
    ways = {line["way"]: line["median_ms"] for line in lines if "median_ms" in line}
    if problem and not ways:
        raise problem
    errors = {line["way"]: line["error"] for line in lines if "error" in line}
    best = min(ways, key=ways.get) if ways else None
    found = {"best": best, "best_ms": ways.get(best), "ways_ms": ways, "errors": errors}
    if problem:
        found |= {"unfinished": str(problem)}
    return found | ({"note": NOTES[network]} if network in NOTES else {})


def answers(bench, script, *arguments):
    """The lines that a peer prints, and why it did not end well, if so."""
    common = ["--device", bench.peers_on, "--seconds", bench.scale.peer_seconds]
    output, problem = output_of([sys.executable, HERE / script, *arguments, *common], bench.record.left())
    lines = [json.loads(line) for line in output.splitlines() if line.startswith("{") and line.endswith("}")]
    return lines, problem
