"""Transfer functions from names, colour maps and lists."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

#: Points of a transfer function that is made from a colour map.
POINTS = 64


def transfer_text(cmap: Any = None, opacity: Any = None) -> str | None:
    """The transfer function of a colour map and opacities, as the setting ``tf``.

    Parameters
    ----------
    cmap : str, Matplotlib colour map, array (n, 3 or 4), or callable
        A name of ``fovolnet info --transfer-functions`` or of Matplotlib; colours 0 to 1 from the lowest to the highest shown
        value.
    opacity : str, sequence of float, or None
        ``"linear"``; opacities of one voxel, 0 to 1, from the lowest to the highest shown value; or the name of a transfer function.

    Returns
    -------
    str or None
        None for the automatic transfer function.
    """
    if opacity is None and (cmap is None or isinstance(cmap, str)):
        return cmap
    if isinstance(opacity, str) and opacity != "linear":
        if cmap is not None:
            raise ValueError(f"opacity={opacity!r} names a whole transfer function; leave out cmap, or give opacities as numbers")
        return opacity
    values = np.linspace(0.0, 1.0, POINTS)
    colours = colours_at(values, cmap if cmap is not None else "gray")
    if opacity is None or isinstance(opacity, str):
        opacities = values if colours.shape[1] == 3 or opacity == "linear" else colours[:, 3]
    else:
        given = np.asarray(opacity, dtype=float)
        if given.ndim != 1 or given.size < 2:
            raise ValueError(f"opacity is a list of two or more numbers, not of shape {given.shape}")
        opacities = np.interp(values, np.linspace(0.0, 1.0, given.size), given)
    points = np.column_stack([values, colours[:, :3], opacities])
    return json.dumps({"points": points.tolist()})


def colours_at(values: np.ndarray, cmap: str | Callable[[np.ndarray], Any] | Sequence[Any]) -> np.ndarray:
    """Colours (n, 3 or 4) of ``cmap`` at ``values``, 0 to 1."""
    if isinstance(cmap, str):
        try:
            from matplotlib import colormaps
        except ImportError:
            raise ValueError(
                f"opacities for the colour map {cmap!r} need Matplotlib; install it, or give colours as an array"
            ) from None
        cmap = colormaps[cmap]
    if callable(cmap):
        return np.asarray(cmap(values), dtype=float)
    colours = np.asarray(cmap, dtype=float)
    if colours.ndim != 2 or colours.shape[0] < 2 or colours.shape[1] not in (3, 4):
        raise ValueError(f"colours have the shape (2 or more, 3 or 4), not {colours.shape}")
    places = np.linspace(0.0, 1.0, len(colours))
    return np.column_stack([np.interp(values, places, channel) for channel in colours.T])
