#!/usr/bin/env python3
"""The planner's frames beside the best of all other ways that take no longer, for several volumes.

    cargo build --release
    python3 benchmarks/never_dominated.py VOLUME[@TF] ... -o FILE.csv [--size 640x360] [--program PROGRAM]

Runs `fovolnet repro alternatives` for each volume. FILE.csv gets a line for each volume, light at rest or moving, budget and
measure (PSNR, JOD of FovVideoVDP and of ColorVideoVDP): the planner's value, the best other way's, and their difference, above 0
where the planner is better. A summary is printed. Only Python's library is needed.
"""

import argparse
import csv
import subprocess
import tempfile
from collections import defaultdict
from pathlib import Path

PROGRAM = Path(__file__).resolve().parents[1] / "target" / "release" / "fovolnet"
LIGHTS = {"planner": "rests", "planner_moving": "moves"}
# How much better another way may be.
ALLOWED = {"PSNR, dB": 0.3, "JOD": 0.02, "JOD in colour": 0.02}


def compared(volume, options):
    """The lines of one volume."""
    with tempfile.TemporaryDirectory() as folder:
        command = [options.program, "repro", "alternatives", "--quick", "--volume", volume, "--size", options.size,
                   "--device", "cpu", "-o", folder]  # fmt: skip
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(map(str, command))}: {done.stderr}")
        for table, light in LIGHTS.items():
            [file] = Path(folder).rglob(f"{table}.csv")
            for row in csv.DictReader(file.open()):
                ours, theirs = float(row["planner"]), float(row["its value"])
                named = {"volume": Path(volume.split("@")[0]).name.split("_")[0], "light": light}
                yield named | row | {"difference": round(ours - theirs, 4)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volumes", nargs="+", metavar="VOLUME[@TF]")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--program", type=Path, default=PROGRAM)
    options = parser.parse_args()
    held = defaultdict(list)
    with options.output.open("w", newline="") as file:
        writer = None
        for volume in options.volumes:
            for row in compared(volume, options):
                writer = writer or csv.DictWriter(file, row.keys())
                if not held:
                    writer.writeheader()
                writer.writerow(row)
                is_alone = row["difference"] != row["difference"]
                held[row["measure"]].append(is_alone or row["difference"] >= -ALLOWED[row["measure"]])
            file.flush()
            print(volume, {measure: f"{sum(all_)} of {len(all_)}" for measure, all_ in held.items()}, flush=True)


if __name__ == "__main__":
    main()
