"""Transfer functions from names, colour maps and lists."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._native import FovolnetError, Volume

#: Points of a transfer function that is made from a colour map.
POINTS = 64

Floats = NDArray[np.float64]


def transfer_text(volume: Volume, cmap: Any = None, opacity: Any = None) -> str:
    """The transfer function of a colour map and opacities for ``volume``, as the setting ``tf``.

    Parameters
    ----------
    volume : Volume
        Its histogram decides automatic opacities.
    cmap : str, Matplotlib colour map, array (n, 3 or 4), or callable
        A name of ``fovolnet info --transfer-functions``, a file of a transfer function, or a name of Matplotlib; or colours 0 to 1
        from the lowest to the highest shown value.
    opacity : float, str, sequence of float, or None
        A factor of the automatic opacity; ``"linear"``; the name of a transfer function that has it; or opacities of one voxel, 0 to 1,
        from the lowest to the highest shown value. None for the automatic opacity.

    Returns
    -------
    str
        A name, or JSON.
    """
    if opacity is None and cmap is None:
        return "auto"
    if opacity is None and isinstance(cmap, str) and is_known(volume, cmap):
        return cmap
    if cmap is None and isinstance(opacity, str) and opacity != "linear":
        return opacity
    places, opacities = opacities_of(volume, cmap, opacity)
    values = np.union1d(np.linspace(0.0, 1.0, POINTS), places)
    colours = colours_at(volume, values, "gray" if cmap is None and isinstance(opacity, str) else cmap)
    points = np.column_stack([values, colours[:, :3], np.interp(values, places, opacities)])
    return json.dumps({"points": points.tolist()})


def opacities_of(volume: Volume, cmap: Any, opacity: Any) -> tuple[Floats, Floats]:
    """Shown values, 0 to 1, and the opacity of a voxel at each."""
    ends = np.array([0.0, 1.0])
    if isinstance(opacity, str):
        if opacity == "linear":
            return ends, ends
        places, _, opacities = points_of(volume, opacity)
        return places, opacities
    if opacity is None or np.ndim(opacity) == 0:
        factor = 1.0 if opacity is None else float(opacity)
        if not 0.0 <= factor <= 1.0:
            raise ValueError(f"an opacity for all values is a factor from 0 to 1, not {factor}")
        own = None if cmap is None or isinstance(cmap, str) else colours_at(volume, np.linspace(0.0, 1.0, POINTS), cmap)
        if own is not None and own.shape[1] == 4 and own[:, 3].min() < 1.0:
            return np.linspace(0.0, 1.0, POINTS), factor * own[:, 3]
        places, _, opacities = points_of(volume, "auto")
        return places, factor * opacities
    given = np.asarray(opacity, dtype=float)
    if given.ndim != 1 or given.size < 2:
        raise ValueError(f"opacity is a list of two or more numbers, not of shape {given.shape}")
    return np.linspace(0.0, 1.0, given.size), given


def points_of(volume: Volume, name: str) -> tuple[Floats, Floats, Floats]:
    """Shown values, colours (n, 3) and opacities of the transfer function ``name``."""
    points = np.asarray(json.loads(volume.transfer_function(name))["points"], dtype=float)
    return points[:, 0], points[:, 1:4], points[:, 4]


def is_known(volume: Volume, name: str) -> bool:
    """Whether ``name`` is that of a transfer function, or a file of one."""
    try:
        volume.transfer_function(name)
    except FovolnetError:
        # A file that cannot be read says why; other names may be Matplotlib's.
        return "." in name
    return True


def colours_at(volume: Volume, values: Floats, cmap: str | Callable[[Floats], Any] | Sequence[Any] | None) -> Floats:
    """Colours (n, 3 or 4) of ``cmap`` at ``values``, 0 to 1; the automatic ones if it is None."""
    if cmap is None or isinstance(cmap, str):
        name = "auto" if cmap is None else {"gray": "grey"}.get(cmap, cmap)
        if is_known(volume, name):
            places, colours, _ = points_of(volume, name)
            return np.column_stack([np.interp(values, places, channel) for channel in colours.T])
        cmap = of_matplotlib(name)
    if callable(cmap):
        return np.asarray(cmap(values), dtype=float)
    given = np.asarray(cmap, dtype=float)
    if given.ndim != 2 or given.shape[0] < 2 or given.shape[1] not in (3, 4):
        raise ValueError(f"colours have the shape (2 or more, 3 or 4), not {given.shape}")
    places = np.linspace(0.0, 1.0, len(given))
    return np.column_stack([np.interp(values, places, channel) for channel in given.T])


def of_matplotlib(name: str) -> Callable[[Floats], Any]:
    """Matplotlib's colour map ``name``."""
    try:
        from matplotlib import colormaps
    except ImportError:
        raise ValueError(
            f"no transfer function is called {name!r}; `fovolnet info --transfer-functions` lists those that there are, and with "
            "Matplotlib installed its colour maps can be used, too"
        ) from None
    try:
        return colormaps[name]
    except KeyError:
        raise ValueError(
            f"neither a transfer function nor a colour map of Matplotlib is called {name!r}; `fovolnet info --transfer-functions` "
            "lists the former"
        ) from None
