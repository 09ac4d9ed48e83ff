"""The widget in JupyterLab and Chromium."""

import json
import subprocess
import sys
import time
from typing import Any

import lab
import numpy as np
import pytest

webdriver = pytest.importorskip("selenium.webdriver", reason="tests in a browser need selenium; pip install selenium")
ActionChains, Keys = webdriver.ActionChains, webdriver.Keys

SCENE = """
import fovolnet as fv
scene = fv.Scene(size=(320, 240), device="cpu")
scene.add_volume(fv.read("head", dims=(48, 48, 48)))
w = scene.widget()
w
"""


def drag(page: lab.Page, box: Any, way: tuple[int, int], *, keys: str = "") -> None:
    actions = ActionChains(page.browser, duration=50)
    if keys:
        actions = actions.key_down(keys)
    actions = actions.move_to_element(box).click_and_hold()
    for _ in range(10):
        actions = actions.move_by_offset(way[0] // 10, way[1] // 10)
    actions = actions.release()
    (actions.key_up(keys) if keys else actions).perform()


def changed(page: lab.Page, box: Any, before: np.ndarray) -> np.ndarray:
    """The picture once it is full and another one than ``before``."""

    def other() -> Any:
        now = page.pixels(box)
        # Frames in motion may be full ones, too.
        time.sleep(0.5)
        if not lab.all_full([box]) or not lab.same(page.pixels(box), now):
            return None
        is_other = now.shape != before.shape or np.abs(now.astype(int) - before).max() > 8
        return (now,) if is_other else None

    return page.until(other)[0]


def test_pointer_wheel_and_keys_move_the_camera(page: lab.Page) -> None:
    page.open([SCENE])
    page.run_cells()
    [box] = page.widgets()
    start = page.pixels(box)
    assert start.shape == (240, 320, 3) and start.std() > 5
    drag(page, box, (60, 0))
    turned = changed(page, box, start)
    drag(page, box, (40, 20), keys=Keys.SHIFT)
    panned = changed(page, box, turned)
    ActionChains(page.browser).scroll_from_origin(_origin(box), 0, -200).perform()
    nearer = changed(page, box, panned)
    ActionChains(page.browser).send_keys(Keys.ARROW_LEFT).perform()
    by_key = changed(page, box, nearer)
    ActionChains(page.browser).send_keys("-").perform()
    farther = changed(page, box, by_key)
    ActionChains(page.browser).double_click(box).perform()
    home = changed(page, box, farther)
    assert np.abs(home.astype(int) - start).max() <= 1
    assert page.text(box) == ""


def _origin(box: Any) -> Any:
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin

    return ScrollOrigin.from_element(box)


def test_python_and_browser_share_the_camera(page: lab.Page) -> None:
    page.open([SCENE])
    page.run_cells()
    [box] = page.widgets()
    start = page.pixels(box)
    drag(page, box, (60, 0))
    turned = changed(page, box, start)
    add_cell(page, "print('azimuth', round(scene.camera.azimuth, 2)); scene.camera.azimuth = 90.0")
    side = changed(page, box, turned)
    # 60 of 240 pixels, and half a turn over the height.
    assert "azimuth -45" in page.output(1)
    add_cell(page, "import numpy as np; scene.size = (320, 240); print(np.array(scene.render()).sum())")
    page.until(lambda: page.output(2))
    assert int(page.output(2)) == int(side.sum())
    add_cell(page, "scene.settings['mode'] = 'mip'")
    changed(page, box, side)


def add_cell(page: lab.Page, code: str) -> None:
    """Runs ``code`` in a new last cell, and waits for its end."""
    script = """
        const [code, done] = arguments;
        const { content, sessionContext } = jupyterapp.shell.currentWidget;
        content.activeCellIndex = content.widgets.length - 1;
        jupyterapp.commands.execute('notebook:insert-cell-below')
            .then(() => { content.activeCell.model.sharedModel.setSource(code); return jupyterapp.commands.execute('notebook:run-cell'); })
            .then(() => done(), (error) => done(String(error)));
    """
    page.browser.execute_async_script(script, code)


def test_the_corner_changes_the_size(page: lab.Page) -> None:
    page.open([SCENE])
    page.run_cells()
    [box] = page.widgets()
    before = page.pixels(box)
    rect = box.rect
    corner = (rect["width"] // 2 - 4, rect["height"] // 2 - 4)
    ActionChains(page.browser).move_to_element_with_offset(box, int(corner[0]), int(corner[1])).click_and_hold().move_by_offset(
        100, 60
    ).release().perform()
    after = changed(page, box, before)
    assert after.shape == (300, 420, 3)


def test_several_widgets_live_side_by_side_and_end_with_their_cells(page: lab.Page) -> None:
    other = SCENE.replace("head", "vortices").replace("w = ", "v = ").replace("\nw\n", "\nv\n").replace("scene", "other")
    page.open([SCENE, other])
    page.run_cells()
    first, second = page.widgets(2)
    pictures = [page.pixels(box) for box in (first, second)]
    drag(page, second, (60, 0))
    changed(page, second, pictures[1])
    assert np.array_equal(page.pixels(first), pictures[0])
    threads = "import threading; print([t.name for t in threading.enumerate()].count('fovolnet-view'))"
    add_cell(page, threads)
    page.until(lambda: page.output(2).strip() == "2")
    add_cell(page, "w.close()")
    page.until(lambda: len(page.boxes()) == 1)
    add_cell(page, threads)
    page.until(lambda: page.output(4).strip() == "1")
    # The view of a cell that is run again goes, and its thread ends soon after.
    add_cell(page, "fv.live_view.IDLE = 0.2")
    page.run("jupyterapp.shell.currentWidget.content.activeCellIndex = 1")
    page.command("notebook:run-cell")
    page.widgets(1)
    add_cell(page, f"import time; time.sleep(1); {threads}")
    page.until(lambda: page.output(6).strip() == "1")


def test_pages_that_are_loaded_again_go_on(page: lab.Page) -> None:
    page.open([SCENE])
    page.run_cells()
    [box] = page.widgets()
    start = page.pixels(box)
    page.command("docmanager:save")
    page.visit("lab/workspaces/again/tree/notebook.ipynb")
    [box] = page.widgets()
    assert lab.same(page.pixels(box), start)
    drag(page, box, (60, 0))
    changed(page, box, start)


def test_errors_of_settings_show_in_the_cell_and_other_errors_in_the_picture(page: lab.Page) -> None:
    page.open([SCENE])
    page.run_cells()
    [box] = page.widgets()
    add_cell(page, "scene.settings['step'] = -1")
    page.until(lambda: "step" in page.output(1))
    drag(page, box, (60, 0))
    page.until(lambda: "step" in page.text(box))
    before = page.pixels(box)
    add_cell(page, "del scene.settings['step']")
    changed(page, box, before)
    assert page.text(box) == ""


def test_a_restarted_kernel_is_said(page: lab.Page) -> None:
    page.open([SCENE])
    page.run_cells()
    [box] = page.widgets()
    page.browser.execute_async_script(
        "const done = arguments[0]; jupyterapp.shell.currentWidget.sessionContext.session.kernel.restart().then(() => done())"
    )
    page.until(lambda: "restarted" in page.text(box))
    page.run_cells()
    [box] = page.widgets()
    assert page.text(box) == ""


def test_saved_notebooks_keep_the_picture(page: lab.Page) -> None:
    page.open([SCENE], "saved.ipynb")
    page.run_cells()
    [box] = page.widgets()
    page.command("docmanager:save")
    path = page.server.folder / "saved.ipynb"
    [output] = json.loads(path.read_text())["cells"][0]["outputs"]
    assert "image/png" in output["data"]
    html = [sys.executable, "-m", "nbconvert", "--to", "html", "--HTMLExporter.embed_images=True", str(path)]
    subprocess.run(html, check=True, capture_output=True)
    assert "data:image/png;base64" in path.with_suffix(".html").read_text()


def test_a_drag_gives_many_frames_and_they_are_all_drawn(page: lab.Page) -> None:
    page.open([SCENE])
    page.run_cells()
    [box] = page.widgets()
    before = int(box.get_attribute("data-frames"))
    for way in (60, -60, 60, -60):
        drag(page, box, (way, 0))
    # Sanity alone: machines differ.
    assert page.until(lambda: int(box.get_attribute("data-frames")) - before >= 8)
    page.widgets()
    assert page.text(box) == ""
