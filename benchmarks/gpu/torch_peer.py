#!/usr/bin/env python3
"""PyTorch on the same GPU: what the device can do at best, and the networks in f16, channels last.

    python3 torch_peer.py ceilings [--device cuda] [--seconds 0.5]
    python3 torch_peer.py NETWORK --size 1280x720 [--tuned] [--device cuda] [--seconds 0.5]

Prints a line of JSON for each thing measured as soon as it is, so that nothing is lost if there is no time for the
rest. Networks run eagerly, compiled, and both as recorded CUDA graphs; with `--tuned` compiled with kernels chosen by
trial. Their frames, as those of `fovolnet bench net`, do not move; their states are those after a few frames.
"""

import argparse
import functools
import json
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/reference/network"))

# Frames before the measured ones whose states these continue.
FRAMES_BEFORE = 3
LEAST_REPEATS = 3


def say(**what):
    """One line of what is known."""
    print(json.dumps(what), flush=True)


def guarded(way, measure):
    """Says what `measure` finds, or why it does not: what a compiler cannot do is a result too."""
    try:
        say(way=way, **measure())
    except Exception as error:
        say(way=way, error=f"{type(error).__name__}: {error}"[:400])


class Timer:
    """Times work on a device for some seconds, after half as many to warm up."""

    def __init__(self, torch, device, seconds):
        self.torch, self.device, self.seconds = torch, device, seconds

    def median_ms(self, work):
        """The median time of `work`, by the clock of the device if it is a GPU."""
        once = self._once_on_gpu if self.device == "cuda" else self._once_on_cpu
        self._again(once, work, self.seconds / 2)
        times = self._again(once, work, self.seconds)
        return {"median_ms": statistics.median(times), "repeats": len(times)}

    @staticmethod
    def _again(once, work, seconds):
        end, times = time.monotonic() + seconds, []
        while time.monotonic() < end or len(times) < LEAST_REPEATS:
            times.append(once(work))
        return times

    def _once_on_gpu(self, work):
        begin, end = (self.torch.cuda.Event(enable_timing=True) for _ in range(2))
        begin.record()
        work()
        end.record()
        end.synchronize()
        return begin.elapsed_time(end)

    @staticmethod
    def _once_on_cpu(work):
        begin = time.perf_counter()
        work()
        return 1e3 * (time.perf_counter() - begin)


def copied(torch, timer):
    """How fast memory is copied, counting what is read and what is written."""
    numbers = 1 << (28 if timer.device == "cuda" else 22)
    a = torch.rand(numbers, device=timer.device)
    b = torch.empty_like(a)
    found = timer.median_ms(lambda: b.copy_(a))
    return {"copy_gb_per_s": 2 * a.nbytes / found["median_ms"] / 1e6} | found


def multiplied(torch, timer):
    """How fast halves are multiplied."""
    side = 8192 if timer.device == "cuda" else 256
    x, y = (torch.randn(side, side, dtype=torch.float16, device=timer.device) for _ in range(2))
    found = timer.median_ms(lambda: x @ y)
    return {"f16_product_tflops": 2 * side**3 / found["median_ms"] / 1e9} | found


class Peer:
    """A network in f16 on a device, with a frame and states that it goes on from."""

    def __init__(self, torch, name, size, device):
        import networks

        lasting = {"dtype": torch.float16, "device": device, "memory_format": torch.channels_last}
        self.torch = torch
        self.module = networks.build(networks.CONFIGS[name], 1).to(**lasting)
        width, height = (side + -side % self.module.multiple for side in size)
        mask = (torch.rand(1, 1, height, width) < 0.03).float()
        frame = torch.rand(1, 3, height, width) * mask, mask, torch.zeros(1, 2, height, width)
        self.frame = [tensor.to(**lasting) for tensor in frame]
        self.states = self.module.initial_states(height, width, torch.float16, device)
        for _ in range(FRAMES_BEFORE):
            _, self.states = self.module(*self.frame, self.states)
        self.states = {name: state.to(**lasting) for name, state in self.states.items()}

    @functools.cached_property
    def compiled(self):
        """The network as `torch.compile` makes it."""
        return self.torch.compile(self.module, dynamic=False)

    def runs(self, network):
        """A call of `network`."""
        return lambda: network(*self.frame, self.states)

    def recorded(self, network):
        """The replay of a call as a CUDA graph."""
        cuda, run = self.torch.cuda, self.runs(network)
        stream = cuda.Stream()
        stream.wait_stream(cuda.current_stream())
        with cuda.stream(stream):
            for _ in range(FRAMES_BEFORE):
                run()
        cuda.current_stream().wait_stream(stream)
        graph = cuda.CUDAGraph()
        with cuda.graph(graph):
            run()
        return graph.replay

    def ways(self, device, tuned):
        """Ways to run it, by name; what prepares one begins when it is called."""
        if tuned:
            ways = {"tuned": lambda: self.torch.compile(self.module, dynamic=False, mode="max-autotune-no-cudagraphs")}
        else:
            ways = {"eager": lambda: self.module, "compiled": lambda: self.compiled}
        for name, network in ways.items():
            yield name, lambda network=network: self.runs(network())
            if device == "cuda":
                yield f"{name} as CUDA graph", lambda network=network: self.recorded(network())


def measure(torch, given):
    """Measures what was asked for."""
    timer = Timer(torch, given.device, given.seconds)
    if given.what == "ceilings":
        name = torch.cuda.get_device_name() if given.device == "cuda" else given.device
        say(way="device", torch=torch.__version__, device=name)
        guarded("copy", lambda: copied(torch, timer))
        guarded("product", lambda: multiplied(torch, timer))
        return
    torch.backends.cudnn.benchmark = True
    peer = Peer(torch, given.what, tuple(map(int, given.size.split("x"))), given.device)
    for way, prepare in peer.ways(given.device, given.tuned):
        guarded(way, lambda prepare=prepare: timer.median_ms(prepare()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", help="ceilings, or the name of a network")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--device", choices=["cuda", "cpu"], default="cuda")
    parser.add_argument("--seconds", type=float, default=0.5, help="of each measurement")
    parser.add_argument("--tuned", action="store_true")
    given = parser.parse_args()
    try:
        import torch
    except ImportError:
        return say(missing="no torch")
    if given.device == "cuda" and not torch.cuda.is_available():
        return say(missing="torch sees no GPU")
    with torch.no_grad():
        measure(torch, given)


if __name__ == "__main__":
    main()
