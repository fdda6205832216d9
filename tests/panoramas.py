"""Panoramas as Radiance (.hdr) and OpenEXR (.exr) files, from a function that returns red, green and blue by column and row."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

Paint = Callable[[int, int], tuple[float, float, float]]


def _rgbe(colour: tuple[float, float, float]) -> bytes:
    brightest = max(colour)
    if brightest < 1e-32:
        return bytes(4)
    exponent = math.frexp(brightest)[1]
    return bytes(min(255, int(c * 2.0 ** (8 - exponent))) for c in colour) + bytes([exponent + 128])


def hdr(width: int, height: int, paint: Paint) -> bytes:
    pixels = b"".join(_rgbe(paint(x, y)) for y in range(height) for x in range(width))
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + pixels


def exr(width: int, height: int, paint: Paint) -> bytes:
    """In lines of 32-bit numbers without compression."""
    def attribute(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(name + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    head = b"\x76\x2f\x31\x01\x02\0\0\0" + b"".join((
        attribute("channels", "chlist", channels), attribute("compression", "compression", b"\0"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)))) + b"\0"
    lines = []
    for y in range(height):
        row = [paint(x, y) for x in range(width)]
        lines.append(struct.pack("<ii", y, 12 * width) + b"".join(struct.pack(f"<{width}f", *(one[c] for one in row)) for c in (2, 1, 0)))
    first, step = len(head) + 8 * height, len(lines[0])
    return head + struct.pack(f"<{height}Q", *(first + step * y for y in range(height))) + b"".join(lines)
