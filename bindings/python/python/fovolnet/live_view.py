"""Pictures of a view that moves and rests, made on a thread of their own."""

from __future__ import annotations

import contextvars
import threading
import time
import weakref
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ._native import FrameProducer, Volume

#: Milliseconds from picture to picture while a view moves.
INTERVAL_MS = 80.0
#: Least milliseconds of a frame itself.
LEAST_MS = 15.0
#: Milliseconds of refinement between two looks for new input.
PIECE_MS = 60.0
#: Seconds without input after which a view rests; with a button held down.
REST, REST_HELD = 0.12, 0.4
#: Frames that may be under way to the browser.
IN_FLIGHT = 2
#: Seconds after which a frame counts as arrived. Browsers cannot answer while a cell runs.
LOST = 0.5
#: Seconds without any browser after which the thread ends and its memory is freed.
IDLE = 20.0
#: Seconds after which the full frame of a resting view is kept for the saved notebook.
KEPT = 1.0
#: Smoothed seconds from sending to drawing above which a connection is slow.
SLOW = 0.15
#: Bytes up to which a picture is sent as it is, and up to which PNG is preferred to JPEG on a quick connection.
RAW_BYTES, PNG_BYTES = 32 << 10, 160 << 10
#: Bytes up to which a full frame is sent without loss.
STILL_BYTES = 2 << 20
QUALITY, STILL_QUALITY = 82, 95
#: Weight of the last value in moving averages.
NEW = 0.3


#: All live views of this process.
ALL: weakref.WeakSet[LiveView] = weakref.WeakSet()


@dataclass(frozen=True)
class Request:
    """A view that is asked for.

    Attributes
    ----------
    settings : str
        JSON with the names of the command line's flags.
    camera : tuple
        Eye, target, and vertical field of view in degrees.
    size : (int, int)
        Width and height in pixels.
    gaze : (float, float)
        Place of the picture, 0 to 1 from its top left.
    held : bool
        Whether a button is held down.
    heard : dict
        Number of the last input of each browser view that this request follows.
    """

    volume: Volume
    settings: str
    camera: tuple[list[float], list[float], float]
    size: tuple[int, int]
    gaze: tuple[float, float] = (0.5, 0.5)
    held: bool = False
    heard: tuple[tuple[str, int], ...] = ()

    def shows_as(self, other: Request | None) -> bool:
        """Whether both have the same full frame."""
        return (
            other is not None
            and self.volume is other.volume
            and (self.settings, self.camera, self.size) == (other.settings, other.camera, other.size)
        )


class LiveView:
    """Makes the pictures of the newest request: quick ones while it changes, then the full frame piece by piece.

    Parameters
    ----------
    send : callable (dict, list of bytes)
        Takes messages for the browser, on the thread of this view.
    keep : callable (bytes)
        Takes full frames as files, some time after the view rests, on the same thread.
    device, threads
        See `Scene`.
    """

    def __init__(
        self,
        send: Callable[[dict[str, Any], list[bytes]], None],
        keep: Callable[[bytes], None],
        *,
        device: str | None = None,
        threads: int | None = None,
    ) -> None:
        self._send, self._keep = send, keep
        self._within = contextvars.copy_context()
        self._device, self._threads = device, threads
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None
        self._wanted: Request | None = None
        self._is_new = False
        self._closed = False
        self._last_input = 0.0
        #: Views in browsers, and the page of each.
        self._watchers: dict[str, str] = {}
        self._in_flight: dict[int, float] = {}
        self._number = 0
        self._arrival = 0.0
        self._png_share = 0.1
        self._encode_ms = 0.0
        self._picture: np.ndarray | None = None
        self._share = 0.0
        #: The last full frame as a file, until it is kept.
        self._unkept: bytes | None = None
        self._error: Exception | None = None
        #: Milliseconds from picture to picture in motion.
        self.interval_ms = INTERVAL_MS
        ALL.add(self)

    # What browsers and Python say, on any thread.

    def answer_here(self) -> None:
        """Sends messages as answers to the one that is handled now. Kernels with subshells deliver the browser's next message
        where the last answer came from; without this they would wait for a running cell."""
        self._within = contextvars.copy_context()

    def want(self, request: Request, *, again: bool = False) -> bool:
        """Makes pictures of ``request`` from now on. Returns whether a picture of it will be sent: it shows something new, or
        it is asked for ``again``."""
        with self._changed:
            if self._closed:
                return False
            is_new = again or not request.shows_as(self._wanted) or self._error is not None
            self._wanted = request
            self._last_input = time.monotonic()
            if is_new:
                self._is_new, self._share, self._error = True, 0.0, None
            if self._thread is None:
                self._is_new, self._share = True, 0.0
                self._thread = threading.Thread(target=self._run, name="fovolnet-view", daemon=True)
                self._thread.start()
            self._changed.notify_all()
            return self._is_new

    def look_at(self, gaze: tuple[float, float]) -> None:
        """The eye looks at ``gaze``: refinement goes on there."""
        with self._changed:
            if self._wanted is not None:
                self._wanted = replace(self._wanted, gaze=gaze)

    def drawn(self, number: int, watcher: str, page: str) -> None:
        """The view ``watcher`` has drawn frame ``number``."""
        with self._changed:
            self._watchers[watcher] = page
            sent = self._in_flight.get(number)
            if sent is not None:
                self._arrival += NEW * (time.monotonic() - sent - self._arrival)
            self._in_flight = {other: at for other, at in self._in_flight.items() if other > number}
            self._changed.notify_all()

    def opened(self, watcher: str, page: str) -> None:
        """A view in a browser is open. Those of other pages, of all live views, may be gone without a word. If they are not, they
        will be heard of."""
        for other in list(ALL):
            other._forget_other_pages(page)
        with self._changed:
            self._watchers[watcher] = page

    def _forget_other_pages(self, page: str) -> None:
        with self._changed:
            self._watchers = {watcher: its for watcher, its in self._watchers.items() if its == page}
            self._last_input = time.monotonic()
            self._changed.notify_all()

    def shut(self, watcher: str) -> None:
        """A view in a browser is gone. After the last one the thread ends, some time later."""
        with self._changed:
            self._watchers.pop(watcher, None)
            self._last_input = time.monotonic()
            self._changed.notify_all()

    def close(self) -> None:
        """Ends the thread and frees its memory once it has finished what it is at, some milliseconds later."""
        with self._changed:
            self._closed = True
            self._wanted = None
            self._watchers.clear()
            thread = self._thread
            self._changed.notify_all()
        if thread is not None and thread is not threading.current_thread():
            thread.join(timeout=2.0)

    @property
    def is_running(self) -> bool:
        """Whether there is a thread."""
        return self._thread is not None

    def picture(self, timeout: float) -> np.ndarray | None:
        """The full frame of the last request, or what there is of it after ``timeout`` seconds: uint8 (height, width, 3).

        Raises
        ------
        FovolnetError
            The request cannot be rendered.
        """
        end = time.monotonic() + timeout
        with self._changed:
            while self._thread is not None and self._error is None and (self._is_new or self._share < 1.0):
                left = end - time.monotonic()
                if left <= 0.0:
                    break
                self._changed.wait(left)
            if self._error is not None:
                raise self._error
            return self._picture

    # The thread.

    def _run(self) -> None:
        producer: FrameProducer | None = None
        made: Request | None = None
        while (task := self._next()) is not None:
            request, is_new = task
            try:
                if producer is None or made is None or made.volume is not request.volume:
                    producer = None
                    producer = FrameProducer(request.volume, request.settings, self._device, self._threads)
                elif made.settings != request.settings:
                    producer.change(request.settings)
                made = request
                if is_new:
                    budget = max(self.interval_ms - self._encode_ms, LEAST_MS)
                    facts = producer.go_to(request.camera, request.size, request.gaze, budget)
                    share = facts["share"]
                else:
                    share = producer.refine(request.gaze, PIECE_MS)
                    facts = {"way": "full frame"}
                self._show(producer, request, {**facts, "share": share})
            except KeyboardInterrupt:
                # An interrupted cell stops all rendering of the process; this view goes on with a new pipeline.
                time.sleep(0.05)
                self._try_again()
            except Exception as error:
                producer = None
                self._fail(request, error)
            except BaseException as error:  # a panic of the native part
                producer = None
                self._fail(request, RuntimeError(f"the renderer failed and begins anew: {error}"))

    def _next(self) -> tuple[Request, bool] | None:
        """Waits for work: a request, and whether it is new. None if the thread ends."""
        while (task := self._waited()) == "keep":
            with self._changed:
                still, self._unkept = self._unkept, None
            if still is not None:
                self._within.run(self._keep, still)
        return task if isinstance(task, tuple) else None

    def _waited(self) -> tuple[Request, bool] | str:
        """Waits for work: a request, and whether it is new; ``"keep"``; or ``"end"``."""
        with self._changed:
            while not self._closed:
                now = time.monotonic()
                wait: float | None = None
                if self._wanted is not None and self._is_new:
                    wait = self._until_free(now)
                    if wait <= 0.0:
                        self._is_new = False
                        return self._wanted, True
                elif self._wanted is not None and self._share < 1.0 and self._error is None:
                    rest = REST_HELD if self._wanted.held else REST
                    wait = max(self._last_input + rest - now, self._until_free(now))
                    if wait <= 0.0:
                        return self._wanted, False
                elif self._unkept is not None:
                    wait = self._last_input + KEPT - now
                    if wait <= 0.0:
                        return "keep"
                elif not self._watchers:
                    wait = self._last_input + IDLE - now
                    if wait <= 0.0:
                        break
                self._changed.wait(wait)
            self._thread = None
            self._in_flight.clear()
            self._unkept = None
            self._changed.notify_all()
            return "end"

    def _until_free(self, now: float) -> float:
        """Seconds until another frame may be sent."""
        self._in_flight = {number: sent for number, sent in self._in_flight.items() if now - sent < LOST}
        if len(self._in_flight) < IN_FLIGHT:
            return 0.0
        return min(self._in_flight.values()) + LOST - now

    def _show(self, producer: FrameProducer, request: Request, facts: dict[str, Any]) -> None:
        """Sends the current picture, and remembers it."""
        is_full = facts["share"] >= 1.0
        started = time.perf_counter()
        encoding, data, width, height = self._encoded(producer, request.size, is_full)
        self._encode_ms += NEW * (1e3 * (time.perf_counter() - started) - self._encode_ms)
        image = producer.image if is_full or self._picture is None else None
        with self._changed:
            if self._closed:
                return
            if not self._is_new:
                self._share = facts["share"]
            self._picture = image if image is not None else self._picture
            self._number += 1
            number = self._number
            if self._watchers:
                self._in_flight[number] = time.monotonic()
            self._changed.notify_all()
        header = {
            "kind": "frame",
            "number": number,
            "encoding": encoding,
            "width": width,
            "height": height,
            "size": list(request.size),
            "share": facts["share"],
            "way": facts["way"],
            "heard": dict(request.heard),
        }
        self._within.run(self._send, header, [data])
        if is_full:
            self._unkept = data

    def _encoded(self, producer: FrameProducer, size: tuple[int, int], is_full: bool) -> tuple[str, bytes, int, int]:
        """The current picture as bytes: their encoding, width and height."""
        pixels = size[0] * size[1]
        if is_full:
            data, width, height = producer.encode("png")
            self._png_share = len(data) / (4 * width * height)
            if len(data) <= STILL_BYTES and self._arrival < SLOW:
                return "png", data, width, height
            return "jpeg", *producer.encode("jpeg", STILL_QUALITY)
        if 4 * pixels <= RAW_BYTES:
            return "raw", *producer.encode("raw")
        if self._png_share * 4 * pixels <= PNG_BYTES and self._arrival < SLOW:
            data, width, height = producer.encode("png")
            self._png_share = len(data) / (4 * width * height)
            return "png", data, width, height
        # Pictures change; PNG is tried again from time to time.
        self._png_share *= 0.99
        return "jpeg", *producer.encode("jpeg", QUALITY)

    def _try_again(self) -> None:
        with self._changed:
            self._is_new = True

    def _fail(self, request: Request, error: Exception) -> None:
        with self._changed:
            if self._is_new:
                # The next request may be better.
                return
            self._error, self._share = error, 1.0
            self._changed.notify_all()
        self._within.run(self._send, {"kind": "error", "text": one_line(error), "heard": dict(request.heard)}, [])


def one_line(error: Exception) -> str:
    """The message of ``error`` in one line."""
    return " ".join(str(error).split()) or type(error).__name__
