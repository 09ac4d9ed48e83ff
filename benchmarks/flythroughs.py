"""What the benchmarks of quality share: running the program, and naming volumes for it."""

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
