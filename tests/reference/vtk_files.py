#!/usr/bin/env python3
"""Rectilinear grids and parallel images that VTK writes, read here and by VTK.

    pip install numpy vtk
    python tests/reference/vtk_files.py compare [PROGRAM]   # PROGRAM is the built describe_volumes
    python tests/reference/vtk_files.py samples             # writes crates/fovol-io/tests/vtk_files

Compared are size, spacing, the place of the first voxel and every value. Values at points of equal distances are those
that VTK reads; at others they are those of VTK's own probe filter at the points of the volume.
"""

import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from summary import Summary

REPOSITORY = Path(__file__).resolve().parents[2]
SAMPLES = REPOSITORY / "crates/fovol-io/tests/vtk_files"
PROGRAM = ["cargo", "run", "--release", "-q", "-p", "fovol-io", "--example", "describe_volumes"]
RANDOM = np.random.default_rng(5)
DIMS = (7, 5, 4)
EVEN = (np.arange(7) * 0.5 + 3, np.arange(5) * 2.0 - 1, np.arange(4) * 0.25)
UNEVEN = (np.array([0, 1, 1.5, 2, 4, 5, 5.5]), np.array([-3, -2, 0, 1, 5.0]), np.array([0.0, 1, 3, 3.5]))
MIXED = (EVEN[0], UNEVEN[1], EVEN[2])


def numbers(count, dtype, components=1):
    shape = (count, components) if components > 1 else count
    if np.dtype(dtype).kind == "f":
        return RANDOM.normal(0, 50, shape).astype(dtype)
    return RANDOM.integers(0, 120, shape).astype(dtype)


def attached(data, dtype, components):
    for attributes, count, name in ((data.GetPointData(), data.GetNumberOfPoints(), "p"), (data.GetCellData(), data.GetNumberOfCells(), "c")):
        array = numpy_to_vtk(numbers(count, dtype, components), deep=True)
        array.SetName(name)
        attributes.AddArray(array)
        if components == 1:
            attributes.SetScalars(array)
    return data


def grid(coordinates, dtype, components=1):
    made = vtk.vtkRectilinearGrid()
    made.SetDimensions(*(len(axis) for axis in coordinates))
    for axis, values in zip("XYZ", coordinates):
        getattr(made, f"Set{axis}Coordinates")(numpy_to_vtk(values.astype("f4" if dtype == "f4" else "f8"), deep=True))
    return attached(made, dtype, components)


def image(dtype, components=1):
    made = vtk.vtkImageData()
    made.SetExtent(-2, 6, 1, 7, 0, 5)
    made.SetSpacing(0.5, 1, 2)
    made.SetOrigin(3, 4, 5)
    return attached(made, dtype, components)


def saved(writer, data, path, mode, compressor, **more):
    writer.SetInputData(data)
    writer.SetFileName(str(path))
    if mode == "ascii":
        writer.SetDataModeToAscii()
    elif mode == "binary":
        writer.SetDataModeToBinary()
    else:
        writer.SetDataModeToAppended()
    writer.SetCompressorType(compressor)
    for name, value in more.items():
        getattr(writer, f"Set{name}")(value)
    assert writer.Write() == 1


def made(folder):
    cases = []
    kinds = ["u1", "i2", "f4", "f8"]
    for number, (coordinates, dtype, mode, compressor) in enumerate(itertools.product((EVEN, UNEVEN, MIXED), kinds, ("ascii", "binary", "appended"), (0, 1, 2))):
        if mode == "ascii" and compressor:
            continue
        path = folder / f"{number:04d}.vtr"
        data = grid(coordinates, dtype)
        saved(vtk.vtkXMLRectilinearGridWriter(), data, path, mode, compressor)
        cases += [(path, "p", 0, data), (path, "c", 0, data)]
    path, data = folder / "vectors.vtr", grid(UNEVEN, "f4", 3)
    saved(vtk.vtkXMLRectilinearGridWriter(), data, path, "appended", 1)
    cases += [(path, "p", 2, data), (path, "c", 1, data)]
    for number, (coordinates, dtype, binary) in enumerate(itertools.product((EVEN, UNEVEN, MIXED), kinds, (False, True))):
        path, data, writer = folder / f"{number:04d}.vtk", grid(coordinates, dtype), vtk.vtkRectilinearGridWriter()
        writer.SetInputData(data)
        writer.SetFileName(str(path))
        writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
        assert writer.Write() == 1
        cases += [(path, "p", 0, data), (path, "c", 0, data)]
    for number, (dtype, pieces, ghosts, mode, components) in enumerate(itertools.product(kinds, (1, 2, 5), (0, 1), ("ascii", "binary", "appended"), (1, 3))):
        path, data = folder / f"{number:04d}.pvti", image(dtype, components)
        saved(vtk.vtkXMLPImageDataWriter(), data, path, mode, 1 + number % 2, NumberOfPieces=pieces, GhostLevel=ghosts, StartPiece=0, EndPiece=pieces - 1)
        cases += [(path, "p", components - 1, data), (path, "c", 0, data)]
    return cases


def expected(case, answer):
    """Values of the array in the data that was written, at the voxels that the answer says."""
    path, name, component, data = case
    is_cells = name != "p"
    attributes = data.GetCellData() if is_cells else data.GetPointData()
    source = attributes.GetArray("c" if is_cells else "p")
    flat = vtk_to_numpy(source).reshape(source.GetNumberOfTuples(), -1)[:, component].astype("f8")
    if isinstance(data, vtk.vtkImageData):
        points = np.array(data.GetDimensions())
        dims = points - 1 if is_cells else points
        origin = np.array(data.GetOrigin()) + np.array(data.GetSpacing()) * (np.array(data.GetExtent()[::2]) + 0.5 * is_cells)
        return dims, data.GetSpacing(), origin, flat
    axes = [vtk_to_numpy(getattr(data, f"Get{axis}Coordinates")()).astype("f8") for axis in "XYZ"]
    if is_cells:
        axes = [(axis[1:] + axis[:-1]) / 2 for axis in axes]
    origin = [axis[0] for axis in axes]
    # VTK interpolates the values on a grid of its own; those of cells are put at points in their middles.
    inner = vtk.vtkRectilinearGrid()
    inner.SetDimensions(*(len(axis) for axis in axes))
    for axis, values in zip("XYZ", axes):
        getattr(inner, f"Set{axis}Coordinates")(numpy_to_vtk(values, deep=True))
    array = numpy_to_vtk(flat, deep=True)
    array.SetName("v")
    inner.GetPointData().SetScalars(array)
    dims, spacing = answer["dims"], [(axis[-1] - axis[0]) / (count - 1) for axis, count in zip(axes, answer["dims"])]
    least = [np.diff(axis).min() for axis in axes]
    wanted = [len(axis) if np.allclose(np.diff(axis), least[i], rtol=1e-4) else min(int(np.ceil((axis[-1] - axis[0]) / least[i] - 1e-9)) + 1, 2 * len(axis)) for i, axis in enumerate(axes)]
    probes = vtk.vtkImageData()
    probes.SetDimensions(*dims)
    # A little inside, as the probe leaves out points on the border by rounding.
    shrink = 1 - 1e-12
    probes.SetSpacing(*(step * shrink for step in spacing))
    probes.SetOrigin(*origin)
    probe = vtk.vtkProbeFilter()
    probe.SetInputData(probes)
    probe.SetSourceData(inner)
    probe.Update()
    return wanted, spacing, origin, vtk_to_numpy(probe.GetOutput().GetPointData().GetArray("v"))


def compare(program):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cases = made(folder)
        path = folder / "gap.pvti"
        saved(vtk.vtkXMLPImageDataWriter(), image("f4"), path, "appended", 1, NumberOfPieces=3, StartPiece=0, EndPiece=2)
        (folder / "gap_1.vti").unlink()
        orders = "".join(
            json.dumps({"path": str(path), "array": "p" if array == "p" else "c", "component": component, "values": str(folder / f"v{i}")}) + "\n"
            for i, (path, array, component, _) in enumerate(cases)
        )  # fmt: skip
        orders += json.dumps({"path": str(folder / "gap.pvti")}) + "\n"
        answers = subprocess.run(program, input=orders, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY, check=True).stdout.splitlines()
        agreed = 0
        summary = Summary()
        kinds = {".vtr": "VTK, rectilinear `.vtr`", ".vtk": "VTK, rectilinear `.vtk`", ".pvti": "VTK, images in pieces `.pvti`"}
        for i, (case, line) in enumerate(zip(cases, answers)):
            answer, wrong = json.loads(line), []
            if "error" in answer:
                wrong = [answer["error"]]
            else:
                dims, spacing, origin, values = expected(case, answer)
                found = np.fromfile(folder / f"v{i}", "<f8")
                wrong += [] if list(dims) == answer["dims"] else [f"dims {answer['dims']}, not {list(dims)}"]
                wrong += [] if np.allclose(spacing, answer["spacing"], rtol=1e-6) else [f"spacing {answer['spacing']}, not {list(spacing)}"]
                wrong += [] if np.allclose(origin, answer["origin"], rtol=1e-6) else [f"origin {answer['origin']}, not {list(origin)}"]
                # Legacy files have six digits in text.
                is_text = case[0].suffix == ".vtk" and b"ASCII" in case[0].read_bytes()[:99]
                if not np.allclose(found, values, rtol=1e-5 if is_text else 2e-6, atol=1e-3 if is_text else 2e-5):
                    wrong += [f"values differ by {np.abs(found - values).max()}"]
            agreed += not wrong
            summary.add(kinds[case[0].suffix], "VTK", "differ" if wrong else "agree")
            if wrong:
                print(case[0].name, case[1], "; ".join(wrong))
        gap = json.loads(answers[-1]).get("error", "a missing piece was read")
        summary.add(kinds[".pvti"], "VTK", "refused" if "missing" in gap else "differ")
        summary.print()
        print(f"{len(cases)} variants: {agreed} agree; a missing piece: {gap}")
        sys.exit(agreed != len(cases) or "missing" not in gap)


def samples():
    """Small files with some of their values, for the test of the crate."""
    SAMPLES.mkdir(exist_ok=True)
    for old in SAMPLES.iterdir():
        old.unlink()
    kept = {}
    for name, data, writer, mode in [
        ("even.vtr", grid(EVEN, "i2"), vtk.vtkXMLRectilinearGridWriter(), "appended"),
        ("uneven.vtr", grid(UNEVEN, "f4"), vtk.vtkXMLRectilinearGridWriter(), "binary"),
        ("mixed.vtr", grid(MIXED, "u1"), vtk.vtkXMLRectilinearGridWriter(), "ascii"),
        ("pieces.pvti", image("i2"), vtk.vtkXMLPImageDataWriter(), "appended"),
    ]:
        more = {"NumberOfPieces": 3, "StartPiece": 0, "EndPiece": 2} if name == "pieces.pvti" else {}
        saved(writer, data, SAMPLES / name, mode, 1, **more)
        kept[name] = data
    for name, binary in (("uneven_text.vtk", False), ("uneven_binary.vtk", True)):
        data, writer = grid(UNEVEN, "f4"), vtk.vtkRectilinearGridWriter()
        writer.SetInputData(data)
        writer.SetFileName(str(SAMPLES / name))
        writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
        assert writer.Write() == 1
        kept[name] = data
    described = {}
    for name, data in kept.items():
        for array in ("p", "c"):
            axes = [np.asarray(axis) for axis in (EVEN if name == "even.vtr" else MIXED if name == "mixed.vtr" else UNEVEN)]
            counts = []
            for axis in axes:
                axis = (axis[1:] + axis[:-1]) / 2 if array == "c" else axis
                steps = np.diff(axis)
                counts.append(len(axis) if np.allclose(steps, steps[0]) else min(int(np.ceil((axis[-1] - axis[0]) / steps.min() - 1e-9)) + 1, 2 * len(axis)))
            dims, spacing, origin, values = expected((None, array, 0, data), {"dims": counts})
            described.setdefault(name, []).append({
                "array": array, "dims": [int(n) for n in dims], "spacing": [float(v) for v in spacing], "origin": [float(v) for v in origin],
                "values": [round(float(v), 4) for v in values[::3]],
            })  # fmt: skip
    (SAMPLES / "values.json").write_text(json.dumps(described, separators=(",", ":")).replace('],"', '],\n"') + "\n")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["compare"]:
            compare(PROGRAM)
        case ["compare", program]:
            compare([program])
        case ["samples"]:
            samples()
        case _:
            sys.exit(__doc__)
