"""What the benchmarks of quality share: running the program, and naming volumes for it."""

import argparse
import csv
import subprocess
import sys
from pathlib import Path

METHODS = ["network", "pull-push", "linear"]
VOLUMES_HELP = "files, or NAME:SIDE:SEED of procedural ones; @ and a transfer function may follow"


def run(*command):
    """Runs a program; what it says is shown if it fails."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")


def volume(given):
    """What `VOLUME[@TF]` means: a short name, the transfer function, and arguments for the program."""
    given, _, transfer = given.partition("@")
    name, *more = given.split(":") if not Path(given).exists() else [given]
    arguments = [name]
    if more:
        arguments += ["--dims", ",".join([more[0]] * 3), "--seed", more[1]]
    arguments += ["--tf", transfer] if transfer else []
    return Path(name).name.split("_")[0].split(".")[0], transfer or "auto", arguments


def options(about, frames, **defaults):
    """What every such script can be told, with `defaults` of its own; weights without one must be given."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volumes", nargs="+", help=VOLUMES_HELP)
    parser.add_argument("--weights", required="weights" not in defaults)
    parser.add_argument("--frames", type=int, default=frames)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--program", default="target/release/fovolnet")
    parser.add_argument("-o", "--output", type=Path, required=True)
    for name in defaults.keys() - {"weights"}:
        parser.add_argument("--" + name.replace("_", "-"))
    parser.set_defaults(**defaults)
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    return given


def write_rows(path, rows):
    """Writes dictionaries with the same keys as CSV."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
