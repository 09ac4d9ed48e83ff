"""Writes a PNG of eight bits and three channels to standard output as PPM: png_to_ppm.py PICTURE.png"""

import struct
import sys
import zlib


def chunks(data):
    at = 8
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        yield data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        at += 12 + length


def paeth(left, above, corner):
    guess = left + above - corner
    return min((left, above, corner), key=lambda value: abs(guess - value))


def unfiltered(kind, row, before):
    out = bytearray(row)
    for i, value in enumerate(row):
        left, corner = (out[i - 3], before[i - 3]) if i >= 3 else (0, 0)
        above = before[i]
        guesses = [0, left, above, (left + above) // 2, paeth(left, above, corner)]
        out[i] = (value + guesses[kind]) & 255
    return out


def main():
    parts = list(chunks(open(sys.argv[1], "rb").read()))
    width, height, depth, colour = struct.unpack(">IIBB", parts[0][1][:10])
    assert (depth, colour) == (8, 2), "eight bits and three channels are expected"
    data = zlib.decompress(b"".join(body for name, body in parts if name == b"IDAT"))
    sys.stdout.buffer.write(b"P6\n%d %d\n255\n" % (width, height))
    row, step = bytearray(3 * width), 3 * width + 1
    for start in range(0, height * step, step):
        row = unfiltered(data[start], data[start + 1 : start + step], row)
        sys.stdout.buffer.write(row)


main()
