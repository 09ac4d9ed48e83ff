#!/usr/bin/env python3
"""Compares exported ONNX files with the reference clips, in ONNX Runtime.

    pip install onnx onnxruntime numpy safetensors
    python check_onnx.py [CASE.safetensors ...] [--exporter "COMMAND"] [--size WxH]

Cases are the clips of make_cases.py; without arguments those of crates/fovol-net/tests/reference are taken. Every named
network is also exported, checked against the ONNX specification, and run for shapes and finite numbers.
"""

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from safetensors import safe_open

ROOT = Path(__file__).resolve().parents[3]
CASES = ROOT / "crates/fovol-net/tests/reference"
EXPORTER = "cargo run --quiet --release -p fovol-net --example export_onnx --"
NETWORKS = ["wnet-paper", "wnet-narrow", "wnet-fast", "deepfovea-fvn", "deepfovea-orig"]
# Of the largest magnitude.
TOLERANCE = 1e-4


class Network:
    """An exported network and what it carries from frame to frame."""

    def __init__(self, path):
        options = onnxruntime.SessionOptions()
        options.log_severity_level = 3
        self.session = onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
        properties = self.session.get_modelmeta().custom_metadata_map
        self.multiple = int(properties["fovolnet.multiple"])
        self.kept = json.loads(properties["fovolnet.states"])
        self.inputs = {value.name: value.shape for value in self.session.get_inputs()}
        self.outputs = [value.name for value in self.session.get_outputs()]
        self.states = None

    def frame(self, colour, mask, motion):
        """The picture [3, rows, columns] of a frame; the next one continues its clip."""
        rows, columns = colour.shape[-2:]
        colour, mask, motion = (self.padded(image) for image in (colour, mask, motion))
        if self.states is None:
            self.states = self.zeros(*colour.shape[-2:])
        wants_mask = self.inputs["input"][1] == 4
        feeds = {"input": np.concatenate([colour, mask], axis=1) if wants_mask else colour, **self.states}
        if "motion" in self.inputs:
            feeds["motion"] = motion
        results = dict(zip(self.outputs, self.session.run(self.outputs, feeds)))
        before = self.states
        self.states = {f"state.{state['name']}": results[f"next.{state['name']}"] for state in self.kept}
        assert all(self.states[name].shape == before[name].shape for name in before), "a state changed its shape"
        assert all(np.isfinite(result).all() for result in results.values()), "numbers that are not finite"
        assert results["output"].shape == colour.shape
        return results["output"][0, :, :rows, :columns]

    def padded(self, image):
        """`image` with a batch axis, replicated at right and bottom to the network's multiple."""
        rows, columns = image.shape[-2:]
        widths = [(0, 0), (0, -rows % self.multiple), (0, -columns % self.multiple)]
        return np.pad(image.astype(np.float32), widths, mode="edge")[None]

    def zeros(self, rows, columns):
        """The states that start a clip."""
        return {
            f"state.{state['name']}": np.zeros(
                (1, state["channels"], rows // state["scale"], columns // state["scale"]), np.float32
            )
            for state in self.kept
        }


def export(exporter, network, seed, folder):
    """Exports and checks a network; the path of its file."""
    path = str(Path(folder) / "network.onnx")
    subprocess.run([*shlex.split(exporter), network, str(seed), path], check=True, cwd=ROOT)
    onnx.checker.check_model(path, full_check=True)
    return path


def check_case(exporter, path):
    """The largest errors of a case's pictures and of its last states, relative to their largest magnitudes."""
    with safe_open(path, framework="numpy") as file:
        facts, arrays = file.metadata(), {name: file.get_tensor(name) for name in file.keys()}
    pictures = 0.0
    with tempfile.TemporaryDirectory() as folder:
        network = Network(export(exporter, facts["config"], facts["seed"], folder))
        for t in range(sum(name.startswith("input.") for name in arrays)):
            colour = arrays[f"input.{t}"]
            motion = arrays.get(f"motion.{t}", np.zeros((2, *colour.shape[1:])))
            picture = network.frame(colour, arrays[f"mask.{t}"], motion)
            pictures = max(pictures, relative_error(picture, arrays[f"output.{t}"]))
    states = [state_error(state[0], name, arrays) for name, state in network.states.items()]
    return pictures, max(states)


def state_error(state, name, arrays):
    """The error of a state `state.NAME` where the case has it or samples of it."""
    if name in arrays:
        return relative_error(state, arrays[name])
    samples = state.flatten()[:: max(1, state.size // 64)][:64]
    return relative_error(samples, arrays[name.replace("state.", "state_samples.", 1)])


def is_clip(path):
    """Whether a file is a clip; others are single layers or weights."""
    with safe_open(path, framework="numpy") as file:
        return "input.0" in file.keys()


def relative_error(actual, expected):
    """The largest difference over the largest magnitude."""
    return float(np.abs(actual - expected).max() / max(np.abs(expected).max(), 1e-30))


def smoke(exporter, name, columns, rows):
    """Runs a named network on noise: shapes, finite numbers, and the time of the last frame in ms."""
    random = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        network = Network(export(exporter, name, 1, folder))
        for _ in range(3):
            mask = (random.random((1, rows, columns)) < 0.1).astype(np.float32)
            colour = random.random((3, rows, columns), np.float32) * mask
            motion = random.normal(0, 3, (2, rows, columns))
            started = time.perf_counter()
            picture = network.frame(colour, mask, motion)
        assert picture.min() >= 0 and picture.max() <= 1 and picture.std() > 0, "no picture"
        return 1000 * (time.perf_counter() - started)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", type=Path)
    parser.add_argument("--exporter", default=EXPORTER, help="command that takes NETWORK SEED OUT.onnx")
    parser.add_argument("--size", default="200x120", help="of the frames that every named network is run on")
    arguments = parser.parse_args()
    failed = 0
    for name in NETWORKS:
        milliseconds = smoke(arguments.exporter, name, *map(int, arguments.size.split("x")))
        print(f"{name}: valid, runs, {milliseconds:.0f} ms a frame of {arguments.size}")
    cases = arguments.cases or list(filter(is_clip, sorted(CASES.glob("*.safetensors"))))
    if not cases:
        print(f"no cases in {CASES}")
    for case in cases:
        pictures, states = check_case(arguments.exporter, case)
        is_same = max(pictures, states) <= TOLERANCE
        failed += not is_same
        verdict = "ok" if is_same else "DIFFERS"
        print(f"{case.name}: {verdict}, relative error of pictures {pictures:.1e}, of states {states:.1e}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
