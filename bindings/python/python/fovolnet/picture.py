"""Pictures that notebooks show and programs save."""

from __future__ import annotations

import os
import struct
import zlib

import numpy as np


class Picture(np.ndarray):
    """A picture: uint8 of shape (height, width, 3 or 4). It is an array, and notebooks show it."""

    def __new__(cls, image: np.ndarray) -> Picture:
        return np.asarray(image).view(cls)

    def _repr_png_(self) -> bytes | None:
        return png(self) if self.ndim == 3 and self.dtype == np.uint8 and self.shape[2] in (3, 4) else None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture as PNG."""
        with open(path, "wb") as file:
            file.write(png(self))


def png(image: np.ndarray) -> bytes:
    """The bytes of a PNG file of ``image``: uint8 of shape (height, width, 3 or 4)."""
    height, width, channels = image.shape
    rows = np.zeros((height, 1 + width * channels), np.uint8)
    rows[:, 1:] = np.asarray(image).reshape(height, -1)
    kind = {3: 2, 4: 6}[channels]
    header = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    parts = [(b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b"")]
    chunks = (struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
