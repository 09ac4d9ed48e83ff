"""Scenes: volumes, a camera, settings, and their pictures."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from threading import RLock
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from . import session
from ._native import Frame, Renderer, Volume
from .camera import Camera
from .clip import write_clip
from .layer import Layer, Layers
from .picture import Picture
from .settings_text import settings_json
from .volumes import as_volume

if TYPE_CHECKING:
    from .widget import Widget

#: Colour maps of further volumes that have no colours of their own, in order.
COLOURS = ("inferno", "viridis", "cividis")

#: Settings that ask for sparse frames, or leave it to the program whether they are.
OF_SPARSE = ("sampling", "reconstruct", "weights", "random_weights", "guide", "pb", "sigma", "gaze", "density", "noise", "quality", "budget")


class Scene:
    """Volumes with a camera and settings.

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
        True or False. `Scene.settings` holds them; changes show in the next picture.

    Examples
    --------
    >>> scene = Scene(size=(64, 48))
    >>> layer = scene.add_volume("head")
    >>> scene.camera.azimuth += 30
    >>> scene.render().shape
    (48, 64, 3)
    >>> layer.cmap = "viridis"
    >>> scene.settings["shadows"] = "cached"
    >>> scene.render().save("head.png")
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
        self.settings: dict[str, Any] = settings
        self.layers = Layers()
        self._device, self._threads = device, threads
        self._camera: Camera | None = None
        self._renderer: Renderer | None = None
        self._shown: Volume | None = None
        self._shown_as: tuple[Any, ...] = ()
        self._is_closed = False
        self._lock = RLock()

    def add_volume(
        self,
        data: Any,
        *,
        spacing: Sequence[float] | None = None,
        origin: Sequence[float] | None = None,
        order: str | None = None,
        rgb: bool = False,
        labels: bool = False,
        clim: Sequence[float] | None = None,
        cmap: Any = None,
        opacity: Any = None,
        blending: str | None = None,
        name: str | None = None,
    ) -> Layer:
        """Shows a volume. Up to four are blended, on the box of the first.

        Parameters
        ----------
        data, spacing, origin, order, rgb, labels, clim
            See `as_volume`.
        cmap : str, Matplotlib colour map, array (n, 3 or 4), or callable, optional
            Colours from the lowest to the highest shown value; or the name or file of a transfer function.
        opacity : float, str, or sequence of float, optional
            A factor of the automatic opacity; the name of a transfer function such as ``"ct-bone"``; ``"linear"``; or opacities of one
            voxel, 0 to 1, from the lowest to the highest shown value.
        blending : {"composite", "mip", "minip", "average", "isosurface"}, optional
            Which values along a ray show. It holds for the whole scene.
        name : str, optional
            Name in `layers`; its number, if not given.

        Returns
        -------
        Layer
            Its attributes can be changed later.

        Raises
        ------
        ValueError
            Data that cannot be rendered, a name that is taken.
        """
        self._check_open()
        volume = as_volume(data, spacing=spacing, origin=origin, order=order, rgb=rgb, labels=labels, clim=clim, name=None)
        name = name if name is not None else f"volume {len(self.layers)}"
        if any(layer.name == name for layer in self.layers):
            raise ValueError(f"a layer is called {name!r} already; give another name, or remove that layer")
        if self.layers and cmap is None and opacity is not None and np.ndim(opacity) == 0 and not isinstance(opacity, str):
            cmap = None if volume.has_own_colours else COLOURS[(len(self.layers) - 1) % len(COLOURS)]
        layer = Layer(volume, name, cmap, opacity)
        _ = layer.transfer
        self.layers.append(layer)
        if blending is not None:
            self.settings["mode"] = blending
        return layer

    def remove(self, layer: Layer | str) -> None:
        """Removes a layer, or the layer of that name."""
        self.layers.remove(self.layers[layer] if isinstance(layer, str) else layer)

    @property
    def camera(self) -> Camera:
        """The camera. It begins with the default view, which shows the whole volume; change it as you like."""
        if self._camera is None:
            with self._lock:
                renderer, given = self._prepared({})
                self._camera = Camera.looking(*renderer.camera(given))
        return self._camera

    @camera.setter
    def camera(self, camera: Camera | None) -> None:
        self._camera = camera

    @property
    def notes(self) -> list[str]:
        """Assumptions and omissions, one line each."""
        with self._lock:
            renderer, given = self._prepared({})
            assert self._shown is not None
            return [*self._shown.notes, *renderer.notes(given)]

    @property
    def gpu(self) -> str | None:
        """Name of the GPU that renders, or None where the processor does."""
        with self._lock:
            renderer, given = self._prepared({})
            return renderer.gpu(given)

    @overload
    def render(self, *, transparent: bool = False, depth: Literal[False] = False) -> Picture: ...

    @overload
    def render(self, *, transparent: bool = False, depth: Literal[True]) -> tuple[Picture, NDArray[np.float32]]: ...

    def render(
        self, *, transparent: bool = False, depth: bool = False
    ) -> Picture | tuple[Picture, NDArray[np.float32]]:
        """Renders a picture.

        Parameters
        ----------
        transparent : bool
            Opacity as a fourth channel instead of the background.
        depth : bool
            Distances, too.

        Returns
        -------
        Picture
            uint8 of shape (height, width, 3 or 4).
        array (height, width), with ``depth``
            float32: distance of each pixel from the eye, along its ray, to where its opacity passes one half, in world units, of which
            the longest side of the volume is one. Where it never does, the mean distance of what shows; infinite where nothing shows.
        """
        with self._lock:
            renderer, given = self._prepared({"transparent": transparent})
            frame = renderer.render(given)
            image = Picture(frame.image_rgba if transparent else frame.image)
            return (image, renderer.depth(given)) if depth else image

    def render_frame(self, *, gaze: Sequence[float] | None = None, **settings: Any) -> Frame:
        """Renders one frame with everything that belongs to it.

        Parameters
        ----------
        gaze : (float, float), optional
            Where the eye looks, as fractions of the picture from its top left, for sparse frames.
        **settings
            Settings of this frame, besides those of the scene.

        Returns
        -------
        Frame
        """
        if gaze is not None:
            settings["gaze"] = gaze
        with self._lock:
            renderer, given = self._prepared(settings)
            return renderer.render(given)

    def frames(
        self, n: int = 100, path: str | os.PathLike[str] | None = "turntable", *, return_sparse: bool = False, **settings: Any
    ) -> Iterator[Frame]:
        """Renders a clip, frame after frame.

        Parameters
        ----------
        n : int
            Number of frames.
        path : str or None
            ``"turntable"``, ``"orbit"``, ``"flythrough"``, or a TOML file of keyframes; None for the camera of the scene, wherever it is
            when a frame is asked for.
        return_sparse : bool
            March few pixels, and find the motion of all. Frames then have ``sparse``, ``mask`` and ``motion``.
        **settings
            Settings of the clip, such as ``sampling="sparse"`` for few pixels, from which a network makes the frame. Every pixel is
            marched, if neither these nor `Scene.settings` say otherwise. ``first_frame`` is the number of the first frame, and ``frames``
            the length of the path, if it is not ``n``: ``frames(10, frames=100, first_frame=40)`` is a part of ``frames(100)``.

        Yields
        ------
        Frame
        """
        if return_sparse:
            settings.setdefault("sampling", "sparse")
        along = {} if path is None else {"path": os.fspath(path)}
        first = int(settings.get("first_frame", self.settings.get("first_frame")) or 0)
        for i in range(n):
            with self._lock:
                renderer, given = self._prepared({"frames": n, **self._of_clips(settings), **along}, is_path=path is not None)
                if i == 0:
                    renderer.reset()
                frame = renderer.render(given, first + i, return_sparse)
            yield frame

    def turntable(
        self,
        path: str | os.PathLike[str],
        *,
        seconds: float = 8.0,
        fps: float = 30.0,
        turn: float = 360.0,
        progress: Callable[[int, int], object] | None = None,
        **settings: Any,
    ) -> str:
        """Writes a clip in which the volume turns once.

        The camera goes round the target from where `camera` is.

        Parameters
        ----------
        path : path
            The extension chooses the format: .mp4, .gif, .webm and others where ffmpeg is installed, and .y4m everywhere.
        seconds, fps : float
            Length, and frames a second.
        turn : float
            Degrees.
        progress : callable, optional
            It is called after each frame, with the number of frames so far and of all.
        **settings
            Settings of the clip, such as ``sampling="sparse"`` for few pixels, from which a network makes the frame.

        Returns
        -------
        str
            The file: ``path``, or with ``.y4m`` added where ffmpeg is needed and not installed.
        """
        n = max(1, round(seconds * fps))
        return write_clip(path, self._turning(n, turn, settings), fps=fps, progress=progress, n=n)

    def _turning(self, n: int, turn: float, settings: dict[str, Any]) -> Iterator[Frame]:
        """Frames from around the target."""
        camera = self.camera
        for i in range(n):
            view = camera.turned(turn * i / n)
            with self._lock:
                renderer, given = self._prepared({"frames": n, **self._of_clips(settings), "camera": view.as_setting()})
                if i == 0:
                    renderer.reset()
                frame = renderer.render(given, i)
            yield frame

    def reference(self) -> NDArray[np.float32]:
        """The picture with every pixel marched and exact shadows: float32 of shape (height, width, 4), 0 to 1."""
        with self._lock:
            renderer, given = self._prepared({})
            return renderer.reference(given)

    def widget(self, *, budget: float = 80.0) -> Widget:
        """An interactive picture for notebooks, turned by the mouse; see `fovolnet.widget.Widget`.

        Parameters
        ----------
        budget : float
            Milliseconds from picture to picture while it moves.

        Raises
        ------
        ImportError
            ``pip install fovolnet[notebook]`` is needed.
        """
        from .widget import Widget

        return Widget(self, budget=budget)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a session file, which the command line, the viewer and `load` open.

        Volumes must come from files, see `read`.
        """
        self._check_open()
        session.write(path, self.layers, self._settings({}))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, device: str | None = None, threads: int | None = None) -> Scene:
        """The scene of a session file, which the command line, the viewer or `save` wrote."""
        layer, settings = session.read(path)
        camera, size = settings.pop("camera", None), settings.pop("size", (1280, 720))
        scene = cls(size=(int(size[0]), int(size[1])), device=device, threads=threads, **settings)
        scene.layers.append(layer)
        if camera is not None:
            scene.camera = Camera.looking(camera[:3], camera[3:6], camera[6])
        return scene

    def close(self) -> None:
        """Frees memory and threads. The scene cannot be used then."""
        with self._lock:
            self.layers.clear()
            self._renderer, self._shown, self._is_closed = None, None, True

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _check_open(self) -> None:
        if self._is_closed:
            raise ValueError("the scene is closed; make another one")

    def _visible(self) -> list[Layer]:
        self._check_open()
        if not self.layers:
            raise ValueError("the scene has no volume; call add_volume")
        visible = [layer for layer in self.layers if layer.visible]
        if not visible:
            raise ValueError("no layer of the scene is visible; set visible of one to True")
        return visible

    def _of_clips(self, settings: dict[str, Any]) -> dict[str, Any]:
        """Settings of a clip: every pixel is marched, unless something asks for sparse frames."""
        if any(name in given for name in OF_SPARSE for given in (settings, self.settings)):
            return settings
        return {"sampling": "full", **settings}

    def _settings(self, settings: dict[str, Any], *, is_path: bool = False) -> dict[str, Any]:
        """All settings with names of Python."""
        given = {"size": self.size, "tf": self._visible()[0].transfer, **self.settings}
        if self._camera is not None and not is_path:
            given["camera"] = self._camera.as_setting()
        given |= settings
        if isinstance(given.get("shadows"), bool):
            given["shadows"] = "on" if given["shadows"] else "off"
        if given.get("sampling") == "sparse":
            given["sampling"] = "compact"
        return given

    def _prepared(self, settings: dict[str, Any], *, is_path: bool = False) -> tuple[Renderer, str]:
        """The renderer of the volumes that are visible now, and all settings."""
        first, *others = self._visible()
        given = settings_json(self._settings(settings, is_path=is_path))
        shown_as = (first.volume, *((other.volume, other.transfer) for other in others))
        if self._renderer is None or shown_as != self._shown_as:
            volume = first.volume
            for other in others:
                volume = volume.with_layer(other.volume, other.transfer)
            if self._renderer is None:
                self._renderer = Renderer(volume, self._device, self._threads)
            else:
                self._renderer.show(volume)
            self._shown, self._shown_as = volume, shown_as
        return self._renderer, given
