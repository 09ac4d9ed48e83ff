#!/usr/bin/env python3
"""Fine integration beside plain: time of marching, difference from small steps, and what the network gains.

    cargo build --release
    python benchmarks/integration.py -o DIR [--only time|error|gain] [--volumes NAME ...] [--rounds 5]

`time.csv`: milliseconds of whole frames of 640x480 by both, in turn in one run, the least of all rounds, for every mode of shadows.
`error.csv`: the mean difference from fine steps of 0.05 in steps of 1/255, over all pixels and over those that show anything.
`gain.csv`: PSNR of the network and of filling by pull-push and linear, over 16 frames at 3 % and 10 % of 480x270, for both.
Needs NumPy and Pillow for the differences.
"""

import argparse
import csv
import json
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "target" / "release" / "fovolnet"
VIEW = ["--camera", "1.2,0.8,1.6,0,0,0,35", "--light", "1,0.3,0.2"]


def measured(volume, *flags):
    """The JSON of `fovolnet render`."""
    command = [PROGRAM, "render", volume, "--device", "cpu", *flags, "--json", "-"]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}: {done.stderr}")
    return json.loads(done.stdout)


def ball(folder):
    """A smooth ball with a jump of opacity at one value: the hardest case for samples at points."""
    import numpy as np

    z, y, x = (np.mgrid[0:64, 0:64, 0:64] + 0.5 - 32.0) / 32.0
    values = np.clip(255.0 * (1.0 - np.sqrt(x * x + y * y + z * z)), 0.0, 255.0)
    volume, transfer = folder / "ball_64x64x64_uint8.raw", folder / "hard.json"
    volume.write_bytes(values.astype(np.uint8).tobytes())
    points = [[0, 0, 0, 1, 0], [0.5, 0, 0, 1, 0], [0.5, 1, 0.8, 0, 0.95], [1, 1, 0.8, 0, 0.95]]
    transfer.write_text(json.dumps({"points": points}))
    return volume, ["--tf", transfer]


def times(volumes, folder, rounds):
    for name, (volume, flags) in volumes.items():
        for shadows in ["on", "cached", "off"]:
            least = {}
            for _ in range(rounds):
                for how in ["plain", "fine"]:
                    out = measured(
                        volume, *flags, "--shadows", shadows, "--integration", how, "--size", "640x480",
                        "--path", "turntable", "--turn", "0", "--frames", "6", "--sampling", "full",
                        "-o", folder / "frames",
                    )  # fmt: skip
                    march = min(frame["ms"]["march"] for frame in out["frames"][1:])
                    least[how] = min(least.get(how, march), march)
            ratio = least["fine"] / least["plain"]
            yield [name, shadows, f"{least['plain']:.2f}", f"{least['fine']:.2f}", f"{ratio:.2f}"]


def pixels(path):
    import numpy as np
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB"), dtype=float)


def errors(volumes, folder):
    import numpy as np

    for name, (volume, flags) in volumes.items():
        for shadows in ["on", "cached", "off"]:
            exact = "off" if shadows == "off" else "on"
            pictures = {}
            for how, step, mode in [("fine", 0.05, exact), ("fine", 0.5, shadows), ("plain", 0.5, shadows)]:
                path = folder / f"{how}_{step}.png"
                measured(
                    volume, *flags, *VIEW, "--shadows", mode, "--integration", how, "--step", step,
                    "--size", "320x240", "--sampling", "full", "-o", path,
                )  # fmt: skip
                pictures[how, step] = pixels(path)
            right = pictures["fine", 0.05]
            for how in ["fine", "plain"]:
                apart = np.abs(pictures[how, 0.5] - right).mean(axis=2)
                lit = (right.max(axis=2) > 5) | (pictures[how, 0.5].max(axis=2) > 5)
                yield [name, shadows, how, f"{apart.mean():.3f}", f"{apart[lit].mean():.3f}"]


def gains(volumes, folder):
    for name, (volume, flags) in volumes.items():
        for pb, sigma in [(0.02, 0.05), (0.08, 0.07)]:
            for how in ["plain", "fine"]:
                psnr = {}
                for method in ["wnet", "linear", "pull-push"]:
                    out = measured(
                        volume, *flags, "--integration", how, "--size", "480x270", "--path", "orbit",
                        "--frames", "16", "--pb", pb, "--sigma", sigma, "--reconstruct", method,
                        "--keep", "reference", "-o", folder / "frames",
                    )  # fmt: skip
                    psnr[method] = out["mean"]["psnr"]
                gain = psnr["wnet"] - max(psnr["linear"], psnr["pull-push"])
                figures = [f"{psnr[method]:.2f}" for method in ["wnet", "linear", "pull-push"]]
                yield [name, pb, how, *figures, f"{gain:.2f}"]


TABLES = {
    "time": (times, ["volume", "shadows", "plain_ms", "fine_ms", "ratio"]),
    "error": (errors, ["volume", "shadows", "integration", "all_pixels", "lit_pixels"]),
    "gain": (gains, ["volume", "pb", "integration", "wnet", "linear", "pull_push", "gain"]),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the tables")
    parser.add_argument("--only", choices=TABLES)
    parser.add_argument("--volumes", nargs="+", default=["head", "tooth", "walnut"])
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        volumes = {name.split("/")[-1].split("_")[0]: (name, []) for name in arguments.volumes}
        for name, (make, header) in TABLES.items():
            if arguments.only not in (None, name):
                continue
            shown = dict(volumes) if name == "gain" else {"ball": ball(folder), **volumes}
            rows = make(shown, folder, arguments.rounds) if name == "time" else make(shown, folder)
            with open(arguments.output / f"{name}.csv", "w", newline="") as file:
                table = csv.writer(file)
                table.writerow(header)
                for row in rows:
                    table.writerow(row)
                    file.flush()
                    print(name, *row, flush=True)


if __name__ == "__main__":
    main()
