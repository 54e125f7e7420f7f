#!/usr/bin/env python3
"""Computes the pictures of lit spheres in assets/matcaps, the materials of shaded surfaces.

The pictures are sRGB. The light is that of a few broad lamps and of a sky above a ground. Needs
only Python's standard library: python3 scripts/matcaps.py
"""

import math
import struct
import zlib
from pathlib import Path

SIDE = 128
OUT = Path(__file__).resolve().parent.parent / "assets" / "matcaps"


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(v):
    length = math.sqrt(dot(v, v))
    return [x / length for x in v]


def mix(a, b, t):
    return [x + (y - x) * t for x, y in zip(a, b)]


def smooth(low, high, x):
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


KEY = unit([-0.45, 0.65, 0.75])
FILL = unit([0.8, 0.1, 0.4])


def sky(n):
    """From 0 below to 1 above."""
    return 0.5 + 0.5 * n[1]


def wrapped(n, lamp):
    return (0.5 + 0.5 * dot(n, lamp)) ** 2


def mirrored(n):
    """The direction that a mirror reflects towards the eye."""
    return [2.0 * n[2] * n[0], 2.0 * n[2] * n[1], 2.0 * n[2] * n[2] - 1.0]


def gloss(n, lamp, sharpness):
    return max(dot(mirrored(n), lamp), 0.0) ** sharpness


def clay(n):
    light = 0.20 + 0.16 * sky(n) + 0.72 * wrapped(n, KEY) + 0.10 * wrapped(n, FILL)
    edge = (1.0 - n[2]) ** 3
    return [c * light + 0.03 * edge for c in (0.56, 0.25, 0.16)]


def porcelain(n):
    around = mix([0.30, 0.29, 0.30], [0.46, 0.48, 0.52], sky(n))
    light = [a + 0.46 * wrapped(n, KEY) for a in around]
    shine = 0.55 * smooth(0.93, 0.965, dot(mirrored(n), KEY)) + 0.10 * gloss(n, FILL, 30)
    rim = 0.22 * (1.0 - n[2]) ** 4 * sky(n)
    return [0.80 * x + shine + rim for x in light]


def steel(n):
    r = mirrored(n)
    horizon = smooth(-0.12, 0.12, r[1])
    ground = mix([0.030, 0.028, 0.027], [0.16, 0.15, 0.145], smooth(-1.0, -0.1, r[1]))
    above = mix([0.62, 0.65, 0.69], [0.17, 0.19, 0.22], smooth(0.0, 1.0, r[1]))
    shine = 0.9 * smooth(0.86, 0.97, dot(r, KEY)) + 0.25 * smooth(0.80, 0.97, dot(r, FILL))
    rim = 0.25 * (1.0 - n[2]) ** 3
    return [x + shine + rim for x in mix(ground, above, horizon)]


def jade(n):
    light = 0.22 + 0.10 * sky(n) + 0.52 * wrapped(n, KEY)
    through = (1.0 - n[2]) ** 2
    body = mix([0.13, 0.40, 0.24], [0.42, 0.70, 0.42], through)
    shine = 0.35 * smooth(0.94, 0.985, dot(mirrored(n), KEY))
    return [c * (light + 0.30 * through) + shine for c in body]


def encoded(c):
    c = min(max(c, 0.0), 1.0)
    c = 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055
    return round(255 * c)


def png(rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", SIDE, SIDE, 8, 2, 0, 0, 0)
    body = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def normal(x, y):
    """The normal of the sphere at a pixel; beyond its edge that of the edge."""
    u, v = (2 * (x + 0.5) / SIDE - 1) / 0.98, (1 - 2 * (y + 0.5) / SIDE) / 0.98
    square = u * u + v * v
    if square > 0.9999:
        scale = math.sqrt(0.9999 / square)
        u, v, square = u * scale, v * scale, 0.9999
    return [u, v, math.sqrt(1.0 - square)]


for material in (clay, porcelain, steel, jade):
    rows = []
    for y in range(SIDE):
        colors = (material(normal(x, y)) for x in range(SIDE))
        rows.append([encoded(c) for color in colors for c in color])
    OUT.mkdir(exist_ok=True)
    (OUT / f"{material.__name__}.png").write_bytes(png(rows))
