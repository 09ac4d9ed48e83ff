"""How far two of the program's EXR pictures are apart, with nothing but the standard library."""

import struct
from array import array
from itertools import accumulate
from operator import sub
from pathlib import Path

# Channels lie in the order of their names; alpha comes first and is no colour.
CHANNELS = 4


def differences(left, right):
    """The largest and the mean difference of the colours of two pictures of one size."""
    largest, total, count = 0.0, 0.0, 0
    tiles, others = tiles_of(left), tiles_of(right)
    if tiles.keys() != others.keys():
        raise ValueError(f"{left} and {right} differ in size")
    for place, (shape, packed) in tiles.items():
        count += (CHANNELS - 1) * shape[0] * shape[1]
        if packed != others[place][1]:
            colours = [colours_of(shape, tile) for tile in (packed, others[place][1])]
            apart = list(map(abs, map(sub, *colours)))
            largest = max(largest, *apart)
            total += sum(apart)
    return largest, total / count


def tiles_of(path):
    """Of every tile, by its place, how many columns and rows it has, and its packed numbers."""
    data = Path(path).read_bytes()
    facts, at = header(data)
    low_x, low_y, high_x, high_y = struct.unpack("<4i", facts["dataWindow"])
    size = high_x - low_x + 1, high_y - low_y + 1
    side = struct.unpack_from("<2I", facts["tiles"])
    across, down = (-(-pixels // edge) for pixels, edge in zip(size, side))
    tiles = {}
    for offset in struct.unpack_from(f"<{across * down}Q", data, at):
        x, y, _, _, length = struct.unpack_from("<5i", data, offset)
        shape = min(side[0], size[0] - x * side[0]), min(side[1], size[1] - y * side[1])
        tiles[x, y] = shape, data[offset + 20 : offset + 20 + length]
    return tiles


def header(data):
    """The attributes of the file, and where they end."""
    at, facts = 8, {}
    while data[at]:
        name, kind = data[at : data.index(0, data.index(0, at) + 1)].decode().split("\0")
        at += len(name) + len(kind) + 2
        (length,) = struct.unpack_from("<i", data, at)
        facts[name] = data[at + 4 : at + 4 + length]
        at += 4 + length
    if facts["compression"] != b"\1":
        raise ValueError("only run-length encoded tiles are read")
    return facts, at + 1


def colours_of(shape, packed):
    """The numbers of the three colours of a tile, row by row."""
    columns, rows = shape
    length = 4 * CHANNELS * columns * rows
    # What would not become smaller is stored as it is.
    numbers = array("f", packed if len(packed) == length else joined(unpacked(packed)))
    row = CHANNELS * columns
    colours = array("f")
    for begin in range(0, len(numbers), row):
        colours += numbers[begin + columns : begin + row]
    return colours


def unpacked(packed):
    """Runs as bytes: a count below zero says how many follow as they are, another how often the next is repeated."""
    out, at = bytearray(), 0
    while at < len(packed):
        count = packed[at]
        if count > 127:
            end = at + 1 + 256 - count
            out += packed[at + 1 : end]
            at = end
        else:
            out += packed[at + 1 : at + 2] * (count + 1)
            at += 2
    return out


def joined(halves):
    """The bytes whose differences, plus 128, are these, those at even places before those at odd ones."""
    halves[0] = (halves[0] + 128) & 255
    sums = bytes(map((255).__and__, accumulate(byte + 128 for byte in halves)))
    middle = (len(sums) + 1) // 2
    out = bytearray(len(sums))
    out[::2], out[1::2] = sums[:middle], sums[middle:]
    return bytes(out)
