#!/usr/bin/env python3
"""The spectra of our spatio-temporal blue noise beside NVIDIA's tiles, computed by NumPy.

    pip install numpy pillow matplotlib
    cargo build --release
    python benchmarks/noise/spectra.py FOLDER    # the 64 stbn_scalar_2Dx1Dx1D_128x128x64x1_*.png

Writes docs/figures/stbn_spectra.png and benchmarks/results/stbn_spectra.json. Power is normalised so that
white noise has 1. NVIDIA's tiles have 8 bits, ours 20.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[2]
FIGURE = REPOSITORY / "docs/figures/stbn_spectra.png"
JSON = REPOSITORY / "benchmarks/results/stbn_spectra.json"


def ours():
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "stbn.npy"
        program = REPOSITORY / "target/release/fovolnet"
        subprocess.run([program, "noise", "make", "--size", "128", "--frames", "64", path], check=True)
        ranks = np.load(path).astype(np.int64)
    assert np.array_equal(np.sort(ranks.ravel()), np.arange(ranks.size)), "ranks are no permutation"
    return (ranks + 0.5) / ranks.size


def theirs(folder):
    files = sorted(folder.glob("stbn_scalar_*.png"), key=lambda path: int(path.stem.rsplit("_", 1)[1]))
    return np.stack([(np.asarray(Image.open(file).convert("L"), float) + 0.5) / 256 for file in files])


def spatial(values):
    """Power over x and y, mean of all slices."""
    centred = values - values.mean(axis=(1, 2), keepdims=True)
    power = np.abs(np.fft.fft2(centred)) ** 2 / values[0].size / values.var()
    return np.fft.fftshift(power.mean(axis=0))


def temporal(values):
    """Power over t, mean of all pixels."""
    centred = values - values.mean()
    power = np.abs(np.fft.rfft(centred, axis=0)) ** 2 / len(values) / values.var()
    return power.mean(axis=(1, 2))


def radial(power, bins=64):
    size = power.shape[0]
    frequency = np.fft.fftshift(np.fft.fftfreq(size))
    f = np.hypot(*np.meshgrid(frequency, frequency)).ravel()
    which = np.digitize(f, np.linspace(0, 0.5, bins + 1)) - 1
    keep = which < bins
    total = np.bincount(which[keep], power.ravel()[keep], bins)
    return total / np.maximum(np.bincount(which[keep], minlength=bins), 1)


def masks(values, densities=(0.01, 0.03, 0.07, 0.1)):
    """Of thresholded slices: the spread of their density, and power below half the mean frequency of samples."""
    found = {}
    for density in densities:
        mask = (values < density).astype(float)
        power = spatial(mask)
        frequency = np.fft.fftshift(np.fft.fftfreq(values.shape[1]))
        f = np.hypot(*np.meshgrid(frequency, frequency))
        low = (f > 0) & (f < 0.5 * np.sqrt(density))
        found[str(density)] = {
            "largest_error_of_density": float(np.abs(mask.mean(axis=(1, 2)) - density).max()),
            "low_frequency_power": float(power[low].mean()),
            "coverage_after_8_frames": float(mask[:8].max(axis=0).mean()),
        }
    return found


def band(curve, low, high):
    f = (np.arange(len(curve)) + 0.5) / len(curve) * 0.5
    return float(curve[(f >= low) & (f < high)].mean())


def figures(values):
    curve, over_time = radial(spatial(values)), temporal(values)
    return {
        "slices": len(values),
        "radial_power": {f"{a}-{b}": band(curve, a, b) for a, b in [(0, 0.06), (0.06, 0.12), (0.12, 0.2), (0.2, 0.3), (0.3, 0.5)]},
        "temporal_power_k1_to_k8": [float(p) for p in over_time[1:9]],
        "temporal_power_highest_quarter": float(over_time[-len(over_time) // 4 :].mean()),
        "temporal_mean_sd": float(values.mean(axis=0).std()),
        "slice_mean_sd": float(values.mean(axis=(1, 2)).std()),
        "masks": masks(values),
    }


def draw(all_values):
    figure, axes = plt.subplots(2, 4, figsize=(14, 7), layout="constrained")
    for row, (name, values) in enumerate(all_values.items()):
        axes[row, 0].imshow(values[0], cmap="gray", vmin=0, vmax=1)
        axes[row, 0].set_title(f"{name}: slice 0")
        axes[row, 1].imshow(values[0] < 0.1, cmap="gray")
        axes[row, 1].set_title("values below 0.1")
        axes[row, 2].imshow(spatial(values), cmap="gray", vmin=0, vmax=2)
        axes[row, 2].set_title("power over x, y (white = 1)")
        for axis in axes[row, :3]:
            axis.set_xticks([])
            axis.set_yticks([])
        axes[0, 3].plot((np.arange(64) + 0.5) / 128, radial(spatial(values)), label=name)
        over_time = temporal(values)
        axes[1, 3].plot(np.arange(len(over_time)) / len(values), over_time, label=name)
    axes[0, 3].set_title("radial mean over x, y")
    axes[1, 3].set_title("over t")
    for axis in axes[:, 3]:
        axis.axhline(1, color="0.8", zorder=0)
        axis.set_xlabel("cycles per pixel" if axis is axes[0, 3] else "cycles per frame")
        axis.legend()
    FIGURE.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(FIGURE, dpi=80)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    all_values = {"ours": ours(), "NVIDIA": theirs(Path(sys.argv[1]))}
    draw(all_values)
    JSON.parent.mkdir(parents=True, exist_ok=True)
    JSON.write_text(json.dumps({name: figures(values) for name, values in all_values.items()}, indent=1) + "\n")
    print(JSON.read_text())


if __name__ == "__main__":
    main()
