"""Scenes: layers, cameras, clips, sessions, threads and memory."""

from __future__ import annotations

import gc
import multiprocessing
import os
import threading
from pathlib import Path

import numpy as np
import pytest
from small_pictures import SIZE, picture

import fovolnet as fv


def scene_of(data, **settings) -> fv.Scene:
    scene = fv.Scene(size=SIZE, device="cpu", **settings)
    scene.add_volume(data)
    return scene


def difference(a, b) -> int:
    return int(np.abs(np.asarray(a).astype(int) - b).max())


def test_the_camera_begins_with_the_default_view_and_turns(scan) -> None:
    scene = scene_of(scan)
    default = scene.render()
    camera = scene.camera
    assert difference(scene.render(), default) <= 1
    camera.azimuth += 30
    assert difference(scene.render(), default) > 30
    camera.azimuth -= 30
    assert difference(scene.render(), default) <= 1
    scene.camera = None
    assert np.array_equal(scene.render(), default)


def test_changes_of_a_layer_show_in_the_next_picture(scan) -> None:
    scene = fv.Scene(size=SIZE, device="cpu")
    layer = scene.add_volume(scan, name="ct")
    plain = scene.render()
    layer.cmap = "viridis"
    assert np.array_equal(scene.render(), picture(scan, cmap="viridis"))
    layer.clim = (0, 500)
    assert layer.clim == (0.0, 500.0)
    assert np.array_equal(scene.render(), picture(scan, cmap="viridis", clim=(0, 500)))
    layer.cmap, layer.opacity = None, [0.0, 0.0, 0.9]
    assert np.array_equal(scene.render(), picture(scan, clim=(0, 500), opacity=[0.0, 0.0, 0.9]))
    scene.settings["mode"] = "mip"
    assert np.array_equal(scene.render(), picture(scan, clim=(0, 500), opacity=[0.0, 0.0, 0.9], mode="mip"))
    assert difference(scene.render(), plain) > 20


def test_colours_and_opacities_come_from_lists_names_and_matplotlib(scan) -> None:
    automatic = picture(scan)
    assert np.array_equal(picture(scan, opacity=1.0), automatic)
    assert picture(scan, opacity=0.1, shadows=False).sum() < picture(scan, shadows=False).sum()
    red = picture(scan, cmap=[[1, 0, 0], [1, 0, 0]])
    assert red[..., 0].max() > 30 and red[..., 1:].max() == 0
    assert np.array_equal(red, picture(scan, cmap=lambda values: np.tile([1.0, 0.0, 0.0], (len(values), 1))))
    assert not np.array_equal(picture(scan, cmap="viridis", opacity="linear"), picture(scan, cmap="viridis"))
    assert not np.array_equal(picture(scan, cmap="viridis", opacity="ct-bone"), picture(scan, opacity="ct-bone"))
    for wrong in ({"opacity": 2.0}, {"opacity": [0.5]}, {"cmap": [[1, 0]]}, {"cmap": "no-such-map"}, {"opacity": "no-such"}):
        with pytest.raises(ValueError):
            picture(scan, **wrong)
    matplotlib = pytest.importorskip("matplotlib")
    assert np.array_equal(picture(scan, cmap="bone"), picture(scan, cmap=matplotlib.colormaps["bone"]))


def test_several_volumes_are_blended(scan, tmp_path: Path, of_command) -> None:
    other = np.ascontiguousarray(scan[:, ::-1])
    for name, values in (("a", scan), ("b", other)):
        fv.write(tmp_path / f"{name}.nrrd", values)
    expected = of_command(tmp_path / "a.nrrd", "--overlay", f"{tmp_path / 'b.nrrd'}@magma")
    scene = fv.Scene(size=SIZE, device="cpu")
    first = scene.add_volume(scan, name="a")
    second = scene.add_volume(other, name="b", cmap="magma")
    assert np.array_equal(scene.render(), expected)
    assert [layer.name for layer in scene.layers] == ["a", "b"]
    second.visible = False
    assert np.array_equal(scene.render(), picture(scan))
    first.visible, second.visible = False, True
    assert np.array_equal(scene.render(), picture(other, cmap="magma"))
    second.visible = False
    with pytest.raises(ValueError, match="visible"):
        scene.render()
    with pytest.raises(ValueError, match="called 'a' already"):
        scene.add_volume(scan, name="a")
    with pytest.raises(KeyError, match="no layer 'c'"):
        scene.remove("c")
    assert scene.layers["b"] is second and scene.layers[-1] is second and scene.layers[:1] == [first]
    scene.remove("a")
    scene.remove(second)
    with pytest.raises(ValueError, match="add_volume"):
        scene.render()
    for number in range(4):
        scene.add_volume(scan, opacity=0.2, name=str(number))
    scene.render()
    scene.add_volume(scan, name="one too many")
    with pytest.raises(ValueError, match="at most 4"):
        scene.render()


def test_pictures_have_opacity_and_depth(scan) -> None:
    scene = scene_of(scan)
    assert scene.render(transparent=True).shape == (64, 96, 4)
    image, depth = scene.render(depth=True)
    assert image.shape == (64, 96, 3) and depth.shape == (64, 96) and depth.dtype == np.float32
    nearest = depth.min()
    assert scene.camera.distance - 1.0 < nearest < scene.camera.distance
    assert np.isinf(depth[0, 0]) and image[0, 0].max() == 0


def test_clips_have_everything_that_belongs_to_their_frames(scan) -> None:
    scene = scene_of(scan, pb=0.1)
    frames = list(scene.frames(3, sampling="compact"))
    assert [frame.index for frame in frames] == [0, 1, 2]
    for frame in frames:
        assert frame.image.shape == (64, 96, 3) and frame.mask.shape == frame.shape == (64, 96)
        assert frame.samples == frame.mask.sum() and 0.0 < frame.density < 0.5
        assert np.array_equal(frame.sparse[..., 3] > 0.5, frame.mask)
        assert frame.depth.shape == (64, 96) and np.isfinite(frame.depth[frame.mask]).any()
        assert frame.times["total"] > 0.0
    assert frames[0].motion is None and frames[2].motion.shape == (64, 96, 2)
    for frame in scene.frames(2, path="flythrough", return_sparse=True, reconstruct="none"):
        assert frame.density < 0.5
    assert frame.motion.shape == (64, 96, 2) and frame.motion.dtype == np.float32


def test_clips_begin_at_any_frame(scan) -> None:
    scene = scene_of(scan, reconstruct="none")
    for sampling in ("full", "sparse"):
        whole = list(scene.frames(6, sampling=sampling))
        part = list(scene.frames(2, frames=6, first_frame=3, sampling=sampling))
        assert [frame.index for frame in part] == [3, 4]
        for frame, expected in zip(part, whole[3:5], strict=True):
            assert np.array_equal(frame.mask, expected.mask) and np.array_equal(frame.image, expected.image)


def test_clips_go_along_with_the_camera_of_the_scene(scan) -> None:
    scene = scene_of(scan)
    images = []
    for frame in scene.frames(2, path=None):
        images.append(frame.image)
        scene.camera.azimuth += 40
    scene.camera.azimuth -= 80
    assert difference(images[0], scene.render()) <= 1 and difference(images[0], images[1]) > 30


def test_the_gaze_moves_the_fovea(scan) -> None:
    scene = scene_of(scan, sampling="compact", sigma=0.1)
    left, right = (scene.render_frame(gaze=(x, 0.5)).mask for x in (0.2, 0.8))
    assert left[:, :32].sum() > 2 * right[:, :32].sum()


def test_frames_can_be_planned_within_a_budget(scan) -> None:
    scene = scene_of(scan, shadows=True)
    exact = scene.render()
    frames = list(scene.frames(4, path=None, budget=200.0))
    assert all(frame.shape == (64, 96) and frame.mask.shape == (64, 96) for frame in frames)
    assert fv.metrics.psnr(exact, frames[-1].image) > 25.0 and frames[-1].times["plan"] > 0.0
    assert np.array_equal(scene.render(), exact)
    with pytest.raises(ValueError, match="budget"):
        scene.render_frame(budget=-1.0)
    with pytest.raises(ValueError, match="transparent"):
        scene.render_frame(quality="auto", transparent=True)


def test_turntables_are_written(scan, tmp_path: Path) -> None:
    scene = scene_of(scan)
    seen: list[tuple[int, int]] = []
    path = scene.turntable(tmp_path / "turn.y4m", seconds=0.1, fps=30, progress=lambda done, n: seen.append((done, n)))
    assert seen == [(1, 3), (2, 3), (3, 3)]
    content = Path(path).read_bytes()
    assert content.startswith(b"YUV4MPEG2 W96 H64 F30:1") and content.count(b"FRAME\n") == 3
    assert fv.write_clip(tmp_path / "path.y4m", scene.frames(2), fps=24000 / 1001).endswith(".y4m")
    assert b"F24000:1001" in (tmp_path / "path.y4m").read_bytes()[:60]
    with pytest.raises(ValueError, match="no kind of clip"):
        scene.turntable(tmp_path / "turn.txt", seconds=0.1)
    with pytest.raises(ValueError, match="no frames"):
        fv.write_clip(tmp_path / "empty.y4m", [])


def test_sessions_are_read_and_written(scan, tmp_path: Path, of_command) -> None:
    fv.write(tmp_path / "a.nrrd", scan)
    fv.write(tmp_path / "b.nrrd", np.ascontiguousarray(scan[::-1]))
    scene = fv.Scene(size=SIZE, device="cpu", shadows="cached", background=(0.1, 0.2, 0.3))
    scene.add_volume(tmp_path / "a.nrrd", clim=(0, 700), cmap="viridis")
    scene.add_volume(tmp_path / "b.nrrd", opacity=0.5)
    scene.camera.azimuth += 20
    scene.save(tmp_path / "scene.toml")
    image = scene.render()
    assert np.array_equal(of_command(tmp_path / "scene.toml"), image)
    loaded = fv.Scene.load(tmp_path / "scene.toml", device="cpu")
    assert np.array_equal(loaded.render(), image)
    assert loaded.camera.azimuth == pytest.approx(scene.camera.azimuth)
    with pytest.raises(ValueError, match="fovolnet.write"):
        scene_of(scan).save(tmp_path / "array.toml")
    fv.write(tmp_path / "a.nrrd", scan + 1)
    with pytest.raises(ValueError, match="has changed"):
        fv.Scene.load(tmp_path / "scene.toml")


def test_closed_scenes_say_so(scan) -> None:
    with scene_of(scan) as scene:
        scene.render()
    for use in (scene.render, lambda: scene.add_volume(scan), lambda: scene.camera, lambda: list(scene.frames(1))):
        with pytest.raises(ValueError, match="closed"):
            use()


def test_two_threads_render_at_once(scan) -> None:
    expected = picture(scan)
    found: list[np.ndarray] = []
    shared = scene_of(scan)
    work = [lambda: found.append(picture(scan)), lambda: found.append(shared.render())]
    threads = [threading.Thread(target=what) for what in 3 * work]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 6 and all(np.array_equal(image, expected) for image in found)


def render_in_a_fork(scan, answers) -> None:
    try:
        picture(scan)
    except ValueError as error:
        answers.put(str(error))
    else:
        answers.put("it rendered")


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_forks_after_use_say_how_to_start_processes(scan) -> None:
    picture(scan)
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    process = context.Process(target=render_in_a_fork, args=(scan, answers))
    process.start()
    answer = answers.get(timeout=60)
    process.join(60)
    assert 'set_start_method("spawn")' in answer and process.exitcode == 0


def resident() -> int:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="only Linux says how much memory a process has")
def test_scenes_leave_no_memory(scan) -> None:
    for _ in range(40):
        picture(scan)
    gc.collect()
    before = resident()
    for _ in range(200):
        picture(scan)
    gc.collect()
    assert resident() - before < 16 << 20


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="only Linux says how much memory a process has")
def test_frames_leave_no_memory(scan) -> None:
    scene = fv.Scene(size=(32, 24), device="cpu", shadows="off")
    layer = scene.add_volume(scan)
    for _ in range(500):
        scene.render()
    before = resident()
    for number in range(10_000):
        if number % 100 == 0:
            layer.opacity = 0.5 + 0.4 * ((number // 100) % 2)
        scene.camera.azimuth += 1
        scene.render()
    assert resident() - before < 16 << 20
