"""Expected values of PSNR, SSIM, MS-SSIM and tPSNR, from scikit-image and pytorch-msssim.

    pip install numpy scikit-image torch pytorch-msssim
    python metrics.py > metrics.json

The pictures are integer formulas, so that the Rust test makes the same ones, bit by bit.
"""

import json
import math

import numpy as np
import torch
from pytorch_msssim import ms_ssim, ssim
from skimage.metrics import mean_squared_error, structural_similarity

from pattern import noise, triangle

# Width, height, size of the flaw.
CASES = [(11, 11, 8), (64, 48, 20), (97, 33, 60), (161, 163, 30), (320, 180, 12), (333, 250, 120), (256, 256, 0)]


def picture(width, height, frame, flaw):
    """RGB in [0, 1] as f32, [height, width, 3]: waves, a flat bright part, and noise of size `flaw`."""
    y, x, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij")
    y, x, c = y.astype(np.int64), x.astype(np.int64), c.astype(np.int64)
    waves = (triangle(3 * x + 2 * y + 5 * frame, 40 + 9 * c) + triangle(x * (c + 1) + 7 * frame, 23)) // 2
    base = np.where(2 * x > width + y, 250 - 3 * c, waves)
    value = base + (noise(x, y, c, frame) - 128) * flaw // 128
    return np.clip(value, 0, 255).astype(np.float32) / np.float32(255)


def tensor(image):
    return torch.from_numpy(image.astype(np.float64)).permute(2, 0, 1)[None]


def gaussian_window():
    """pytorch-msssim's window in double precision; in its own single precision SSIM is off by 1e-5."""
    offsets = torch.arange(11, dtype=torch.float64) - 5
    weights = torch.exp(-(offsets**2) / (2 * 1.5**2))
    return (weights / weights.sum()).reshape(1, 1, 1, -1).repeat(3, 1, 1, 1)


def case(width, height, flaw):
    reference = [picture(width, height, f, 0).astype(np.float64) for f in range(2)]
    test = [picture(width, height, f, flaw).astype(np.float64) for f in range(2)]
    mse = mean_squared_error(reference[0], test[0])
    a, b = tensor(reference[0]), tensor(test[0])
    options = dict(channel_axis=2, data_range=1.0)
    gaussian = structural_similarity(
        reference[0], test[0], gaussian_weights=True, sigma=1.5, use_sample_covariance=False, **options
    )
    torch_options = dict(data_range=1.0, win=gaussian_window())
    assert abs(gaussian - ssim(a, b, **torch_options).item()) < 1e-9
    return {
        "size": [width, height],
        "flaw": flaw,
        "mse": mse,
        "psnr": min(100.0, 10 * math.log10(1 / mse)) if mse > 0 else 100.0,
        "ssim_gaussian": gaussian,
        "ssim_uniform7": structural_similarity(reference[0], test[0], **options),
        "ms_ssim": ms_ssim(a, b, **torch_options).item() if min(width, height) > 160 else None,
        "temporal_mse": mean_squared_error(reference[1] - reference[0], test[1] - test[0]),
    }


if __name__ == "__main__":
    print(json.dumps([case(*c) for c in CASES], indent=1))
