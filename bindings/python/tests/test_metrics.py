"""Metrics and reconstruction beside NumPy, and networks for other programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_pictures import picture

import fovolnet as fv


def test_metrics_of_equal_and_noisy_pictures(scan) -> None:
    image = picture(scan)
    assert fv.metrics.psnr(image, image) == 100.0 and fv.metrics.ssim(image, image) == pytest.approx(1.0)
    noisy = np.clip(image + np.random.default_rng(1).integers(0, 9, image.shape), 0, 255).astype(np.uint8)
    expected = -10 * np.log10(np.mean((noisy / 255.0 - image / 255.0) ** 2))
    assert fv.metrics.psnr(image, noisy) == pytest.approx(expected, abs=1e-3)
    assert fv.metrics.psnr(image / 255.0, noisy / 255.0) == pytest.approx(expected, abs=1e-3)
    large = np.kron(image, np.ones((4, 4, 1), np.uint8))
    assert fv.metrics.ms_ssim(large, large) == pytest.approx(1.0)
    with pytest.raises(ValueError, match="uint8, or float"):
        fv.metrics.psnr(image.astype(int), image)


def test_temporal_psnr_is_that_of_changes(scan) -> None:
    generator = np.random.default_rng(2)
    reference = generator.random((3, 8, 8, 3)).astype(np.float32)
    test = np.clip(reference + 0.02 * generator.standard_normal(reference.shape), 0, 1).astype(np.float32)
    change = [(test[i] - test[i - 1]) - (reference[i] - reference[i - 1]) for i in (1, 2)]
    expected = -10 * np.log10(np.mean([np.mean(delta**2) for delta in change]))
    assert fv.metrics.tpsnr(reference, test) == pytest.approx(expected, abs=1e-2)


def test_jod_of_clips_and_pictures(scan) -> None:
    scene = fv.Scene(size=(192, 128), device="cpu")
    scene.add_volume(scan)
    clip = np.stack([frame.image for frame in scene.frames(4)])
    worse = np.clip(clip.astype(int) + 25 * (np.arange(192) % 8 < 4)[:, None], 0, 255).astype(np.uint8)
    for metric in ("fvvdp", "cvvdp"):
        assert fv.metrics.jod(clip, clip, metric=metric) == pytest.approx(10.0)
        assert fv.metrics.jod(clip, worse, metric=metric) < 9.5
        assert fv.metrics.jod(clip[0], worse[0], metric=metric) < 9.5
    assert fv.metrics.jod(clip, worse, gaze=(0.5, 0.5)) != fv.metrics.jod(clip, worse)
    with pytest.raises(ValueError, match="no gaze"):
        fv.metrics.jod(clip, worse, gaze=(0.5, 0.5), metric="cvvdp")
    with pytest.raises(ValueError):
        fv.metrics.jod(clip, worse[:2])
    with pytest.raises(ValueError, match="display|standard"):
        fv.metrics.jod(clip, worse, display="wall")


def test_sparse_frames_of_others_are_filled(scan) -> None:
    scene = fv.Scene(size=(96, 64), device="cpu")
    scene.add_volume(scan)
    full = scene.render() / np.float32(255.0)
    mask = np.random.default_rng(0).random((64, 96)) < 0.3
    for weights in ("wnet-fast", "linear"):
        filled = fv.Reconstructor(weights)(full, mask)
        assert filled.shape == (64, 96, 3) and filled.dtype == np.float32
        assert fv.metrics.psnr(full, filled) > 25.0, weights
    exact, coarse = (fv.Reconstructor("wnet-fast", precision=precision)(full, mask) for precision in ("f32", "int8"))
    assert fv.metrics.psnr(exact, coarse) > 30.0 and not np.array_equal(exact, coarse)
    with pytest.raises(ValueError, match="precision"):
        fv.Reconstructor("wnet-fast", precision="exact")(full, mask)


def test_networks_are_written_for_other_programs(tmp_path: Path) -> None:
    arrays = fv.load_weights("wnet-fast")
    assert all(array.dtype == np.float32 for array in arrays.values()) and sum(array.size for array in arrays.values()) > 10_000
    fv.save_weights(tmp_path / "w.safetensors")
    again = fv.load_weights(tmp_path / "w.safetensors")
    assert all(np.array_equal(array, again[name]) for name, array in arrays.items()) and len(again) == len(arrays)
    multiple = fv.export_onnx(tmp_path / "w.onnx")
    assert multiple >= 2 and (tmp_path / "w.onnx").stat().st_size > 4 * sum(array.size for array in arrays.values()) // 2
    safetensors = pytest.importorskip("safetensors.numpy")
    theirs = safetensors.load_file(tmp_path / "w.safetensors")
    assert all(np.array_equal(array, theirs[name]) for name, array in arrays.items())
    onnxruntime = pytest.importorskip("onnxruntime")
    assert onnxruntime.InferenceSession(str(tmp_path / "w.onnx")).get_inputs()
