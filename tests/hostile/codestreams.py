"""Compressed images that claim more than they contain: JPEG, JPEG-LS, JPEG 2000, RLE."""

from __future__ import annotations

import struct


def _segment(marker: int, body: bytes) -> bytes:
    return struct.pack(">HH", marker, len(body) + 2) + body


def jpeg(width: int, height: int, sof: int = 0xFFC3, components: int = 1, bits: int = 16, scans: int = 1,
         data: bytes = b"\0" * 64, before: bytes = b"") -> bytes:
    """Returns a frame header, a Huffman table with a single code, and endless scans if `scans` says so."""
    parts = b"".join(struct.pack(">BBB", n + 1, 0x11, 0) for n in range(components))
    frame = _segment(sof, struct.pack(">BHHB", bits, height, width, components) + parts)
    table = _segment(0xFFC4, b"\0" + bytes([1] + [0] * 15) + b"\0")
    quantisation = _segment(0xFFDB, b"\0" + b"\1" * 64)
    chosen = bytes([components]) + b"".join(bytes([n + 1, 0]) for n in range(components))
    spectrum = b"\0\x3f\0" if sof in (0xFFC0, 0xFFC1, 0xFFC2) else b"\1\0\0"
    scan = _segment(0xFFDA, chosen + spectrum) + data
    return b"\xff\xd8" + before + quantisation + frame + table + scan * scans + b"\xff\xd9"


def jpeg_ls(width: int, height: int, data: bytes = b"\0" * 64, preset: bytes = b"") -> bytes:
    frame = _segment(0xFFF7, struct.pack(">BHHB", 12, height, width, 1) + b"\1\x11\0")
    return b"\xff\xd8" + frame + preset + _segment(0xFFDA, b"\1\1\0\0\0\0") + data + b"\xff\xd9"


def jpeg_2000(width: int, height: int, tile: tuple[int, int] | None = None, origin: tuple[int, int] = (0, 0),
              components: int = 1, precinct: int | None = None, block: tuple[int, int] = (4, 4), levels: int = 5,
              layers: int = 1, data: bytes = b"\0" * 64) -> bytes:
    """`block` and `precinct` are exponents as in the standard (ITU-T T.800, A.6.1)."""
    tiles = tile or (width, height)
    size = struct.pack(">H8LH", 0, width + origin[0], height + origin[1], *origin, *tiles, 0, 0, components)
    size += b"\x0b\1\1" * components
    style = struct.pack(">BBHBBBBBB", precinct is not None, 0, layers, 0, levels, block[0], block[1], 0, 1)
    if precinct is not None:
        style += bytes([precinct << 4 | precinct]) * (levels + 1)
    steps = b"\x40" + bytes([12 << 3]) * (3 * levels + 1)
    tile_part = _segment(0xFF90, struct.pack(">HLBB", 0, 0, 0, 1)) + b"\xff\x93" + data
    return (b"\xff\x4f" + _segment(0xFF51, size) + _segment(0xFF52, style) + _segment(0xFF5C, steps) + tile_part
            + b"\xff\xd9")


def rle(*segments: bytes, count: int | None = None, offsets: list[int] | None = None) -> bytes:
    """Returns one frame (DICOM PS3.5, G). `count` and `offsets` override the true values."""
    if offsets is None:
        offsets, at = [], 64
        for segment in segments:
            offsets.append(at)
            at += len(segment)
    table = [len(segments) if count is None else count, *offsets][:16]
    return struct.pack("<16I", *table, *[0] * (16 - len(table))) + b"".join(segments)


def rle_zeros(count: int) -> bytes:
    """Returns `count` zeros in runs of 128, which take two bytes each."""
    return b"\x81\0" * (count // 128)
