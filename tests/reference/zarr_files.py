#!/usr/bin/env python3
"""Zarr and OME-Zarr in hundreds of variants, read here and by the libraries that wrote them.

    pip install zarr ome-zarr numcodecs xarray tifffile numpy
    python tests/reference/zarr_files.py compare [PROGRAM]   # all variants; PROGRAM is the built describe_volumes
    python tests/reference/zarr_files.py samples             # writes crates/fovol-io/tests/zarr_files

Every variant is written by one of the libraries. What it should be as a volume follows from the NumPy array that went
in, or from what the library reads back where the encoding loses some of it. Compared are size, type, spacing, unit,
position, times, channels, levels, labels and every value. Variants that are refused on purpose must give an error of
one line.
"""

import itertools
import json
import shutil
import subprocess
import sys
import tempfile
import warnings
import zipfile
from pathlib import Path

import numcodecs
import numpy as np
import ome_zarr.format
import ome_zarr.writer
import tifffile
import xarray
import zarr
import zarr.codecs as codecs
import zarr.codecs.numcodecs as outside

from summary import Summary

REPOSITORY = Path(__file__).resolve().parents[2]
SAMPLES = REPOSITORY / "crates/fovol-io/tests/zarr_files"
PROGRAM = ["cargo", "run", "--release", "-q", "-p", "fovol-io", "--example", "describe_volumes"]
TYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8"]
# One in so many values of a sample is written down.
EVERY = 7
# Bytes of the largest sample.
LARGEST = 4500
RANDOM = np.random.default_rng(7)
warnings.filterwarnings("ignore")


def numbers(shape, dtype):
    """Smooth values with some noise, so that codecs have something to pack, over the range of the type."""
    dtype = np.dtype(dtype)
    if dtype.kind == "b":
        return RANDOM.integers(0, 2, shape).astype(bool)
    smooth = np.add.outer(np.arange(np.prod(shape[:-1])) // 3, np.arange(shape[-1]) // 2).reshape(shape)
    if dtype.kind == "f":
        return (smooth * 0.5 - 9 + (RANDOM.random(shape) < 0.2)).astype(dtype)
    info = np.iinfo(dtype)
    wild = RANDOM.integers(info.min, info.max, shape, dtype=dtype.newbyteorder("="), endpoint=True)
    return np.where(RANDOM.random(shape) < 0.1, wild, smooth % 100).astype(dtype)


def short(dtype):
    dtype = np.dtype(dtype)
    return "u8" if dtype.kind == "b" else f"{dtype.kind}{8 * dtype.itemsize}"


class Case:
    """A file, the choices of the user, and the volume it should give; no volume where it is refused."""

    def __init__(self, path, volume, **said):
        self.path, self.volume = path, volume
        self.order = {key: said.pop(key) for key in ("array", "time", "channel", "component", "level") if key in said}
        self.said = said


class Cases:
    def __init__(self, folder):
        self.folder, self.cases, self.paths = folder, [], 0
        # The kind of the files that are added, and the library that writes them.
        self.kind = None

    def path(self, ending=".zarr"):
        self.paths += 1
        return self.folder / f"{self.paths:04d}{ending}"

    def add(self, path, volume, **said):
        case = Case(path, volume, **said)
        is_packed = any(ending in str(path) for ending in (".zip", ".ozx"))
        case.kind = ("Zarr in archives, `.zarr.zip` and `.ozx`", "zarr, ome-zarr") if is_packed else self.kind
        self.cases.append(case)


# Arrays alone

SHAPE = (7, 9, 11)
CHUNKS = [(7, 9, 11), (2, 3, 4), (1, 9, 11), (4, 4, 4), (8, 16, 16), (7, 1, 11)]
V2_CODECS = [
    None, numcodecs.Zstd(3), numcodecs.GZip(5), numcodecs.Zlib(1), numcodecs.BZ2(1), numcodecs.LZ4(),
    *[numcodecs.Blosc(cname, 5, shuffle) for cname in ("blosclz", "lz4", "lz4hc", "zlib", "zstd") for shuffle in (0, 1, 2)],
    numcodecs.Blosc("zstd", 0), numcodecs.Blosc("lz4", 9, 1, 128),
]  # fmt: skip


def v2(path, values, chunks, **options):
    array = zarr.create_array(path, shape=values.shape, dtype=values.dtype, chunks=chunks, zarr_format=2, **options)
    array[...] = values
    return array


def arrays_of_v2(cases):
    for code, order, memory, separator in itertools.product(TYPES, "<>", "CF", "./"):
        values, path = numbers(SHAPE, order + code), cases.path()
        v2(path, values, (3, 4, 5), order=memory, chunk_key_encoding={"name": "v2", "separator": separator})
        cases.add(path, values)
    for codec, code, chunks in itertools.product(V2_CODECS, ("u1", "<u2", ">f4", "<f8"), ((7, 9, 11), (3, 4, 5))):
        values, path = numbers(SHAPE, code), cases.path()
        v2(path, values, chunks, compressors=codec)
        cases.add(path, values, label=f"{codec} {code}")
    # Blocks that Blosc splits, with a last one that is shorter, and chunks of several blocks.
    for cname, shuffle, code in itertools.product(("blosclz", "lz4", "zlib", "zstd"), (0, 1, 2), ("u1", "<u2", "<f4", "<f8", "<i8")):
        values, path = numbers((33, 41, 57), code), cases.path()
        v2(path, values, (32, 40, 56), compressors=numcodecs.Blosc(cname, 5, shuffle, 4096))
        cases.add(path, values, label=f"{cname} {shuffle} {code}")
        values, path = numbers((40, 64, 64), code), cases.path()
        v2(path, values, (40, 64, 64), compressors=numcodecs.Blosc(cname, 5, shuffle))
        cases.add(path, values, label=f"{cname} {shuffle} {code}")
    for filters, code in [
        ([numcodecs.Delta("<i4")], "<i4"), ([numcodecs.Delta("<i2")], "<i2"), ([numcodecs.Delta("<f4")], "<f4"),
        ([numcodecs.Delta(">i4", ">i4")], ">i4"), ([numcodecs.FixedScaleOffset(-9.0, 10.0, "<f8", "<i4")], "<f8"),
        ([numcodecs.FixedScaleOffset(-9.0, 2.0, "<f4", "<u2")], "<f4"), ([numcodecs.Quantize(2, "<f4")], "<f4"),
        ([numcodecs.BitRound(8)], "<f4"), ([numcodecs.PackBits()], "?"), ([numcodecs.Shuffle(4)], "<f4"),
        ([numcodecs.CRC32()], "<u2"), ([numcodecs.Adler32()], "<u2"), ([numcodecs.Fletcher32()], "<u2"),
        ([numcodecs.Fletcher32()], "u1"), ([numcodecs.CRC32C()], "<u2"),
        ([numcodecs.Delta("<i4"), numcodecs.Shuffle(4)], "<i4"),
    ]:  # fmt: skip
        for codec in (None, numcodecs.Zlib(1), numcodecs.Blosc("lz4")):
            values, path = numbers(SHAPE, code), cases.path()
            array = v2(path, values, (3, 4, 5), filters=filters, compressors=codec)
            cases.add(path, array[...], label=f"{filters} {codec}", tolerance=1e-7)
    for chunks in CHUNKS:
        values, path = numbers(SHAPE, "<i2"), cases.path()
        v2(path, values, chunks)
        cases.add(path, values)
    for value, code in [(0, "u1"), (7, ">i2"), (-2.5, "<f4"), (np.nan, "<f4"), (np.inf, ">f8"), (2**64 - 1, "<u8"), (True, "?")]:
        path = cases.path()
        array = zarr.create_array(path, shape=SHAPE, dtype=code, chunks=(3, 4, 5), fill_value=value, zarr_format=2)
        array[3:6, 4:, :5] = numbers((3, 5, 5), code)
        cases.add(path, array[...])


V3_CODECS = [
    [], [codecs.ZstdCodec(level=3)], [codecs.GzipCodec(level=5)], [codecs.Crc32cCodec()], [codecs.ZstdCodec(), codecs.Crc32cCodec()],
    [codecs.ZstdCodec(checksum=True)], [outside.Zlib(level=1)], [outside.LZ4()], [outside.BZ2(level=1)], [outside.Shuffle(elementsize=2), outside.Zlib()],
    *[[codecs.BloscCodec(cname=cname, shuffle=shuffle)] for cname in ("blosclz", "lz4", "lz4hc", "zlib", "zstd") for shuffle in ("noshuffle", "shuffle", "bitshuffle")],
]  # fmt: skip


def v3(path, values, chunks, **options):
    endian = options.pop("endian", None)
    if endian:
        options["serializer"] = codecs.BytesCodec(endian=endian)
    array = zarr.create_array(path, shape=values.shape, dtype=values.dtype, chunks=chunks, zarr_format=3, **options)
    array[...] = values
    return array


def arrays_of_v3(cases):
    for code, endian, name, separator in itertools.product(TYPES, ("little", "big"), ("default", "v2"), "./"):
        values, path = numbers(SHAPE, code), cases.path()
        v3(path, values, (3, 4, 5), endian=endian, chunk_key_encoding={"name": name, "separator": separator})
        cases.add(path, values)
    for pipeline, code, chunks in itertools.product(V3_CODECS, ("u1", "u2", "f4", "f8"), ((7, 9, 11), (3, 4, 5))):
        # The filter of numcodecs wants whole values.
        if code == "u1" and any(isinstance(codec, outside.Shuffle) for codec in pipeline):
            continue
        values, path = numbers(SHAPE, code), cases.path()
        v3(path, values, chunks, compressors=pipeline)
        cases.add(path, values, label=f"{pipeline} {code}")
    for order, endian, code in itertools.product(itertools.permutations(range(3)), ("little", "big"), ("u1", "i2", "f4")):
        values, path = numbers(SHAPE, code), cases.path()
        v3(path, values, (3, 4, 5), filters=[codecs.TransposeCodec(order=order)], endian=endian)
        cases.add(path, values, label=f"{order}")
    for order, second in itertools.product(itertools.permutations(range(3)), repeat=2):
        values, path = numbers(SHAPE, "u2"), cases.path()
        v3(path, values, (3, 4, 5), filters=[codecs.TransposeCodec(order=order), codecs.TransposeCodec(order=second)])
        cases.add(path, values)
    for shards, chunks, code in itertools.product([(8, 9, 12), (4, 6, 6), (8, 12, 12)], [(2, 3, 3), (4, 3, 6), (1, 3, 2)], ("u1", "u2", "f4")):
        if any(shard % chunk for shard, chunk in zip(shards, chunks)):
            continue
        for compressors, location in itertools.product(([], [codecs.ZstdCodec()], [codecs.BloscCodec(cname="lz4")]), ("start", "end")):
            values, path = numbers(SHAPE, code), cases.path()
            inner = [codecs.BytesCodec(endian="big" if code == "f4" else "little"), *compressors]
            sharding = codecs.ShardingCodec(chunk_shape=chunks, codecs=inner, index_location=location)
            zarr.create_array(path, shape=SHAPE, dtype=code, chunks=shards, serializer=sharding, compressors=None)[...] = values
            cases.add(path, values, label=f"{shards} {chunks} {location}")
    # Transposed shards of transposed chunks, shards in shards, a packed shard.
    for order, second in itertools.product(itertools.permutations(range(3)), ((0, 1, 2), (2, 0, 1))):
        values, path = numbers(SHAPE, "u2"), cases.path()
        shard = (12, 12, 12)
        chunk = (6, 4, 3)
        inner = [codecs.TransposeCodec(order=second), codecs.BytesCodec(), codecs.ZstdCodec()]
        zarr.create_array(
            path, shape=SHAPE, dtype="u2", chunks=shard, filters=[codecs.TransposeCodec(order=order)],
            serializer=codecs.ShardingCodec(chunk_shape=chunk, codecs=inner), compressors=None,
        )[...] = values  # fmt: skip
        cases.add(path, values, label=f"{order} {second}")
    inner = codecs.ShardingCodec(chunk_shape=(2, 3, 3), codecs=[codecs.BytesCodec(), codecs.ZstdCodec()])
    for outer in ([], [codecs.GzipCodec()]):
        values, path = numbers(SHAPE, "u2"), cases.path()
        sharding = codecs.ShardingCodec(chunk_shape=(4, 6, 6), codecs=[inner, *outer])
        zarr.create_array(path, shape=SHAPE, dtype="u2", chunks=(8, 12, 12), serializer=sharding, compressors=outer or None)[...] = values
        cases.add(path, values)
    for value, code in [(0, "u1"), (7, "i2"), (-2.5, "f4"), (np.nan, "f4"), (-np.inf, "f8"), (2**64 - 1, "u8"), (True, "?")]:
        for options in ({}, {"shards": (6, 8, 10)}):
            path = cases.path()
            array = zarr.create_array(path, shape=SHAPE, dtype=code, chunks=(3, 4, 5), fill_value=value, **options)
            array[3:6, 4:, :5] = numbers((3, 5, 5), code)
            cases.add(path, array[...])
    for filters, code in [([outside.Delta(dtype="<i4")], "i4"), ([outside.FixedScaleOffset(offset=-9.0, scale=2.0, dtype="<f4", astype="<i2")], "f4")]:
        values, path = numbers(SHAPE, code), cases.path()
        array = v3(path, values, (3, 4, 5), filters=filters)
        cases.add(path, array[...], tolerance=1e-7)


def hierarchies(cases):
    """Groups, archives, axes by names, parts, files that are refused."""
    for version in (2, 3):
        path = cases.path()
        group = zarr.create_group(path, zarr_format=version, attributes={"not": float("nan")})
        small, large = numbers((3, 4, 5), "u2"), numbers((5, 6, 7), "f4")
        group.create_array("a/small", data=small)
        group.create_array("b/c/large", data=large)
        group.create_array("line", data=np.arange(900))
        cases.add(path, large, chosen="b/c/large")
        for name in ("a/small", "/a/small", "a//small/"):
            cases.add(path, small, array=name)
        cases.add(Path(f"{path}:a/small"), small)
        cases.add(path / "a" / "small", small)
        cases.add(path, None, array="gone")
        cases.add(path, None, array="../other")
        cases.add(path, None, array="line")
        cases.add(path, None, level=1)
        cases.add(path, None, array="a")
        for ending, method, inner in itertools.product((".zarr.zip", ".ozx", ".zip"), (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED), ("", "x.zarr/")):
            archive = zipped(path, cases.path(ending), method, inner)
            cases.add(archive, large, chosen="b/c/large")
            cases.add(Path(f"{archive}:a/small"), small)
        path, values = cases.path(), numbers((7, 6, 5, 9), "f4")
        zarr.create_array(path, data=values, chunks=(2, 3, 4, 5), zarr_format=version)
        for time in (0, 6):
            cases.add(path, values[time], time=time, times=7)
        path, values = cases.path(), numbers((6, 5, 4, 3), "u1")
        zarr.create_array(path, data=values, chunks=(2, 3, 4, 2), zarr_format=version)
        for component in range(3):
            cases.add(path, values[..., component], component=component, components=3)
        path, values = cases.path(), numbers((6, 5), "u1")
        zarr.create_array(path, data=values, chunks=(4, 4), zarr_format=version)
        cases.add(path, values)
        for code in ("c8", "S4", "U4", "M8[s]"):
            path = cases.path()
            zarr.create_array(path, shape=(3, 3, 3), dtype=code, zarr_format=version)
            cases.add(path, None)
        path = cases.path()
        zarr.create_array(path, shape=(2**16, 2**16, 2**15), chunks=(64, 64, 64), dtype="u1", zarr_format=version)
        cases.add(path, None)
        path = cases.path()
        zarr.create_array(path, shape=(1000, 1000, 1000), chunks=(100, 100, 100), dtype="u1", zarr_format=version)
        cases.add(path, None)
        path = cases.path()
        zarr.create_group(path, zarr_format=version)
        cases.add(path, None)
        for steps, has_fill in itertools.product((None, (3.0, 2.0, 0.5)), (False, True)):
            path, values = cases.path(), RANDOM.integers(-50, 50, (2, 4, 5, 6)).astype("i2")
            array = xarray.DataArray(values, dims=("time", "z", "y", "x"), name="density")
            if steps:
                axes = zip("zyx", values.shape[1:], steps, strict=True)
                array = array.assign_coords({name: (name, np.arange(length) * step, {"units": "mm"}) for name, length, step in axes})
            if has_fill:
                array = array.astype("f4").where(array > -40)
            encoding = {"density": {"dtype": "i2", "scale_factor": 0.5, "add_offset": 1.0, "_FillValue": -99}} if has_fill else {}
            array.to_dataset().to_zarr(path, zarr_format=version, encoding=encoding)
            expected = xarray.open_zarr(path, consolidated=False)["density"].values[1].astype("f8")
            cases.add(path, expected, time=1, times=2, spacing=steps and steps[::-1], units="mm" if steps else None, type="any", chosen="density")
    damaged(cases)


def zipped(folder, archive, method, inner):
    with zipfile.ZipFile(archive, "w", method) as file:
        for found in sorted(folder.rglob("*")):
            if found.is_file():
                file.write(found, inner + str(found.relative_to(folder)))
    return archive


def damaged(cases):
    def fresh(**options):
        path = cases.path()
        zarr.create_array(path, data=numbers((8, 8, 8), "u2"), chunks=(4, 8, 8), **options)
        return path

    for options in ({"zarr_format": 2}, {"zarr_format": 3}, {"zarr_format": 3, "shards": (8, 8, 8)}, {"zarr_format": 3, "compressors": codecs.BloscCodec()}):
        for change in (lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b[:9] + b"\xff" * 9 + b[18:]):
            path = fresh(**options)
            chunk = next(found for found in sorted(path.rglob("*")) if found.is_file() and found.name[0] not in ".z")
            chunk.write_bytes(change(chunk.read_bytes()))
            cases.add(path, None)
        path = fresh(**options)
        said = next(found for found in sorted(path.rglob("*")) if found.name in (".zarray", "zarr.json"))
        text = said.read_text()
        for old, new in [("{", "["), ('"shape"', '"forme"'), ("8,", "-8,"), ("zstd", "lzma2"), ("uint16", "float80"), ("<u2", "<u3"), ("4,", "0,")]:
            # Blosc says in each chunk what packed it.
            if old in text and not (old == "zstd" and "blosc" in text):
                said.write_text(text.replace(old, new))
                cases.add(shutil.copytree(path, cases.path()), None, label=f"{old} {new}")


# OME-Zarr

AXES = {"t": ("time", "second"), "c": ("channel", None), "z": ("space", "micrometer"), "y": ("space", "micrometer"), "x": ("space", "micrometer")}
FORMATS = {"0.4": ome_zarr.format.FormatV04(), "0.5": ome_zarr.format.FormatV05()}


def axes_of(names, units=True):
    axes = [{"name": name, "type": AXES[name][0], "unit": AXES[name][1]} for name in names]
    return [{key: value for key, value in axis.items() if value and (units or key != "unit")} for axis in axes]


def halved(values, names):
    part = tuple(slice(None, None, 2) if name in "zyx" else slice(None) for name in names)
    return np.ascontiguousarray(values[part])


def picked(values, names, time=0, channel=0):
    """The volume z, y, x of a time point and channel."""
    part = tuple({"t": time, "c": channel}.get(name, slice(None)) for name in names)
    volume, left = values[part], [name for name in names if name in "zyx"]
    return np.transpose(volume, [left.index(name) for name in "zyx" if name in left])


def image(path, values, names, version, scale=0.5, translation=None, chunks=None, omero=None, units=True):
    """Writes an image of three levels by ome-zarr."""
    levels = [values]
    while len(levels) < 3:
        levels.append(halved(levels[-1], names))
    transforms = []
    for level in range(len(levels)):
        steps = {"z": 2.0 * scale, "y": scale, "x": scale * 0.75}
        scales = [steps[name] * 2**level if name in "zyx" else 1.0 for name in names]
        transforms.append([{"type": "scale", "scale": scales}])
        if translation:
            transforms[-1].append({"type": "translation", "translation": [translation[name] for name in names]})
    root = zarr.open_group(path, mode="w", zarr_format=2 if version == "0.4" else 3)
    options = {"chunks": chunks} if chunks else {}
    ome_zarr.writer.write_multiscale(
        levels, root, fmt=FORMATS[version], axes=axes_of(names, units), coordinate_transformations=transforms, storage_options=options,
    )  # fmt: skip
    if omero:
        attributes = dict(root.attrs)
        if version == "0.4":
            root.attrs["omero"] = omero
        else:
            root.attrs["ome"] = {**attributes["ome"], "omero": omero}
    return levels, root


def level_path(root, level):
    attributes = dict(root.attrs)
    return attributes.get("ome", attributes)["multiscales"][0]["datasets"][level]["path"]


OMERO = {"channels": [
    {"label": "DAPI", "color": "0000FF", "active": True, "window": {"min": 0, "max": 65535, "start": 10, "end": 90}},
    {"label": "GFP", "color": "00ff00", "active": False, "window": {"min": 0, "max": 65535, "start": 0, "end": 50}},
]}  # fmt: skip


def ome_images(cases):
    for version, names in itertools.product(FORMATS, ("tczyx", "czyx", "tzyx", "zyx", "cyx", "yx", "tcyx")):
        cases.kind = (f"OME-Zarr {version}, {len(names)} axes", "ome-zarr")
        shape = [{"t": 3, "c": 2, "z": 7, "y": 9, "x": 11}[name] for name in names]
        for code, chunks in itertools.product(("u1", "u2", "f4"), (None, tuple(max(1, (length + 1) // 2) for length in shape))):
            values, path = numbers(tuple(shape), code), cases.path()
            has_channels = "c" in names
            levels, root = image(path, values, names, version, chunks=chunks, omero=OMERO if has_channels and code == "u2" else None)
            counts = {"times": 3 if "t" in names else 1, "channels": 2 if has_channels else 1, "levels": 3}
            for level, (time, channel) in enumerate([(0, 0), (2, 1), (1, 0)]):
                said = dict(counts, level_shown=level, units="µm", spacing=[0.375 * 2**level, 0.5 * 2**level, (1.0 if "z" in names else 0.375) * 2**level])
                if has_channels and code == "u2":
                    said |= {"names": ["DAPI", "GFP"], "range": [[10, 90], [0, 50]][channel]}
                order = {}
                if "t" in names:
                    order["time"] = time
                if has_channels:
                    order["channel"] = channel
                expected = picked(levels[level], names, order.get("time", 0), order.get("channel", 0))
                if level > 0:
                    order["level"] = level
                cases.add(path, expected, **order, **said)
                if level == 1:
                    order.pop("level")
                    cases.add(path, expected, array=level_path(root, 1), **order, **said)
                    cases.add(path / level_path(root, 1), expected, **order, **said)
            cases.add(path, None, level=3)
            cases.add(path, None, time=3)
    for version, names in itertools.product(FORMATS, ("xyz", "zxy", "xzy")):
        cases.kind = (f"OME-Zarr {version}, axes in other orders", "ome-zarr")
        # ome-zarr wants z, y, x in order; other programs write any.
        values, path = numbers((5, 6, 7), "u2"), cases.path()
        levels, root = image(path, values, "zyx", version, translation={"z": 10.0, "y": 20.0, "x": 30.0})
        attributes = dict(root.attrs)
        for axis, name in zip((attributes if version == "0.4" else attributes["ome"])["multiscales"][0]["axes"], names):
            axis["name"] = name
        root.attrs.update(attributes)
        by_name = dict(zip(names, (1.0, 0.5, 0.375), strict=True))
        origin = dict(zip(names, (10.0, 20.0, 30.0), strict=True))
        cases.add(path, picked(values, names), levels=3, units="µm", spacing=[by_name[n] for n in "xyz"], origin=[origin[n] for n in "xyz"])
    for version in FORMATS:
        cases.kind = (f"OME-Zarr {version}, labels, series and plates", "ome-zarr")
        path, values = cases.path(), numbers((8, 10, 12), "u2")
        levels, root = image(path, values, "zyx", version, units=False)
        labels = RANDOM.integers(0, 3, values.shape).astype("i4")
        ome_zarr.writer.write_multiscale_labels(
            pyramid=[labels], group=root, name="nuclei", axes="zyx", fmt=FORMATS[version],
            coordinate_transformations=[[{"type": "scale", "scale": [1.0, 0.5, 0.375]}]],
            label_metadata={"colors": [{"label-value": 1, "rgba": [255, 0, 0, 255]}], "properties": [{"label-value": 2, "class": "cell"}]},
        )  # fmt: skip
        said = {"spacing": [0.375, 0.5, 1.0]}
        cases.add(path, values, levels=3, **said)
        for place in (Path(f"{path}:labels/nuclei"), path / "labels" / "nuclei", path / "labels"):
            cases.add(place, labels, labels=[1, 2], type="any", **said)
        for method in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            archive = zipped(path, cases.path(".ozx"), method, "")
            cases.add(archive, values, levels=3, **said)
            cases.add(archive, levels[2], levels=3, level=2, spacing=[1.5, 2.0, 4.0])
            cases.add(archive, labels, array="labels/nuclei", labels=[1, 2], type="any", **said)
        # bioformats2raw puts series beside each other, plates have wells.
        path = cases.path()
        root = zarr.open_group(path, mode="w", zarr_format=2 if version == "0.4" else 3)
        layout = {"bioformats2raw.layout": 3}
        root.attrs.update(layout if version == "0.4" else {"ome": layout})
        series = [image(path / str(i), numbers((5, 6, 7), "u2"), "zyx", version)[0][0] for i in range(2)]
        for i in range(2):
            cases.add(path, series[i], array=str(i), chosen=str(i), levels=3, units="µm", spacing=[0.375, 0.5, 1.0])
        cases.add(path, series[0], chosen="0", levels=3, units="µm", spacing=[0.375, 0.5, 1.0])
        path = cases.path()
        root = zarr.open_group(path, mode="w", zarr_format=2 if version == "0.4" else 3)
        ome_zarr.writer.write_plate_metadata(root, ["A"], ["1", "2"], ["A/1", "A/2"], fmt=FORMATS[version])
        for well in ("1", "2"):
            group = root.require_group(f"A/{well}")
            ome_zarr.writer.write_well_metadata(group, ["0"], fmt=FORMATS[version])
            values = image(path / "A" / well / "0", numbers((5, 6, 7), "u2"), "zyx", version)[0][0]
        cases.add(path, values, array="A/2/0", chosen="A/2/0", levels=3, units="µm", spacing=[0.375, 0.5, 1.0])
        # A level that is missing, axes that do not fit.
        path = cases.path()
        _, root = image(path, numbers((5, 6, 7), "u2"), "zyx", version)
        shutil.rmtree(path / level_path(root, 0))
        cases.add(path, None)
        cases.add(shutil.copytree(path, cases.path()), None, level=0)


# TIFF of microscopes


def tiff_files(cases):
    for code, shape in itertools.product(("u1", "u2", "f4"), ((2, 5, 3, 6, 7), (1, 5, 2, 6, 7), (3, 1, 1, 6, 7))):
        values, path = numbers(shape, code), cases.path(".ome.tif")
        cases.kind = ("OME-TIFF", "tifffile")
        names, colours = [f"ch{i}" for i in range(shape[2])], [-16776961, 0x00FF00FF, 65535][: shape[2]]
        tifffile.imwrite(path, values, metadata={
            "axes": "TZCYX", "PhysicalSizeX": 0.25, "PhysicalSizeXUnit": "µm", "PhysicalSizeY": 0.5, "PhysicalSizeYUnit": "µm",
            "PhysicalSizeZ": 2000, "PhysicalSizeZUnit": "nm", "Channel": {"Name": names, "Color": colours},
        })  # fmt: skip
        times, channels = shape[0], shape[2]
        order = {"time": times - 1, "channel": channels - 1}
        colours_said = [[255, 0, 0], [0, 255, 0], [0, 0, 255]][:channels]
        cases.add(path, values[-1, :, -1], **order, times=times, channels=channels, spacing=[0.25, 0.5, 2.0], units="µm", names=names if channels > 1 else None, colours=colours_said)
        path = cases.path(".tif")
        cases.kind = ("TIFF of ImageJ", "tifffile")
        tifffile.imwrite(path, values, imagej=True, resolution=(4, 2), metadata={
            "axes": "TZCYX", "spacing": 2.0, "unit": "um", "Ranges": [float(i) for c in range(channels) for i in (c, c + 60)],
            "LUTs": [np.outer(colour, np.arange(256)).astype("u2").__floordiv__(255).astype("u1") for colour in colours_said],
        })  # fmt: skip
        if shape[1] > 1:
            cases.add(path, values[-1, :, -1], **order, times=times, channels=channels, spacing=[0.25, 0.5, 2.0], units="µm", range=[channels - 1, channels + 59], colours=colours_said if channels > 1 else None)


WRITERS = {
    arrays_of_v2: "Zarr 2, arrays", arrays_of_v3: "Zarr 3, arrays", hierarchies: "Zarr 2 and 3, groups, refusals, damage",
    ome_images: "OME-Zarr", tiff_files: "TIFF",
}  # fmt: skip


def made(folder):
    cases = Cases(folder)
    for write, kind in WRITERS.items():
        cases.kind = (kind, "zarr, xarray")
        write(cases)
    return cases.cases


# Comparison


def dims_of(volume):
    shape = list(volume.shape)
    return ([1] * (3 - len(shape)) + shape)[::-1]


def problems(case, answer, values):
    if case.volume is None:
        if "error" not in answer:
            return ["it was read, but should be refused"]
        return [] if "\n" not in answer["error"] and len(answer["error"]) > 20 else [answer["error"]]
    if "error" in answer:
        return [answer["error"]]
    said, found = case.said, []
    wanted = {
        "dims": dims_of(case.volume), "dtype": said.get("type", short(case.volume.dtype)), "times": said.get("times", 1),
        "components": said.get("components", 1), "units": said.get("units"), "spacing": said.get("spacing") or [1.0] * 3,
        "levels": said.get("levels", 1), "level": said.get("level_shown", case.order.get("level", 0)), "channels": said.get("channels", 1),
        "channel_names": said.get("names"), "origin": said.get("origin"), "array": said.get("chosen"), "range": said.get("range"),
    }  # fmt: skip
    for key, value in wanted.items():
        is_near = key in ("spacing", "origin") and value is not None and answer[key] is not None
        same = np.allclose(answer[key], value, rtol=1e-6) if is_near else answer[key] == value
        if not same and value is not None and value != "any":
            found.append(f"{key} {answer[key]}, not {value}")
    colours = [display["colour"] for display in answer["displays"]]
    if said.get("colours") and colours != said["colours"]:
        found.append(f"colours {colours}, not {said['colours']}")
    if "labels" in said and [label["value"] for label in answer["labels"] or []] != said["labels"]:
        found.append(f"labels {answer['labels']}")
    # An assumed spacing is never silent.
    if not said.get("spacing") and not any("--spacing" in note for note in answer["notes"]):
        found.append("no note on the spacing")
    expected = case.volume.astype("f8").ravel()
    tolerance = said.get("tolerance", 0) * max(1.0, np.nanmax(np.abs(expected)))
    if values.shape != expected.shape or not np.allclose(values, expected, rtol=0, atol=tolerance, equal_nan=True):
        found.append(f"values {values[:4]}, not {expected[:4]}")
    return found


def compare(program):
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
            summary.add(*case.kind, "differ" if wrong else "refused" if case.volume is None else "agree")
            if wrong:
                print(f"{case.path.name} {case.order} {case.said}: {'; '.join(wrong)}")
        summary.print()
        print(f"{len(cases)} variants: {agreed} agree, {refused} are refused as they should, {len(cases) - agreed - refused} differ")
        sys.exit(agreed + refused != len(cases))


def samples():
    """Small archives of each kind with their values, for the test of the crate."""
    kept = {}
    steps = {arrays_of_v2: 23, arrays_of_v3: 23, hierarchies: 9, ome_images: 13, tiff_files: 5}
    SAMPLES.mkdir(exist_ok=True)
    for old in SAMPLES.iterdir():
        old.unlink()
    with tempfile.TemporaryDirectory() as folder:
        for write, step in steps.items():
            cases = Cases(Path(folder) / write.__name__)
            cases.folder.mkdir()
            write(cases)
            sound = [case for case in cases.cases if case.volume is not None and case.path.exists() and case.volume.size <= 700]
            for case in sound[::step] + sound[-1:]:
                # A folder within a hierarchy is no file to keep.
                if case.path.parent != cases.folder:
                    continue
                name = f"{write.__name__}_{case.path.name}"
                if case.path.is_dir():
                    name += ".zip"
                    zipped(case.path, SAMPLES / name, zipfile.ZIP_DEFLATED, "")
                else:
                    (SAMPLES / name).write_bytes(case.path.read_bytes())
                if (SAMPLES / name).stat().st_size > LARGEST:
                    (SAMPLES / name).unlink()
                    continue
                kept.setdefault(name, []).append(described(case))
    lines = (f"{json.dumps(name)}: {json.dumps(found, separators=(',', ':'))}" for name, found in sorted(kept.items()))
    (SAMPLES / "values.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


def described(case):
    def number(value):
        if not np.isfinite(value):
            return None
        return int(value) if value == int(value) else round(float(value), 6)

    values = [number(value) for value in case.volume.astype("f8").ravel()[::EVERY]]
    return {
        **case.order, "dims": dims_of(case.volume), "spacing": case.said.get("spacing") or [1.0] * 3,
        "levels": case.said.get("levels", 1), "channels": case.said.get("channels", 1), "times": case.said.get("times", 1),
        "names": case.said.get("names"), "origin": case.said.get("origin"), "range": case.said.get("range"), "values": values,
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
