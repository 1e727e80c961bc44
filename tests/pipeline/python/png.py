"""8-bit RGB PNG files as numpy arrays, for comparisons."""
import struct
import zlib

import numpy as np


def read(path):
    data = path.read_bytes()
    at, packed, width, height = 8, b"", 0, 0
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colours = struct.unpack(">IIBB", body[:10])
            assert (depth, colours) == (8, 2)
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    out = np.zeros((height, 3 * width), np.uint8)
    for y in range(height):
        above = out[y - 1] if y else np.zeros(3 * width, np.uint8)
        for x in range(3 * width):
            a, b = (int(out[y, x - 3]) if x > 2 else 0), int(above[x])
            c = int(above[x - 3]) if x > 2 else 0
            p = a + b - c
            paeth = min((a, b, c), key=lambda v: abs(p - v))
            out[y, x] = (int(rows[y, 1 + x]) + (0, a, b, (a + b) // 2, paeth)[rows[y, 0]]) & 255
    return out.reshape(height, width, 3)
