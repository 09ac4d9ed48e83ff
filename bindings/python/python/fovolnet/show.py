"""A picture of a volume in one line."""

from __future__ import annotations

from typing import Any

from .picture import Picture
from .scene import Scene


def show(data: Any, *, size: tuple[int, int] = (800, 600), **options: Any) -> Picture:
    """Shows a volume as a picture, which notebooks display.

    Parameters
    ----------
    data : array, Volume, path, or image of another library
        See `as_volume` and `read`.
    size : (int, int)
        Width and height in pixels.
    **options
        Parameters of `Scene.add_volume`; all others are settings of the `Scene`.

    Returns
    -------
    Picture
    """
    of_volume = ("spacing", "order", "rgb", "clim", "cmap", "opacity", "blending")
    given = {name: options.pop(name) for name in of_volume if name in options}
    if isinstance(data, str) or hasattr(data, "__fspath__"):
        from .volumes import read

        data = read(data)
    scene = Scene(size=size, **options)
    scene.add_volume(data, **given)
    return scene.render()
