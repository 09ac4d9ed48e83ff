"""Scenes: volumes, a camera, settings, and their pictures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ._native import Frame, Renderer, Volume
from .camera import Camera
from .picture import Picture
from .settings_text import settings_json
from .transfer_functions import transfer_text
from .volumes import as_volume


class Scene:
    """A volume with a camera and settings.

    Parameters
    ----------
    size : (int, int)
        Width and height of pictures in pixels.
    device : str, optional
        ``"auto"``, ``"cpu"``, ``"gpu"`` or ``"gpu:NAME"``.
    threads : int, optional
        All cores, if not given.
    **settings
        Flags of the command line with ``_`` for ``-``, such as ``shadows="cached"``, ``mode="mip"``, ``step=0.5``. ``shadows`` may be
        True or False.

    Examples
    --------
    >>> scene = Scene(size=(64, 48))
    >>> _ = scene.add_volume(read("marschner-lobb", dims=(24, 24, 24)))
    >>> scene.camera.azimuth += 30
    >>> scene.render().shape
    (48, 64, 3)
    """

    def __init__(
        self,
        size: tuple[int, int] = (1280, 720),
        *,
        device: str | None = None,
        threads: int | None = None,
        **settings: Any,
    ) -> None:
        self.size = size
        self.settings = settings
        self._device, self._threads = device, threads
        self._volume: Volume | None = None
        self._transfer: str | None = None
        self._camera: Camera | None = None
        self._renderer: Renderer | None = None
        self._given = ""

    def add_volume(
        self,
        data: Any,
        *,
        spacing: Sequence[float] | None = None,
        order: str | None = None,
        rgb: bool = False,
        clim: Sequence[float] | None = None,
        cmap: Any = None,
        opacity: Any = None,
        blending: str | None = None,
    ) -> Volume:
        """Shows a volume.

        Parameters
        ----------
        data, spacing, order, rgb, clim
            See `as_volume`.
        cmap, opacity
            Colours and opacities; see ``transfer_functions.transfer_text``.
        blending : {"composite", "mip", "minip", "average", "isosurface"}, optional

        Returns
        -------
        Volume
        """
        if self._volume is not None:
            raise ValueError("the scene has a volume; make another Scene for another one")
        self._volume = as_volume(data, spacing=spacing, order=order, rgb=rgb, clim=clim)
        self._transfer = transfer_text(cmap, opacity)
        if blending is not None:
            self.settings["mode"] = blending
        return self._volume

    @property
    def volume(self) -> Volume:
        """The volume that is shown."""
        if self._volume is None:
            raise ValueError("the scene has no volume; call add_volume")
        return self._volume

    @property
    def camera(self) -> Camera:
        """The camera. It begins with the default view, which shows the whole volume; change it as you like."""
        if self._camera is None:
            self._camera = Camera.looking(*self._prepared({}).camera())
        return self._camera

    @camera.setter
    def camera(self, camera: Camera | None) -> None:
        self._camera = camera

    @property
    def notes(self) -> list[str]:
        """Assumptions and omissions, one line each."""
        return [*self.volume.notes, *self._prepared({}).notes]

    def render(self, *, transparent: bool = False) -> Picture:
        """Renders a picture.

        Parameters
        ----------
        transparent : bool
            Opacity as a fourth channel instead of the background.

        Returns
        -------
        Picture
            uint8 of shape (height, width, 3 or 4).
        """
        frame = self.render_frame(transparent=transparent)
        return Picture(frame.image_rgba if transparent else frame.image)

    def render_frame(self, **settings: Any) -> Frame:
        """Renders one frame with everything that belongs to it. ``settings`` hold for this frame and on."""
        return self._prepared(settings).render(0)

    def frames(self, n: int, path: str | None = "turntable", **settings: Any) -> Iterator[Frame]:
        """Renders a clip, frame after frame.

        Parameters
        ----------
        n : int
            Number of frames.
        path : str or None
            ``"turntable"``, ``"orbit"``, ``"flythrough"``, or a TOML file of keyframes; None for the scene's camera.
        **settings
            Such as ``sampling="compact"`` for sparse frames that a network fills.

        Yields
        ------
        Frame
        """
        settings = {"frames": n, **settings, **({} if path is None else {"path": path})}
        renderer = self._prepared(settings, is_path=path is not None)
        renderer.reset()
        for i in range(n):
            yield renderer.render(i)

    def reference(self) -> Picture:
        """The picture with every pixel marched and exact shadows: float32 of shape (height, width, 4)."""
        return Picture(self._prepared({}).reference(0))

    def _prepared(self, settings: dict[str, Any], *, is_path: bool = False) -> Renderer:
        """The renderer for the scene as it is now."""
        all_settings = {"size": self.size, "tf": self._transfer, **self.settings, **settings}
        if isinstance(all_settings.get("shadows"), bool):
            all_settings["shadows"] = "on" if all_settings["shadows"] else "off"
        if self._camera is not None and not is_path:
            all_settings["camera"] = self._camera.as_setting()
        given = settings_json(all_settings)
        if self._renderer is None:
            self._renderer = Renderer(self.volume, given, self._device, self._threads)
        elif given != self._given:
            self._renderer.change(given)
        self._given = given
        return self._renderer
