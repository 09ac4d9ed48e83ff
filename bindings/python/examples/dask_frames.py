"""Renders the frames of one clip with Dask workers.

Every worker is a process that opens the volume once and renders whole runs of frames. Frames are PNG files. A frame gets its name when
it is complete, so a job that was stopped goes on where it left off: run the same command again. One job at a time may write to a folder.

    pip install fovolnet "dask[distributed]"
    python dask_frames.py head frames --frames 48 --size 640x360 --workers 2
    python dask_frames.py /data/scan.nrrd /data/frames --scheduler tcp://10.0.0.1:8786

With ``--scheduler`` the workers of a running cluster do the work. They need fovolnet, and volume and folder under the same paths. Start
them with one thread each: ``dask worker tcp://10.0.0.1:8786 --nthreads 1``. The renderer uses all cores of a worker's machine; give
``--threads`` where a machine has several workers.

``--sparse`` marches few pixels, and a network makes the frames from them. The network remembers earlier frames of a run and nothing from
before the run, so runs should be long. A run with a missing frame is then rendered from its beginning, and the frame has the same bytes.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from threading import Lock
from typing import cast
from uuid import uuid4

from dask.distributed import Client, Worker, WorkerPlugin, as_completed, get_worker

import fovolnet as fv


@dataclass(frozen=True)
class Job:
    """A clip. All processes agree on it, and a folder holds the frames of one."""

    volume: str
    folder: str
    frames: int
    size: tuple[int, int]
    run: int
    sparse: bool

    def path(self, i: int) -> Path:
        """File of frame `i`."""
        return Path(self.folder) / f"frame_{i:05}.png"

    def missing(self, run: range) -> list[int]:
        """Numbers of the frames of `run` that do not exist yet."""
        return [i for i in run if not self.path(i).exists()]

    def runs(self) -> list[range]:
        """Runs of frames with at least one that is missing."""
        runs = [range(start, min(start + self.run, self.frames)) for start in range(0, self.frames, self.run)]
        return [run for run in runs if self.missing(run)]


class OwnScene(WorkerPlugin):
    """The scene of a worker. It is opened with the first run, and closed with the worker."""

    name = "fovolnet-scene"

    def __init__(self, job: Job, threads: int | None) -> None:
        self.job, self.threads = job, threads

    def setup(self, worker: Worker) -> None:
        """Begins without a scene: opening one here would keep the worker from answering."""
        self.scene: fv.Scene | None = None
        self.lock = Lock()

    def teardown(self, worker: Worker) -> None:
        """Frees memory and threads."""
        if self.scene is not None:
            self.scene.close()

    def render(self, run: range) -> int:
        """Writes the missing frames of `run` and returns how many these were."""
        job, written = self.job, 0
        # A scene renders one clip at a time, even if the worker has several threads.
        with self.lock:
            for frame in self._frames(run):
                if not job.path(frame.index).exists():
                    save(frame, job.path(frame.index))
                    written += 1
        return written

    def _frames(self, run: range) -> Iterator[fv.Frame]:
        """The missing frames of `run`; with a network those before them, too, because it remembers them."""
        if self.scene is None:
            self.scene = fv.Scene(size=self.job.size, threads=self.threads)
            self.scene.add_volume(self.job.volume)
        missing = self.job.missing(run)
        parts = [range(i, i + 1) for i in missing]
        if self.job.sparse and missing:
            parts = [range(run.start, missing[-1] + 1)]
        sampling = "sparse" if self.job.sparse else "full"
        for part in parts:
            yield from self.scene.frames(len(part), frames=self.job.frames, first_frame=part.start, sampling=sampling)


def save(frame: fv.Frame, path: Path) -> None:
    """Writes a frame under another name, and renames it when all of it is on the disk."""
    part = path.with_name(f"{path.stem}.{uuid4().hex}.part")
    try:
        fv.Picture(frame.image).save(part)
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def render_run(run: range) -> int:
    """The task of a worker: `run` with the worker's own scene."""
    return cast(OwnScene, get_worker().plugins[OwnScene.name]).render(run)


def prepare(job: Job) -> None:
    """Makes the folder, removes files that a stopped job left incomplete, and refuses frames of another job."""
    folder = Path(job.folder)
    folder.mkdir(parents=True, exist_ok=True)
    for part in folder.glob("frame_*.part"):
        part.unlink()
    description, facts = folder / "job.json", json.dumps(asdict(job), indent=2) + "\n"
    if description.exists() and description.read_text() != facts:
        raise ValueError(f"{description}: this folder has frames of another job; name another folder, or delete it")
    description.write_text(facts)


def connected(arguments: argparse.Namespace) -> Client:
    """A client of a running scheduler, or of workers on this machine. Dask starts each in a new process, never by a fork."""
    if arguments.scheduler:
        return Client(arguments.scheduler)  # type: ignore[no-untyped-call]
    local = {"n_workers": arguments.workers, "threads_per_worker": 1, "dashboard_address": None}
    return Client(processes=True, **local)  # type: ignore[no-untyped-call]


def render(job: Job, arguments: argparse.Namespace) -> None:
    """Renders the missing frames of `job`."""
    runs = job.runs()
    print(f"{sum(len(job.missing(run)) for run in runs)} of {job.frames} frames are missing, in {len(runs)} runs", flush=True)
    if not runs:
        return
    threads = arguments.threads or (None if arguments.scheduler else max(1, (os.cpu_count() or 1) // arguments.workers))
    with connected(arguments) as client:
        client.register_plugin(OwnScene(job, threads))
        # Tasks are impure: their result is files, so Dask must not take it from an earlier call.
        tasks = client.map(render_run, runs, pure=False)
        done = 0
        for task in as_completed(tasks):  # type: ignore[no-untyped-call]
            done += task.result()
            print(f"{done} frames written", flush=True)


def size(text: str) -> tuple[int, int]:
    """Width and height from a text such as 640x360."""
    width, height = text.split("x")
    return int(width), int(height)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", help="a file, or the name of a procedural volume such as head")
    parser.add_argument("folder", type=Path, help="where the frames go")
    parser.add_argument("--frames", type=int, default=48, help="length of the clip, a full turn [default: 48]")
    parser.add_argument("--size", type=size, default=(640, 360), help="width x height [default: 640x360]")
    parser.add_argument("--run", type=int, default=16, help="frames that a worker renders at a time [default: 16]")
    parser.add_argument("--sparse", action="store_true", help="march few pixels; a network makes the frames")
    parser.add_argument("--scheduler", help="address of a running scheduler [default: workers on this machine]")
    parser.add_argument("--workers", type=int, default=2, help="workers on this machine [default: 2]")
    parser.add_argument("--threads", type=int, help="threads of each worker's renderer")
    given = parser.parse_args()
    volume = os.path.abspath(given.volume) if os.path.exists(given.volume) else given.volume
    job = Job(volume, str(given.folder.absolute()), given.frames, given.size, given.run, given.sparse)
    try:
        prepare(job)
        render(job, given)
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
