"""Invalid single files: lengths, nesting, representations, numbers, truncations."""

from __future__ import annotations

from functools import partial
from typing import Iterator

from .cases import Case, of_files
from .dicom_bytes import (BIG_ENDIAN, DEFLATED, EXPLICIT, IMPLICIT, ITEM_END, JPEG_LOSSLESS, LONG, RLE, SEQUENCE_END,
                          UNDEFINED, deflate, element, encapsulated, header, implicit, item, meta, noise, series,
                          slice_file, u16, u32)

DEEP = 10_000


def cases() -> Iterator[Case]:
    yield from lengths()
    yield from nesting()
    yield from endless()
    yield from representations()
    yield from sizes()
    yield from numbers()
    yield from truncations()
    yield from blobs()


def lengths() -> Iterator[Case]:
    lie = partial(of_files, "length lies")
    for vr in sorted(LONG - {"SQ"}):
        yield lie(f"{vr} claims 2 GB", "damaged", lambda vr=vr: series(private=element(0x00091001, vr, b"xx", 0x7FFFFFFE)))
    for vr in ("LO", "PN", "DS", "US"):
        yield lie(f"{vr} claims 65534 bytes", "damaged",
                  lambda vr=vr: series(pixels=b"", private=element(0x00091001, vr, b"xx", 0xFFFE)))
    yield lie("a sequence claims 4 GB", "damaged", lambda: series(nested=element(0x00081111, "SQ", item(b""), 0xFFFFFFF0)))
    yield lie("an item claims more than its sequence", "damaged",
              lambda: series(nested=element(0x00081111, "SQ", item(element(0x00080104, "LO", "x"), 0xFFFF))))
    yield lie("an element claims more than its item", "damaged",
              lambda: series(nested=element(0x00081111, "SQ", item(element(0x00080104, "LO", "x", 40)))))
    yield lie("text without a length", "damaged", lambda: series(private=element(0x00091001, "UT", b"xx", UNDEFINED)))
    yield lie("pixels claim 4 GB", "damaged", lambda: series(pixels=element(0x7FE00010, "OW", noise(1, 256), 0xFFFFFFFE)))
    yield lie("pixels are fewer than their rows", "damaged", lambda: series(pixels=element(0x7FE00010, "OW", noise(1, 200))))
    yield lie("a fragment claims 4 GB", "damaged", lambda: series(
        syntax=RLE, pixels=element(0x7FE00010, "OB", item() + item(b"xx", 0xFFFFFFF0), UNDEFINED) + SEQUENCE_END))
    yield lie("a fragment without a length", "damaged", lambda: series(
        syntax=RLE, pixels=element(0x7FE00010, "OB", item() + item(b"xx", UNDEFINED), UNDEFINED) + SEQUENCE_END))
    yield lie("the header's transfer syntax claims 64 KB", "damaged not_dicom", lambda: [
        bytes(128) + b"DICM" + element(0x00020010, "UI", EXPLICIT, 0xFFFE) + b"".join(header(n)) for n in range(20)])
    yield lie("the header's private part claims 4 GB", "damaged", lambda: [
        bytes(128) + b"DICM" + element(0x00020102, "OB", b"xx", 0xFFFFFFFF) + b"".join(header(n)) for n in range(20)])
    yield lie("implicit: an element claims 4 GB", "damaged", lambda: [
        meta(IMPLICIT) + implicit(0x00080016, b"1.2.840.10008.5.1.4.1.1.2\0") + implicit(0x00091001, b"xx", 0xFFFFFFF0)] * 20)


def nested(depth: int, defined: bool, vr: str = "SQ") -> bytes:
    """Built from the inside out if lengths are stated, otherwise as begin and end markers."""
    if not defined:
        return (element(0x00081111, vr, b"", UNDEFINED) + item(b"", UNDEFINED)) * depth + (ITEM_END + SEQUENCE_END) * depth
    heads, inner = [], 0
    for _ in range(depth):
        heads.append(element(0x00081111, vr, b"", inner + 8) + item(b"", inner))
        inner += len(heads[-1])
    return b"".join(reversed(heads))


def nesting() -> Iterator[Case]:
    deep = partial(of_files, "nesting")
    for defined in (True, False):
        for vr in ("SQ", "UN"):
            how = "stated" if defined else "open"
            yield deep(f"{DEEP} {vr} deep, lengths {how}", "too_large damaged",
                       lambda d=defined, vr=vr: series(nested=nested(DEEP, d, vr)))
    yield deep("implicit, 10000 deep", "too_large", lambda: [
        meta(IMPLICIT) + (implicit(0x00081111, b"", UNDEFINED) + item(b"", UNDEFINED)) * DEEP] * 20)
    yield deep("4 MB of beginnings", "too_large", lambda: [
        meta() + (element(0x00081111, "SQ", b"", UNDEFINED) + item(b"", UNDEFINED)) * 209_715])
    yield deep("10000 deep, deflated", "too_large", lambda: series(syntax=DEFLATED, nested=nested(DEEP, False)))
    yield deep("10000 deep in an icon", "too_large damaged", lambda: series(
        private=element(0x00880200, "SQ", item(nested(DEEP, False), UNDEFINED), UNDEFINED) + ITEM_END + SEQUENCE_END))


def endless() -> Iterator[Case]:
    endless_ = partial(of_files, "endless")
    yield endless_("a sequence that never ends", "damaged", lambda: series(
        nested=element(0x00081111, "SQ", item(b"") * 500, UNDEFINED)))
    yield endless_("a million empty items", "too_large", lambda: [
        meta() + element(0x00081111, "SQ", item(b"") * 1_000_000, UNDEFINED) + SEQUENCE_END])
    yield endless_("a million empty elements", "too_large no_slices", lambda: [meta() + element(0x00091001, "LO") * 1_000_000])
    yield endless_("a million empty fragments", "too_large", lambda: [
        slice_file(0, syntax=RLE, pixels=encapsulated(*[b""] * 1_000_000))])
    yield endless_("an item that never ends", "damaged", lambda: series(
        nested=element(0x00081111, "SQ", item(element(0x00080104, "LO", "x"), UNDEFINED), UNDEFINED)))
    yield endless_("pixels in fragments that never end", "damaged", lambda: series(
        syntax=RLE, pixels=encapsulated(bytes(64), end=b"")))
    yield endless_("ends of sequences only", "damaged", lambda: series(nested=SEQUENCE_END * 1000))


def representations() -> Iterator[Case]:
    wrong = partial(of_files, "wrong representations")
    yield wrong("rows as a long", "damaged", lambda: series(rows=element(0x00280010, "UL", u32(16))))
    yield wrong("rows as two numbers", "damaged", lambda: series(rows=element(0x00280010, "US", u16(16) * 2)))
    yield wrong("rows as text", "damaged", lambda: series(rows=element(0x00280010, "DS", "16")))
    yield wrong("rows as a sequence", "damaged", lambda: series(rows=element(0x00280010, "SQ", item(b""))))
    yield wrong("rows as unknown, with items", "damaged", lambda: series(rows=element(0x00280010, "UN", item(b""))))
    yield wrong("rows twice", "damaged", lambda: series(rows=element(0x00280010, "US", u16(16)) * 2))
    yield wrong("frames as a number", "damaged", lambda: series(frames=element(0x00280008, "US", u16(1))))
    yield wrong("frames as words", "damaged", lambda: series(frames=element(0x00280008, "IS", "many")))
    yield wrong("pixels twice", "damaged", lambda: series(tail=element(0x7FE00010, "OW", noise(1, 256))))
    yield wrong("pixels as a sequence", "damaged", lambda: series(pixels=element(0x7FE00010, "SQ", item(noise(1, 256)))))
    yield wrong("pixels in fragments, said to be raw", "damaged", lambda: series(pixels=encapsulated(noise(1, 256))))
    yield wrong("raw pixels, said to be RLE", "damaged", lambda: series(syntax=RLE))
    yield wrong("raw pixels, said to be JPEG", "damaged", lambda: series(syntax=JPEG_LOSSLESS))
    yield wrong("little endian, said to be big", "damaged", lambda: series(syntax=BIG_ENDIAN))
    yield wrong("explicit, said to be implicit", "damaged too_large no_slices", lambda: series(syntax=IMPLICIT))
    yield wrong("implicit, said to be explicit", "damaged", lambda: [
        meta() + implicit(0x00080016, b"1.2.840.10008.5.1.4.1.1.2\0") + implicit(0x00280010, u16(16))] * 20)
    for vr in ("ZZ", "\0\0", "\xff\xff"):
        yield wrong(f"a representation {vr!r}", "damaged", lambda vr=vr: series(private=element(0x00091001, vr, b"xx")))
    yield wrong("a position of 5000 characters", "damaged", lambda: series(
        position=element(0x00200032, "UT", b"0\\0\\" + b"0" * 4997)))
    yield wrong("a transfer syntax of 1000 characters", "unsupported_compression", lambda: series(syntax="1" * 1000))
    yield wrong("a transfer syntax with a name in it", "unsupported_compression", lambda: series(syntax="1.2.Muller <b>"))
    yield wrong("a video", "unsupported_compression", lambda: series(syntax="1.2.840.10008.1.2.4.102"))
    yield wrong("elements in falling order", "damaged ready", lambda: [
        meta() + b"".join(reversed(header(n))) + element(0x7FE00010, "OW", noise(n, 256)) for n in range(20)])


def sizes() -> Iterator[Case]:
    size = partial(of_files, "sizes")
    few = element(0x7FE00010, "OW", b"xx")
    yield size("65535 squared", "too_large", lambda: series(rows=element(0x00280010, "US", u16(65535)),
                                                            columns=element(0x00280011, "US", u16(65535)), pixels=few))
    yield size("65535 squared, as if in JPEG", "too_large", lambda: series(
        rows=element(0x00280010, "US", u16(65535)), columns=element(0x00280011, "US", u16(65535)), syntax=JPEG_LOSSLESS,
        pixels=encapsulated(b"\xff\xd8\xff\xd9")))
    for frames in ("2147483647", "9223372036854775807", "18446744073709551616", "-1", "0", "1e9"):
        yield size(f"{frames} frames", "too_large damaged no_position", lambda f=frames: series(
            frames=element(0x00280008, "IS", f), pixels=few))
    yield size("65535 samples a pixel", "too_large", lambda: series(samples=element(0x00280002, "US", u16(65535)), pixels=few,
                                                                    rows=element(0x00280010, "US", u16(8192))))
    yield size("65535 bits", "damaged too_large no_slices", lambda: series(
        bits=element(0x00280100, "US", u16(65535)) + element(0x00280101, "US", u16(65535))))
    yield size("no bits", "pixel_format", lambda: series(
        bits=element(0x00280100, "US", u16(0)) + element(0x00280101, "US", u16(0))))
    yield size("more bits stored than there are", "pixel_format", lambda: series(
        bits=element(0x00280100, "US", u16(16)) + element(0x00280101, "US", u16(40))))
    yield size("no rows", "no_spacing damaged no_slices pixel_format", lambda: series(rows=element(0x00280010, "US", u16(0))))


def numbers() -> Iterator[Case]:
    number = partial(of_files, "numbers")
    for text in ("nan\\nan\\nan", "inf\\0\\0", "1e308\\1e308\\1e308", "1e400\\0\\0", "0x10\\0\\0", "\\\\", "0\\0"):
        yield number(f"position {text}", "no_position one_position", lambda t=text: series(
            position=element(0x00200032, "DS", t)))
    yield number("positions 1e308 apart", "no_position", lambda: [
        slice_file(n, position=element(0x00200032, "DS", f"0\\0\\{n}e307")) for n in range(-10, 10)])
    yield number("positions 1e-300 apart", "one_position", lambda: [
        slice_file(n, position=element(0x00200032, "DS", f"0\\0\\{n}e-300")) for n in range(1, 21)])
    for text in ("0\\0\\0\\0\\0\\0", "1\\0\\0\\1\\0\\0", "nan\\0\\0\\0\\nan\\0", "1e200\\0\\0\\0\\1e200\\0"):
        yield number(f"orientation {text}", "bad_orientation no_position", lambda t=text: series(
            orientation=element(0x00200037, "DS", t)))
    for text in ("0\\0", "-1\\1", "1e-320\\1e-320", "1e300\\1e300", "nan\\1"):
        yield number(f"pixel spacing {text}", "no_spacing", lambda t=text: series(
            spacing=element(0x00280030, "DS", t)))


def truncations() -> Iterator[Case]:
    """Truncates after, or in the middle of, every kind of element."""
    cut = partial(of_files, "truncations")
    inside = element(0x00080104, "LO", "nested text")
    body = [("preamble", bytes(128)), ("magic", b"DICM"), ("header", meta()[132:])]
    body += [("short element", element(0x00080008, "CS", "ORIGINAL\\PRIMARY")), ("class", element(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2")),
             ("sequence", element(0x00081111, "SQ", b"", UNDEFINED)), ("item", item(b"", UNDEFINED)), ("nested element", inside),
             ("nested sequence", element(0x00081199, "SQ", item(inside))), ("end of an item", ITEM_END),
             ("end of a sequence", SEQUENCE_END), ("private element", element(0x00091001, "OB", bytes(40))),
             ("unknown element", element(0x00091002, "UN", bytes(40))), ("long text", element(0x00204000, "UT", "x" * 40)),
             *((f"element {n}", e) for n, e in enumerate(header()[3:])), ("pixels", element(0x7FE00010, "OW", noise(1, 256)))]
    whole, at = b"".join(part for _, part in body), 0
    for name, part in body:
        for where, offset in (("in", len(part) // 2), ("in the length of", 7), ("behind", len(part))):
            end = at + offset
            if where == "behind" and name == "pixels" or where == "in the length of" and len(part) < 9:
                continue
            yield cut(f"{where} {name}", "damaged not_dicom no_slices", lambda e=end: [whole[:e]] * 20)
        at += len(part)
    packed = slice_file(0, syntax=RLE, pixels=encapsulated(bytes(64) + b"\0" * 64))
    for name, left in (("the end of the fragments", 4), ("a fragment", 60), ("the offset table", 140)):
        yield cut(f"in {name}", "damaged", lambda n=left: [packed[:-n]] * 20)
    deflated = meta(DEFLATED) + deflate(b"".join(header()) + element(0x7FE00010, "OW", noise(1, 256)))
    yield cut("in a deflated file", "damaged", lambda: [deflated[:-20]] * 20)
    yield cut("at the start of a deflated file", "damaged", lambda: [deflated[:len(meta(DEFLATED)) + 3]] * 20)


def blobs() -> Iterator[Case]:
    blob = partial(of_files, "private blobs")
    yield blob("a private blob of 64 MB", "ready", lambda: [
        slice_file(0, private=element(0x00091001, "OB", bytes(64 << 20))), *series()[1:]])
    yield blob("a private blob of 64 MB, deflated", "too_large", lambda: [
        meta(DEFLATED) + deflate(b"".join(header(n, private=element(0x00091001, "OB", bytes(64 << 20)))) +
                                 element(0x7FE00010, "OW", noise(n, 256))) for n in range(3)])
    yield blob("private blobs that look like files", "ready", lambda: series(
        private=element(0x00091001, "OB", slice_file(99)) + element(0x00091002, "UN", bytes(128) + b"DICM" + bytes(40))))
