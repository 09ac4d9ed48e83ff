"""JupyterLab with a notebook in headless Chromium."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

#: Milliseconds that scripts of the page may take.
SCRIPT_SECONDS = 120


def missing() -> str | None:
    """What the tests lack here, in one line."""
    for module in ("jupyterlab", "anywidget", "selenium", "nbformat", "PIL"):
        try:
            __import__(module)
        except ImportError:
            return f"tests in a browser need {module}; pip install jupyterlab anywidget selenium pillow"
    if chromium() is None or driver() is None:
        return "tests in a browser need Chromium and its driver; apt install chromium chromium-driver"
    return None


def chromium() -> str | None:
    return shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chromium-browser")


def driver() -> str | None:
    return shutil.which("chromedriver")


class Server:
    """A Jupyter server in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        options = {
            "ServerApp.port": self.port,
            "ServerApp.ip": "127.0.0.1",
            "ServerApp.root_dir": folder,
            "ServerApp.open_browser": False,
            "IdentityProvider.token": "",
            "ServerApp.allow_root": True,
            "LabApp.expose_app_in_browser": True,
            "LabApp.news_url": "",
            "LabServerApp.user_settings_dir": folder / ".settings",
            "LabServerApp.workspaces_dir": folder / ".workspaces",
        }
        flags = [f"--{name}={value}" for name, value in options.items()]
        self.log = open(folder / "server.log", "wb")
        environment = {**os.environ, "JUPYTER_RUNTIME_DIR": str(folder / ".runtime"), "IPYTHONDIR": str(folder / ".ipython")}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *flags], stdout=self.log, stderr=self.log, cwd=folder, env=environment
        )
        wait_for(lambda: self._answers(), 60.0)

    def _answers(self) -> bool:
        if self.process.poll() is not None:
            raise RuntimeError((self.folder / "server.log").read_text())
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{self.port}/api/status", timeout=5).read()
            return True
        except OSError:
            return False

    def stop(self) -> None:
        # Kernels end with their server where it is asked kindly.
        self.process.terminate()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self.log.close()


class Page:
    """A notebook in a browser."""

    def __init__(self, server: Server, size: tuple[int, int] = (1200, 1600)) -> None:
        from selenium import webdriver

        options = webdriver.ChromeOptions()
        options.binary_location = str(chromium())
        profile = server.folder / f".chromium-{time.monotonic_ns()}"
        flags = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--force-device-scale-factor=1"]
        flags += ["--enable-precise-memory-info", "--js-flags=--expose-gc", f"--user-data-dir={profile}"]
        for flag in [*flags, f"--window-size={size[0]},{size[1]}"]:
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.server = server
        self.browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(str(driver())))
        self.browser.set_script_timeout(SCRIPT_SECONDS)

    def open(self, cells: Sequence[str], name: str = "notebook.ipynb") -> None:
        """Opens a notebook of these cells."""
        import nbformat

        notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
        notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
        nbformat.write(notebook, self.server.folder / name)
        self.visit(f"lab/workspaces/{Path(name).stem}/tree/{name}?reset")

    def visit(self, path: str) -> None:
        self.browser.get(f"http://127.0.0.1:{self.server.port}/{path}")
        ready = "return !!(window.jupyterapp && jupyterapp.shell.currentWidget?.context?.isReady)"
        self.until(lambda: self.run(ready) and self.run("return jupyterapp.shell.currentWidget.sessionContext.isReady"), 90.0)
        # The file browser takes a third of the window.
        self.run("if (!jupyterapp.shell.leftCollapsed) jupyterapp.shell.collapseLeft()")

    def file(self, path: Path) -> None:
        """Opens a file without a server."""
        self.browser.get(path.as_uri())

    def command(self, name: str, **options: Any) -> Any:
        """Executes a command of JupyterLab and waits for it."""
        script = "const done = arguments[2]; jupyterapp.commands.execute(arguments[0], arguments[1]).then(() => done(), (e) => done(String(e)))"
        return self.browser.execute_async_script(script, name, options)

    def run_cells(self) -> None:
        self.command("notebook:run-all-cells")

    def run(self, script: str, *arguments: Any) -> Any:
        return self.browser.execute_script(script, *arguments)

    def until(self, condition: Callable[[], Any], seconds: float = 30.0) -> Any:
        try:
            return wait_for(condition, seconds)
        except TimeoutError:
            log = "\n".join(entry["message"] for entry in self.browser.get_log("browser")[-20:])
            self.browser.save_screenshot(str(self.server.folder / "failed.png"))
            raise TimeoutError(f"nothing came; {self.server.folder}/failed.png shows the page, which said\n{log}") from None

    def boxes(self) -> list[Any]:
        return self.browser.find_elements("css selector", ".fovolnet")

    def widgets(self, count: int = 1) -> list[Any]:
        """The widgets, once there are ``count`` with full frames."""
        return self.until(lambda: len(all := self.boxes()) == count and all_full(all) and all, 60.0)

    def pixels(self, box: Any) -> Any:
        """The canvas of a widget: uint8 of shape (height, width, 3)."""
        import base64
        import io

        import numpy as np
        from PIL import Image

        url = self.run("return arguments[0].querySelector('canvas').toDataURL('image/png')", box)
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).convert("RGB"))

    def text(self, box: Any) -> str:
        """The message of a widget."""
        return str(self.run("return arguments[0].querySelector('p').textContent", box))

    def output(self, cell: int) -> str:
        """The text that a cell has printed."""
        # Cells out of sight are not in the page.
        script = """
            const outputs = jupyterapp.shell.currentWidget.content.widgets[arguments[0]].model.outputs.toJSON();
            return outputs.map((output) => output.text ?? '').flat().join('');
        """
        return str(self.run(script, cell))

    def screenshot(self, name: str) -> Path:
        path = self.server.folder / name
        self.browser.save_screenshot(str(path))
        return path

    def close(self) -> None:
        """Ends the kernel and the browser."""
        script = "const done = arguments[0]; Promise.resolve(window.jupyterapp?.shell.currentWidget?.sessionContext.shutdown()).finally(done)"
        self.browser.execute_async_script(script)
        self.browser.quit()


def same(a: Any, b: Any) -> bool:
    """Whether two pictures are equal."""
    return a.shape == b.shape and bool((a == b).all())


def all_full(boxes: Sequence[Any]) -> bool:
    return all(box.get_attribute("data-share") == "1" for box in boxes)


def wait_for(condition: Callable[[], Any], seconds: float) -> Any:
    end = time.monotonic() + seconds
    while not (value := condition()):
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.05)
    return value
