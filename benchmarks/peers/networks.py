#!/usr/bin/env python3
"""Networks at 1280x720: this program against ONNX Runtime, OpenVINO and PyTorch on the exported ONNX, in one run.

    python3 -m venv venv && venv/bin/pip install onnx onnxruntime openvino torch numpy
    cargo build --release
    venv/bin/python benchmarks/peers/networks.py [--network wnet-paper] [--threads 2] [--rounds 3] [-o FILE.json]

All are given the same random weights and the same kind of frame, two threads, and two frames to warm up. The rounds
alternate between the programs. What is not installed is left out. PyTorch runs the modules of
`tests/reference/network/networks.py`. OpenVINO's bf16 is measured where it says that the processor has it. For int8 the
graph is quantised by ONNX Runtime: every convolution, activations by the ranges of one frame, weights for each channel.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/release/fovolnet"
SIZE = (1280, 720)


def padded(multiple):
    return [-(-side // multiple) * multiple for side in SIZE[::-1]]


def inputs_of(shapes, height, width):
    """Random samples, and zero states."""
    random = np.random.default_rng(1)
    feeds = {}
    for name, channels, scale in shapes:
        shape = (1, channels, height // scale, width // scale)
        feeds[name] = np.zeros(shape, np.float32)
        if name == "input":
            feeds[name] = (random.random(shape) * (random.random((1, 1, height, width)) < 0.03)).astype(np.float32)
    return feeds


def onnx_runtime(path, threads):
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    session = onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    facts = session.get_modelmeta().custom_metadata_map
    height, width = padded(int(facts["fovolnet.multiple"]))
    shapes = [(f"state.{s['name']}", s["channels"], s["scale"]) for s in json.loads(facts["fovolnet.states"])]
    given = {i.name: i.shape[1] for i in session.get_inputs()}
    shapes += [(name, given[name], 1) for name in ("input", "motion") if name in given]
    feeds = inputs_of(shapes, height, width)
    return feeds, lambda: session.run(None, feeds)


def quantised(path, folder, feeds):
    """The graph with all convolutions in int8: where it was written."""
    from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static

    class OneFrame(CalibrationDataReader):
        def __init__(self):
            self.frames = [feeds]

        def get_next(self):
            return self.frames.pop() if self.frames else None

    out = str(Path(folder) / "int8.onnx")
    kinds = {"activation_type": QuantType.QUInt8, "weight_type": QuantType.QInt8}
    quantize_static(
        path, out, OneFrame(), quant_format=QuantFormat.QDQ, per_channel=True, op_types_to_quantize=["Conv"], **kinds
    )
    return out


def open_vino(path, threads, feeds, precision):
    import openvino

    core = openvino.Core()
    if precision == "bf16" and "BF16" not in core.get_property("CPU", "OPTIMIZATION_CAPABILITIES"):
        return None
    config = {"INFERENCE_NUM_THREADS": threads, "INFERENCE_PRECISION_HINT": precision, "PERFORMANCE_HINT": "LATENCY"}
    model = core.read_model(path)
    model.reshape({name: list(array.shape) for name, array in feeds.items()})
    compiled = core.compile_model(model, "CPU", config)
    request = compiled.create_infer_request()
    return lambda: request.infer(feeds)


def pytorch(network, threads, feeds):
    sys.path.insert(0, str(ROOT / "tests/reference/network"))
    import networks
    import torch

    torch.set_num_threads(threads)
    module = networks.build(networks.CONFIGS[network], 0).float().eval()
    colour = torch.from_numpy(feeds["input"][:, :3].copy())
    mask = torch.from_numpy((feeds["input"].max(axis=1, keepdims=True) > 0).astype(np.float32))
    motion = torch.zeros(1, 2, *colour.shape[-2:])
    states = module.initial_states(*colour.shape[-2:], torch.float32)

    def run():
        with torch.no_grad():
            module(colour, mask, motion, states)

    return run


def ours(network, threads, precision):
    command = [PROGRAM, "bench", "net", "--random-weights", network, "--threads", str(threads)]
    command += ["--precision", precision, "--repeats", "3", "--json", "-"]
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return report["median_ms"], report


def timed(run):
    started = time.perf_counter()
    run()
    return 1e3 * (time.perf_counter() - started)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--network", default="wnet-paper")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "out/peers/networks.json")
    options = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = str(options.threads)
    times, reports = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "network.onnx")
        subprocess.run([PROGRAM, "export", "--onnx", path, "--random-weights", options.network], check=True)
        feeds, run = onnx_runtime(path, options.threads)
        peers = {"ONNX Runtime f32": run}
        for name, make in {
            "OpenVINO f32": lambda: open_vino(path, options.threads, feeds, "f32"),
            "OpenVINO bf16": lambda: open_vino(path, options.threads, feeds, "bf16"),
            "OpenVINO int8": lambda: open_vino(quantised(path, folder, feeds), options.threads, feeds, "f32"),
            "ONNX Runtime int8": lambda: onnx_runtime(quantised(path, folder, feeds), options.threads)[1],
            "PyTorch f32": lambda: pytorch(options.network, options.threads, feeds),
        }.items():
            try:
                peers[name] = make()
            except ImportError as missing:
                print(f"left out: {name} ({missing})")
        peers = {name: run for name, run in peers.items() if run}
        for run in peers.values():
            run(), run()
        for _ in range(options.rounds):
            for name, run in peers.items():
                times.setdefault(name, []).append(timed(run))
            for precision in ("f32", "bf16", "int8"):
                milliseconds, reports[precision] = ours(options.network, options.threads, precision)
                times.setdefault(f"fovolnet {precision}", []).append(milliseconds)
    medians = {name: statistics.median(values) for name, values in times.items()}
    for name, milliseconds in sorted(medians.items(), key=lambda item: item[1]):
        print(f"{name:<20} {milliseconds:9.1f} ms")
    f32 = min(ms for name, ms in medians.items() if name.endswith("f32") and not name.startswith("fovolnet"))
    ratios = {"f32 of the best f32 peer": medians["fovolnet f32"] / f32}
    for precision in ("bf16", "int8"):
        if f"OpenVINO {precision}" in medians:
            ratio = medians[f"fovolnet {precision}"] / medians[f"OpenVINO {precision}"]
            ratios[f"{precision} of OpenVINO {precision}"] = ratio
    print(ratios)
    machine = {"processor": reports["f32"].get("on"), "peak_tflops": reports["f32"]["peak_tflops"]}
    out = {"network": options.network, "threads": options.threads, "size": SIZE, "date": time.strftime("%Y-%m-%d")}
    out |= {"machine": machine, "median_ms": medians, "all_ms": times, "ratios": ratios}
    options.output.parent.mkdir(parents=True, exist_ok=True)
    options.output.write_text(json.dumps(out, indent=1) + "\n")


if __name__ == "__main__":
    main()
