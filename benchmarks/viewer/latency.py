#!/usr/bin/env python3
"""How long the viewer's interface takes to answer while pictures are made: from a pointer event of the X server (XTEST) to the
first changed pixel of what lies under the pointer.

    apt-get install xvfb libxtst6
    cargo build --release
    python3 benchmarks/viewer/latency.py [VOLUME] [--side 256] [--answers 60] [--busy nice19] [-o FILE.json]

A display of its own (Xvfb), the viewer drawn by whatever Vulkan there is (Mesa's llvmpipe counts as none: then everything runs
on the processor). First, with the view at rest, places are looked for that light up under the pointer. Then answers are timed
from place to place: at rest, while the path is played, and while a turned view is held (a button pressed and moved), of which the
change of the picture is timed too. While the path is played, pictures are counted as well.

With --busy every processor has a program of its own beside all that, which never rests: of this niceness, 0 to 19.

A virtual machine stands still now and then, all its processors at once, for longer than an answer takes. A process that comes
before all others on every processor notes when it could not run either; answers are counted without that time, too.
"""

import argparse
import ctypes
import json
import multiprocessing
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
# Seconds for which a process that only sleeps has to be late for the machine to have stood still.
LATE = 0.005


class Standstills:
    """Notes from when to when none of the processors ran what comes before everything else."""

    def __init__(self):
        self.ends = multiprocessing.Event()
        self.watchers = []
        for processor in sorted(os.sched_getaffinity(0)):
            theirs, ours = multiprocessing.Pipe()
            watcher = multiprocessing.Process(target=self.watch, args=(processor, theirs), daemon=True)
            watcher.start()
            self.watchers.append((watcher, ours))

    def watch(self, processor, told):
        os.sched_setaffinity(0, {processor})
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(50))
        except PermissionError:
            print("no right to come before everything else: what stands still may only be busy", file=sys.stderr)
        gaps, last = [], time.perf_counter()
        while not self.ends.is_set():
            time.sleep(0.001)
            now = time.perf_counter()
            if now - last > LATE:
                gaps.append((last, now))
            last = now
        told.send(gaps)

    def end(self):
        """Those of all processors at once."""
        self.ends.set()
        everywhere = None
        for watcher, ours in self.watchers:
            gaps = ours.recv()
            watcher.join()
            everywhere = gaps if everywhere is None else common(everywhere, gaps)
        return [(a, b) for a, b in everywhere if b - a > LATE]


def common(some, others):
    """What lies in intervals of both lists."""
    both = [(max(a, c), min(b, d)) for a, b in some for c, d in others]
    return [(a, b) for a, b in both if a < b]


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


def answer(do, look, limit=3.0):
    """When `do` was begun, and the first other look after it, in seconds."""
    before = look()
    started = time.perf_counter()
    do()
    while time.perf_counter() - started < limit:
        if look() != before:
            return started, time.perf_counter()
        # Looking all the time would take a processor away.
        time.sleep(0.001)
    return started, None


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
    """Answers from place to place, as `answer` has them."""
    times = []
    for number in range(count):
        x, y = points[number % len(points)]
        display.move(WINDOW[0] // 2, WINDOW[1] // 2)
        # Anywhere in the time that a picture takes.
        time.sleep(0.15 + 0.25 * random.random())
        times.append(answer(lambda: display.move(x, y), lambda: display.around(x, y)))
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
        times.append(answer(lambda: display.move(x, middle[1]), lambda: picture(display)))
    display.button(False)
    return times


def pictures_a_second(display, seconds=6.0):
    """How often the middle of the window changes."""
    started, count, last = time.perf_counter(), 0, picture(display)
    while time.perf_counter() - started < seconds:
        time.sleep(0.004)
        now = picture(display)
        count += now != last
        last = now
    return count / (time.perf_counter() - started)


def niceness(text):
    """That of nice0 to nice19."""
    number = text.removeprefix("nice")
    if text == number or not number.isdigit() or int(number) > 19:
        raise argparse.ArgumentTypeError(f"`{text}` is none of nice0 to nice19")
    return int(number)


def busy(nice):
    """Programs that never rest, one for each processor."""
    command = ["nice", "-n", str(nice), "sh", "-c", "while :; do :; done"]
    return [subprocess.Popen(command) for _ in os.sched_getaffinity(0)]


def summary(times, standstills):
    """Figures of answers, with the time in which the machine stood still and without it."""
    answered = [(a, b) for a, b in times if b is not None]
    known = sorted(1e3 * (b - a) for a, b in answered)
    stood_still = [1e3 * sum(d - c for c, d in common([time], standstills)) for time in answered]
    running = [1e3 * (b - a) - still for (a, b), still in zip(answered, stood_still)]
    at = lambda share: known[min(len(known) - 1, int(share * len(known)))] if known else None
    return {
        "answers": len(known),
        "none within 3 s": len(times) - len(known),
        "median_ms": statistics.median(known) if known else None,
        "p95_ms": at(0.95),
        "max_ms": known[-1] if known else None,
        "within_50_ms": sum(t <= 50 for t in known) / max(1, len(times)),
        "answers in which the machine stood still": sum(still > 0 for still in stood_still),
        "without_standstills_max_ms": max(running, default=None),
        "without_standstills_within_50_ms": sum(t <= 50 for t in running) / max(1, len(times)),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", nargs="?", default="engine")
    parser.add_argument("--side", type=int, default=256)
    parser.add_argument("--answers", type=int, default=60)
    parser.add_argument("--viewer", type=Path, default=VIEWER)
    parser.add_argument("--busy", type=niceness, metavar="niceN")
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
    others = []
    try:
        display = Display(name)
        time.sleep(25)
        points = places(display, 6)
        if not points:
            sys.exit("nothing lights up under the pointer; is the window there?")
        print("places:", points)
        report = {"volume": f"{arguments.volume} {arguments.side}^3", "window": WINDOW, "places": points}
        if arguments.busy is not None:
            others = busy(arguments.busy)
            report["busy beside it"] = f"{len(others)} programs of niceness {arguments.busy}"
        began, standstills = time.perf_counter(), Standstills()
        times = {"at rest": answers(display, points, arguments.answers)}
        times["turned view, to the picture"] = turns(display, arguments.answers)
        display.move(WINDOW[0] // 2, WINDOW[1] // 2)
        display.focus()
        display.key(SPACE)
        time.sleep(3)
        report["pictures a second"] = round(pictures_a_second(display), 2)
        if report["pictures a second"] < 0.5:
            sys.exit("the path does not play")
        times["path played"] = answers(display, points, arguments.answers)
        noted = standstills.end()
        report |= {name: summary(part, noted) for name, part in times.items()}
        report["standstills of the machine"] = {
            "number": len(noted),
            "longest_ms": max((1e3 * (b - a) for a, b in noted), default=None),
            "in_s": time.perf_counter() - began,
        }
        print(json.dumps(report, indent=1))
        if arguments.output:
            arguments.output.write_text(json.dumps(report, indent=1) + "\n")
    finally:
        for process in [viewer, server, *others]:
            process.kill()
            process.wait()


main()
