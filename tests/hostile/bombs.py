"""Small inputs that unpack to large ones: deflate, RLE, JPEG, JPEG-LS, JPEG 2000."""

from __future__ import annotations

from functools import partial
from typing import Iterator

from . import codestreams as code
from .cases import Case, of_files
from .dicom_bytes import (DEFLATED, JPEG_12, JPEG_2000, JPEG_BASELINE, JPEG_LOSSLESS, JPEG_LS, RLE, deflate, element,
                          encapsulated, header, meta, noise, series, slice_file, u16)

MB = 1 << 20


def cases() -> Iterator[Case]:
    yield from of_deflate()
    yield from of_rle()
    yield from of_jpeg()
    yield from of_jpeg_ls()
    yield from of_jpeg_2000()


def of_deflate() -> Iterator[Case]:
    bomb = partial(of_files, "deflate")
    zeros = [bytes(MB)] * 1024
    yield bomb("1 MB unpacks to 1 GB", "too_large", lambda: [
        meta(DEFLATED) + deflate([b"".join(header()), element(0x7FE00010, "OW", b"", 0x7FFFFFFE), *zeros])])
    many = deflate([b"".join(header()), element(0x00091001, "OB", b"", 15 * MB), *zeros[:15],
                    element(0x7FE00010, "OW", noise(1, 256))])
    yield bomb("500 files of 15 KB that unpack to 7 GB", "too_large", lambda: [meta(DEFLATED) + many] * 500)
    yield bomb("a million elements in 3 KB", "too_large", lambda: [
        meta(DEFLATED) + deflate(element(0x00091001, "LO") * 1_000_000)] * 20)
    yield bomb("no deflate at all", "damaged", lambda: [meta(DEFLATED) + noise(n, 500) for n in range(20)])
    yield bomb("a distance before the beginning", "damaged", lambda: [meta(DEFLATED) + b"\x63\x00\x11\x00\x00\xff\xff"] * 20)


def of_rle() -> Iterator[Case]:
    bomb = partial(of_files, "RLE")

    def rle(*fragments: bytes, **change):
        return lambda: series(syntax=RLE, pixels=encapsulated(*fragments), **change)

    good = code.rle(b"\x81\0" * 2, b"\x81\0" * 2)
    yield bomb("17 MB of fragments that each unpack", "damaged", lambda: [
        slice_file(n, syntax=RLE, rows=2048, columns=2048, pixels=encapsulated(*[good] * 90_000)) for n in range(2)])
    yield bomb("segments a hundred times longer than the picture", "damaged", rle(code.rle(*[code.rle_zeros(256 * 100)] * 2)))
    yield bomb("segments that are too short", "damaged", rle(code.rle(*[code.rle_zeros(128)] * 2)))
    yield bomb("more segments than a header holds", "damaged", rle(code.rle(b"\x81\0" * 4, count=4_000_000_000)))
    yield bomb("segments beyond the fragment", "damaged", rle(code.rle(b"\x81\0" * 4, count=2, offsets=[64, 0xFFFFFFF0])))
    yield bomb("segments that overlap", "damaged", rle(code.rle(b"\x81\0" * 4, count=2, offsets=[64, 64])))
    yield bomb("segments backwards", "damaged", rle(code.rle(b"\x81\0" * 4, count=2, offsets=[66, 64])))
    yield bomb("a literal run beyond the end", "damaged", rle(code.rle(b"\x7f", b"\x7f")))
    yield bomb("a fragment shorter than its header", "damaged", rle(b"\2\0\0\0"))
    yield bomb("no fragment", "damaged", rle())
    yield bomb("20 slices of 4096 x 4096 of nothing", "too_large", lambda: series(
        syntax=RLE, rows=element(0x00280010, "US", u16(4096)), columns=element(0x00280011, "US", u16(4096)),
        pixels=encapsulated(code.rle(*[code.rle_zeros(4096 * 4096)] * 2))))


def of_jpeg() -> Iterator[Case]:
    bomb = partial(of_files, "JPEG")

    def jpeg(data: bytes, syntax: str = JPEG_LOSSLESS, **change):
        return lambda: series(syntax=syntax, pixels=encapsulated(data), **change)

    yield bomb("65500 squared inside, 16 squared outside", "damaged", jpeg(code.jpeg(65500, 65500)))
    yield bomb("255 components", "damaged", jpeg(code.jpeg(16, 16, components=4)))
    yield bomb("progressive, 50000 scans", "damaged", jpeg(
        code.jpeg(16, 16, sof=0xFFC2, bits=8, scans=50_000, data=b"\0"), JPEG_BASELINE))
    yield bomb("baseline, 50000 scans", "damaged", jpeg(code.jpeg(16, 16, sof=0xFFC0, bits=8, scans=50_000, data=b"\0"), JPEG_BASELINE))
    yield bomb("arithmetic coding", "damaged", jpeg(code.jpeg(16, 16, sof=0xFFCB)))
    yield bomb("a second picture behind the first", "ready", jpeg(code.jpeg(16, 16) + code.jpeg(65500, 65500)))
    yield bomb("a second frame header", "damaged", jpeg(
        code.jpeg(16, 16)[:-2] + code.jpeg(65500, 65500)[2:]))
    yield bomb("a second picture in a second fragment", "damaged", lambda: series(
        syntax=JPEG_LOSSLESS, pixels=encapsulated(code.jpeg(16, 16), code.jpeg(65500, 65500))))
    yield bomb("16 MB of comments", "damaged too_few_slices", lambda: [slice_file(n, syntax=JPEG_LOSSLESS, pixels=encapsulated(
        code.jpeg(16, 16, data=b"", before=(b"\xff\xfe\xff\xff" + bytes(65533)) * 250)[:-2])) for n in range(2)])
    yield bomb("no height until later (DNL)", "damaged", jpeg(code.jpeg(16, 0)))
    yield bomb("20 slices of 5000 x 5000 in 200 bytes each", "too_large", jpeg(
        code.jpeg(5000, 5000), rows=element(0x00280010, "US", u16(5000)), columns=element(0x00280011, "US", u16(5000))))
    yield bomb("12 bits, said to be 200", "damaged", jpeg(code.jpeg(16, 16, sof=0xFFC1, bits=200), JPEG_12))
    yield bomb("no picture", "damaged", jpeg(b"no picture"))
    yield bomb("markers without end", "damaged", jpeg(b"\xff\xd8" + b"\xff" * 100_000))


def of_jpeg_ls() -> Iterator[Case]:
    bomb = partial(of_files, "JPEG-LS")

    def jpeg_ls(data: bytes, **change):
        return lambda: series(syntax=JPEG_LS, pixels=encapsulated(data), **change)

    yield bomb("JPEG-LS: 65500 squared inside", "damaged", jpeg_ls(code.jpeg_ls(65500, 65500)))
    yield bomb("JPEG-LS: a larger size in a preset", "damaged", jpeg_ls(
        code.jpeg_ls(16, 16, preset=b"\xff\xf8\x00\x0c\x04\x04\x00\x01\x00\x00\x00\x01\x00\x00")))
    yield bomb("JPEG-LS: thresholds that contradict", "damaged", jpeg_ls(
        code.jpeg_ls(16, 16, preset=b"\xff\xf8\x00\x0d\x01\xff\xff\x00\x00\x00\x00\x00\x00\x00\x00")))
    yield bomb("JPEG-LS: a plain JPEG", "damaged", jpeg_ls(code.jpeg(16, 16)))
    yield bomb("JPEG-LS: 20 slices of 5000 x 5000", "too_large", jpeg_ls(
        code.jpeg_ls(5000, 5000), rows=element(0x00280010, "US", u16(5000)), columns=element(0x00280011, "US", u16(5000))))


def of_jpeg_2000() -> Iterator[Case]:
    bomb = partial(of_files, "JPEG 2000")

    def j2k(data: bytes, **change):
        return lambda: series(syntax=JPEG_2000, pixels=encapsulated(data), **change)

    def large(side: int, data: bytes, slices: int = 20):
        return lambda: [slice_file(n, syntax=JPEG_2000, rows=side, columns=side, pixels=encapsulated(data)) for n in range(slices)]

    yield bomb("J2K: 2^31 squared inside", "damaged", j2k(code.jpeg_2000(1 << 31, 1 << 31)))
    yield bomb("J2K: far from the origin", "damaged", j2k(code.jpeg_2000(16, 16, origin=(0xFFFFFF00, 0xFFFFFF00), tile=(16, 16))))
    yield bomb("J2K: tiles of one pixel", "damaged", large(255, code.jpeg_2000(255, 255, tile=(1, 1))))
    yield bomb("J2K: tiles of nothing", "damaged", j2k(code.jpeg_2000(16, 16, tile=(0, 0))))
    yield bomb("J2K: 16384 components", "damaged", j2k(code.jpeg_2000(16, 16, components=16384)))
    yield bomb("J2K: precincts of one pixel", "damaged", large(2048, code.jpeg_2000(2048, 2048, precinct=0)))
    yield bomb("J2K: blocks of one pixel", "damaged", large(2048, code.jpeg_2000(2048, 2048, block=(0xFE, 0xFE))))
    yield bomb("J2K: the smallest blocks", "damaged", large(4096, code.jpeg_2000(4096, 4096, block=(0, 0)), 1))
    yield bomb("J2K: 65535 layers", "damaged", j2k(code.jpeg_2000(16, 16, layers=65535)))
    yield bomb("J2K: 200 levels", "damaged", j2k(code.jpeg_2000(16, 16, levels=200)))
    yield bomb("J2K: no codestream in 64 KB", "damaged", j2k(bytes(65536)))
    yield bomb("J2K: 20 slices of 5000 x 5000 in 200 bytes", "too_large", large(5000, code.jpeg_2000(5000, 5000)))
