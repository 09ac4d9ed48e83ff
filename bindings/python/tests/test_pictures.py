"""Pictures of arrays beside those of the command line."""

import gc
import os
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

import fovolnet as fv

COMMAND = os.environ.get("FOVOLNET_COMMAND")


@pytest.fixture
def scan() -> np.ndarray:
    """An asymmetric volume, [z, y, x]."""
    z, y, x = np.mgrid[0:20, 0:24, 0:32]
    ball = np.clip(9.0 - np.sqrt((z - 8.0) ** 2 + (y - 10.0) ** 2 + (x - 12.0) ** 2), 0.0, 9.0)
    return np.asarray(100.0 * ball + 3.0 * x + (y > 18) * 400.0, np.int16)


def picture(data: object, **options: object) -> np.ndarray:
    return fv.show(data, size=(96, 64), device="cpu", **options)


def of_command(path: Path, folder: Path, *flags: str) -> np.ndarray:
    if COMMAND is None:
        pytest.skip("FOVOLNET_COMMAND names no command")
    image = pytest.importorskip("PIL.Image")
    out = folder / "out.png"
    line = [COMMAND, "render", str(path), "--size", "96x64", "--device", "cpu", "-o", str(out), *flags]
    subprocess.run(line, check=True, capture_output=True)
    return np.asarray(image.open(out).convert("RGB"))


def test_arrays_are_shown_as_the_command_line_shows_their_file(scan: np.ndarray, tmp_path: Path) -> None:
    path = tmp_path / "scan_32x24x20_int16.raw"
    scan.tofile(path)
    expected = of_command(path, tmp_path, "--spacing", "1,1,2.5")
    assert np.array_equal(picture(scan, spacing=(1, 1, 2.5)), expected)
    assert np.array_equal(picture(fv.read(path, spacing=(1, 1, 2.5))), expected)


def test_settings_mean_what_flags_mean(scan: np.ndarray, tmp_path: Path) -> None:
    path = tmp_path / "scan_32x24x20_int16.raw"
    scan.tofile(path)
    expected = of_command(path, tmp_path, "--mode", "mip", "--tf", "viridis", "--step", "0.25", "--range", "0,900")
    assert np.array_equal(picture(scan, mode="mip", cmap="viridis", step=0.25, clim=(0, 900)), expected)


def test_every_layout_and_type_gives_the_same_picture(scan: np.ndarray) -> None:
    expected = picture(scan, clim=(0, 900))
    fortran = np.asfortranarray(scan)
    turned = np.ascontiguousarray(scan.transpose(2, 1, 0))
    big = scan.astype(">i2")
    strided = np.repeat(scan, 2, axis=2)[..., ::2]
    read_only = scan.copy()
    read_only.setflags(write=False)
    for array in (fortran, big, strided, read_only, scan.astype(np.float32), scan.astype(np.int32), scan.astype(np.float64)):
        assert np.abs(picture(array, clim=(0, 900)).astype(int) - expected).max() <= 1, array.dtype
    assert np.array_equal(picture(turned, order="xyz", clim=(0, 900)), expected)


def test_objects_of_other_libraries_bring_their_order_and_spacing(scan: np.ndarray) -> None:
    expected = picture(scan, spacing=(1.0, 1.5, 2.5))
    sitk = pytest.importorskip("SimpleITK")
    image = sitk.GetImageFromArray(scan)
    image.SetSpacing((1.0, 1.5, 2.5))
    assert np.array_equal(picture(image), expected)
    nib = pytest.importorskip("nibabel")
    nifti = nib.Nifti1Image(scan.transpose(2, 1, 0), np.diag([1.0, 1.5, 2.5, 1.0]))
    assert np.array_equal(picture(nifti), expected)
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.ImageData(dimensions=scan.shape[::-1], spacing=(1.0, 1.5, 2.5))
    grid["values"] = scan.ravel()
    assert np.array_equal(picture(grid), expected)
    xarray = pytest.importorskip("xarray")
    axes = {name: step * np.arange(n) for name, n, step in zip("zyx", scan.shape, (2.5, 1.5, 1.0))}
    assert np.array_equal(picture(xarray.DataArray(scan, coords=axes, dims=list("zyx"))), expected)


def test_colours_of_voxels_need_to_be_asked_for() -> None:
    colours = np.zeros((8, 9, 10, 4), np.uint8)
    colours[..., 0] = 200
    colours[2:6, 2:6, 2:6, 3] = 255
    image = picture(colours, rgb=True)
    assert image[..., 0].max() > 50 and image[..., 1:].max() == 0
    with pytest.raises(ValueError, match="rgb=True"):
        picture(colours)


def test_what_cannot_be_shown_raises_with_a_remedy(scan: np.ndarray) -> None:
    for wrong, part in [
        (np.zeros((4, 4)), r"shape \(z, y, x\)"),
        (np.zeros((0, 4, 4)), "voxel"),
        (scan.astype(object), "convert"),
        (scan.astype(complex), "convert"),
        ("no-such-file.nrrd", "no-such-file"),
    ]:
        with pytest.raises(ValueError, match=part):
            picture(wrong)
    with pytest.raises(ValueError, match="mode|variant"):
        picture(scan, mode="xray")
    with pytest.raises(ValueError, match="unknown field"):
        picture(scan, shadow="on")


def test_masked_and_missing_values_are_transparent() -> None:
    values = np.full((8, 8, 8), 5.0, np.float32)
    values[2:4] = 0.0
    masked = np.ma.masked_greater(values, 4.0)
    nan = np.where(values > 4.0, np.nan, values)
    options = {"clim": (-1.0, 1.0)}
    assert np.array_equal(picture(masked, **options), picture(nan, **options))


def test_the_camera_begins_with_the_default_view_and_turns(scan: np.ndarray) -> None:
    scene = fv.Scene(size=(96, 64), device="cpu")
    scene.add_volume(scan)
    default = scene.render()
    camera = scene.camera
    assert np.abs(scene.render().astype(int) - default).max() <= 1
    camera.azimuth += 30
    assert np.abs(scene.render().astype(int) - default).max() > 30
    camera.azimuth -= 30
    assert np.abs(scene.render().astype(int) - default).max() <= 1


def test_clips_have_everything_that_belongs_to_their_frames(scan: np.ndarray) -> None:
    scene = fv.Scene(size=(96, 64), device="cpu", pb=0.1)
    scene.add_volume(scan)
    frames = list(scene.frames(3, sampling="compact"))
    assert [frame.index for frame in frames] == [0, 1, 2]
    for frame in frames:
        assert frame.image.shape == (64, 96, 3) and frame.mask.shape == (64, 96)
        assert frame.samples == frame.mask.sum() and 0.0 < frame.density < 0.5
        assert np.array_equal(frame.sparse[..., 3] > 0.5, frame.mask)
        assert frame.depth.shape == (64, 96) and np.isfinite(frame.depth[frame.mask]).any()
        assert frame.times["total"] > 0.0
    assert frames[0].motion is None and frames[2].motion.shape == (64, 96, 2)


def test_sparse_frames_of_others_are_filled(scan: np.ndarray) -> None:
    scene = fv.Scene(size=(96, 64), device="cpu")
    scene.add_volume(scan)
    full = scene.render() / np.float32(255.0)
    mask = np.random.default_rng(0).random((64, 96)) < 0.3
    for weights in ("wnet-fast", "linear"):
        filled = fv.Reconstructor(weights)(full, mask)
        assert filled.shape == (64, 96, 3) and filled.dtype == np.float32
        assert fv.metrics.psnr(full, filled) > 25.0, weights
    with pytest.raises(ValueError, match="mask"):
        fv.Reconstructor("linear")(full, mask[:10])


def test_metrics_of_equal_pictures(scan: np.ndarray) -> None:
    image = picture(scan)
    assert fv.metrics.psnr(image, image) == 100.0 and fv.metrics.ssim(image, image) == pytest.approx(1.0)
    noisy = np.clip(image + np.random.default_rng(1).integers(0, 9, image.shape), 0, 255).astype(np.uint8)
    expected = -10 * np.log10(np.mean((noisy / 255.0 - image / 255.0) ** 2))
    assert fv.metrics.psnr(image, noisy) == pytest.approx(expected, abs=1e-3)


def test_two_threads_render_at_once(scan: np.ndarray) -> None:
    expected = picture(scan)
    found: list[np.ndarray] = []
    threads = [threading.Thread(target=lambda: found.append(picture(scan))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4 and all(np.array_equal(image, expected) for image in found)


def resident() -> int:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_scenes_leave_no_memory(scan: np.ndarray) -> None:
    for _ in range(40):
        picture(scan)
    gc.collect()
    before = resident()
    for _ in range(200):
        picture(scan)
    gc.collect()
    assert resident() - before < 16 << 20


def test_pictures_are_saved_and_shown_by_notebooks(scan: np.ndarray, tmp_path: Path) -> None:
    image_module = pytest.importorskip("PIL.Image")
    image = picture(scan)
    assert image._repr_png_()[:4] == b"\x89PNG"
    image.save(tmp_path / "scan.png")
    assert np.array_equal(np.asarray(image_module.open(tmp_path / "scan.png")), image)
    scene = fv.Scene(size=(96, 64), device="cpu")
    scene.add_volume(scan)
    assert scene.render(transparent=True).shape == (64, 96, 4)
