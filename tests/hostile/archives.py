"""Uploads that are not a plain tar of plain files: names, links, devices, sparse files, nested archives."""

from __future__ import annotations

import gzip
import io
import tarfile
import zipfile
from functools import partial
from typing import Iterable, Iterator

from .cases import Case, of_files, of_tar
from .dicom_bytes import TAR_END, bundle, entry, padded, series, slice_file, tar_header

MB = 1 << 20
NAMES = {"upwards": b"../../../../../../etc/cron.d/x", "absolute": b"/etc/passwd", "of Windows": b"C:\\Windows\\x.dll",
         "with escapes": b"\x1b]0;x\x07\x1b[31m", "with a line's end": b"a\nb\r.dcm", "no UTF-8": b"\xff\xfe\xc3\x28",
         "of a device": b"/dev/stdin", "of this process": b"/proc/self/mem", "empty": b"", "of dots": b"..",
         "with quotes": b"'; DROP TABLE uploads; --", "with formats": b"%s%n%s%n{{7*7}}${jndi:x}"}


def cases() -> Iterator[Case]:
    yield from names()
    yield from links()
    yield from sizes()
    yield from extensions()
    yield from inside_others()
    yield from damage()


def named(name: bytes, files: Iterable[bytes]) -> list[bytes]:
    return [entry(data, name) for data in files] + [TAR_END]


def names() -> Iterator[Case]:
    trick = partial(of_tar, "names")
    for how, name in NAMES.items():
        yield trick(f"a name {how}, around a good scan", "ready", lambda n=name: named(n, series()))
        yield trick(f"a name {how}, around nothing", "not_dicom", lambda n=name: named(n, [b"nothing at all " * 40] * 20))
    long = b"../" * 33_000 + b"x"
    yield trick("a name of 99000 letters (GNU)", "ready damaged", lambda: [
        entry(long, b"././@LongLink", b"L"), *named(b"short", series())])
    yield trick("a name of 99000 letters (pax)", "ready damaged", lambda: [
        entry(pax(path=long), b"pax", b"x"), *named(b"short", series())])


def links() -> Iterator[Case]:
    link = partial(of_tar, "links and devices")

    def only(kind: bytes, target: bytes = b"", devices=(0, 0), magic=b"ustar\x0000"):
        return lambda: [tar_header(b"%05d.dcm" % n, 0, kind, target, magic, devices) for n in range(20)] + [TAR_END]

    yield link("symbolic links to /etc/passwd", "empty", only(b"2", b"/etc/passwd"))
    yield link("symbolic links to the memory of this process", "empty", only(b"2", b"/proc/self/mem"))
    yield link("hard links to /etc/shadow", "empty", only(b"1", b"/etc/shadow"))
    yield link("character devices (/dev/zero)", "empty", only(b"3", devices=(1, 5)))
    yield link("block devices", "empty", only(b"4", devices=(8, 0)))
    yield link("pipes", "empty", only(b"6"))
    yield link("folders", "empty", only(b"5"))
    yield link("a kind that nobody knows", "not_dicom", only(b"Z"))
    yield link("a link, then files through it", "ready", lambda: [
        tar_header(b"out", 0, b"2", b"/tmp"), *(entry(f, b"out/%d" % n) for n, f in enumerate(series())), TAR_END])
    yield link("hard links to a good slice", "too_few_slices", lambda: [
        entry(slice_file(0), b"first"), *[tar_header(b"%d" % n, 0, b"1", b"first") for n in range(40)], TAR_END])
    yield link("hard links with contents", "empty too_few_slices damaged", lambda: [
        *[entry(slice_file(n), b"%d" % n, b"1", link=b"first") for n in range(40)], TAR_END])


def pax(**records: bytes) -> bytes:
    """Returns records of an extended header, each prefixed with its length (POSIX)."""
    out = b""
    for key, value in records.items():
        body = b" " + key.replace("_", ".").encode() + b"=" + value + b"\n"
        length = len(body) + len(str(len(body)))
        length += len(str(length)) - len(str(len(body)))
        out += str(length).encode() + body
    return out


def sizes() -> Iterator[Case]:
    size = partial(of_tar, "sizes in the archive")
    yield size("a file of 1.5 GB of nothing", "not_dicom too_large", lambda: [tar_header(size=1536 * MB), 1536 * MB, TAR_END])
    yield size("8 GB claimed, nothing there", "damaged", lambda: [tar_header(size=8 << 30), bytes(2048)])
    yield size("2^62 bytes claimed", "damaged", lambda: [tar_header(size=b"\x80" + (1 << 62).to_bytes(11, "big")), bytes(4096)])
    yield size("less than no bytes claimed", "damaged", lambda: [tar_header(size=b"\xff" * 12), bytes(4096)])
    yield size("a size that is not a number", "damaged not_dicom", lambda: [tar_header(size=b"many bytes!\0"), bytes(4096)])
    yield size("2^60 bytes by an extended header", "damaged", lambda: [
        entry(pax(size=b"1152921504606846976"), b"pax", b"x"), *named(b"a", series())])
    yield size("less than no bytes by an extended header", "damaged", lambda: [
        entry(pax(size=b"-1"), b"pax", b"x"), *named(b"a", series())])
    yield size("30000 files", "too_large", lambda: [entry(b"x", b"a")] * 30_000 + [TAR_END])
    yield size("300000 folders", "empty", lambda: [tar_header(b"a/", 0, b"5")] * 300_000 + [TAR_END])


def old_sparse(real: int) -> bytes:
    """Returns GNU's sparse format: 512 bytes at the end of `real`, with zeros before them."""
    rest = bytes(386 - 345) + b"%011o\0%011o\0" % (real - 512, 512) + bytes(3 * 24) + b"\0" + b"%011o\0" % real
    return tar_header(b"a", 512, b"S", magic=b"ustar  \0", rest=rest) + bytes(512)


def extensions() -> Iterator[Case]:
    trick = partial(of_tar, "extensions of tar")
    for real in (600 * MB, 1000 * MB, 8 << 30):
        yield trick(f"sparse files of {real >> 20} MB (GNU)", "damaged", lambda r=real: [old_sparse(r)] * 20 + [TAR_END])
    for version, records in (("0.1", {"GNU_sparse_size": b"1000000000", "GNU_sparse_numblocks": b"1", "GNU_sparse_map": b"999999488,512"}),
                             ("1.0", {"GNU_sparse_major": b"1", "GNU_sparse_minor": b"0", "GNU_sparse_realsize": b"1000000000"})):
        block = padded(b"1\n999999488\n512\n") + bytes(512) if version == "1.0" else bytes(512)
        yield trick(f"sparse files of 1 GB (pax {version})", "damaged", lambda r=records, b=block: [
            entry(pax(**r), b"pax", b"x") + entry(b, b"a")] * 20 + [TAR_END])
    yield trick("a million sparse pieces", "damaged", lambda: [
        entry(pax(GNU_sparse_size=b"1000000000", GNU_sparse_map=b",".join(b"%d,1" % (2 * n) for n in range(100_000))), b"pax", b"x"),
        entry(bytes(512), b"a"), TAR_END])
    yield trick("an extended header of 64 MB", "damaged ready", lambda: [
        entry(pax(comment=b"x" * (64 * MB)), b"pax", b"x"), *named(b"a", series())])
    yield trick("a global extended header of 64 MB", "damaged ready", lambda: [
        entry(pax(comment=b"x" * (64 * MB)), b"pax", b"g"), *named(b"a", series())])
    yield trick("a long name of 1 GB", "damaged", lambda: [tar_header(b"././@LongLink", 1000 * MB, b"L"), 1000 * MB, *named(b"a", series())])
    yield trick("a long link of 64 MB", "damaged", lambda: [
        entry(b"x" * (64 * MB), b"././@LongLink", b"K"), *named(b"a", series())])
    yield trick("100000 extended headers in a row", "damaged ready", lambda: [
        entry(pax(comment=b"x"), b"pax", b"x")] * 100_000 + named(b"a", series()))
    yield trick("an extended header without an end", "damaged ready", lambda: [
        entry(b"99999999999999999999 path=x\n", b"pax", b"x"), *named(b"a", series())])
    yield trick("a volume of several (M)", "damaged not_dicom missing_slices ready", lambda: [
        tar_header(b"a", 512, b"M"), bytes(512), *named(b"a", series())])
    yield trick("AppleDouble files", "ready", lambda: [
        part for n, f in enumerate(series()) for part in (entry(b"\0\5\x16\7" + bytes(80), b"._%d" % n), entry(f, b"%d" % n))] + [TAR_END])


def zipped(files: Iterable[bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as into:
        for number, data in enumerate(files):
            into.writestr(f"../{number}.dcm", data)
    return out.getvalue()


def tar_of(compression: str) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode=f"w:{compression}") as tar:
        for number, data in enumerate(series()):
            info = tarfile.TarInfo(str(number))
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))
    return out.getvalue()


def inside_others() -> Iterator[Case]:
    raw = partial(of_tar, "other archives")
    held = partial(of_files, "archives within")
    yield raw("a zip instead of a tar", "damaged", lambda: [zipped(series())])
    for compression in ("gz", "bz2", "xz"):
        yield raw(f"a tar packed with {compression}", "damaged", lambda c=compression: [tar_of(c)])
    yield raw("a gzip bomb instead of a tar", "damaged", lambda: [gzip.compress(bytes(256 * MB), 9)])
    yield raw("an ISO image", "empty damaged", lambda: [bytes(32768) + b"\1CD001\1\0", 4 * MB])
    yield raw("a RAR, a 7z, a cpio", "damaged", lambda: [b"Rar!\x1a\x07\0" + bytes(900) + b"7z\xbc\xaf\x27\x1c" + b"070707" * 400])
    yield raw("a script", "damaged", lambda: [b"#!/bin/sh\ntouch /tmp/pwned\n" * 400])
    yield held("zips in the tar", "not_dicom", lambda: [zipped(series())] * 3)
    yield held("zip bombs in the tar", "not_dicom", lambda: [zipped([bytes(64 * MB)])] * 3)
    yield held("tars in the tar", "not_dicom", lambda: [bundle(series())] * 3)
    yield held("gzipped slices", "not_dicom", lambda: [gzip.compress(f) for f in series()])
    yield held("a DICOMDIR alone", "no_slices not_dicom damaged", lambda: [
        slice_file(0, pixels=b"", sop_class=b"\x08\0\x16\0UI\x14\x001.2.840.10008.1.3.10")])
    yield held("programs, pages and pictures", "not_dicom", lambda: [
        b"MZ" + bytes(2000), b"\x7fELF" + bytes(2000), b"<html><script>alert(1)</script>" * 90, b"\x89PNG\r\n\x1a\n" + bytes(2000)])


def damage() -> Iterator[Case]:
    bad = partial(of_tar, "broken archives")
    good = bundle(series())
    yield bad("nothing", "empty damaged", lambda: [b""])
    yield bad("one byte", "damaged", lambda: [b"x"])
    yield bad("zeros", "empty", lambda: [10 * MB])
    yield bad("noise", "damaged", lambda: [bytes((n * 7919 + n // 251) % 255 + 1 for n in range(50_000))])
    yield bad("cut in a header", "damaged", lambda: [good[:3000]])
    yield bad("cut in a file", "damaged", lambda: [good[:-1500 - 512]])
    yield bad("a wrong sum in the second header", "damaged", lambda: [
        entry(series()[0]), tar_header().replace(b"ustar", b"vstar"), *named(b"a", series())])
    yield bad("rubbish between two files", "damaged", lambda: [entry(series()[0]), b"rubbish " * 64, *named(b"a", series())])
