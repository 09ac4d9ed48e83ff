"""The programs of the project: the command ``fovolnet`` and its viewer.

``pip install`` puts both on the PATH; ``python -m fovolnet`` is the command, too.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from . import _native


def command() -> None:
    """Runs the command ``fovolnet`` with the arguments of this process, and ends it."""
    # The viewer is found beside the command, also where that folder is not on the PATH.
    folder = str(Path(sys.argv[0]).resolve().parent)
    os.environ["PATH"] = os.pathsep.join([folder, str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    sys.exit(_native.run_command(["fovolnet", *sys.argv[1:]]))


def viewer() -> None:
    """Runs ``fovolnet-viewer`` with the arguments of this process, and ends it."""
    sys.exit(_native.run_viewer(["fovolnet-viewer", *sys.argv[1:]]))


def run(*arguments: str | os.PathLike[str]) -> str:
    """Runs the command ``fovolnet`` in a process of its own.

    Parameters
    ----------
    *arguments
        Words of the command line, such as ``"info"``, ``"scan.nrrd"``.

    Returns
    -------
    str
        What it printed.

    Raises
    ------
    RuntimeError
        The command failed; the message is its own.
    """
    line = [sys.executable, "-m", "fovolnet", *(os.fspath(argument) for argument in arguments)]
    done = subprocess.run(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip().removeprefix("error: ") or f"fovolnet ended with status {done.returncode}")
    return done.stdout


def repro(
    *tables: str, output: str | os.PathLike[str] = "fovolnet-repro", volumes: Sequence[str | os.PathLike[str]] = (), quick: bool = False
) -> Path:
    """Makes tables and figures of the paper's evaluation.

    Parameters
    ----------
    *tables : str
        ``"jod"``, ``"speedups"``, ``"quality"``, ``"all"`` or others that ``fovolnet repro --help`` lists.
    output : path
        Folder for report.html, figures, and values as JSON and CSV.
    volumes : sequence of paths
        Volumes to evaluate; the procedural ones, if not given.
    quick : bool
        Few and small frames: minutes instead of hours.

    Returns
    -------
    Path
        The folder.
    """
    chosen = [word for volume in volumes for word in ("--volume", os.fspath(volume))]
    run("repro", *tables, "-o", output, *chosen, *(["--quick"] if quick else []))
    return Path(output)
