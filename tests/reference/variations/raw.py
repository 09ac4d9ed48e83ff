"""Bare voxels, described by the words of their name or by a sidecar; NumPy wrote them."""

import gzip
import json

import numpy as np

from .case import TYPES, Case, chance, directions, named, pick, sizes, spacing, voxels

SHORT = {"uint8": "u8", "int8": "i8", "uint16": "u16", "int16": "i16", "uint32": "u32", "int32": "i32", "uint64": "u64",
         "int64": "i64", "float32": "f32", "float64": "f64", "float16": "f16"}  # fmt: skip
LITTLE, BIG = ["le", "LE", "little", "LittleEndian", "lsb"], ["be", "BE", "big", "BigEndian", "msb"]


def make(rng, stem):
    dtype = pick(rng, [*TYPES, "float16"])
    is_big, dims = chance(rng, 0.5), sizes(rng)
    data = voxels(rng, dtype, dims)
    content = data.astype(data.dtype.newbyteorder(">" if is_big else "<")).tobytes(order="F")
    maker = pick(rng, [by_name, by_name, by_json, by_dat])
    path, extra = maker(rng, stem, dtype, dims, is_big, content)
    return Case(path, data.astype(np.float64), how=f"raw {maker.__name__}", **{"orientation": False, **extra})


def by_name(rng, stem, dtype, dims, is_big, content):
    order = pick(rng, BIG if is_big else LITTLE)
    kind = pick(rng, [dtype, dtype.upper(), SHORT[dtype]])
    side = "x".join(map(str, dims))
    words = [pick(rng, [side, side, side.upper(), side.replace("x", "×")])]
    steps = [1.0, 1.0, 1.0]
    if chance(rng, 0.4):
        steps = [float(s) for s in np.round(rng.uniform(0.1, 4, size=3), 2)]
        unit = pick(rng, ["", "", "mm", "um"])
        # Whole numbers are sizes where they come first; the spacing follows.
        words.append("x".join(repr(s) for s in steps) + unit)
    is_silent = not is_big and chance(rng, 0.5)
    if not is_silent and order.lower() in ("le", "be") and chance(rng, 0.4):
        kind += order
        is_silent = True
    words.insert(int(rng.integers(len(words) + 1)), kind)
    if not is_silent:
        words.insert(words.index(kind) + 1, order)
    separator = pick(rng, ["_", "-", " ", "."])
    name = separator.join([stem.name, *words]) + ".raw"
    if chance(rng, 0.3):
        name, content = name + ".gz", gzip.compress(content)
    path = stem.with_name(name)
    path.write_bytes(content)
    return path, {"spacing": steps}


def by_json(rng, stem, dtype, dims, is_big, content):
    offset, steps, axes = int(rng.integers(0, 40)), spacing(rng), directions(rng)
    said = {pick(rng, ["dims", "size", "resolution"]): dims, pick(rng, ["dtype", "type"]): pick(rng, [dtype, SHORT[dtype]]),
            "spacing": steps, "offset": offset}  # fmt: skip
    if is_big or chance(rng, 0.5):
        said["endian"] = "big" if is_big else "little"
    extra = {"spacing": steps}
    if chance(rng, 0.5):
        said |= {
            "orientation": axes.tolist(),
            "origin": [1, 2.5, -3],
            "space": pick(rng, ["patient", "other"]),
            "units": "mm",
        }
        extra |= {"orientation": axes, "origin": [1, 2.5, -3], "units": "mm", "is_patient": said["space"] == "patient"}
    named(stem, ".raw").write_bytes(bytes(range(offset)) + content)
    if chance(rng, 0.5):
        said["file"] = stem.name + ".raw"
    named(stem, ".json").write_text(json.dumps(said))
    return named(stem, pick(rng, [".raw", ".json"])), extra


def by_dat(rng, stem, dtype, dims, is_big, content):
    word = {"float32": "FLOAT", "float64": "DOUBLE", "uint8": "UCHAR", "uint16": "USHORT"}.get(dtype, dtype.upper())
    steps = spacing(rng)
    lines = [f"ObjectFileName: {stem.name}.raw", f"Resolution: {' '.join(map(str, dims))}", f"Format: {word}",
             f"SliceThickness: {' '.join(map(str, steps))}"]  # fmt: skip
    if is_big:
        lines.append("ByteOrder: BigEndian")
    named(stem, ".raw").write_bytes(content)
    named(stem, ".dat").write_text(pick(rng, ["\n", "\r\n"]).join(lines) + "\n")
    return named(stem, pick(rng, [".raw", ".dat"])), {"spacing": steps}
