"""ONNX Runtime on the same GPU, by CUDA and by TensorRT: the exported networks, states and frames staying on the device."""

import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

# What each is told; TensorRT multiplies halves.
PROVIDERS = {
    "cuda": ("CUDAExecutionProvider", {"use_tf32": 1}),
    "tensorrt": ("TensorrtExecutionProvider", {"trt_fp16_enable": True}),
}


def installed():
    """ONNX Runtime and those of PROVIDERS that it has, if it is installed and has any."""
    try:
        import onnxruntime
    except ImportError:
        return None, {}
    available = onnxruntime.get_available_providers()
    return onnxruntime, {way: given for way, given in PROVIDERS.items() if given[0] in available}


def bound(onnxruntime, session, size, device):
    """A binding of random samples and of states that are kept, all on `device`."""
    import numpy as np

    random = np.random.default_rng(1)
    facts = session.get_modelmeta().custom_metadata_map
    multiple = int(facts["fovolnet.multiple"])
    width, height = (-(-side // multiple) * multiple for side in size)
    scales = {f"state.{state['name']}": state["scale"] for state in json.loads(facts["fovolnet.states"])}
    binding = session.io_binding()
    for given in session.get_inputs():
        scale = scales.get(given.name, 1)
        values = np.zeros((1, given.shape[1], height // scale, width // scale), np.float32)
        if given.name == "input":
            sampled = random.random((1, 1, height, width)) < 0.03
            values = (random.random(values.shape) * sampled).astype(np.float32)
        binding.bind_ortvalue_input(given.name, onnxruntime.OrtValue.ortvalue_from_numpy(values, device, 0))
    for made in session.get_outputs():
        binding.bind_output(made.name, device)
    return binding


def median_ms(onnxruntime, path, provider, size, device="cuda", repeats=30, warm_up=10):
    """The median time of a frame of the network in `path`."""
    session = onnxruntime.InferenceSession(str(path), providers=[provider])
    if session.get_providers()[0] != provider[0]:
        raise RuntimeError(f"{provider[0]} could not be started")
    binding = bound(onnxruntime, session, size, device)
    times = []
    for number in range(warm_up + repeats):
        begin = time.perf_counter()
        session.run_with_iobinding(binding)
        binding.synchronize_outputs()
        if number >= warm_up:
            times.append(1e3 * (time.perf_counter() - begin))
    return statistics.median(times)


def network(program, name, size):
    """Median times of a frame of network `name`, by the way that it runs; nothing where nothing is installed."""
    onnxruntime, ways = installed()
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "network.onnx"
        if ways:
            subprocess.run([program, "export", "--random-weights", name, "--onnx", path], check=True, capture_output=True)
        for way, provider in ways.items():
            try:
                found[way] = median_ms(onnxruntime, path, provider, size)
            except Exception as error:  # What a provider cannot do is a result too.
                found[way] = None
                found[f"{way}_error"] = str(error).splitlines()[0][:200]
    return found
