"""Clips of integer formulas with flaws. `../clips/mod.rs` makes the same ones, bit by bit."""

import itertools

import numpy as np

from pattern import noise, triangle


def scene(width, height, frame, shift):
    """Values 0…255, [height, width, 3]: moving waves and a disc."""
    y, x, c = (v.astype(np.int64) for v in np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij"))
    x = x + shift
    waves = (triangle(3 * x + 2 * y + 5 * frame, 40 + 9 * c) + triangle(x * (c + 1) + 7 * frame, 23)) // 2
    disc = (x - width // 3 - 2 * frame) ** 2 + (y - height // 2) ** 2 < (height // 3) ** 2
    return np.where(disc, 200 - 60 * c, waves)


def blurred(values, radius):
    """Means over squares, with repeated edges, rounded."""
    height, width, _ = values.shape
    padded = np.pad(values, ((radius, radius), (radius, radius), (0, 0)), mode="edge")
    side = 2 * radius + 1
    total = sum(padded[i : i + height, j : j + width] for i, j in itertools.product(range(side), range(side)))
    return (total + side * side // 2) // (side * side)


def picture(width, height, frame, flaw, size):
    """A frame, as f32 in [0, 1]."""
    values = scene(width, height, frame, size if flaw == "shift" else 0)
    if flaw == "noise":
        y, x, c = (v.astype(np.int64) for v in np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij"))
        values = values + (noise(x, y, c, frame) - 128) * size // 128
    elif flaw == "blur":
        values = blurred(values, size)
    elif flaw == "brighter" or flaw == "flicker" and frame % 2 == 1:
        values = values + size
    elif flaw == "tint":
        values = values + size * (1 - np.arange(3))
    return np.clip(values, 0, 255).astype(np.float32) / np.float32(255)
