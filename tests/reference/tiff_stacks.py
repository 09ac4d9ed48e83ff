#!/usr/bin/env python3
"""Small TIFF stacks as tifffile writes them, and what their volumes hold.

    python tests/reference/tiff_stacks.py

Writes them to `crates/fovol-io/tests/tiff`, and `stacks.json` beside them: for every channel and time point of each file
the size, the spacing, its unit and the values, x fastest.
"""

import json
from pathlib import Path

import numpy as np
import tifffile

FOLDER = Path(__file__).resolve().parents[2] / "crates/fovol-io/tests/tiff"
# Slices, rows and columns of one volume.
SHAPE = (3, 4, 5)


def values(channels, times, dtype):
    """An array of axes T, Z, C, Y, X in which every value is another."""
    slices, rows, columns = SHAPE
    count = times * slices * channels * rows * columns
    return np.arange(count).astype(dtype).reshape(times, slices, channels, rows, columns)


def reference(array, spacing, units):
    """What each channel and time point of `array` (T, Z, C, Y, X) is as a volume."""
    volumes = []
    for time in range(array.shape[0]):
        for channel in range(array.shape[2]):
            part = array[time, :, channel]
            dims = list(part.shape[::-1])
            volume = {"channel": channel, "time": time, "dims": dims, "spacing": spacing, "units": units}
            volumes.append(volume | {"values": [float(v) for v in part.ravel()]})
    return volumes


def main():
    FOLDER.mkdir(exist_ok=True)
    stacks = {}

    def write(name, array, reference, **settings):
        # Three slices are no three colours.
        tifffile.imwrite(FOLDER / name, array, **{"photometric": "minisblack"} | settings)
        stacks[name] = reference

    many = values(2, 2, "uint16")
    spaced = {"spacing": 0.3, "unit": "um", "axes": "TZCYX"}
    pitch = {"resolution": (10.0, 5.0), "resolutionunit": 1}
    expected = reference(many, [0.1, 0.2, 0.3], "µm")
    write("imagej.tif", many, expected, imagej=True, metadata=spaced, **pitch)
    write("imagej_one_page.tif", many, expected, imagej=True, metadata=spaced, truncate=True, **pitch)
    one = values(1, 1, "uint16")
    metadata = {"spacing": 2.0, "unit": "mm", "axes": "ZYX"}
    expected = reference(one, [1.0, 1.0, 2.0], "mm")
    write("imagej_one_page_zyx.tif", one[0, :, 0], expected, imagej=True, metadata=metadata, truncate=True)

    sizes = {"PhysicalSizeX": 0.5, "PhysicalSizeY": 0.25, "PhysicalSizeZ": 2000.0, "PhysicalSizeZUnit": "nm"}
    expected = reference(many, [0.5, 0.25, 2.0], "µm")
    for axes in ("TZCYX", "TCZYX", "CTZYX", "ZTCYX"):
        order = ["TZCYX".index(axis) for axis in axes]
        metadata = {"axes": axes, "Channel": {"Name": ["DAPI", "GFP"]}, **sizes}
        write(f"ome_{axes.lower()}.ome.tif", many.transpose(order), expected, ome=True, metadata=metadata)
    channels = values(2, 1, "uint8")
    expected = reference(channels, [1.0, 1.0, 1.0], None)
    write("shaped.tif", channels[0].transpose(1, 0, 2, 3), expected, metadata={"axes": "CZYX"})
    centimetres = values(1, 1, "uint8")
    expected = reference(centimetres, [0.05, 0.05, 0.05], "mm")
    write("centimetres.tif", centimetres[0, :, 0], expected, resolution=(200, 200), resolutionunit=3)
    for dtype in ("uint8", "int16", "float32"):
        array = values(1, 1, dtype) - (30 if dtype != "uint8" else 0)
        expected = reference(array, [1.0, 1.0, 1.0], None)
        write(f"white_{dtype}.tif", array[0, :, 0].astype(dtype), expected, photometric="miniswhite")

    # What was written is what tifffile reads.
    for name, volumes in stacks.items():
        total = sum(sum(volume["values"]) for volume in volumes)
        assert tifffile.imread(FOLDER / name).astype(float).sum() == total, name
    (FOLDER / "stacks.json").write_text(json.dumps(stacks, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
