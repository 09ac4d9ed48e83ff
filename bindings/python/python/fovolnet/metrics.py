"""Quality of pictures."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _native


def psnr(reference: Any, test: Any) -> float:
    """Peak signal-to-noise ratio in dB of two pictures (height, width, 3 or 4), uint8 or float 0 to 1."""
    return _native.psnr(floats(reference), floats(test))


def ssim(reference: Any, test: Any) -> float:
    """Structural similarity of two pictures (height, width, 3 or 4), uint8 or float 0 to 1."""
    return _native.ssim(floats(reference), floats(test))


def floats(picture: Any) -> np.ndarray:
    """``picture`` as float32, 0 to 1, in C order."""
    picture = np.asarray(picture)
    if picture.dtype == np.uint8:
        picture = picture / np.float32(255.0)
    return np.ascontiguousarray(picture, dtype=np.float32)
