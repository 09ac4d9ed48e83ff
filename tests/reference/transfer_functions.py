"""Compares transfer functions with VTK at 1,001 values, and writes reference values for the tests.

    python tests/reference/transfer_functions.py compare TRANSFER_TABLE FILE...   # all maps of the files
    python tests/reference/transfer_functions.py write                           # the reference values

TRANSFER_TABLE is the program of `cargo build --release -p fovol-io --example transfer_table`. Colours come from
vtkColorTransferFunction, opacities from vtkPiecewiseFunction, both set as ParaView sets them.
"""

import json
import math
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree

import numpy
import vtk

LAST = 1000
HERE = pathlib.Path(__file__).parent
OUTPUT = HERE.parent.parent / "crates/fovol-io/src/transfer_function/vtk_values.json"


def colours(points, space, log=False, wrap=False):
    function = vtk.vtkColorTransferFunction()
    function.SetAllowDuplicateScalars(1)
    setter = {
        "rgb": "RGB", "hsv": "HSV", "lab": "Lab", "cielab": "Lab", "lab/ciede2000": "LabCIEDE2000",
        "diverging": "Diverging", "step": "Step", "prolab": "Prolab",
    }[space.lower()]
    getattr(function, f"SetColorSpaceTo{setter}")()
    function.SetHSVWrap(wrap)
    if log:
        function.SetScaleToLog10()
    for point in numpy.reshape(points, (-1, 4)):
        function.AddRGBPoint(*point)
    return function


def opacities(points):
    function = vtk.vtkPiecewiseFunction()
    function.SetAllowDuplicateScalars(1)
    for point in numpy.reshape(points, (-1, 4)):
        function.AddPoint(*point)
    return function


def sampled(colour, opacity):
    """The range of both, and their values there."""
    low, high = colour.GetRange()
    if opacity:
        low, high = min(low, opacity.GetRange()[0]), max(high, opacity.GetRange()[1])
    rows = []
    for i in range(LAST + 1):
        x = low + i / LAST * (high - low)
        rows.append([*colour.GetColor(x), opacity.GetValue(x) if opacity else i / LAST])
    return low, high, numpy.array(rows)


def of_map(entry):
    is_set = lambda key: bool(entry.get(key))
    colour = colours(entry["RGBPoints"], entry.get("ColorSpace", "RGB"), is_set("UseLogScale"), is_set("HSVWrap"))
    return sampled(colour, opacities(entry["Points"]) if "Points" in entry else None)


def counted(text):
    numbers = [float(word) for word in text.split()]
    assert numbers[0] == len(numbers) - 1
    return numbers[1:]


def of_property(colour, opacity):
    points = [[x, y, 0.5, 0.0] for x, y in numpy.reshape(counted(opacity), (-1, 2))]
    return sampled(colours(counted(colour), "RGB"), opacities(points))


def expected(file):
    """Name and values of every continuous function in `file`."""
    text = file.read_text()
    if file.suffix == ".json":
        # ParaView's own file ends in a comma.
        entries = json.loads(re.sub(r",(\s*[\]}])", r"\1", text))
        entries = entries if isinstance(entries, list) else [entries]
        for entry in entries:
            if "RGBPoints" in entry:
                yield entry["Name"], of_map(entry)
            elif "colorTransfer" in entry:
                yield entry["name"], of_property(entry["colorTransfer"], entry["scalarOpacity"])
    elif file.suffix == ".xml":
        for entry in xml.etree.ElementTree.fromstring(text).iter("VolumeProperty"):
            yield entry.get("name"), of_property(entry.get("colorTransfer"), entry.get("scalarOpacity"))
    elif file.suffix == ".vp":
        opacity, _, colour = [line for line in text.splitlines() if len(line.split()) > 1]
        yield None, of_property(colour, opacity)
    elif file.suffix == ".itf":
        root = xml.etree.ElementTree.fromstring(text)
        rows = [[float(p.find("pos").get("content")), *(float(p.find("rgba").get(c)) for c in "xyzw")]
                for p in root.iter("Point")]
        yield None, sampled(colours([row[:4] for row in rows], "RGB"),
                            opacities([[row[0], row[4], 0.5, 0.0] for row in rows]))
    elif file.suffix == ".txt":
        rows = numpy.loadtxt(file)
        places = numpy.arange(len(rows)) / (len(rows) - 1)
        yield None, sampled(colours(numpy.column_stack([places, rows]), "RGB"), None)


def compare(program, files):
    worst, count, bad = 0.0, 0, 0
    for file in map(pathlib.Path, files):
        found_names = {}
        for name, (low, high, rows) in expected(file):
            if name in found_names:
                print(f"{file.name} #{name}: a second one of this name, not reached")
                continue
            found_names[name] = True
            argument = f"{file}#{name}" if name else str(file)
            run = subprocess.run([program, argument], capture_output=True, text=True)
            if run.returncode:
                print(f"{argument}: {run.stderr.strip()}")
                bad += 1
                continue
            found = json.loads(run.stdout)
            if found["range"] and not numpy.allclose(found["range"], [low, high]):
                print(f"{argument}: range {found['range']}, VTK {[low, high]}")
                bad += 1
            error = numpy.abs(numpy.array(found["rgba"]) - rows).max()
            count, worst = count + 1, max(worst, error)
            if error > 1 / 255:
                at = numpy.abs(numpy.array(found["rgba"]) - rows).max(axis=1).argmax()
                print(f"{argument}: off by {error * 255:.2f}/255 at {at}: {found['rgba'][at]}, VTK {rows[at]}")
                bad += 1
    print(f"{count} functions, {bad} differ; the largest difference is {worst * 255:.3f}/255")
    return bad


STOPS = [0, 0.1, 0.1, 0.9, 0.3, 0.9, 0.8, 0.1, 0.7, 0.9, 0.2, 0.1, 1, 0.95, 0.95, 0.9]
MAPS = [
    {"ColorSpace": space, "RGBPoints": STOPS} for space in ["RGB", "HSV", "Lab", "Diverging", "Step", "Lab/CIEDE2000"]
] + [
    {"ColorSpace": "HSV", "HSVWrap": 1, "RGBPoints": STOPS},
    {"ColorSpace": "RGB", "UseLogScale": 1, "RGBPoints": [0.01, 0, 0, 0, 1, 1, 0, 0, 1000, 1, 1, 1]},
    {"ColorSpace": "RGB", "RGBPoints": [-100, 0, 0, 0, 300, 1, 1, 1],
     "Points": [-50, 0, 0.2, 0, 20, 0.8, 0.7, 0.5, 90, 0.1, 0.5, 1, 120, 0.6, 0.3, 0.9, 200, 0.2, 0.5, 0.1, 250, 1, 0.5, 0]},
    {"ColorSpace": "Prolab", "RGBPoints": STOPS},
]


def write():
    cases = []
    for number, entry in enumerate(MAPS):
        entry = {"Name": str(number), **entry}
        low, high, rows = of_map(entry)
        # Every 37th value: the places are no multiples of those of the points.
        cases.append({"map": entry, "range": [low, high], "every": 37,
                      "rgba": [[round(float(x), 6) for x in row] for row in rows[::37]]})
    OUTPUT.write_text("[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]\n")


if __name__ == "__main__":
    if sys.argv[1:2] == ["write"]:
        write()
    elif len(sys.argv) > 3 and sys.argv[1] == "compare":
        sys.exit(min(compare(sys.argv[2], sys.argv[3:]), 1))
    else:
        sys.exit(__doc__)
