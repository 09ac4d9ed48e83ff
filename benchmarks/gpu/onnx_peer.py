#!/usr/bin/env python3
"""ONNX Runtime on the same GPU, by CUDA and by TensorRT: an exported network, frame and states staying on the device.

    python3 onnx_peer.py NETWORK.onnx --size 1280x720 [--device cuda] [--seconds 0.5]

Prints a line of JSON for each way. Graphs are turned into f16 where a converter is installed (`onnxconverter_common`,
or the one that comes with ONNX Runtime); those in f32 CUDA multiplies in TF32, and TensorRT in halves where it likes.
"""

import argparse
import functools
import json
import statistics
import sys
import time
from pathlib import Path

from torch_peer import LEAST_REPEATS, guarded, say

# What each is told.
PROVIDERS = {
    "cuda": {
        "CUDA": ("CUDAExecutionProvider", {"use_tf32": 1}),
        "TensorRT": ("TensorrtExecutionProvider", {"trt_fp16_enable": True}),
    },
    "cpu": {"CPU": ("CPUExecutionProvider", {})},
}
ELEMENTS = {"tensor(float)": "float32", "tensor(float16)": "float16"}


def converter():
    """What turns graphs into f16."""
    try:
        from onnxconverter_common.float16 import convert_float_to_float16
    except ImportError:
        from onnxruntime.transformers.float16 import convert_float_to_float16
    return convert_float_to_float16


def in_halves(path):
    """The graph of `path` in f16, beside it."""
    import onnx

    halves = path.with_suffix(".f16.onnx")
    onnx.save(converter()(onnx.load(path), keep_io_types=False), halves)
    return halves


def bound(onnxruntime, session, size, device):
    """A binding of random samples and states, and of outputs, all on `device`."""
    import numpy as np

    random = np.random.default_rng(1)
    facts = session.get_modelmeta().custom_metadata_map
    multiple = int(facts["fovolnet.multiple"])
    width, height = (-(-side // multiple) * multiple for side in size)
    scales = {f"state.{state['name']}": state["scale"] for state in json.loads(facts["fovolnet.states"])}
    binding = session.io_binding()
    for given in session.get_inputs():
        scale = scales.get(given.name, 1)
        values = random.random((1, given.shape[1], height // scale, width // scale))
        if given.name == "input":
            values *= random.random((1, 1, height, width)) < 0.03
        elif given.name == "motion":
            values *= 0
        values = np.ascontiguousarray(values, ELEMENTS[given.type])
        binding.bind_ortvalue_input(given.name, onnxruntime.OrtValue.ortvalue_from_numpy(values, device, 0))
    for made in session.get_outputs():
        binding.bind_output(made.name, device)
    return binding


def median_ms(onnxruntime, path, provider, given):
    """The median time of a frame of the network in `path`, by the clock of the host."""
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(str(path), options, providers=[provider])
    if session.get_providers()[0] != provider[0]:
        raise RuntimeError(f"{provider[0]} could not be started")
    binding = bound(onnxruntime, session, tuple(map(int, given.size.split("x"))), given.device)
    times = []
    while sum(times) < given.seconds or len(times) < 2 * LEAST_REPEATS:
        begin = time.perf_counter()
        session.run_with_iobinding(binding)
        binding.synchronize_outputs()
        times.append(time.perf_counter() - begin)
    # The first half was to warm up.
    times = times[len(times) // 2 :]
    return {"median_ms": 1e3 * statistics.median(times), "repeats": len(times)}


def measure(onnxruntime, ways, given):
    """Says what each way takes, in f16 and in f32."""
    graphs = {"f32, TF32 where it can": given.path}
    try:
        graphs = {"f16": in_halves(given.path)} | graphs
    except Exception as error:
        say(way="f16", error=f"the graph was not turned into f16: {type(error).__name__}: {error}"[:400])
    for way, provider in ways.items():
        for graph, path in graphs.items():
            frame = functools.partial(median_ms, onnxruntime, path, provider, given)
            guarded(f"{way}, {graph}", frame)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--device", choices=list(PROVIDERS), default="cuda")
    parser.add_argument("--seconds", type=float, default=0.5, help="of each measurement")
    given = parser.parse_args()
    try:
        import onnxruntime
    except ImportError:
        return say(missing="no ONNX Runtime")
    available = onnxruntime.get_available_providers()
    ways = {way: provider for way, provider in PROVIDERS[given.device].items() if provider[0] in available}
    if not ways:
        return say(missing=f"ONNX Runtime without a GPU: it has {', '.join(available)}")
    measure(onnxruntime, ways, given)


if __name__ == "__main__":
    sys.exit(main())
