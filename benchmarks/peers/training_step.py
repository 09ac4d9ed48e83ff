#!/usr/bin/env python3
"""A step of training: fovolnet-train against Python's torch on the same network, in one run.

    . training/environment
    (cd training && cargo build --release)
    python benchmarks/peers/training_step.py [--network wnet-fast] [--clip 16] [--size 256] [--threads 2] [-o FILE.json]

A step is forward through one clip of frames with the state carried along, L1 in the mean over frames, backward through
all of it, and the optimiser. Both compute in f32 with the same libtorch. Python runs the modules of
`tests/reference/network/networks.py` and `torch.optim.RAdam`, which does nearly what our optimiser does. Rounds
alternate; each measures one step after one to warm up. Beside them stand our ways that Python's modules do not have.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import torch

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/reference/network"))
import networks  # noqa: E402

WAYS = {
    "fovolnet-train f32": [],
    "fovolnet-train f32 channels last": ["--channels-last"],
    "fovolnet-train bf16": ["--bf16"],
    "fovolnet-train bf16 channels last": ["--bf16", "--channels-last"],
}


def program():
    folder = os.environ.get("CARGO_TARGET_DIR", ROOT / "training/target")
    return Path(folder) / "release/fovolnet-train"


def ours(options, way):
    """Seconds of one step."""
    command = [program(), "bench-step", "--network", options.network, "--clip", str(options.clip)]
    command += ["--size", str(options.size), "--threads", str(options.threads), *way]
    report = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return json.loads(report)["seconds"][0]


def pytorch(options):
    """A function that takes one step."""
    torch.set_num_threads(options.threads)
    network = networks.build(networks.CONFIGS[options.network], 1).train().requires_grad_(True)
    optimiser = torch.optim.RAdam(network.parameters(), lr=1e-3, weight_decay=1e-2, decoupled_weight_decay=True)
    edge = options.size
    clip = []
    for _ in range(options.clip):
        target, mask = torch.rand(1, 3, edge, edge), (torch.rand(1, 1, edge, edge) < 0.05).float()
        clip.append((target * mask, mask, (torch.rand(1, 2, edge, edge) - 0.5) * 4, target))

    def step():
        states = network.initial_states(edge, edge, torch.float32)
        losses = []
        for colour, mask, motion, target in clip:
            picture, states = network(colour, mask, motion, states)
            losses.append((picture - target).abs().mean())
        optimiser.zero_grad(set_to_none=False)
        torch.stack(losses).mean().backward()
        optimiser.step()

    return step


def timed(run):
    started = time.perf_counter()
    run()
    return time.perf_counter() - started


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--network", default="wnet-fast", choices=networks.CONFIGS)
    parser.add_argument("--clip", type=int, default=16)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = str(options.threads)
    step = pytorch(options)
    seconds = {}
    for _ in range(options.rounds):
        step()
        seconds.setdefault("Python's torch f32", []).append(timed(step))
        for name, way in WAYS.items():
            seconds.setdefault(name, []).append(ours(options, way))
    medians = {name: statistics.median(values) for name, values in seconds.items()}
    # Where others use the machine as well, the best says more than the median.
    best = {name: min(values) for name, values in seconds.items()}
    for name, values in seconds.items():
        all_of_them = " ".join(f"{s:.2f}" for s in values)
        print(f"{name:<36} median {medians[name]:6.2f} s   best {best[name]:6.2f} s   {all_of_them}")
    print(f"{'load of the machine':<36} {os.getloadavg()[0]:7.2f}")
    facts = {name: getattr(options, name) for name in ("network", "clip", "size", "threads")}
    out = facts | {"date": time.strftime("%Y-%m-%d"), "torch": torch.__version__}
    out |= {"processors": os.cpu_count(), "load": os.getloadavg()[0], "median_s": medians, "best_s": best, "all_s": seconds}
    if options.output:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        options.output.write_text(json.dumps(out, indent=1) + "\n")


if __name__ == "__main__":
    main()
