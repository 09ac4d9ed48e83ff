"""Integer formulas of pictures. `../pattern/mod.rs` has the same."""

import numpy as np


def triangle(t, period):
    """A triangle wave 0…255 of integers."""
    t = t % (2 * period)
    return np.minimum(t, 2 * period - t) * 255 // period


def noise(x, y, c, frame):
    """A hash of the pixel, 0…255."""
    h = (x * 374761393 + y * 668265263 + c * 2246822519 + frame * 3266489917) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    return (h ^ (h >> 16)) & 255
