"""What the tests share: an asymmetric volume, and pictures of the command line."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@pytest.fixture
def scan() -> np.ndarray[Any, Any]:
    """An asymmetric volume, [z, y, x]."""
    z, y, x = np.mgrid[0:20, 0:24, 0:32]
    ball = np.clip(9.0 - np.sqrt((z - 8.0) ** 2 + (y - 10.0) ** 2 + (x - 12.0) ** 2), 0.0, 9.0)
    return np.asarray(100.0 * ball + 3.0 * x + (y > 18) * 400.0, np.int16)


@pytest.fixture
def of_command(tmp_path: Path) -> Callable[..., np.ndarray[Any, Any]]:
    """The command line's picture of a file, with further flags."""
    image = pytest.importorskip("PIL.Image")

    def rendered(path: Path | str, *flags: str) -> np.ndarray[Any, Any]:
        out = tmp_path / "of_command.png"
        # Another build of the program may be named; the package carries one.
        named = os.environ.get("FOVOLNET_COMMAND")
        program = [named] if named else [sys.executable, "-m", "fovolnet"]
        line = [*program, "render", str(path), "--size", "96x64", "--device", "cpu", "-o", str(out), *flags]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return np.asarray(image.open(out).convert("RGB"))

    return rendered
