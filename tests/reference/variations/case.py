"""One random file, and what it holds by the word of an outside library or of the numbers that were written."""

from dataclasses import dataclass, field

import numpy as np

TYPES = ["uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"]
UNITS = {"mm": "mm", "micron": "µm", "um": "µm", "µm": "µm", "meter": "m", "m": "m", "cm": "cm", "nm": "nm"}


@dataclass
class Case:
    """`values` is indexed by x, y, z; fields that are None are not compared, `orientation` False is none at all."""

    path: object
    values: np.ndarray
    spacing: object = None
    orientation: object = None
    origin: object = None
    units: object = None
    components: int = 1
    times: int = 1
    channels: int = 1
    is_patient: object = None
    # What is chosen: component, time, channel, array.
    chosen: dict = field(default_factory=dict)
    # How the file was made, for reports.
    how: str = ""


class Unreadable(Exception):
    """No library reads the file, and so should we not."""


def pick(rng, items):
    """One of `items`; numpy would turn them into an array."""
    return items[int(rng.integers(len(items)))]


def named(stem, ending):
    """`stem`, which may have a dot of its own, with `ending`."""
    return stem.with_name(stem.name + ending)


def chance(rng, share):
    return bool(rng.random() < share)


def sizes(rng, count=3, most=7):
    return tuple(int(n) for n in rng.integers(1, most + 1, size=count))


def voxels(rng, dtype, shape):
    """Random values; doubles hold every integer up to 2^53."""
    dtype = np.dtype(dtype)
    if dtype.kind == "f":
        return (rng.normal(size=shape) * 10.0 ** rng.integers(-2, 4)).astype(dtype)
    limits = np.iinfo(dtype)
    low, high = max(limits.min, -(2**50)), min(limits.max, 2**50)
    return rng.integers(low, high, size=shape, dtype=dtype, endpoint=True)


def spacing(rng, count=3):
    return [float(np.float32(s)) for s in np.round(rng.uniform(0.05, 9, size=count), 3)]


def directions(rng):
    """Columns of a random rotation: along the axes in any of 48 ways, or oblique, or mirrored."""
    if chance(rng, 0.4):
        axes = np.eye(3)[:, rng.permutation(3)] * rng.choice([-1.0, 1.0], size=3)
        return axes + 0.0
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return axes


def unit_columns(matrix):
    """The columns of `matrix` as directions, and their lengths."""
    lengths = np.linalg.norm(matrix, axis=0)
    return matrix / lengths, lengths
