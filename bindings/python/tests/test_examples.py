"""Examples, each run in a process of its own as a user runs it, and again after it was stopped."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_pictures import SIZE

import fovolnet as fv

EXAMPLES = Path(__file__).parent.parent / "examples"


def run(name: str, *arguments: object, status: int = 0) -> str:
    """What the example prints. It ends with `status`."""
    line = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout + done.stderr


def needs(module: str) -> Any:
    """The module that an example needs; the test is skipped without it."""
    return pytest.importorskip(module, reason=f"the example needs {module.split('.')[0]}, which is not installed")


def files(folder: Path, kind: str) -> dict[str, tuple[int, bytes]]:
    """Time and content of the files of a folder."""
    return {path.name: (path.stat().st_mtime_ns, path.read_bytes()) for path in folder.glob(kind)}


@pytest.fixture
def volume(scan: np.ndarray[Any, Any], tmp_path: Path) -> Path:
    """A small volume in a file."""
    path = tmp_path / "scan.nrrd"
    fv.write(path, scan)
    return path


@pytest.mark.parametrize("sparse", [False, True])
def test_dask_renders_the_frames_that_are_missing(volume: Path, tmp_path: Path, sparse: bool) -> None:
    needs("dask.distributed")
    folder = tmp_path / "frames"
    command = ["dask_frames.py", volume, folder, "--frames", 6, "--size", "96x64", "--run", 3, *["--sparse"] * sparse]
    assert "6 of 6 frames are missing, in 2 runs" in run(*command)
    before = files(folder, "*.png")
    assert sorted(before) == [f"frame_{i:05}.png" for i in range(6)]
    assert len({content for _, content in before.values()}) == 6
    with fv.Scene(size=SIZE) as scene:
        scene.add_volume(volume)
        for frame in scene.frames(6, sampling="sparse" if sparse else "full"):
            # Frame 3 begins a run, so the network remembers nothing before it.
            if not sparse or frame.index < 3:
                fv.Picture(frame.image).save(tmp_path / "expected.png")
                assert (tmp_path / "expected.png").read_bytes() == before[f"frame_{frame.index:05}.png"][1]

    (folder / "frame_00004.png").unlink()
    (folder / "frame_00004.0123.part").write_bytes(before["frame_00004.png"][1][:100])
    assert "1 of 6 frames are missing, in 1 runs" in run(*command)
    after = files(folder, "*")
    assert sorted(after) == sorted([*before, "job.json"])
    assert after["frame_00004.png"][1] == before["frame_00004.png"][1]
    assert all(after[name] == before[name] for name in before if name != "frame_00004.png")
    if sparse:
        return
    assert run(*command) == "0 of 6 frames are missing, in 0 runs\n"
    assert "another job" in run("dask_frames.py", volume, folder, "--frames", 7, status=1)
    assert "check the path" in run("dask_frames.py", "missing.nrrd", tmp_path / "none", "--workers", 1, status=1)


def test_ray_reports_bad_volumes_and_renders_the_others(volume: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs("ray")
    # Ray keeps a key of its own in the home folder.
    monkeypatch.setitem(os.environ, "HOME", str(tmp_path))
    bad, folder = tmp_path / "bad.nrrd", tmp_path / "pictures"
    bad.write_text("NRRD0004\ntype: short\n")
    command = ["ray_volumes.py", folder, bad, volume, "marschner-lobb", "missing.nrrd", "--size", "96x64"]
    assert "2 pictures, 2 failed" in run(*command, status=1)

    def summary() -> list[dict[str, str]]:
        with (folder / "summary.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    rows = summary()
    assert [row["status"] for row in rows] == ["failed", "rendered", "rendered", "failed"]
    assert "no sizes" in rows[0]["error"] and "check the path" in rows[3]["error"]
    assert rows[1]["voxels"] == "20x24x32" and float(rows[1]["seconds"]) > 0
    before = files(folder, "*.png")
    assert sorted(before) == sorted(row["picture"] for row in rows[1:3])
    with fv.Scene(size=SIZE) as scene:
        scene.add_volume(volume)
        scene.render().save(tmp_path / "expected.png")
    assert before[rows[1]["picture"]][1] == (tmp_path / "expected.png").read_bytes()

    missing = rows[2]["picture"]
    (folder / missing).unlink()
    (folder / f"{missing}.part").write_bytes(b"\x89PNG")
    fv.write(bad, np.zeros((4, 4, 4), np.uint8))
    assert "3 of 4 volumes have no picture yet" in run(*command, status=1)
    after = files(folder, "*")
    assert after[missing][1] == before[missing][1]
    assert after[rows[1]["picture"]] == before[rows[1]["picture"]]
    assert not [name for name in after if name.endswith(".part")]
    assert [row["status"] for row in summary()] == ["rendered", "kept", "rendered", "failed"]
    assert summary()[1] == {**rows[1], "status": "kept"}


def test_clips_for_torch_follow_from_the_seed_alone(volume: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    needs("torch")
    arguments = ["torch_clips.py", "--volumes", volume, "marschner-lobb", "--clips", 4, "--frames", 3, "--size", "96x64"]
    lines = run(*arguments, "--workers", 2)
    assert len(re.findall(r"[1-9]\d\.\d\d dB", lines)) == 2
    assert run(*arguments, "--workers", 0) == lines
    assert run(*arguments, "--workers", 0, "--seed", 1) != lines

    monkeypatch.syspath_prepend(EXAMPLES)
    import torch
    from torch_clips import SparseClips

    clips = SparseClips([str(volume)], 3, frames=3, size=SIZE)
    last = clips[2]
    again = SparseClips([str(volume)], 3, frames=3, size=SIZE)
    assert all(torch.equal(last[name], values) for name, values in again[2].items())
    assert not torch.equal(clips[0]["full"], last["full"])
    assert {name: tuple(values.shape) for name, values in last.items()} == {
        "colours": (3, 3, 64, 96), "mask": (3, 1, 64, 96), "motion": (3, 2, 64, 96), "full": (3, 3, 64, 96)
    }  # fmt: skip
    assert torch.equal(last["colours"], last["full"] * last["mask"])
    assert 0.0 < last["mask"].mean() < 0.2 and last["motion"][1:].abs().max() > 0.1
    with pytest.raises(IndexError):
        clips[3]


@pytest.mark.parametrize("weights", ["wnet-fast", "wnet-paper"])
def test_networks_in_torch_are_those_of_the_package(volume: Path, weights: str) -> None:
    needs("torch")
    # The sides are no multiples of 16, so frames are padded.
    lines = run("torch_network.py", volume, "--weights", weights, "--size", "90x70", "--frames", 12)
    differences = [float(number) for number in re.findall(r"difference (\d\S+)", lines)]
    assert len(differences) == 12 and max(differences) < 1e-5, lines
