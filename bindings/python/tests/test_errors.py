"""Wrong input: exceptions that say how to mend it."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from small_pictures import picture

import fovolnet as fv


def test_arrays_that_cannot_be_shown_raise_with_a_remedy(scan) -> None:
    for wrong, part in [
        (np.zeros((4, 4)), r"array\[None\]"),
        (np.zeros((2, 4, 4, 4)), r"array\[0\]"),
        (np.zeros(()), r"\(z, y, x\)"),
        (np.zeros((0, 4, 4)), "no voxels"),
        (scan.astype(object), "astype"),
        (scan.astype(complex), "abs"),
        (scan.astype(np.longdouble), "float64"),
        (scan.astype("M8[s]"), "astype"),
        (scan.astype(str), "astype"),
        ([[["a"]]], "astype"),
        (None, "astype|shape"),
        ("no-such-file.nrrd", "no-such-file"),
        ("haed", "did you mean head"),
    ]:
        with pytest.raises(ValueError, match=part):
            picture(wrong)


def test_wrong_arguments_raise_with_a_remedy(scan) -> None:
    for wrong, part in [
        ({"spacing": (1, 2)}, "three numbers"),
        ({"spacing": (1, 2, np.nan)}, "three numbers"),
        ({"spacing": (1, -2, 3)}, "spacing"),
        ({"clim": (5, 5)}, "lower one first"),
        ({"clim": (1,)}, "two numbers"),
        ({"order": "xzy"}, "'zyx' or 'xyz'"),
        ({"mode": "xray"}, "mode"),
        ({"shadow": "on"}, "unknown field"),
        ({"step": -1}, "step"),
        ({"step": "far"}, "step"),
        ({"background": (1, 1)}, "background"),
        ({"rgb": True}, "rgb=True"),
    ]:
        with pytest.raises(ValueError, match=part):
            picture(scan, **wrong)
    with pytest.raises(ValueError, match="device|gpu"):
        fv.Scene(size=(8, 8), device="abacus").add_volume(scan) and fv.show(scan, device="abacus")
    for size in ((0, 5), (5, 10**6), (10**5, 10**5)):
        with pytest.raises(ValueError):
            fv.Scene(size=size, device="cpu").add_volume(scan) and fv.show(scan, size=size, device="cpu")


def test_too_large_arrays_are_refused_without_their_memory() -> None:
    huge = np.broadcast_to(np.uint8(3), (1 << 14, 1 << 14, 1 << 14))
    with pytest.raises((ValueError, MemoryError)):
        picture(huge)


def test_values_that_are_not_finite_are_noted(scan) -> None:
    values = scan.astype(np.float32)
    values[:2] = np.nan
    values[3, 0, 0] = np.inf
    scene = fv.Scene(size=(32, 24), device="cpu")
    scene.add_volume(values)
    assert any("NaN" in note for note in scene.notes)
    assert picture(np.full((4, 4, 4), np.nan, np.float32)).max() == 0


def test_sparse_frames_of_the_wrong_shape_are_refused(scan) -> None:
    full = picture(scan)
    with pytest.raises(ValueError, match="mask"):
        fv.Reconstructor("linear")(full, np.ones((10, 10), bool))
    with pytest.raises(ValueError, match="shape"):
        fv.Reconstructor("linear")(full[..., 0], np.ones(full.shape[:2], bool))
    with pytest.raises(ValueError, match="no-such"):
        fv.Reconstructor("no-such")(full, np.ones(full.shape[:2], bool))


INTERRUPTED = """
import signal
import fovolnet as fv
# Shells let programs in the background ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = fv.Scene(size=(1280, 720), device="cpu", step=0.02)
scene.add_volume("head")
scene.camera
try:
    print("ready", flush=True)
    scene.render()
except KeyboardInterrupt:
    print("interrupted", flush=True)
scene.settings["step"] = 1.0
scene.size = (64, 48)
print(scene.render().shape)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals")
def test_ctrl_c_ends_a_picture_and_the_scene_goes_on() -> None:
    with subprocess.Popen([sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        try:
            said, _ = process.communicate(timeout=120)
        finally:
            process.kill()
    assert said == "interrupted\n(48, 64, 3)\n"


def test_the_package_carries_the_command() -> None:
    assert "fovolnet" in fv.programs.run("--version")
    with pytest.raises(RuntimeError, match="no-such"):
        fv.programs.run("info", "no-such.nrrd")
