#!/usr/bin/env python3
"""NumPy, HDF5 and NetCDF files in hundreds of variants, read here and by the libraries that wrote them.

    pip install numpy h5py netCDF4 xarray scipy
    python tests/reference/arrays.py compare [PROGRAM]   # all variants; PROGRAM is the built describe_volumes
    python tests/reference/arrays.py samples             # writes crates/fovol-io/tests/array_files

Every variant is written by one of the libraries. What the array should be as a volume follows from the NumPy array that
went in, and for packed NetCDF values from what netCDF4 or xarray reads back. Compared are size, type, spacing, unit,
times, components and every value. Variants that are refused on purpose must give an error of one line.
"""

import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import scipy.io
import xarray

from summary import Summary

REPOSITORY = Path(__file__).resolve().parents[2]
SAMPLES = REPOSITORY / "crates/fovol-io/tests/array_files"
PROGRAM = ["cargo", "run", "--release", "-q", "-p", "fovol-io", "--example", "describe_volumes"]
TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8"]
# One in so many values of a sample is written down.
EVERY = 5
RANDOM = np.random.default_rng(7)


def numbers(shape, dtype):
    """Random values of all bits of an integer, or moderate floats."""
    dtype = np.dtype(dtype)
    if dtype.kind == "b":
        return RANDOM.integers(0, 2, shape).astype(bool)
    if dtype.kind == "f":
        return RANDOM.normal(0, 100, shape).astype(dtype)
    info = np.iinfo(dtype)
    return RANDOM.integers(info.min, info.max, shape, dtype=dtype.newbyteorder("="), endpoint=True).astype(dtype)


def short(dtype):
    dtype = np.dtype(dtype)
    return "u8" if dtype.kind == "b" else f"{dtype.kind}{8 * dtype.itemsize}"


class Case:
    """A file, the choices of the user, and the volume it should give; no volume where it is refused."""

    def __init__(self, path, volume, **said):
        self.path, self.volume = path, volume
        self.order = {key: said.pop(key) for key in ("array", "time", "channel", "component") if key in said}
        self.said = said


class Cases:
    def __init__(self, folder):
        self.folder, self.cases = folder, []

    def path(self, ending):
        return self.folder / f"{len(self.cases):04d}{ending}"

    def add(self, path, volume, **said):
        self.cases.append(Case(path, volume, **said))


# NumPy


def numpy_files(cases):
    shapes = [(3, 4, 5), (7, 6), (1, 5, 4), (40, 3, 35), (6, 5, 4, 1), (1, 6, 5, 9)]
    for code, order, shape in itertools.product(TYPES, "<>", shapes):
        values = numbers(shape, order + code)
        for memory in "CF":
            path = cases.path(".npy")
            np.save(path, np.asarray(values, order=memory))
            cases.add(path, values)
    for version in [(1, 0), (2, 0), (3, 0)]:
        path, values = cases.path(".npy"), numbers((3, 4, 5), "<i2")
        with open(path, "wb") as file:
            np.lib.format.write_array(file, values, version=version)
        cases.add(path, values)
    path, values = cases.path(".npy"), numbers((3, 4, 5), "?")
    np.save(path, values)
    cases.add(path, values)
    path, values = cases.path(".npy"), numbers((6, 5, 4, 3), "u1")
    np.save(path, values)
    for component in range(3):
        cases.add(path, values[..., component], component=component, components=3)
    for memory in "CF":
        path, values = cases.path(".npy"), numbers((7, 6, 5, 9), "<f4")
        np.save(path, np.asarray(values, order=memory))
        for time in (0, 6):
            cases.add(path, values[time], time=time, times=7)
    for values in [
        np.zeros((3, 3, 3), "c8"), np.zeros((3, 3, 3), "c16"), np.zeros((3, 3, 3), "O"), np.zeros((3, 3, 3), "g"),
        np.zeros((3, 3, 3), "U4"), np.zeros((3, 3, 3), "S4"), np.zeros((3, 3, 3), "M8[s]"), np.zeros(9, "f4"),
        np.zeros((3, 3), [("a", "f4"), ("b", "i4")]), np.zeros((9, 0, 9)), np.zeros((9, 9, 9, 9, 9)), np.float32(1),
    ]:  # fmt: skip
        path = cases.path(".npy")
        np.save(path, values, allow_pickle=True)
        cases.add(path, None)
    for save, memory in itertools.product((np.savez, np.savez_compressed), "CF"):
        path = cases.path(".npz")
        small, large = numbers((3, 4, 5), "<u2"), np.asarray(numbers((5, 6, 7), ">f4"), order=memory)
        save(path, flat=np.zeros((50, 50)), small=small, large=large, line=np.arange(900))
        cases.add(path, large, chosen="large")
        cases.add(path, small, array="small", chosen="small")
        cases.add(path, None, array="line")
        cases.add(path, None, array="gone")
    path, values = cases.path(".npz"), numbers((3, 4, 5), "<u2")
    np.savez(path, values)
    cases.add(path, values, chosen="arr_0")


# HDF5


def hdf5_options():
    """Arguments of create_dataset: every layout and filter that h5py writes."""
    yield {}
    # Chunks larger than the data need room to grow.
    yield {"chunks": (8, 16, 16), "maxshape": (None, None, None)}
    for chunks in [(2, 3, 4), (7, 9, 11), (1, 9, 11), True]:
        yield {"chunks": chunks}
        yield {"chunks": chunks, "maxshape": (None, 9, 11)}
        yield {"chunks": chunks, "maxshape": (None, None, None)}
    for filters in [
        {"compression": "gzip"}, {"compression": "gzip", "shuffle": True}, {"compression": "lzf"},
        {"compression": "lzf", "shuffle": True}, {"shuffle": True}, {"fletcher32": True},
        {"compression": "gzip", "shuffle": True, "fletcher32": True},
        {"compression": "szip"}, {"compression": "szip", "compression_opts": ("ec", 8)},
        {"compression": "gzip", "chunks": (3, 4, 5)}, {"compression": "gzip", "maxshape": (None, 9, None), "chunks": (2, 2, 8)},
    ]:  # fmt: skip
        yield filters


def hdf5_datasets(cases):
    for libver, code, order in itertools.product(("earliest", "latest", ("v108", "v108")), TYPES, "<>"):
        for options in hdf5_options() if code in ("u1", "u2", "f4") else [{}, {"compression": "gzip", "shuffle": True}]:
            values, path = numbers((7, 9, 11), order + code), cases.path(".h5")
            with h5py.File(path, "w", libver=libver) as file:
                file.create_dataset("data", data=values, **options)
            cases.add(path, values, label=f"{libver} {order}{code} {options}")


def hdf5_specials(cases):
    def file(**options):
        return h5py.File(cases.path(".h5"), "w", **options)

    for libver in ("earliest", "latest"):
        with file(libver=libver, userblock_size=1024) as f:
            values = f["v"] = numbers((4, 5, 6), "<i4")
        cases.add(cases.path(".h5"), values)
        with file(libver=libver) as f:
            values = numbers((4, 5, 6), "u1")
            dcpl = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            dcpl.set_layout(h5py.h5d.COMPACT)
            dataset = h5py.h5d.create(f.id, b"v", h5py.h5t.STD_U8LE, h5py.h5s.create_simple((4, 5, 6)), dcpl)
            dataset.write(h5py.h5s.ALL, h5py.h5s.ALL, values)
        cases.add(cases.path(".h5"), values)
        for offset in (0, 3):
            with file(libver=libver) as f:
                values = RANDOM.integers(0, 900, (8, 9, 10)).astype("i4")
                f.create_dataset("v", data=values, chunks=(4, 5, 5), scaleoffset=offset and 12, compression="gzip")
            cases.add(cases.path(".h5"), values)
        with file(libver=libver) as f:
            values = RANDOM.normal(0, 1, (8, 9, 10)).astype("f4")
            f.create_dataset("v", data=values, chunks=(4, 5, 5), scaleoffset=3)
        # What is lost in packing shows only when the file is read again.
        with h5py.File(cases.path(".h5")) as f:
            values = f["v"][...]
        cases.add(cases.path(".h5"), values)
        # Chunks that nobody wrote have the fill value.
        for chunks in (None, (4, 4, 4)):
            with file(libver=libver) as f:
                dataset = f.create_dataset("v", (9, 10, 11), "<f4", chunks=chunks, fillvalue=-2.5)
                dataset[5:7, 2:4] = 3
                values = dataset[...]
            cases.add(cases.path(".h5"), values)
            with file(libver=libver) as f:
                values = f.create_dataset("v", (9, 10, 11), ">i2", chunks=chunks, fillvalue=7)[...]
            cases.add(cases.path(".h5"), values)
        # Sizes that were changed.
        with file(libver=libver) as f:
            dataset = f.create_dataset("v", data=numbers((9, 9, 9), "u2"), chunks=(4, 4, 4), maxshape=(None,) * 3)
            dataset.resize((12, 5, 10))
            dataset[9:, 1:3] = 77
            values = dataset[...]
        cases.add(cases.path(".h5"), values)
        with file(libver=libver) as f:
            dataset = f.create_dataset("v", (64, 8, 8), "u2", chunks=(1, 8, 8), maxshape=(None, 8, 8), compression="gzip")
            for z in range(64):
                dataset[z] = values = numbers((8, 8), "u2")
            values = dataset[...]
        cases.add(cases.path(".h5"), values)
        # More chunks than one node or block of an index holds.
        for maxshape in (None, (None, 60, 60), (None, None, None)):
            with file(libver=libver) as f:
                values = numbers((60, 60, 60), "u1")
                f.create_dataset("v", data=values, chunks=(3, 4, 5), maxshape=maxshape)
            cases.add(cases.path(".h5"), values)
        # Groups, links, attributes in masses.
        with file(libver=libver, track_order=libver == "latest") as f:
            values = numbers((4, 5, 6), "<f8")
            f["a/b/c/volume"] = values
            f["other"] = np.zeros((2, 2, 2))
            f["link"] = h5py.SoftLink("/a/b/c/volume")
            f["circle"] = h5py.SoftLink("/a")
            f["a/b/up"] = f["a"]
            f["outside"] = h5py.ExternalLink("elsewhere.h5", "/v")
            f["text"] = "some text"
            for i in range(60):
                f[f"many/group{i}/line"] = np.arange(3)
                f["a/b/c/volume"].attrs[f"attribute{i}"] = "x" * 30
        path = cases.path(".h5")
        cases.add(path, values)
        for name in ("/a/b/c/volume", "a/b/c/volume", "/link"):
            cases.add(path, values, array=name)
        cases.add(path, None, array="/gone")
        cases.add(path, None, array="/outside")
        cases.add(path, None, array="/text")
        cases.add(Path(f"{path}:/other"), np.zeros((2, 2, 2)), chosen="/other")
        # Times, components, axes of values.
        with file(libver=libver) as f:
            values = f["v"] = numbers((5, 4, 6, 7), "<i2")
        path = cases.path(".h5")
        for time in (0, 4):
            cases.add(path, values[time], time=time, times=5)
        with file(libver=libver) as f:
            values = numbers((5, 4, 6, 7), "<i2")
            f.create_dataset("v", data=values, chunks=(2, 3, 3, 3), compression="gzip")
        path = cases.path(".h5")
        for time in (0, 3):
            cases.add(path, values[time], time=time, times=5)
        with file(libver=libver) as f:
            values = f["v"] = numbers((5, 4, 6, 3), "u1")
        cases.add(cases.path(".h5"), values[..., 2], component=2, components=3)
        with file(libver=libver) as f:
            values = numbers((5, 4, 6, 2), "<f4")
            dataset = f.create_dataset("v", (5, 4, 6), np.dtype(("<f4", (2,))))
            dataset[...] = values
        cases.add(cases.path(".h5"), values[..., 1], component=1, components=2)
        # Types.
        with file(libver=libver) as f:
            values = f["v"] = numbers((4, 5, 6), "?")
        cases.add(cases.path(".h5"), values, type="i8")
        with file(libver=libver) as f:
            values = RANDOM.integers(0, 3, (4, 5, 6)).astype("u2")
            f.create_dataset("v", data=values, dtype=h5py.enum_dtype({"A": 0, "B": 1, "C": 2}, basetype="u2"))
        cases.add(cases.path(".h5"), values)
        for values in [
            np.zeros((3, 3, 3), "c8"), np.zeros((3, 3, 3), "g"), np.zeros((3, 3, 3), [("a", "f4"), ("b", "i4")]),
            np.zeros((3, 3, 3), "S4"), np.arange(9), np.float32(1), np.zeros((9, 0, 9)), np.zeros((9,) * 5, "u1"),
        ]:  # fmt: skip
            with file(libver=libver) as f:
                f["v"] = values
            cases.add(cases.path(".h5"), None)
        with file(libver=libver):
            pass
        cases.add(cases.path(".h5"), None)
        # Spacing.
        for name, units in [("element_size_um", "µm"), ("spacing", None), ("voxel_size", None), ("resolution", None)]:
            with file(libver=libver) as f:
                values = f["v"] = numbers((4, 5, 6), "u1")
                f["v"].attrs[name] = np.array([3.0, 2.0, 0.5], "f4" if units else "f8")
            cases.add(cases.path(".h5"), values, spacing=[0.5, 2, 3], units=units)
        with file(libver=libver) as f:
            values = f["v"] = numbers((4, 5, 6), "u1")
            for axis, (name, step) in enumerate(zip("zyx", (4.0, 2.0, 0.25))):
                f[name] = np.arange(values.shape[axis]) * step + 1
                f[name].make_scale(name)
                f[name].attrs["units"] = "mm"
                f["v"].dims[axis].attach_scale(f[name])
        cases.add(cases.path(".h5"), values, spacing=[0.25, 2, 4], units="mm")
        microscopes(cases, file, libver)


def microscopes(cases, file, libver):
    with file(libver=libver) as f:
        values = {}
        for t, s, level in itertools.product(range(2), range(2), range(2)):
            found = values[t, s, level] = numbers((8 >> level, 10 >> level, 12 >> level), "i2")
            f.create_dataset(f"t{t:05d}/s{s:02d}/{level}/cells", data=found, chunks=(4, 4, 4), compression="gzip")
        for s in range(2):
            f[f"s{s:02d}/resolutions"] = np.array([[1.0, 1, 1], [2, 2, 2]])
            f[f"s{s:02d}/subdivisions"] = np.array([[4, 4, 4], [4, 4, 4]], "i4")
    path = cases.path(".h5")
    for t, s in itertools.product(range(2), range(2)):
        cases.add(path, values[t, s, 0].view("u2"), time=t, channel=s, times=2)
    with file(libver=libver) as f:
        def text(group, **said):
            for name, value in said.items():
                f.require_group(group).attrs[name] = np.frombuffer(str(value).encode(), "S1")

        values = numbers((8, 10, 12), "u2")
        text("DataSetInfo/Image", X=12, Y=9, Z=7, ExtMin0=0, ExtMin1=0, ExtMin2=1, ExtMax0=6, ExtMax1=9, ExtMax2=15, Unit="um")
        text("DataSetInfo/Channel 0", Name="DAPI")
        f.create_dataset("DataSet/ResolutionLevel 0/TimePoint 0/Channel 0/Data", data=values, chunks=(4, 4, 4), compression="gzip")
        text("DataSet/ResolutionLevel 0/TimePoint 0/Channel 0", ImageSizeX=12, ImageSizeY=9, ImageSizeZ=7)
    cases.add(cases.path(".h5"), values[:7, :9], spacing=[0.5, 1, 2], units="µm")


# NetCDF

KINDS = ["NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "NETCDF4", "NETCDF4_CLASSIC"]


def netcdf_files(cases):
    for kind, code in itertools.product(KINDS, TYPES):
        if code == "f2" or (code in ("u1", "u2", "u4", "u8", "i8") and kind not in ("NETCDF4", "NETCDF3_64BIT_DATA")):
            continue
        for is_unlimited, steps, has_scale, has_fill in itertools.product((False, True), (None, (3, 2, 0.5), (-3, 2, 0.5)), (False, True), (False, True)):
            if has_scale and code[0] == "f":
                continue
            path = cases.path(".nc")
            with netCDF4.Dataset(path, "w", format=kind) as file:
                raw = write_variable(file, code, is_unlimited, steps, has_scale, has_fill)
            with netCDF4.Dataset(path) as file:
                # Without an attribute, netCDF4 takes its default fill values for marks; others do not.
                file["v"].set_auto_mask(has_fill)
                expected = np.ma.filled(np.ma.asarray(file["v"][...]).astype("f8"), np.nan)
            is_marked = has_fill and np.isnan(expected).any()
            cases.add(
                path, expected, type=None if is_marked else short(raw.dtype), label=f"{kind} {code}",
                spacing=[0.5, 2, 3] if steps else None, units="m" if steps else None, tolerance=2e-7 if has_scale else 0,
            )  # fmt: skip


def write_variable(file, code, is_unlimited, steps, has_scale, has_fill):
    shape = (4, 5, 6)
    for axis, name in enumerate("zyx"):
        file.createDimension(name, None if is_unlimited and axis == 0 else shape[axis])
        if steps:
            coordinate = file.createVariable(name, "f8", (name,))
            coordinate[:] = 10 + np.arange(shape[axis]) * steps[axis]
            coordinate.units = "m"
    raw = numbers(shape, code)
    mark = raw.dtype.type(99)
    variable = file.createVariable("v", code, ("z", "y", "x"), fill_value=mark if has_fill else False)
    if has_fill:
        raw[1, 2:4] = mark
    if has_scale:
        variable.scale_factor, variable.add_offset = 0.25, 10.0
    variable.set_auto_maskandscale(False)
    variable[:] = raw
    # Several variables share the records of one file.
    file.createVariable("w", "i1", ("z", "y"))[:] = np.ones(shape[:2])
    return raw


def netcdf_specials(cases):
    for kind in KINDS:
        path = cases.path(".nc")
        values = numbers((3, 4, 5, 6), "f4")
        with netCDF4.Dataset(path, "w", format=kind) as file:
            for name, length in [("time", None), ("lev", 4), ("lat", 5), ("lon", 6)]:
                file.createDimension(name, length)
            time = file.createVariable("time", "f8", ("time",))
            time.units = "days since 2001-01-01"
            file.createVariable("t", "f4", ("time", "lev", "lat", "lon"))[:] = values
            file.createVariable("s", "f4", ("time", "lat", "lon"))[:] = values[:, 0]
            time[:] = np.arange(3)
        for t in (0, 2):
            cases.add(path, values[t], time=t, times=3, chosen="t")
            cases.add(path, values[t, 0], time=t, times=3, array="s")
        cases.add(Path(f"{path}:s"), values[0, 0], times=3)
        cases.add(path, None, array="gone")
        cases.add(path, None, time=3)
        path = cases.path(".nc")
        with netCDF4.Dataset(path, "w", format=kind) as file:
            for name, length in [("z", 4), ("y", 5), ("x", 6)]:
                file.createDimension(name, length)
            variable = file.createVariable("v", "i2", ("z", "y", "x"))
            variable.missing_value = np.int16(5)
            variable.valid_range = np.array([-900, 900], "i2")
            variable.set_auto_maskandscale(False)
            variable[:] = RANDOM.integers(-1000, 1000, (4, 5, 6)).astype("i2")
        with netCDF4.Dataset(path) as file:
            expected = np.ma.filled(file["v"][...].astype("f8"), np.nan)
        cases.add(path, expected, type="f32")
    for order, is_mapped in itertools.product("<>", (False, True)):
        path = cases.path(".nc")
        values = numbers((4, 5, 6), order + "i2")
        with scipy.io.netcdf_file(path, "w", version=2 if is_mapped else 1) as file:
            for name, length in [("z", None), ("y", 5), ("x", 6)]:
                file.createDimension(name, length)
            file.createVariable("v", "i2", ("z", "y", "x"))[:] = values
        cases.add(path, values)
    for engine in ("netcdf4", "scipy"):
        path = cases.path(".nc")
        values = RANDOM.normal(0, 1, (4, 5, 6)).astype("f4")
        values[2, 2] = np.nan
        array = xarray.DataArray(
            values, dims=("z", "y", "x"), name="density",
            coords={"z": np.arange(4) * 3.0, "y": np.arange(5) * 2.0, "x": np.arange(6) * 0.5},
        )  # fmt: skip
        encoding = {"density": {"dtype": "i2", "scale_factor": 0.001, "add_offset": 1.0, "_FillValue": -32768}}
        array.to_dataset().to_netcdf(path, engine=engine, encoding=encoding)
        expected = xarray.load_dataset(path, engine=engine)["density"].values
        cases.add(path, expected, type="f32", spacing=[0.5, 2, 3], tolerance=1e-6)
    path = cases.path(".nc")
    with netCDF4.Dataset(path, "w") as file:
        group = file.createGroup("inner")
        for name, length in [("z", 4), ("y", 5), ("x", 6)]:
            group.createDimension(name, length)
        values = numbers((4, 5, 6), "f4")
        group.createVariable("v", "f4", ("z", "y", "x"), zlib=True, complevel=4)[:] = values
    cases.add(path, values, chosen="/inner/v")


def made(folder):
    cases = Cases(folder)
    for write in (numpy_files, hdf5_datasets, hdf5_specials, netcdf_files, netcdf_specials):
        write(cases)
    return cases.cases


# Comparison


def dims_of(volume):
    shape = [n for n in volume.shape]
    while len(shape) > 3 and 1 in shape:
        shape.remove(1)
    return ([1] * (3 - len(shape)) + shape)[::-1]


def problems(case, answer, values):
    if case.volume is None:
        if "error" not in answer:
            return ["it was read, but should be refused"]
        return [] if "\n" not in answer["error"] and len(answer["error"]) > 20 else [answer["error"]]
    if "error" in answer:
        return [answer["error"]]
    found = []
    wanted = {
        "dims": dims_of(case.volume), "dtype": case.said.get("type", short(case.volume.dtype)), "times": case.said.get("times", 1),
        "components": case.said.get("components", 1), "units": case.said.get("units"), "spacing": case.said.get("spacing") or [1.0] * 3,
    }  # fmt: skip
    if "chosen" in case.said:
        wanted["array"] = case.said["chosen"]
    for key, value in wanted.items():
        same = np.allclose(answer[key], value, rtol=1e-6) if key == "spacing" else answer[key] == value
        if not same and value is not None:
            found.append(f"{key} {answer[key]}, not {value}")
    # An assumed spacing is never silent.
    if not case.said.get("spacing") and not any("--spacing" in note for note in answer["notes"]):
        found.append("no note on the spacing")
    expected = case.volume.astype("f8").ravel()
    tolerance = case.said.get("tolerance", 0) * max(1.0, np.nanmax(np.abs(expected)))
    if values.shape != expected.shape or not np.allclose(values, expected, rtol=0, atol=tolerance, equal_nan=True):
        found.append(f"values {values[:4]}, not {expected[:4]}")
    return found


def kind_of(path):
    """The kind of file, and the library that wrote it."""
    kinds = {".npy": ("NumPy, `.npy`", "NumPy"), ".npz": ("NumPy, `.npz`", "NumPy"), ".h5": ("HDF5", "h5py")}
    if path.suffix in kinds:
        return kinds[path.suffix]
    is_classic = path.exists() and path.read_bytes()[:3] == b"CDF"
    return ("NetCDF, classic" if is_classic else "NetCDF-4"), "netCDF4, xarray, SciPy"


def compare(program, made=made, kind_of=kind_of):
    with tempfile.TemporaryDirectory() as folder:
        cases = made(Path(folder))
        output = Path(folder) / "values"
        orders = "".join(json.dumps({"path": str(case.path), "values": f"{output}{i}", **case.order}) + "\n" for i, case in enumerate(cases))
        answers = subprocess.run(program, input=orders, stdout=subprocess.PIPE, text=True, cwd=REPOSITORY, check=True).stdout
        agreed = refused = 0
        summary = Summary()
        for i, (case, line) in enumerate(zip(cases, answers.splitlines(), strict=True)):
            answer, path = json.loads(line), Path(f"{output}{i}")
            wrong = problems(case, answer, np.fromfile(path, "<f8") if path.exists() else None)
            agreed += not wrong and case.volume is not None
            refused += not wrong and case.volume is None
            summary.add(*kind_of(case.path), "differ" if wrong else "refused" if case.volume is None else "agree")
            if wrong:
                print(f"{case.path.name} {case.order} {case.said}: {'; '.join(wrong)}")
        summary.print()
        print(f"{len(cases)} variants: {agreed} agree, {refused} are refused as they should, {len(cases) - agreed - refused} differ")
        sys.exit(agreed + refused != len(cases))


def samples():
    """Small files of each kind with their values, for the test of the crate."""
    kept = {}
    steps = {numpy_files: 53, hdf5_datasets: 130, hdf5_specials: 7, netcdf_files: 71, netcdf_specials: 3}
    SAMPLES.mkdir(exist_ok=True)
    for old in SAMPLES.iterdir():
        old.unlink()
    with tempfile.TemporaryDirectory() as folder:
        for write, step in steps.items():
            cases = Cases(Path(folder) / write.__name__)
            cases.folder.mkdir()
            write(cases)
            small = [case for case in cases.cases if case.volume is not None and is_small(case)]
            # Files of the NetCDF-4 library are never so small.
            large = [case for case in cases.cases if case.said.get("label") == "NETCDF4 i2" and case.said["spacing"]]
            for case in small[::step] + small[-1:] + sorted(large, key=lambda case: case.path.stat().st_size)[:1]:
                name = f"{write.__name__}_{case.path.name}"
                (SAMPLES / name).write_bytes(case.path.read_bytes())
                kept.setdefault(name, []).append(described(case))
    lines = (f"{json.dumps(name)}: {json.dumps(found, separators=(',', ':'))}" for name, found in sorted(kept.items()))
    (SAMPLES / "values.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


def is_small(case):
    return case.path.exists() and case.path.stat().st_size < 7500 and case.volume.size <= 700


def described(case):
    def number(value):
        return None if np.isnan(value) else int(value) if value == int(value) else round(float(value), 6)

    values = [number(value) for value in case.volume.astype("f8").ravel()[::EVERY]]
    return {
        **case.order, "dims": dims_of(case.volume), "spacing": case.said.get("spacing") or [1.0] * 3,
        "tolerance": max(case.said.get("tolerance", 0), 1e-6), "values": values,
    }  # fmt: skip


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
