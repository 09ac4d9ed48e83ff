"""Renders many volumes with Ray actors, on this machine or on a cluster.

Every actor is a process that renders one volume after the other. Pictures and a summary come back to the machine where this script runs;
actors need the volumes under the same paths, and fovolnet. A file that cannot be rendered is reported with its error and does not end
the job, nor does a process that dies. Run the command again to go on with a job that was stopped: pictures that exist are kept.
Delete the picture of a volume that has changed.

    pip install fovolnet ray
    python ray_volumes.py pictures scans/*.nrrd --actors 2
    python ray_volumes.py pictures @list.txt --address auto --cpus 8 --actors 20

The folder then holds a PNG file for each volume and `summary.csv`: volume, picture, status (rendered, kept or failed), seconds, voxels
along z, y, x, and the error. The exit status is 1 if a volume failed. ``@list.txt`` stands for the lines of a file.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import io
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import ray
from ray.exceptions import RayError

import fovolnet as fv
from fovolnet.picture import png


@dataclass(frozen=True)
class Result:
    """A line of the summary."""

    volume: str
    picture: str
    status: str
    seconds: float = 0.0
    voxels: str = ""
    error: str = ""


class VolumeRenderer:
    """An actor. Ray starts its process anew, not by a fork, so the renderer's threads are its own."""

    def __init__(self, size: tuple[int, int], threads: int) -> None:
        self.size, self.threads = size, threads

    def render(self, volume: str) -> tuple[bytes, str]:
        """The PNG file of a volume, and its voxels along z, y, x."""
        with fv.Scene(size=self.size, threads=self.threads) as scene:
            layer = scene.add_volume(volume)
            return png(scene.render()), "x".join(map(str, layer.volume.shape))


def picture_name(volume: str, size: tuple[int, int]) -> str:
    """A name for each path and size: files of different folders may be called the same."""
    return f"{Path(volume).name}.{hashlib.sha256(repr((volume, size)).encode()).hexdigest()[:8]}.png"


def write(path: Path, content: bytes) -> None:
    """Writes a file under another name, and renames it when all of it is on the disk."""
    part = path.with_name(path.name + ".part")
    with part.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)


def write_summary(folder: Path, results: list[Result]) -> None:
    """Writes a table of results."""
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(Result)])
    table.writeheader()
    table.writerows(asdict(result) for result in results)
    write(folder / "summary.csv", text.getvalue().encode())


def earlier_results(folder: Path) -> dict[str, Result]:
    """Results of an earlier job in this folder."""
    path = folder / "summary.csv"
    if not path.exists():
        return {}
    with path.open(newline="", encoding="utf-8") as file:
        rows: list[dict[str, Any]] = list(csv.DictReader(file))
    return {row["volume"]: Result(**{**row, "seconds": float(row["seconds"])}) for row in rows}


def error_line(error: Exception) -> str:
    """The error in one line. Ray wraps errors of actors; the cause is the renderer's own."""
    cause = getattr(error, "cause", None) or error
    return (str(cause).strip().splitlines() or [type(cause).__name__])[0]


def rendered(volumes: list[str], folder: Path, given: argparse.Namespace) -> Iterator[Result]:
    """Results of `volumes` in the order in which they are ready. Each actor has one volume at a time."""
    kind: Any = ray.remote(num_cpus=given.cpus, max_restarts=-1)(VolumeRenderer)
    idle = [kind.remote(given.size, given.cpus) for _ in range(min(given.actors, len(volumes)))]
    waiting, running = list(reversed(volumes)), dict[Any, tuple[str, Any, float]]()
    while waiting or running:
        while waiting and idle:
            volume, actor = waiting.pop(), idle.pop()
            running[actor.render.remote(volume)] = (volume, actor, time.monotonic())
        [ready], _ = ray.wait(list(running), num_returns=1)
        volume, actor, start = running.pop(ready)
        idle.append(actor)
        result = Result(volume, picture_name(volume, given.size), "rendered", round(time.monotonic() - start, 3))
        try:
            content, voxels = ray.get(ready)
            write(folder / result.picture, content)
            yield replace(result, voxels=voxels)
        except (RayError, ValueError) as error:
            yield replace(result, picture="", status="failed", error=error_line(error))


def render(volumes: list[str], folder: Path, given: argparse.Namespace) -> list[Result]:
    """Renders the volumes that have no picture yet, and returns the results of all."""
    folder.mkdir(parents=True, exist_ok=True)
    earlier, results = earlier_results(folder), dict[str, Result]()
    for volume in volumes:
        if (folder / picture_name(volume, given.size)).exists():
            known = earlier.get(volume, Result(volume, picture_name(volume, given.size), "kept"))
            results[volume] = replace(known, status="kept")
    missing = [volume for volume in volumes if volume not in results]
    print(f"{len(missing)} of {len(volumes)} volumes have no picture yet", flush=True)
    if missing:
        ray.init(address=given.address, include_dashboard=False if given.address is None else None, log_to_driver=False)
        for result in rendered(missing, folder, given):
            results[result.volume] = result
            write_summary(folder, [results[volume] for volume in volumes if volume in results])
            print(f"{result.volume}: {result.error or result.picture}", flush=True)
        ray.shutdown()
    in_order = [results[volume] for volume in volumes]
    write_summary(folder, in_order)
    return in_order


def size(text: str) -> tuple[int, int]:
    """Width and height from a text such as 640x360."""
    width, height = text.split("x")
    return int(width), int(height)


def absolute(volume: str) -> str:
    """The path of a file for other processes; names of procedural volumes stay."""
    return os.path.abspath(volume) if os.path.exists(volume) else volume


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, fromfile_prefix_chars="@"
    )
    parser.add_argument("folder", type=Path, help="where the pictures go")
    parser.add_argument("volumes", nargs="+", help="files, or names of procedural volumes such as head")
    parser.add_argument("--size", type=size, default=(640, 360), help="width x height [default: 640x360]")
    parser.add_argument("--address", help="address of a running Ray cluster, or auto [default: this machine]")
    parser.add_argument("--actors", type=int, default=2, help="number of actors [default: 2]")
    parser.add_argument("--cpus", type=int, default=1, help="processors, and threads, of each actor [default: 1]")
    given = parser.parse_args()
    volumes = list(dict.fromkeys(map(absolute, given.volumes)))
    results = render(volumes, given.folder, given)
    failed = sum(result.status == "failed" for result in results)
    print(f"{len(results) - failed} pictures, {failed} failed; see {given.folder / 'summary.csv'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
