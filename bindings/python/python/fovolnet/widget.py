"""A scene in a notebook, turned by the mouse."""

from __future__ import annotations

import base64
import sys
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import traitlets

from . import orbit
from ._native import FrameProducer, Volume
from .camera import Camera
from .live_view import LiveView, Request
from .picture import Picture, png
from .scene import Scene
from .settings_text import settings_json

try:
    import anywidget
except ImportError as error:
    raise ImportError("the interactive widget needs anywidget; pip install fovolnet[notebook], and restart the kernel") from error

#: Seconds that the first picture may take before the notebook goes on.
FIRST_PICTURE = 4.0
#: Largest width and height, and most pixels, of pictures for browsers.
LONGEST_SIDE, MOST_PIXELS = 4096, 4_000_000


class Widget(anywidget.AnyWidget):
    """A scene that the mouse turns. Pictures are rendered by the kernel and shown in the browser.

    Drag turns the view. Drag with the right button, or with Shift, moves it. The wheel comes nearer. A double click goes back to
    the default view. Two fingers zoom and move. With the keyboard: arrows turn, Shift and arrows move, + and − zoom, 0 goes
    back. The lower right corner changes the size.

    While the view moves, a planner chooses how frames are made so that they keep ``budget``. A view that rests becomes the full
    frame with exact shadows.

    Parameters
    ----------
    scene : Scene
        Its camera follows the mouse. Changes of its camera and settings show at the end of the cell, or by `update`.
    budget : float
        Milliseconds from picture to picture in motion.

    Notes
    -----
    Kernels run one cell at a time. While a cell runs, JupyterLab 4.4 with ipykernel 7 or newer still hears the mouse. Others
    hear it when the cell has ended.

    The saved notebook has the first picture. With the widget's state saved, it has the last one.

    Examples
    --------
    >>> scene = Scene(size=(640, 480))  # doctest: +SKIP
    >>> scene.add_volume(read("head", dims=(128, 128, 128)))  # doctest: +SKIP
    >>> scene.widget()  # doctest: +SKIP
    """

    _esm = Path(__file__).parent / "widget.js"
    _css = Path(__file__).parent / "widget.css"

    #: Width and height in CSS pixels before the corner is dragged.
    _size = traitlets.List(traitlets.Int(), [640, 480]).tag(sync=True)
    #: The last full frame, as PNG or JPEG: shown where no kernel runs.
    _still = traitlets.Bytes(b"").tag(sync=True)
    #: Description for screen readers.
    _label = traitlets.Unicode("").tag(sync=True)

    def __init__(self, scene: Scene, *, budget: float = 80.0) -> None:
        z, y, x = scene._visible()[0].volume.shape[:3]
        label = f"Volume of {x} by {y} by {z} voxels. Drag or press arrow keys to turn, plus and minus to zoom, 0 for the default view."
        super().__init__(_size=[int(side) for side in scene.size], _label=label)
        self.scene = scene
        self._pixels = (int(scene.size[0]), int(scene.size[1]))
        self._gaze = (0.5, 0.5)
        self._held = False
        self._heard: dict[str, int] = {}
        self._blended: tuple[tuple[Any, ...], Volume] | None = None
        self._live = LiveView(self.send, self._keep, device=scene._device, threads=scene._threads)
        self.budget = budget
        self.on_msg(self._receive)
        self._stop_following = follow_cells(self)

    @property
    def budget(self) -> float:
        """Milliseconds from picture to picture in motion."""
        return self._live.interval_ms

    @budget.setter
    def budget(self, milliseconds: float) -> None:
        if not 0.0 < milliseconds < float("inf"):
            raise ValueError(f"a budget of {milliseconds} ms is no time for a frame; give a number above 0")
        self._live.interval_ms = float(milliseconds)

    def update(self) -> None:
        """Shows the camera and settings that the scene has now. Cells do so when they end.

        Raises
        ------
        FovolnetError
            A setting is invalid.
        """
        FrameProducer.check(self._volume(), self._settings())
        self._want()

    def picture(self, timeout: float = 60.0) -> Picture | None:
        """The full frame of the view as it is now, at the size in the browser.

        Parameters
        ----------
        timeout : float
            Seconds to wait for it. Then the last full frame is returned.

        Returns
        -------
        Picture or None
            uint8 of shape (height, width, 3).
        """
        self.update()
        image = self._live.picture(timeout)
        return None if image is None else Picture(image)

    def close(self) -> None:
        """Ends rendering, frees its memory and removes the widget from the notebook."""
        # The constructor of the base class may fail before these exist.
        if hasattr(self, "_stop_following"):
            self._stop_following()
            self._live.close()
        super().close()

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        image = self.picture(FIRST_PICTURE)
        bundle = super()._repr_mimebundle_(**kwargs)
        if bundle is None or image is None:
            return bundle
        data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
        height, width = image.shape[:2]
        picture = {"image/png": base64.b64encode(png(image)).decode(), "text/plain": f"<fovolnet.Widget {width}x{height}>"}
        return {**data, **picture}, metadata

    def _want(self, *, again: bool = False) -> bool:
        """Asks for pictures of the scene as it is now. Returns whether a new one will be sent."""
        camera = self._camera()
        request = Request(
            volume=self._volume(),
            settings=self._settings(),
            camera=([float(c) for c in camera.eye], [float(c) for c in camera.target], float(camera.fovy)),
            size=self._pixels,
            gaze=self._gaze,
            held=self._held,
            heard=tuple(self._heard.items()),
        )
        return self._live.want(request, again=again)

    def _settings(self, **others: Any) -> str:
        """Settings of the scene without camera and size, which requests have."""
        return settings_json({**self.scene._settings({}), "camera": None, "size": None, **others})

    def _volume(self) -> Volume:
        """The volume of the scene with its further layers."""
        first, *others = self.scene._visible()
        layers = (first.volume, *((other.volume, other.transfer) for other in others))
        if self._blended is None or self._blended[0] != layers:
            volume = first.volume
            for other in others:
                volume = volume.with_layer(other.volume, other.transfer)
            self._blended = (layers, volume)
        return self._blended[1]

    def _camera(self) -> Camera:
        """The camera of the scene. It begins with the default view."""
        if self.scene._camera is None:
            # The scene would open a renderer of its own to find it.
            found = FrameProducer.default_camera(self._volume(), self._settings(size=self._pixels))
            self.scene.camera = Camera.looking(*found)
        return self.scene.camera

    def _keep(self, still: bytes) -> None:
        self._still = still

    def _receive(self, _: Any, message: dict[str, Any], buffers: list[Any]) -> None:
        """Takes a message of a browser. Errors go there, since no cell would show them."""
        self._live.answer_here()
        try:
            self._take(message)
        except Exception as error:
            self.send({"kind": "error", "text": " ".join(str(error).split()), "heard": dict(self._heard)})

    def _take(self, message: dict[str, Any]) -> None:
        kind, view = message["kind"], message["view"]
        if kind == "drawn":
            self._live.drawn(message["number"], view, message["page"])
        elif kind in ("open", "size"):
            if kind == "open":
                self._live.opened(view, message["page"])
            self._pixels = fitting(message["width"], message["height"])
            self._want(again=kind == "open")
        elif kind == "gaze":
            self._live.look_at(self._looked_at(message))
        elif kind == "input":
            self._looked_at(message)
            self._held = bool(message["held"])
            self._heard[view] = message["number"]
            self._move(message)
            if not self._want():
                self.send({"kind": "heard", "heard": dict(self._heard)})
        elif kind == "shut":
            self._heard.pop(view, None)
            self._live.shut(view)

    def _looked_at(self, message: dict[str, Any]) -> tuple[float, float]:
        x, y = message["gaze"]
        self._gaze = (min(max(float(x), 0.0), 1.0), min(max(float(y), 0.0), 1.0))
        return self._gaze

    def _move(self, message: dict[str, Any]) -> None:
        """Moves the camera of the scene."""
        if message.get("home"):
            self.scene.camera = None
        camera = self._camera()
        if "turn" in message:
            orbit.turn(camera, *message["turn"])
        if "pan" in message:
            orbit.pan(camera, *message["pan"])
        if "zoom" in message:
            orbit.zoom(camera, *message["zoom"])


def fitting(width: float, height: float) -> tuple[int, int]:
    """The size of pictures for ``width`` by ``height`` pixels of a browser."""
    scale = min(1.0, LONGEST_SIDE / max(width, height, 1.0), float(np.sqrt(MOST_PIXELS / max(width * height, 1.0))))
    return max(1, round(width * scale)), max(1, round(height * scale))


def follow_cells(widget: Widget) -> Any:
    """Updates ``widget`` after every cell. Returns what ends that."""
    try:
        from IPython import get_ipython
    except ImportError:
        return lambda: None
    shell = get_ipython()
    if shell is None:
        return lambda: None
    known = weakref.ref(widget)
    said = ""

    def after_cell(*_: Any) -> None:
        nonlocal said
        alive = known()
        if alive is None or not alive._live.is_running:
            return
        if alive.scene._is_closed:
            alive._live.close()
            return
        try:
            alive.update()
            said = ""
        except ValueError as error:
            text = f"{type(error).__name__}: {error}"
            # It belongs to the cell, which has ended already. Later cells need not hear it again.
            if text != said:
                print(text, file=sys.stderr)
            said = text

    shell.events.register("post_run_cell", after_cell)

    def stop() -> None:
        if after_cell in shell.events.callbacks["post_run_cell"]:
            shell.events.unregister("post_run_cell", after_cell)

    return stop
