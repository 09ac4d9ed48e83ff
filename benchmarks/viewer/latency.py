#!/usr/bin/env python3
"""How long the viewer's interface takes to answer while pictures are made: from a pointer event of the X server (XTEST) to the
first changed pixel of what lies under the pointer.

    apt-get install xvfb libxtst6
    cargo build --release
    python3 benchmarks/viewer/latency.py [VOLUME] [--side 256] [--answers 60] [-o FILE.json]

A display of its own (Xvfb), the viewer drawn by whatever Vulkan there is (Mesa's llvmpipe counts as none: then everything runs
on the processor). First, with the view at rest, places are looked for that light up under the pointer. Then answers are timed
from place to place: at rest, while the path is played, and while a turned view is held (a button pressed and moved), of which the
change of the picture is timed too.
"""

import argparse
import ctypes
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
VIEWER = ROOT / "target/release/fovolnet-viewer"
WINDOW = (1280, 720)
# What is compared around the pointer.
AROUND = (36, 10)
SPACE = 0x20


class Image(ctypes.Structure):
    """The beginning of Xlib's XImage."""

    _fields_ = [
        ("width", ctypes.c_int),
        ("height", ctypes.c_int),
        ("xoffset", ctypes.c_int),
        ("format", ctypes.c_int),
        ("data", ctypes.c_void_p),
        ("byte_order", ctypes.c_int),
        ("bitmap_unit", ctypes.c_int),
        ("bitmap_bit_order", ctypes.c_int),
        ("bitmap_pad", ctypes.c_int),
        ("depth", ctypes.c_int),
        ("bytes_per_line", ctypes.c_int),
    ]


class Display:
    """A connection to an X server, its pointer and its pixels."""

    def __init__(self, name):
        self.x = ctypes.CDLL("libX11.so.6")
        self.test = ctypes.CDLL("libXtst.so.6")
        self.x.XOpenDisplay.restype = ctypes.c_void_p
        self.x.XDefaultRootWindow.restype = ctypes.c_ulong
        self.x.XGetImage.restype = ctypes.POINTER(Image)
        self.x.XKeysymToKeycode.restype = ctypes.c_ubyte
        self.display = ctypes.c_void_p(self.x.XOpenDisplay(name.encode()))
        self.root = ctypes.c_ulong(self.x.XDefaultRootWindow(self.display))

    def move(self, x, y):
        self.test.XTestFakeMotionEvent(self.display, 0, x, y, ctypes.c_ulong(0))
        self.x.XFlush(self.display)

    def button(self, is_down):
        self.test.XTestFakeButtonEvent(self.display, 1, int(is_down), ctypes.c_ulong(0))
        self.x.XFlush(self.display)

    def key(self, symbol):
        code = self.x.XKeysymToKeycode(self.display, ctypes.c_ulong(symbol))
        for is_down in (1, 0):
            self.test.XTestFakeKeyEvent(self.display, code, is_down, ctypes.c_ulong(0))
        self.x.XFlush(self.display)

    def focus(self):
        """Keys go to the window under the pointer from now on."""
        window, other, number = ctypes.c_ulong(), ctypes.c_ulong(), ctypes.c_int()
        self.x.XQueryPointer(
            self.display, self.root, ctypes.byref(other), ctypes.byref(window), *[ctypes.byref(number)] * 5
        )
        self.x.XSetInputFocus(self.display, window, 1, ctypes.c_ulong(0))
        self.x.XFlush(self.display)

    def pixels(self, x, y, width, height):
        image = self.x.XGetImage(self.display, self.root, x, y, width, height, ctypes.c_ulong(0xFFFFFFFF), 2)
        data = ctypes.string_at(image.contents.data, image.contents.bytes_per_line * height)
        self.x.XDestroyImage(image)
        return data

    def around(self, x, y):
        return self.pixels(x - AROUND[0] // 2, y - AROUND[1] // 2, *AROUND)


def answer(display, do, look, limit=3.0):
    """Milliseconds from `do` to another look."""
    before = look()
    started = time.perf_counter()
    do()
    while time.perf_counter() - started < limit:
        if look() != before:
            return 1e3 * (time.perf_counter() - started)
        # Looking all the time would take a processor away.
        time.sleep(0.001)
    return None


def places(display, wanted):
    """Points of the panels that light up under the pointer."""
    found = []
    for x in (30, 90, 150, WINDOW[0] - 180, WINDOW[0] - 90):
        for y in range(12, WINDOW[1] - 12, 11):
            if any(abs(x - a) < 60 and abs(y - b) < 24 for a, b in found):
                continue
            display.move(WINDOW[0] // 2, WINDOW[1] // 2)
            time.sleep(0.12)
            before = [display.around(x, y) for _ in range(2)]
            display.move(x, y)
            time.sleep(0.12)
            if before[0] == before[1] != display.around(x, y):
                found.append((x, y))
                if len(found) == wanted:
                    return found
    return found


def answers(display, points, count):
    """Answers from place to place, in milliseconds."""
    times = []
    for number in range(count):
        x, y = points[number % len(points)]
        display.move(WINDOW[0] // 2, WINDOW[1] // 2)
        # Anywhere in the time that a picture takes.
        time.sleep(0.15 + 0.25 * random.random())
        times.append(answer(display, lambda: display.move(x, y), lambda: display.around(x, y)))
    return times


def picture(display):
    """The middle of the window."""
    return display.pixels(WINDOW[0] // 2 - 40, WINDOW[1] // 2 - 40, 80, 80)


def turns(display, count):
    """A turned view: from a moved pointer to the picture's change, while a button is held."""
    middle = [WINDOW[0] // 2, WINDOW[1] // 2]
    display.move(*middle)
    time.sleep(1.0)
    display.button(True)
    times = []
    for number in range(count):
        time.sleep(0.4 + 0.2 * random.random())
        x = middle[0] + (40 if number % 2 else -40)
        times.append(answer(display, lambda: display.move(x, middle[1]), lambda: picture(display)))
    display.button(False)
    return times


def summary(times):
    known = sorted(t for t in times if t is not None)
    at = lambda share: known[min(len(known) - 1, int(share * len(known)))] if known else None
    return {
        "answers": len(known),
        "none within 3 s": len(times) - len(known),
        "median_ms": statistics.median(known) if known else None,
        "p95_ms": at(0.95),
        "max_ms": known[-1] if known else None,
        "within_50_ms": sum(t <= 50 for t in known) / max(1, len(times)),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", nargs="?", default="engine")
    parser.add_argument("--side", type=int, default=256)
    parser.add_argument("--answers", type=int, default=60)
    parser.add_argument("--viewer", type=Path, default=VIEWER)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    random.seed(1)
    folder = tempfile.TemporaryDirectory()
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{WINDOW[0]}x{WINDOW[1]}x24"],
        pass_fds=[write],
        stderr=subprocess.DEVNULL,
    )
    name = ":" + os.read(read, 16).decode().strip()
    environment = dict(os.environ, DISPLAY=name, XDG_RUNTIME_DIR=folder.name, FOVOLNET_STATE=folder.name + "/state")
    dims = ",".join([str(arguments.side)] * 3)
    viewer = subprocess.Popen(
        [arguments.viewer, arguments.volume, "--dims", dims, "--window", f"{WINDOW[0]}x{WINDOW[1]}"]
        + ["--device", "cpu", "--path", "flythrough", "--frames", "500"],
        env=environment,
        stderr=subprocess.DEVNULL,
    )
    try:
        display = Display(name)
        time.sleep(25)
        points = places(display, 6)
        if not points:
            sys.exit("nothing lights up under the pointer; is the window there?")
        print("places:", points)
        report = {"volume": f"{arguments.volume} {arguments.side}^3", "window": WINDOW, "places": points}
        report["at rest"] = summary(answers(display, points, arguments.answers))
        report["turned view, to the picture"] = summary(turns(display, arguments.answers))
        display.move(WINDOW[0] // 2, WINDOW[1] // 2)
        display.focus()
        display.key(SPACE)
        time.sleep(3)
        pictures = {picture(display) for _ in range(40) if time.sleep(0.05) is None}
        if len(pictures) < 5:
            sys.exit("the path does not play")
        report["pictures in 2 s"] = len(pictures)
        report["path played"] = summary(answers(display, points, arguments.answers))
        print(json.dumps(report, indent=1))
        if arguments.output:
            arguments.output.write_text(json.dumps(report, indent=1) + "\n")
    finally:
        viewer.kill()
        server.kill()
        viewer.wait()
        server.wait()


main()
