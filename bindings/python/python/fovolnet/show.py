"""A picture of a volume in one line."""

from __future__ import annotations

from typing import Any

from .picture import Picture
from .scene import Scene

#: Parameters of `Scene.add_volume`.
OF_VOLUME = ("spacing", "origin", "order", "rgb", "labels", "clim", "cmap", "opacity", "blending", "name")


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
    given = {name: options.pop(name) for name in OF_VOLUME if name in options}
    with Scene(size=size, **options) as scene:
        scene.add_volume(data, **given)
        return scene.render()
