#!/usr/bin/env python3
"""Chunks that Blosc itself packs, for the tests of crates/fovol-io/src/volume/blosc.

    pip install numpy blosc
    python tests/reference/blosc_chunks.py   # writes crates/fovol-io/src/volume/blosc/chunks.bin

The chunks stand behind one another in the order of the loops below; `blosc/tests.rs` has the same loops and the same values.
"""

import itertools
from pathlib import Path

import blosc
import numpy as np

CHUNKS = Path(__file__).resolve().parents[2] / "crates/fovol-io/src/volume/blosc/chunks.bin"


def smooth(count):
    """Values that shrink: bytes that change slowly."""
    i = np.arange(count, dtype="u8")
    return (i // 300 + (i // 1024) * (i // 2 % 2)).astype("u1").tobytes()


def repeated(count):
    """Noise that comes again after 8,500 bytes, farther than BloscLZ counts in 13 bits."""
    noise, state = bytearray(), 1
    for _ in range(8500):
        state = (state * 1103515245 + 12345) & 0x7FFFFFFF
        noise.append(state >> 16 & 0xFF)
    return bytes(noise[i % 8500] for i in range(count))


def main():
    out = bytearray()
    shuffles = [blosc.NOSHUFFLE, blosc.SHUFFLE, blosc.BITSHUFFLE]
    blosc.set_nthreads(1)
    for codec, shuffle, size, length in itertools.product(["blosclz", "lz4", "zlib"], shuffles, [1, 3, 4], [0, 1000, 12000]):
        blosc.set_blocksize(4096 if length > 2000 else 0)
        out += blosc.compress(smooth(length), typesize=size, clevel=9, shuffle=shuffle, cname=codec)
    blosc.set_blocksize(0)
    for codec in ["blosclz", "lz4"]:
        out += blosc.compress(repeated(17500), typesize=1, clevel=9, shuffle=blosc.NOSHUFFLE, cname=codec)
    out += blosc.compress(smooth(1000), typesize=4, clevel=9, cname="zstd")
    CHUNKS.write_bytes(out)


main()
