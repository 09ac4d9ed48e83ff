"""A picture of a volume in one line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .notebook import has_widgets
from .picture import Picture
from .scene import Scene

if TYPE_CHECKING:
    from .widget import Widget

#: Parameters of `Scene.add_volume`.
OF_VOLUME = ("spacing", "origin", "order", "rgb", "labels", "clim", "cmap", "opacity", "blending", "name")


def show(
    data: Any, *, size: tuple[int, int] = (800, 600), interactive: bool | None = None, **options: Any
) -> Picture | Widget:
    """Shows a volume: in notebooks as a widget that the mouse turns, elsewhere as a picture.

    Parameters
    ----------
    data : array, Volume, path, or image of another library
        See `as_volume` and `read`.
    size : (int, int)
        Width and height in pixels.
    interactive : bool, optional
        Whether to make a widget. If not given, notebooks do where anywidget is installed: ``pip install fovolnet[notebook]``.
    **options
        Parameters of `Scene.add_volume`; all others are settings of the `Scene`.

    Returns
    -------
    Picture or Widget
    """
    given = {name: options.pop(name) for name in OF_VOLUME if name in options}
    if has_widgets() if interactive is None else interactive:
        live = Scene(size=size, **options)
        live.add_volume(data, **given)
        return live.widget()
    with Scene(size=size, **options) as scene:
        scene.add_volume(data, **given)
        return scene.render()
