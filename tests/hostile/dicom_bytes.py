"""Writes DICOM and tar byte by byte, because writers that validate their output cannot produce invalid files."""

from __future__ import annotations

import random
import struct
import zlib
from typing import Iterable

UNDEFINED = 0xFFFFFFFF
IMPLICIT, EXPLICIT, BIG_ENDIAN = "1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"
DEFLATED, RLE = "1.2.840.10008.1.2.1.99", "1.2.840.10008.1.2.5"
JPEG_BASELINE, JPEG_12, JPEG_LOSSLESS = (f"1.2.840.10008.1.2.4.{n}" for n in (50, 51, 70))
JPEG_LS, JPEG_2000 = "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.90"
CT = "1.2.840.10008.5.1.4.1.1.2"
LONG = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"}


def u16(value: int) -> bytes:
    return struct.pack("<H", value)


def u32(value: int) -> bytes:
    return struct.pack("<I", value)


def element(tag: int, vr: str, value: bytes | str = b"", length: int | None = None) -> bytes:
    """Returns an element in explicit little endian. `length` overrides the true length."""
    data = value.encode() if isinstance(value, str) else value
    if len(data) % 2:
        data += b"\0" if vr in ("UI", "OB", "UN") else b" "
    claimed = len(data) if length is None else length
    head = u16(tag >> 16) + u16(tag & 0xFFFF) + vr.encode("latin-1")
    return head + (u16(0) + u32(claimed) if vr in LONG else u16(claimed & 0xFFFF)) + data


def implicit(tag: int, value: bytes = b"", length: int | None = None) -> bytes:
    return u16(tag >> 16) + u16(tag & 0xFFFF) + u32(len(value) if length is None else length) + value


def item(value: bytes = b"", length: int | None = None) -> bytes:
    return implicit(0xFFFEE000, value, length)


ITEM_END, SEQUENCE_END = implicit(0xFFFEE00D), implicit(0xFFFEE0DD)


def meta(syntax: str = EXPLICIT, preamble: bytes = bytes(128)) -> bytes:
    uid = element(0x00020010, "UI", syntax)
    return preamble + b"DICM" + element(0x00020000, "UL", u32(len(uid))) + uid


def encapsulated(*fragments: bytes, offsets: bytes = b"", end: bytes = SEQUENCE_END) -> bytes:
    """Returns compressed pixels: the offset table, then the fragments."""
    body = b"".join(item(f + b"\0" * (len(f) % 2)) for f in (offsets, *fragments))
    return element(0x7FE00010, "OB", body, UNDEFINED) + end


def noise(number: int, rows: int, columns: int = 1) -> bytes:
    """Returns 16-bit values from 0 to 2047, always the same for a number, which compress as little as a real slice."""
    source, count = random.Random(number), rows * columns
    return struct.pack(f"<{count}H", *(source.randrange(2048) for _ in range(count)))


def header(number: int = 0, rows: int | bytes = 16, columns: int | bytes = 16, **change: bytes | None) -> list[bytes]:
    """Returns the elements of a plain CT slice in ascending order. `change` replaces an element by its name or, with None, omits
    it. `rows` and `columns` given as bytes are elements, too."""
    parts = {
        "image_type": element(0x00080008, "CS", "ORIGINAL\\PRIMARY\\AXIAL"),
        "sop_class": element(0x00080016, "UI", CT),
        "sop_uid": element(0x00080018, "UI", f"1.2.3.4.{number + 1}"),
        "modality": element(0x00080060, "CS", "CT"),
        "nested": b"", "private": b"",
        "patient": element(0x00100010, "PN", "Nobody"),
        "series_uid": element(0x0020000E, "UI", "1.2.3.4.5"),
        "position": element(0x00200032, "DS", f"0\\0\\{2 * number}"),
        "orientation": element(0x00200037, "DS", "1\\0\\0\\0\\1\\0"),
        "samples": element(0x00280002, "US", u16(1)),
        "photometric": element(0x00280004, "CS", "MONOCHROME2"),
        "frames": b"",
        "rows": rows if isinstance(rows, bytes) else element(0x00280010, "US", u16(rows)),
        "columns": columns if isinstance(columns, bytes) else element(0x00280011, "US", u16(columns)),
        "spacing": element(0x00280030, "DS", "1\\1"),
        "bits": element(0x00280100, "US", u16(16)) + element(0x00280101, "US", u16(12)),
        "high_bit": element(0x00280102, "US", u16(11)) + element(0x00280103, "US", u16(0)),
        "rescale": element(0x00281052, "DS", "-1024") + element(0x00281053, "DS", "1"),
    }
    assert not change.keys() - parts.keys(), change.keys() - parts.keys()
    return [part for part in {**parts, **change}.values() if part]


def slice_file(number: int = 0, pixels: bytes | None = None, syntax: str = EXPLICIT, rows: int | bytes = 16,
               columns: int | bytes = 16, tail: bytes = b"", **change: bytes | None) -> bytes:
    if pixels is None:
        pixels = element(0x7FE00010, "OW", noise(number, *(16 if isinstance(n, bytes) else n for n in (rows, columns))))
    body = b"".join(header(number, rows, columns, **change)) + pixels + tail
    return meta(syntax) + (deflate(body) if syntax == DEFLATED else body)


def series(count: int = 20, **change) -> list[bytes]:
    """Returns a valid series unless something is changed. `change` is as in slice_file, the same for all slices."""
    return [slice_file(number, **change) for number in range(count)]


def deflate(data: bytes | Iterable[bytes], finish: bool = True) -> bytes:
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    parts = [data] if isinstance(data, bytes) else data
    packed = b"".join(packer.compress(part) for part in parts)
    return packed + (packer.flush() if finish else b"")


def tar_header(name: bytes = b"00001.dcm", size: int | bytes = 0, kind: bytes = b"0", link: bytes = b"",
               magic: bytes = b"ustar\x0000", devices: tuple[int, int] = (0, 0), rest: bytes = b"") -> bytes:
    """Returns one block. A `size` given as bytes is used unchanged. `rest` replaces the bytes after the first 345."""
    stated = size if isinstance(size, bytes) else b"%011o\0" % size
    block = bytearray(512)
    for at, field in ((0, name[:100]), (100, b"0000644\0"), (108, b"0000000\0"), (116, b"0000000\0"), (124, stated),
                      (136, b"00000000000\0"), (148, b" " * 8), (156, kind), (157, link[:100]), (257, magic),
                      (329, b"%07o\0" % devices[0]), (337, b"%07o\0" % devices[1]), (345, rest[:155])):
        block[at:at + len(field)] = field
    block[148:156] = b"%06o\0 " % sum(block)
    return bytes(block)


def padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 512)


def entry(data: bytes, name: bytes = b"00001.dcm", kind: bytes = b"0", **more) -> bytes:
    return tar_header(name, len(data), kind, **more) + padded(data)


TAR_END = bytes(1024)


def bundle(files: Iterable[bytes]) -> bytes:
    """Returns the tar that a browser creates from the files of a series (docs/contracts.md, "Upload bundle")."""
    return b"".join(entry(data, b"%05d.dcm" % n) for n, data in enumerate(files, 1)) + TAR_END
