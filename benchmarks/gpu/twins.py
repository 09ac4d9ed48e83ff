"""Whether pictures of the GPU are those of the processor."""

import tempfile
from itertools import product
from pathlib import Path

from exr import differences
from record import Task

# What the colours of two full frames may differ by, and what they may in the mean.
MOST, MEAN = 2 / 255, 2e-3
# The least PSNR of the last frame of a clip that a network filled in f16, against f32 on the processor, in dB.
LEAST_DB = 45.0
NETWORKS = {"wnet-fast": "wnet", "wnet-paper": "wnet", "deepfovea-fvn": "deepfovea"}
DENSITIES = [("0.03", "0.02"), ("0.07", "0.06")]
# From inside the volume, and along an axis.
CAMERAS = {"inside": "0.1,0.05,-0.28,0,0,0,70", "axis": "0,0,1.9,0,0,0,35"}


def march(bench):
    """Every pixel marched: shadows, shading, cameras and types of voxels."""
    bench.volumes.begin(bench.scale.compared, bench.scale.sides[0])
    first, *others = bench.scale.compared
    ways = product(("on", "off", "cached"), ("flat", "gradient"))
    scenes = [(first, shadows, shading, "orbit") for shadows, shading in ways]
    scenes += [(first, "on", "flat", camera) for camera in CAMERAS]
    scenes += [(name, "on", "flat", "orbit") for name in others]
    for name, shadows, shading, camera in scenes:
        key = {"what": "march", "volume": name, "shadows": shadows, "shading": shading, "camera": camera}
        yield Task(key, lambda key=key: marched(bench, **key))


def marched(bench, what, volume, shadows, shading, camera):
    """How far one full frame of the GPU is from that of the processor."""
    seen = ["--camera", CAMERAS[camera]] if camera in CAMERAS else ["--path", camera]
    lit = ["--shadows", shadows, "--shading", shading, "--sampling", "full", "--reconstruct", "none"]
    with tempfile.TemporaryDirectory(dir=bench.folder) as folder:
        on_gpu, on_cpu, _ = rendered_twice(bench, folder, volume, bench.scale.sizes[0], *lit, *seen, "--format", "exr")
        largest, mean = differences(on_cpu / "frame_0000.exr", on_gpu / "frame_0000.exr")
    return {"largest": largest, "mean": mean, "held": largest <= MOST and mean <= MEAN}


def masks(bench):
    """Masks and compact lists."""
    for density in DENSITIES:
        key = {"what": "masks", "volume": bench.scale.compared[0], "density": ", ".join(density)}
        yield Task(key, lambda density=density, name=key["volume"]: masked(bench, name, density))


def masked(bench, volume, density, frames=4):
    """Whether masks are the same bytes, lists as long, and what marching lists leaves in sparse frames the same.

    The order of lists is not to be seen here; `crates/fovol-render/tests/gpu_twins.rs` compares it.
    """
    chosen = ["--pb", density[0], "--sigma", density[1], "--gaze", "wander", "--path", "flythrough"]
    kept = ["--frames", frames, "--reconstruct", "none", "--keep", "mask,sparse", "--format", "exr"]
    with tempfile.TemporaryDirectory(dir=bench.folder) as folder:
        on_gpu, on_cpu, reports = rendered_twice(bench, folder, volume, bench.scale.sizes[0], *chosen, *kept)
        names = sorted(path.name for path in on_cpu.glob("mask_*"))
        is_same_mask = all((on_cpu / name).read_bytes() == (on_gpu / name).read_bytes() for name in names)
        sparse = [differences(on_cpu / f"sparse_{i:04}.exr", on_gpu / f"sparse_{i:04}.exr") for i in range(frames)]
    lengths = [[frame["samples"] for frame in report["frames"]] for report in reports]
    is_as_long, largest = lengths[0] == lengths[1], max(largest for largest, _ in sparse)
    is_held = len(names) == frames and is_same_mask and is_as_long and largest <= MOST
    return {
        "masks": len(names),
        "same_masks": is_same_mask,
        "lengths": lengths[0],
        "same_lengths": is_as_long,
        "largest": largest,
        "held": is_held,
    }


def networks(bench):
    """Clips filled by networks with the weights that come with the program."""
    for name, how in NETWORKS.items():
        yield Task({"what": "network", "network": name}, lambda name=name, how=how: filled(bench, name, how), 240.0)


def filled(bench, network, how):
    """The PSNR of every frame of a clip in f16 on the GPU, against f32 on the processor."""
    size, frames = bench.scale.clip
    clip = ["--path", "flythrough", "--frames", frames, "--format", "exr"]
    filling = ["--reconstruct", how, "--weights", network]
    precisions = ["--precision", "f16"], ["--precision", "f32"]
    volume = bench.scale.compared[0]
    with tempfile.TemporaryDirectory(dir=bench.folder) as folder:
        on_gpu, on_cpu, _ = rendered_twice(bench, folder, volume, size, *clip, *filling, own=precisions)
        compared = bench.program.json("metrics", on_cpu, on_gpu)
    each = [float(frame["psnr"]) for frame in compared["frames"]]
    return {"size": size, "last_db": each[-1], "least_db": min(each), "db": each, "held": each[-1] >= LEAST_DB}


def rendered_twice(bench, folder, volume, size, *arguments, own=((), ())):
    """Folders of the same frames of the GPU and of the processor, and both reports; `own` is what only one is told.

    The processor renders as the GPU does: plain steps, no guide, densities that look at nothing.
    """
    same = ["--integration", "plain", "--guide", "none", "--density", "fixed"]
    folders, reports = [], []
    for device, more in zip((bench.device, "cpu"), own):
        folders.append(Path(folder) / ("cpu" if device == "cpu" else "gpu"))
        given = bench.volumes.given(volume, bench.scale.sides[0])
        said = ["render", *given, "--size", size, *same, *arguments, *more, "--device", device, "-o", folders[-1]]
        reports.append(bench.program.json(*said))
    return *folders, reports
