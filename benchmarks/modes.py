#!/usr/bin/env python3
"""Quality of sparse frames in every mode, of label maps, several volumes and coloured voxels: PSNR against full frames.

    python3 -m venv venv && venv/bin/pip install numpy==2.4.6
    venv/bin/python benchmarks/modes.py --program target/release/fovolnet --data DIR [--only labels]

DIR has published volumes, NAME_XxYxZ_TYPE.raw.gz. Label maps, second volumes and colours are made from them. Each figure is the mean
of 8 frames of 640x360 that turn by 10 degrees, P_b 0.03, sigma 0.02, against full frames of the same kind.
"""

import argparse
import gzip
import json
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

VOLUMES = ["heart", "aneurism", "lung_ct", "tooth", "engine"]
WAYS = {
    "wnet-fast, light ratio": ["--reconstruct", "wnet", "--guide", "quarter"],
    "wnet-fast, colours": ["--reconstruct", "wnet", "--guide", "none"],
    "linear": ["--reconstruct", "linear"],
    "pull-push": ["--reconstruct", "pull-push"],
}
VIEW = ["--size", "640x360", "--frames", "8", "--path", "turntable", "--turn", "10"]
SPARSE = ["--sampling", "compact", "--pb", "0.03", "--sigma", "0.02", "--keep", "frame,reference"]


def nrrd(path, values, kinds=""):
    """Writes `values`, [z, y, x] or [z, y, x, component], as NRRD."""
    types = {"uint8": "uint8", "int16": "int16", "float32": "float"}
    sizes = " ".join(str(n) for n in values.shape[::-1])
    head = f"NRRD0004\ntype: {types[str(values.dtype)]}\ndimension: {values.ndim}\nsizes: {sizes}\n"
    path.write_bytes((head + kinds + "endian: little\nencoding: raw\n\n").encode() + values.tobytes())
    return str(path)


def published(data, name):
    file = next(data.glob(f"{name}_*.raw.gz"))
    x, y, z, kind = re.search(r"_(\d+)x(\d+)x(\d+)_(\w+)\.", file.name).groups()
    dtype = {"uint8": "u1", "int16": "<i2", "uint16": "<u2", "float32": "<f4"}[kind]
    voxels = np.frombuffer(gzip.decompress(file.read_bytes()), dtype).reshape(int(z), int(y), int(x))
    return file, voxels


def unit(voxels):
    low, high = np.percentile(voxels, [1, 99.9])
    return np.clip((voxels - low) / max(high - low, 1e-6), 0.0, 1.0).astype(np.float32)


def labels(voxels):
    """Five labels by value, as a segmentation by thresholds has them."""
    return np.digitize(unit(voxels), [0.2, 0.35, 0.5, 0.65, 0.8]).astype(np.uint8)


def blobs(voxels):
    """A second volume: smooth spots where the first has its upper values, as of a tracer."""
    rng = np.random.default_rng(1)
    inside = np.argwhere(unit(voxels) > 0.4)
    sum_ = np.zeros(voxels.shape, np.float32)
    grid = np.meshgrid(*(np.arange(n, dtype=np.float32) for n in voxels.shape), indexing="ij", sparse=True)
    for centre in inside[rng.integers(0, len(inside), 8)]:
        away = sum((axis - at) ** 2 for axis, at in zip(grid, centre))
        sum_ += np.exp(-away / (2.0 * (0.06 * max(voxels.shape)) ** 2))
    return sum_


def colours(voxels):
    """Values in colours that change with the place."""
    value = unit(voxels)
    shares = [np.linspace(0.3, 1.0, n, dtype=np.float32) for n in voxels.shape]
    red, green, blue = (
        value * shares[0][:, None, None],
        value * shares[1][None, :, None],
        value * shares[2][None, None, ::-1],
    )
    return (np.stack([red, green, blue], axis=-1) * 255).astype(np.uint8)


def subjects(data, folder):
    """Kinds of pictures: name, volume and flags."""
    for name in VOLUMES:
        file, voxels = published(data, name)
        for mode, flags in (
            ("mip", []),
            ("minip", ["--tf", "grey"]),
            ("average", ["--tf", "grey"]),
            ("isosurface", []),
        ):
            yield mode, name, str(file), ["--mode", mode, *flags]
        seg = nrrd(folder / f"{name}.seg.nrrd", labels(voxels))
        yield "labels", name, seg, []
        overlay = nrrd(folder / f"{name}_tracer.nrrd", blobs(voxels))
        plain = nrrd(folder / f"{name}.nrrd", np.ascontiguousarray(unit(voxels)))
        yield "two volumes", name, plain, ["--overlay", f"{overlay}@inferno", "--tf", "grey"]
        kinds = "kinds: RGB-color domain domain domain\n"
        yield "colours", name, nrrd(folder / f"{name}_rgb.nrrd", colours(voxels), kinds), []


def psnr(program, volume, flags, folder):
    out = folder / "out.json"
    command = [program, "render", volume, "-o", str(folder / "frames"), *VIEW, *SPARSE, *flags, "--json", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return None, done.stderr.strip().splitlines()[-1]
    return json.loads(out.read_text())["mean"].get("psnr"), ""


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default="target/release/fovolnet")
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--only", help="one kind of picture")
    arguments = parser.parse_args()
    print("| kind | volume | " + " | ".join(WAYS) + " |\n|" + "---|" * (2 + len(WAYS)))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind, volume, source, flags in subjects(arguments.data, folder):
            if arguments.only and kind != arguments.only:
                continue
            cells = []
            for way in WAYS.values():
                decibels, problem = psnr(arguments.program, source, [*flags, *way], folder)
                cells.append("–" if decibels is None else f"{decibels:.1f}")
                if problem:
                    print(f"<!-- {kind} {volume} {' '.join(way)}: {problem} -->")
            print(f"| {kind} | {volume} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
