"""The notebook widget without a browser: motions, the protocol, threads and memory."""

import gc
import io
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import fovolnet as fv
from fovolnet import live_view, orbit
from fovolnet._native import FrameProducer
from fovolnet.live_view import LiveView, Request

SIZE = (96, 72)


@pytest.fixture
def scene() -> Iterator[fv.Scene]:
    with fv.Scene(size=SIZE, device="cpu") as scene:
        scene.add_volume(fv.read("head", dims=(32, 32, 32)))
        yield scene


def until(condition: Callable[[], Any], seconds: float = 60.0) -> Any:
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, "nothing comes"
        time.sleep(0.005)
    return value


class Browser:
    """Takes the messages of a live view or widget, as a browser would."""

    def __init__(self) -> None:
        self.messages: list[tuple[dict[str, Any], list[bytes]]] = []
        self.stills: list[bytes] = []
        self.threads: set[str] = set()

    def take(self, message: dict[str, Any], buffers: Any = ()) -> None:
        self.threads.add(threading.current_thread().name)
        self.messages.append((message, list(buffers or [])))

    @property
    def frames(self) -> list[dict[str, Any]]:
        return [message for message, _ in self.messages if message["kind"] == "frame"]

    def last_image(self) -> np.ndarray:
        image = pytest.importorskip("PIL.Image")
        message, [data] = next(pair for pair in reversed(self.messages) if pair[0]["kind"] == "frame")
        if message["encoding"] == "raw":
            return np.frombuffer(data, np.uint8).reshape(message["height"], message["width"], 4)[..., :3]
        return np.asarray(image.open(io.BytesIO(data)).convert("RGB"))


def request_of(scene: fv.Scene, azimuth: float = 0.0, **changes: Any) -> Request:
    camera = scene.camera.turned(azimuth)
    view = (list(map(float, camera.eye)), list(map(float, camera.target)), camera.fovy)
    return Request(**{"volume": scene.layers[0].volume, "settings": "{}", "camera": view, "size": SIZE, **changes})


@pytest.fixture
def live() -> Iterator[tuple[LiveView, Browser]]:
    browser = Browser()
    view = LiveView(browser.take, browser.stills.append, device="cpu")
    yield view, browser
    view.close()


def test_the_volume_follows_the_pointer() -> None:
    camera = fv.Camera(10.0, 20.0, 2.0, fovy=40.0)
    orbit.turn(camera, 0.25, 0.1)
    assert (camera.azimuth, camera.elevation) == (pytest.approx(-35.0), pytest.approx(38.0))
    orbit.turn(camera, 2.0, 9.0)
    assert camera.azimuth == pytest.approx(-35.0) and camera.elevation == orbit.HIGHEST
    camera = fv.Camera(0.0, 0.0, 2.0, fovy=90.0)
    orbit.pan(camera, 0.5, 0.25)
    assert np.allclose(camera.target, [-2.0, 1.0, 0.0])


def test_zooming_keeps_what_is_under_the_pointer() -> None:
    camera = fv.Camera(30.0, 25.0, 2.0, np.array([0.1, 0.2, 0.3]), 35.0)
    before = camera.target + orbit.in_target_plane(camera, 0.3, -0.2)
    orbit.zoom(camera, 0.5, 0.3, -0.2)
    assert camera.distance == 1.0
    # The place lies in the plane of the target, where the pointer still is.
    assert np.allclose(camera.target + orbit.in_target_plane(camera, 0.3, -0.2), before)
    orbit.zoom(camera, 1e-9)
    assert camera.distance == orbit.NEAREST


def test_a_producer_rests_at_the_full_frame(scene: fv.Scene) -> None:
    producer = FrameProducer(scene.layers[0].volume, "{}", "cpu")
    camera = scene.camera
    view = (list(map(float, camera.eye)), list(map(float, camera.target)), camera.fovy)
    for budget in (1000.0, 0.01, 0.01, 0.01):
        made = producer.go_to(view, SIZE, (0.5, 0.5), budget)
    assert made["width"] < SIZE[0] and made["share"] == 0.0
    shares = [producer.refine((0.2, 0.2), 0.5)]
    while shares[-1] < 1.0:
        shares.append(producer.refine((0.2, 0.2), 0.5))
        assert len(shares) < 10000
    assert shares == sorted(shares) and len(shares) > 2
    # However long pixels seem to take, there are few pieces.
    producer.go_to(view, SIZE, (0.5, 0.5), 0.01)
    pieces = 1
    while producer.refine((0.5 + 0.3 * np.sin(pieces), 0.5), 1e-9) < 1.0:
        pieces += 1
    assert pieces <= 300
    assert np.array_equal(producer.image, scene.render())


def test_encodings_hold_the_picture(scene: fv.Scene) -> None:
    image = pytest.importorskip("PIL.Image")
    producer = FrameProducer(scene.layers[0].volume, "{}", "cpu")
    with pytest.raises(fv.FovolnetError, match="no picture"):
        producer.encode("png")
    camera = scene.camera
    producer.go_to((list(camera.eye), list(camera.target), camera.fovy), SIZE)
    png, width, height = producer.encode("png")
    assert np.array_equal(np.asarray(image.open(io.BytesIO(png))), producer.image)
    raw, *_ = producer.encode("raw")
    assert np.array_equal(np.frombuffer(raw, np.uint8).reshape(height, width, 4)[..., :3], producer.image)
    jpeg, *_ = producer.encode("jpeg", 90)
    assert fv.metrics.psnr(np.asarray(image.open(io.BytesIO(jpeg))), producer.image) > 30.0
    for wrong in (("gif", 80), ("jpeg", 0)):
        with pytest.raises(fv.FovolnetError, match="encoded as|quality"):
            producer.encode(*wrong)


def test_pictures_come_until_the_frame_is_full(scene: fv.Scene, live: tuple[LiveView, Browser]) -> None:
    view, browser = live
    view.want(request_of(scene, heard=(("a", 3),)))
    until(lambda: browser.frames and browser.frames[-1]["share"] == 1.0)
    assert np.array_equal(browser.last_image(), scene.render())
    assert browser.threads == {"fovolnet-view"} and browser.frames[-1]["heard"] == {"a": 3}
    count = len(browser.frames)
    assert not view.want(request_of(scene)), "nothing new"
    time.sleep(0.3)
    assert len(browser.frames) == count
    assert view.want(request_of(scene), again=True)
    until(lambda: len(browser.frames) > count)


def test_the_last_full_frame_is_kept(scene: fv.Scene, live: tuple[LiveView, Browser]) -> None:
    image = pytest.importorskip("PIL.Image")
    view, browser = live
    view.want(request_of(scene))
    [still] = until(lambda: browser.stills)
    assert np.array_equal(np.asarray(image.open(io.BytesIO(still))), scene.render())


def test_the_newest_request_wins_and_few_frames_are_under_way(scene: fv.Scene, live: tuple[LiveView, Browser]) -> None:
    view, browser = live
    view.opened("a", "page")
    requests = [request_of(scene, azimuth, heard=(("a", azimuth),)) for azimuth in range(1, 60)]
    for request in requests:
        view.want(request)
        time.sleep(0.002)
    until(lambda: browser.frames and browser.frames[-1]["heard"] == {"a": 59})
    # Nobody answers, so after the first two frames others wait until those count as lost.
    assert len(browser.frames) < 8
    view.drawn(browser.frames[-1]["number"], "a", "page")
    until(lambda: view._share == 1.0 or view.drawn(browser.frames[-1]["number"], "a", "page"))
    scene.camera = scene.camera.turned(59.0)
    assert np.array_equal(view.picture(20.0), scene.render())


def test_errors_are_one_line_and_do_not_end_it(scene: fv.Scene, live: tuple[LiveView, Browser]) -> None:
    view, browser = live
    view.want(request_of(scene, settings='{"step": -1}'))
    with pytest.raises(fv.FovolnetError, match="step"):
        view.picture(20.0)
    [error] = [message for message, _ in browser.messages if message["kind"] == "error"]
    assert "\n" not in error["text"] and error["text"]
    view.want(request_of(scene))
    assert view.picture(20.0) is not None


def test_threads_end_when_nobody_looks_and_when_closed(
    scene: fv.Scene, live: tuple[LiveView, Browser], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_view, "IDLE", 0.2)
    monkeypatch.setattr(live_view, "KEPT", 0.0)
    view, _ = live
    view.opened("a", "page")
    view.want(request_of(scene))
    assert view.picture(20.0) is not None
    time.sleep(0.5)
    assert view.is_running, "somebody looks"
    view.opened("b", "another page")
    view.shut("b")
    until(lambda: not view.is_running)
    view.want(request_of(scene, 5.0))
    assert view.is_running and view.picture(20.0) is not None
    view.close()
    until(lambda: not view.is_running)
    assert not view.want(request_of(scene, 9.0)) and not view.is_running


def test_an_interrupted_cell_leaves_views_alone(scene: fv.Scene, live: tuple[LiveView, Browser]) -> None:
    import signal

    view, _ = live
    view.want(request_of(scene, size=(640, 480)))
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
            big = fv.Scene(size=(2000, 2000), device="cpu", step=0.02)
            big.add_volume(fv.read("head", dims=(64, 64, 64)))
            big.render()
            time.sleep(10.0)
    finally:
        signal.signal(signal.SIGINT, handler)
    view.want(request_of(scene, 7.0))
    scene.camera = scene.camera.turned(7.0)
    assert np.array_equal(view.picture(20.0), scene.render())


@pytest.fixture
def widget(scene: fv.Scene, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    pytest.importorskip("anywidget")
    widget = scene.widget()
    browser = Browser()
    monkeypatch.setattr(widget._live, "_send", browser.take)
    monkeypatch.setattr(widget, "send", browser.take)
    widget.browser = browser
    yield widget
    widget.close()


def tell(widget: Any, kind: str, **message: Any) -> None:
    widget._receive(widget, {"kind": kind, "view": "a", "page": "p", **message}, [])


def at_rest(widget: Any) -> dict[str, Any]:
    def rests() -> Any:
        frames = widget.browser.frames
        if frames:
            tell(widget, "drawn", number=frames[-1]["number"])
        return frames and frames[-1]["share"] == widget._live._share == 1.0 and not widget._live._is_new and frames[-1]

    return until(rests)


def test_widgets_move_the_camera_of_their_scene(widget: Any, scene: fv.Scene) -> None:
    tell(widget, "open", width=120, height=90)
    assert at_rest(widget)["size"] == [120, 90]
    before = scene.camera.azimuth
    tell(widget, "input", number=1, gaze=[0.3, 0.4], held=True, turn=[0.1, 0.0])
    assert scene.camera.azimuth == pytest.approx(before - 18.0)
    at_rest(widget)
    tell(widget, "input", number=2, gaze=[0.3, 0.4], held=False)
    assert widget.browser.messages[-1][0] == {"kind": "heard", "heard": {"a": 2}}, "inputs that show nothing new are answered"
    assert at_rest(widget)["size"] == [120, 90]
    scene.size = (120, 90)
    assert np.array_equal(widget.browser.last_image(), scene.render())
    tell(widget, "input", number=3, gaze=[0.5, 0.5], held=False, zoom=[0.5, 0.1, 0.1], pan=[0.1, 0.0])
    tell(widget, "input", number=4, gaze=[0.5, 0.5], held=False, home=True)
    assert scene.camera.azimuth == pytest.approx(before) and np.allclose(scene.camera.target, 0.0, atol=1e-6)


def test_changes_of_the_scene_show(widget: Any, scene: fv.Scene) -> None:
    tell(widget, "open", width=96, height=72)
    at_rest(widget)
    for change in (
        lambda: setattr(scene.camera, "azimuth", 50.0),
        lambda: scene.settings.update(mode="mip"),
        lambda: setattr(scene.layers[0], "cmap", "viridis"),
        lambda: scene.add_volume(fv.read("vortices", dims=(24, 24, 24)), opacity=0.5),
    ):
        change()
        assert np.array_equal(widget.picture(), scene.render())
    scene.settings["step"] = -1.0
    with pytest.raises(fv.FovolnetError, match="step"):
        widget.update()


def test_wrong_messages_are_answered_by_an_error(widget: Any) -> None:
    tell(widget, "input", number=1)
    assert widget.browser.messages[-1][0]["kind"] == "error"
    tell(widget, "open", width=1e9, height=1e9)
    assert at_rest(widget)["size"] == [2000, 2000]


def test_saved_notebooks_have_a_picture(widget: Any, scene: fv.Scene) -> None:
    import base64

    image = pytest.importorskip("PIL.Image")
    data, _ = widget._repr_mimebundle_()
    png = image.open(io.BytesIO(base64.b64decode(data["image/png"])))
    assert np.array_equal(np.asarray(png), scene.render())
    assert "application/vnd.jupyter.widget-view+json" in data and "96x72" in data["text/plain"]
    until(lambda: widget._still)
    assert np.array_equal(np.asarray(image.open(io.BytesIO(widget._still))), scene.render())


def test_widgets_leave_no_threads_and_no_memory(scene: fv.Scene) -> None:
    pytest.importorskip("anywidget")

    def one() -> None:
        widget = scene.widget()
        assert widget.picture() is not None
        widget.close()

    def resident() -> int:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096

    for _ in range(10):
        one()
    gc.collect()
    threads, before = threading.active_count(), resident()
    for _ in range(40):
        one()
    gc.collect()
    assert threading.active_count() <= threads
    assert resident() - before < 16 << 20


def test_a_missing_anywidget_is_said_with_a_remedy(scene: fv.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "anywidget", None)
    monkeypatch.delitem(sys.modules, "fovolnet.widget", raising=False)
    monkeypatch.delattr(fv, "widget", raising=False)
    with pytest.raises(ImportError, match=r"pip install fovolnet\[notebook\]"):
        scene.widget()
