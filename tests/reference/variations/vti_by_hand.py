"""`.vti` files as programs other than VTK write them: attributes in any order and quotes, comments."""

import base64
import struct
import zlib

import numpy as np
import vtk

from .case import TYPES, chance, directions, named, pick, sizes, spacing, voxels

NAMES = {"uint8": "UInt8", "int8": "Int8", "uint16": "UInt16", "int16": "Int16", "uint32": "UInt32", "int32": "Int32",
         "uint64": "UInt64", "int64": "Int64", "float32": "Float32", "float64": "Float64"}  # fmt: skip


def make(rng, stem, seen):
    """The case of a random file, by the function that asks VTK."""
    dims, first = sizes(rng), rng.integers(-3, 5, size=3) if chance(rng, 0.3) else (0, 0, 0)
    extent = " ".join(f"{a} {a + d - 1}" for a, d in zip(first, dims))
    coding = {"order": pick(rng, "<>"), "word": pick(rng, "IQ"), "is_packed": chance(rng, 0.4)}
    head = {"type": "ImageData", "version": pick(rng, ["0.1", "1.0", "2.2"]),
            "byte_order": {"<": "LittleEndian", ">": "BigEndian"}[coding["order"]]}  # fmt: skip
    if coding["word"] == "Q" or chance(rng, 0.5):
        head["header_type"] = {"I": "UInt32", "Q": "UInt64"}[coding["word"]]
    if coding["is_packed"]:
        head["compressor"] = "vtkZLibDataCompressor"
    image = {"WholeExtent": extent, "Spacing": " ".join(map(str, spacing(rng))), "Origin": "1.5 -2 3e1"}
    if chance(rng, 0.5):
        image["Direction"] = " ".join(repr(float(n)) for n in directions(rng).ravel())
    appended, kind = bytearray(), pick(rng, ["raw", "base64"])
    arrays = "".join(
        array(rng, coding, int(np.prod(dims)), f"a{i}", appended, kind) for i in range(pick(rng, [1, 2, 3]))
    )
    active = {"Scalars": "a0"} if chance(rng, 0.4) else {}
    note = "<!-- <DataArray> of a test -->" if chance(rng, 0.5) else ""
    declaration = pick(rng, ['<?xml version="1.0"?>', ""])
    text = (
        f"{declaration}{element(rng, 'VTKFile', head)}{element(rng, 'ImageData', image)}{note}"
        f"{element(rng, 'Piece', {'Extent': extent})}{element(rng, 'PointData', active)}{arrays}</PointData><CellData/></Piece></ImageData>"
    ).encode()
    if appended:
        mark = pick(rng, ["_", "\n  _"])
        text += f'<AppendedData encoding="{kind}">{mark}'.encode() + appended + b"\n</AppendedData>"
    path = named(stem, ".vti")
    path.write_bytes(text + b"</VTKFile>\n")
    return seen(rng, path, vtk.vtkXMLImageDataReader(), "VTI by hand")


def element(rng, name, attributes):
    pairs = [f"{key}={quote}{value}{quote}" for key, value in attributes.items() for quote in [pick(rng, ["'", '"'])]]
    rng.shuffle(pairs)
    return f"<{name}{pick(rng, [' ', chr(10)])}{' '.join(pairs)}>{pick(rng, ['', chr(10)])}"


def array(rng, coding, count, name, appended, kind):
    dtype, components = pick(rng, TYPES), pick(rng, [1, 1, 3])
    values = voxels(rng, dtype, (count, components))
    attributes = {"type": NAMES[dtype], "Name": name, "format": pick(rng, ["ascii", "binary", "appended"])}
    if components > 1 or chance(rng, 0.5):
        attributes["NumberOfComponents"] = components
    if attributes["format"] == "ascii":
        separator = pick(rng, [" ", "\n", "  "])
        content = separator.join(repr(v.item()) for v in values.ravel())
        return element(rng, "DataArray", attributes) + content + "</DataArray>"
    table, data = encoded(rng, coding, values)
    if attributes["format"] == "binary":
        return element(rng, "DataArray", attributes) + in_base64(coding, table, data) + "\n</DataArray>"
    attributes["offset"] = len(appended)
    appended += table + data if kind == "raw" else in_base64(coding, table, data).encode()
    return element(rng, "DataArray", attributes).rstrip().removesuffix(">") + "/>"


def encoded(rng, coding, values):
    """The lengths and the bytes of an array, in several blocks where it is packed."""
    order, word = coding["order"], coding["word"]
    data = values.astype(values.dtype.newbyteorder(order)).tobytes()
    if not coding["is_packed"]:
        return struct.pack(order + word, len(data)), data
    size = 8 * int(rng.integers(1, 40))
    blocks = [zlib.compress(data[i : i + size]) for i in range(0, len(data), size)]
    table = [len(blocks), size, len(data) % size, *map(len, blocks)]
    return struct.pack(f"{order}{len(table)}{word}", *table), b"".join(blocks)


def in_base64(coding, table, data):
    """Lengths and bytes in one run, or in two where the lengths are a table of blocks."""
    if coding["is_packed"]:
        return base64.b64encode(table).decode() + base64.b64encode(data).decode()
    return base64.b64encode(table + data).decode()
