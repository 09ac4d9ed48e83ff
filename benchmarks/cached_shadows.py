#!/usr/bin/env python3
"""Cached shadows beside shadow rays: error and time of whole frames, and the time that the cache takes.

    cargo build --release
    python3 benchmarks/cached_shadows.py VOLUME[@TF] ... -o FILE.csv [--programs PROGRAM ...] [--frames 3] [--integration plain]

VOLUME is a file, or NAME:EDGE for a procedural volume. For each program, volume and of three lights: PSNR and SSIM of frames with
cached shadows against exact ones, milliseconds of a whole frame by both, and of the cache: what the first frame takes longer
than the others. Programs run in turn. Only Python's library is needed.
"""

import argparse
import csv
import json
import statistics
import subprocess
import tempfile
from pathlib import Path

PROGRAM = Path(__file__).resolve().parents[1] / "target" / "release" / "fovolnet"
LIGHTS = {"default": "0.5,1,0.3", "diagonal": "1,0.9,0.8", "along an axis": "0,0,1"}


def subject(text):
    """Arguments of the volume that `text` names, and its name."""
    volume, _, transfer = text.partition("@")
    name, _, edge = volume.partition(":")
    dims = ["--dims", ",".join([edge] * 3)] if edge else []
    return name, [name, *dims, *(["--tf", transfer] if transfer else [])]


def rendered(program, scene, shadows, more, options):
    """The frames of the report of a render."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            program, "render", *scene, "--shadows", shadows, "--integration", options.integration, "--size", options.size,
            "--path", "flythrough", "--first-frame", "60", "--frames", options.frames, "--sampling", "full",
            "--device", "cpu", "-o", f"{folder}/frames", "--json", f"{folder}/report.json", *more,
        ]  # fmt: skip
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(map(str, command))}: {done.stderr}")
        return json.loads(Path(folder, "report.json").read_text())["frames"]


def row_of(program, text, light, options):
    name, scene = subject(text)
    lit = ["--light", LIGHTS[light]]
    compared = rendered(program, scene, "cached", [*lit, "--keep", "reference"], options)
    cached = rendered(program, scene, "cached", lit, options)
    exact = rendered(program, scene, "on", lit, options)

    def median(frames):
        return statistics.median(frame["ms"]["march"] for frame in frames[1:])

    return {
        "program": Path(program).name,
        "volume": Path(name).name.split(".")[0],
        "light": light,
        "psnr": round(statistics.fmean(frame["psnr"] for frame in compared), 2),
        "ssim": round(statistics.fmean(frame["ssim"] for frame in compared), 4),
        "cached_ms": round(median(cached), 2),
        "exact_ms": round(median(exact), 2),
        "cache_ms": round(cached[0]["ms"]["march"] - median(cached), 1),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volumes", nargs="+", metavar="VOLUME[@TF]")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--programs", nargs="+", default=[PROGRAM])
    parser.add_argument("--frames", type=int, default=3)
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--integration", default="plain")
    options = parser.parse_args()
    rows = []
    for text in options.volumes:
        for light in LIGHTS:
            for program in options.programs:
                rows.append(row_of(program, text, light, options))
                print(rows[-1])
    with options.output.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
