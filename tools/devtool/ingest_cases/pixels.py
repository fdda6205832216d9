"""Series with special packings of pixels: cases 16 to 21."""

from __future__ import annotations

import shutil
import struct
import subprocess
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Callable

import numpy as np
from pydicom import dcmread
from pydicom.dataset import Dataset
from pydicom.encaps import encapsulate, generate_frames
from pydicom.uid import (DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian, JPEG2000Lossless,
                         MPEG2MPML, RLELossless)

from ..console import CliError
from .phantom import Series, Slice, dataset, enhanced, write

Make = Callable[[Path], None]


def _changed(slices: list[Slice], change: Callable[[Dataset, np.ndarray], np.ndarray], series: Series = Series()) -> Make:
    """Writes each file with other pixels. `change` receives the pixels as they would be stored."""
    def make(folder: Path) -> None:
        files = []
        for one in slices:
            ds = dataset(series, one)
            ds.PixelData = change(ds, series.stored(one)).tobytes()
            files.append(ds)
        write(folder, files)
    return make


def padded(series: Series, slices: list[Slice], padding: int) -> Make:
    """Writes slices with a round field of view, whose corners are padding."""
    def change(ds: Dataset, stored: np.ndarray) -> np.ndarray:
        ds.add_new(0x00280120, "SS" if series.signed else "US", padding)
        y, x = np.ogrid[:ds.Rows, :ds.Columns]
        outside = ((y - ds.Rows / 2 + 0.5) / ds.Rows) ** 2 + ((x - ds.Columns / 2 + 0.5) / ds.Columns) ** 2 > 0.25
        return np.where(outside, padding, stored).astype(stored.dtype)
    return _changed(slices, change, series)


def dirty_bits(slices: list[Slice], signed: bool) -> Make:
    """Writes slices of 12 bits in 16, with overlay or undefined data in the upper bits."""
    slices = [replace(one, intercept=1000.0 if signed else -1024.0) for one in slices]

    def change(_: Dataset, stored: np.ndarray) -> np.ndarray:
        dirt = (np.arange(stored.size).reshape(stored.shape) % 16) << 12
        return (stored.astype(np.uint16) & 0xFFF | dirt).astype(np.uint16)
    return _changed(slices, change, Series(bits=12, signed=signed))




def displayed_inverted(slices: list[Slice]) -> Make:
    """Writes a CT that asks for an inverted display. Its values are Hounsfield units anyway."""
    def change(ds: Dataset, stored: np.ndarray) -> np.ndarray:
        ds.PhotometricInterpretation = "MONOCHROME1"
        return stored
    return _changed(slices, change)


def negative(series: Series, slices: list[Slice]) -> Make:
    def change(ds: Dataset, stored: np.ndarray) -> np.ndarray:
        ds.PhotometricInterpretation = "MONOCHROME1"
        return (65535 - stored.astype(np.int64)).astype(np.uint16)
    return _changed(slices, change, series)


def coloured(slices: list[Slice], photometric: str) -> Make:
    def change(ds: Dataset, stored: np.ndarray) -> np.ndarray:
        ds.PhotometricInterpretation = photometric
        ds.BitsAllocated, ds.BitsStored, ds.HighBit = 8, 8, 7
        if photometric != "PALETTE COLOR":
            ds.SamplesPerPixel, ds.PlanarConfiguration = 3, 0
        return np.full((*stored.shape, ds.SamplesPerPixel), 99, np.uint8)
    return _changed(slices, change)


def compressed_frames(series: Series, slices: list[Slice], syntax: str = RLELossless) -> Make:
    def make(folder: Path) -> None:
        ds = enhanced(series, slices)
        ds.compress(syntax)
        write(folder, [ds])
    return make


def in_pieces(made: Make, pieces: int, offsets: str = "") -> Make:
    """Splits each image into several fragments. `offsets`: "basic", "extended", or empty for no offset table."""
    def make(folder: Path) -> None:
        made(folder)
        for file in folder.iterdir():
            ds = dcmread(file)
            pictures = list(generate_frames(ds.PixelData, number_of_frames=int(ds.get("NumberOfFrames", 1))))
            ds.PixelData = encapsulate(pictures, fragments_per_frame=pieces, has_bot=offsets == "basic")
            if offsets == "extended":
                # Excludes the empty table of 8 bytes that precedes each image.
                lengths = [len(encapsulate([one], fragments_per_frame=pieces, has_bot=False)) - 8 for one in pictures]
                ds.ExtendedOffsetTable = struct.pack(f"<{len(lengths)}Q", *accumulate(lengths[:-1], initial=0))
                ds.ExtendedOffsetTableLengths = struct.pack(f"<{len(lengths)}Q", *lengths)
            ds.save_as(file)
    return make


def transfer_syntaxes(slices: list[Slice]) -> list[tuple[str, Make, float, str | None]]:
    """Returns name, series, tolerance in the phantom's values, and the browser's result if it differs."""
    def raw(syntax: str) -> Make:
        series = Series(syntax=syntax)
        return lambda folder: write(folder, [dataset(series, one) for one in slices])

    def compressed(syntax: str, **how) -> Make:
        def make(folder: Path) -> None:
            files = [dataset(Series(), one) for one in slices]
            for ds in files:
                ds.compress(syntax, **how)
            write(folder, files)
        return make

    def by_dcmtk(tool: str, *options: str, bits: int = 16, lift: float = 0.0) -> Make:
        # 8 and 12 bits cannot hold the phantom's values without a coarser scale.
        slope = 1.0 if bits == 16 else 4200.0 / (1 << bits)
        ready = [replace(one, slope=slope, intercept=-1024.0 + lift) for one in slices]
        return lambda folder: _by_dcmtk(folder, ready, bits, [tool, *options])

    return [
        ("implicit little endian", raw(ImplicitVRLittleEndian), 6, None),
        ("big endian", raw(ExplicitVRBigEndian), 6, None),
        ("deflated", raw(DeflatedExplicitVRLittleEndian), 6, None),
        ("RLE", compressed(RLELossless), 6, None),
        ("JPEG lossless", by_dcmtk("dcmcjpeg", "+el"), 6, None),
        ("JPEG lossless, first order", by_dcmtk("dcmcjpeg", "+e1"), 6, None),
        ("JPEG baseline, 8 bits", by_dcmtk("dcmcjpeg", "+eb", "+q", "98", bits=8), 60, None),
        ("JPEG extended, 12 bits", by_dcmtk("dcmcjpeg", "+ee", "+q", "98", bits=12), 60, None),
        ("JPEG-LS", by_dcmtk("dcmcjpls", "+el"), 6, None),
        ("JPEG-LS, near-lossless", by_dcmtk("dcmcjpls", "+en", "+md", "2"), 9, None),
        ("JPEG 2000, lossless", compressed(JPEG2000Lossless), 6, None),
        ("JPEG lossless, each in 4 pieces", in_pieces(by_dcmtk("dcmcjpeg", "+e1"), 4), 6, None),
        ("JPEG-LS, each in 3 pieces", in_pieces(by_dcmtk("dcmcjpls", "+el"), 3), 6, None),
        ("JPEG 2000, each in 5 pieces", in_pieces(compressed(JPEG2000Lossless), 5), 6, None),
    ]


def _by_dcmtk(folder: Path, slices: list[Slice], bits: int, command: list[str]) -> None:
    """Writes slices with DCMTK's encoders, which are independent of the tested decoders."""
    if not shutil.which(command[0]):
        raise CliError(f"there is no {command[0]} (Debian's dcmtk)")
    series = Series(bits=bits)
    plain = folder.with_name(folder.name + "-plain")
    files = [dataset(series, one) for one in slices]
    if bits == 8:
        for ds, one in zip(files, slices):
            ds.BitsAllocated = 8
            ds.PixelData = series.stored(one).astype(np.uint8).tobytes()
            ds["PixelData"].VR = "OB"
    write(plain, files)
    folder.mkdir(parents=True, exist_ok=True)
    for file in plain.iterdir():
        done = subprocess.run([*command, str(file), str(folder / file.name)], capture_output=True, text=True)
        if done.returncode != 0:
            raise CliError(f"{command[0]} failed: {done.stderr.strip()}")
    shutil.rmtree(plain)


def unsupported(slices: list[Slice]) -> Make:
    def make(folder: Path) -> None:
        write(folder, [dataset(Series(), one) for one in slices])
        for file in folder.iterdir():     # each file claims another syntax, which alone decides
            data = file.read_bytes()
            wanted = MPEG2MPML.encode()
            at = data.index(b"1.2.840.10008.1.2.1\0")
            grown = bytearray(data[:at] + wanted + b"\0" * (len(wanted) % 2) + data[at + 20:])
            more = len(wanted) + len(wanted) % 2 - 20
            grown[at - 2:at] = (20 + more).to_bytes(2, "little")
            group = int.from_bytes(grown[140:144], "little") + more
            grown[140:144] = group.to_bytes(4, "little")
            file.write_bytes(bytes(grown))
    return make


def beheaded(slices: list[Slice], keep_meta: bool, syntax: str = ExplicitVRLittleEndian) -> Make:
    series = Series(syntax=syntax)

    def make(folder: Path) -> None:
        write(folder, [dataset(series, one) for one in slices])
        for file in folder.iterdir():
            data = file.read_bytes()
            group = int.from_bytes(data[140:144], "little")
            file.write_bytes(data[132:] if keep_meta else data[144 + group:])
    return make


def cut_off(slices: list[Slice], which: set[int]) -> Make:
    def make(folder: Path) -> None:
        files = [dataset(Series(), one) for one in slices]
        numbers = {files[i].SOPInstanceUID for i in which}
        write(folder, files)
        for file in folder.iterdir():
            data = file.read_bytes()
            if any(number.encode() in data for number in numbers):
                file.write_bytes(data[:len(data) * 2 // 3])
    return make
