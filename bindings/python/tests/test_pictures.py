"""Pictures of arrays beside those of the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_pictures import picture

import fovolnet as fv


def test_arrays_are_shown_as_the_command_line_shows_their_file(scan, tmp_path: Path, of_command) -> None:
    path = tmp_path / "scan_32x24x20_int16.raw"
    scan.tofile(path)
    expected = of_command(path, "--spacing", "1,1,2.5")
    assert np.array_equal(picture(scan, spacing=(1, 1, 2.5)), expected)
    assert np.array_equal(picture(fv.read(path, spacing=(1, 1, 2.5))), expected)


def test_settings_mean_what_flags_mean(scan, tmp_path: Path, of_command) -> None:
    path = tmp_path / "scan_32x24x20_int16.raw"
    scan.tofile(path)
    expected = of_command(path, "--mode", "mip", "--tf", "viridis", "--step", "0.25", "--range", "0,900")
    assert np.array_equal(picture(scan, mode="mip", cmap="viridis", step=0.25, clim=(0, 900)), expected)
    expected = of_command(path, "--shadows", "off", "--clip-plane", "1,0,0,-0.1", "--background", "1,1,1", "--projection", "orthographic")
    planes = {"clip_plane": [(1, 0, 0, -0.1)], "background": (1, 1, 1), "projection": "orthographic"}
    assert np.array_equal(picture(scan, shadows=False, **planes), expected)


def test_every_layout_and_type_gives_the_same_picture(scan) -> None:
    expected = picture(scan, clim=(0, 900))
    fortran = np.asfortranarray(scan)
    turned = np.ascontiguousarray(scan.transpose(2, 1, 0))
    strided = np.repeat(scan, 2, axis=2)[..., ::2]
    read_only = scan.copy()
    read_only.setflags(write=False)
    types = [scan.astype(kind) for kind in (">i2", np.float16, np.float32, np.float64, np.int32, ">u4", np.int64, np.uint64, ">f8")]
    for array in (fortran, strided, read_only, *types):
        assert np.abs(picture(array, clim=(0, 900)).astype(int) - expected).max() <= 1, array.dtype
    assert np.array_equal(picture(turned, order="xyz", clim=(0, 900)), expected)


def test_small_integers_and_truth_values_are_shown(scan) -> None:
    mask = scan > 500
    assert np.array_equal(picture(mask, clim=(0, 1)), picture(mask.astype(np.uint8), clim=(0, 1)))
    assert picture(mask, clim=(0, 1)).max() > 30
    assert np.array_equal(picture((scan // 8).astype(np.int8), clim=(0, 110)), picture((scan // 8).astype(np.int8).astype(np.int16), clim=(0, 110)))


def test_arrays_are_not_copied_where_their_layout_allows(scan) -> None:
    assert np.shares_memory(np.asarray(fv.as_volume(scan)), scan)
    assert not np.shares_memory(np.asarray(fv.as_volume(np.asfortranarray(scan))), scan)
    values = np.asarray(fv.as_volume(scan.astype(">i2")))
    assert values.dtype == np.dtype(">i2") and np.array_equal(values, scan)
    with pytest.raises(ValueError, match="read-only|read only"):
        np.asarray(fv.as_volume(scan))[0, 0, 0] = 1


def test_values_of_files_are_arrays(scan, tmp_path: Path) -> None:
    path = tmp_path / "scan.nrrd"
    assert fv.write(path, scan, spacing=(1, 2, 3)) == []
    volume = fv.read(path)
    assert np.array_equal(np.asarray(volume), scan)
    assert volume.spacing == [1.0, 2.0, 3.0] and volume.shape == (20, 24, 32) and volume.dtype == "i16"
    assert volume.range == [float(scan.min()), float(scan.max())] and volume.rescale == (1.0, 0.0)
    assert "scan.nrrd" in repr(volume)


def test_colours_of_voxels_need_to_be_asked_for() -> None:
    colours = np.zeros((8, 9, 10, 4), np.uint8)
    colours[..., 0] = 200
    colours[2:6, 2:6, 2:6, 3] = 255
    image = picture(colours, rgb=True)
    assert image[..., 0].max() > 50 and image[..., 1:].max() == 0
    with pytest.raises(ValueError, match="rgb=True"):
        picture(colours)


def test_masked_and_missing_values_are_transparent() -> None:
    values = np.full((8, 8, 8), 5.0, np.float32)
    values[2:4] = 0.0
    nan = np.where(values > 4.0, np.nan, values)
    for masked in (np.ma.masked_greater(values, 4.0), np.ma.masked_greater(values.astype(np.int16), 4)):
        assert np.array_equal(picture(masked, clim=(-1.0, 1.0)), picture(nan, clim=(-1.0, 1.0)))
    whole = np.ma.masked_array(values)
    assert np.array_equal(picture(whole, clim=(-1.0, 9.0)), picture(values, clim=(-1.0, 9.0)))


def test_labels_are_shown_without_interpolation() -> None:
    labels = np.zeros((12, 12, 12), np.uint8)
    labels[2:8, 2:8, 2:8], labels[5:10, 5:10, 5:10] = 1, 7
    assert np.array_equal(picture(labels), picture(labels, labels=True))
    floats = labels.astype(np.float32)
    assert np.array_equal(picture(labels, labels=True), picture(labels, interpolation="nearest"))
    assert not np.array_equal(picture(floats), picture(labels))


def test_pictures_are_saved_and_shown_by_notebooks(scan, tmp_path: Path) -> None:
    image_module = pytest.importorskip("PIL.Image")
    image = fv.Picture(picture(scan))
    assert image._repr_png_()[:4] == b"\x89PNG"
    image.save(tmp_path / "scan.png")
    assert np.array_equal(np.asarray(image_module.open(tmp_path / "scan.png")), image)
    assert image[:, :, 0]._repr_png_() is None
