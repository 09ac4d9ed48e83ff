"""PyTorch on the same GPU: the ceilings of the device, and the networks in eager mode, compiled and as CUDA graphs."""

import statistics
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/reference/network"))


def cuda():
    """PyTorch, if there is one that sees a GPU."""
    try:
        import torch
    except ImportError:
        return None
    return torch if torch.cuda.is_available() else None


def median_ms(torch, work, repeats=30, warm_up=10):
    """The median time of `work` on the device."""
    for _ in range(warm_up):
        work()
    times = []
    for _ in range(repeats):
        begin, end = (torch.cuda.Event(enable_timing=True) for _ in range(2))
        begin.record()
        work()
        end.record()
        end.synchronize()
        times.append(begin.elapsed_time(end))
    return statistics.median(times)


def ceilings(torch):
    """How fast memory is copied, and how fast halves are multiplied."""
    a = torch.empty(1 << 28, dtype=torch.float32, device="cuda")
    b = torch.empty_like(a)
    copied = median_ms(torch, lambda: b.copy_(a))
    side = 8192
    x, y = (torch.randn(side, side, dtype=torch.float16, device="cuda") for _ in range(2))
    multiplied = median_ms(torch, lambda: x @ y)
    return {
        "device": torch.cuda.get_device_name(),
        "copy_gb_per_s": 2 * a.numel() * 4 / copied / 1e6,
        "f16_matmul_tflops": 2 * side**3 / multiplied / 1e9,
    }


def network(torch, name, size):
    """Median times of a frame of network `name`, by the way that it runs."""
    import networks

    torch.backends.cudnn.benchmark = True
    module = networks.build(networks.CONFIGS[name], 1).half().cuda().to(memory_format=torch.channels_last)
    width, height = size
    height, width = (side + -side % module.multiple for side in (height, width))

    def lasting(tensor):
        return tensor.half().cuda().contiguous(memory_format=torch.channels_last)

    states = {k: lasting(v) for k, v in module.initial_states(height, width, torch.float32).items()}
    mask = (torch.rand(1, 1, height, width) < 0.03).float()
    frame = [lasting(t) for t in (torch.rand(1, 3, height, width) * mask, mask, torch.zeros(1, 2, height, width))]

    def run(step):
        with torch.inference_mode():
            return step(*frame, states)

    found = {"eager": median_ms(torch, lambda: run(module))}
    for way, mode in [("compiled", None), ("cuda_graphs", "reduce-overhead")]:
        try:
            compiled = torch.compile(module, mode=mode)
            found[way] = median_ms(torch, lambda: run(compiled))
        except Exception as error:  # What a compiler cannot do is a result too.
            found[way] = None
            found[f"{way}_error"] = str(error).splitlines()[0][:200]
    return found
