"""The cases of the ingest design ("Cases and the right result"), each with series that represent it.

`expected` is the server's result (judge.py), and `says` contains words of its repairs or its reason. The browser agrees as far as
headers suffice. `browser` is set where it cannot know, or must refuse for another reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Callable

from pydicom.uid import JPEG2000Lossless

from . import pixels
from .judge import Volume
from .phantom import (CT, ENHANCED_CT, ENHANCED_MR, MR, PT, SAGITTAL, Series, Slice, Values, dataset, enhanced, even,
                      lifted, stack, write)

Make = Callable[[Path], None]
ANY_BUT_BUILT = "any but built"     # for single files that must be refused for any reason


@dataclass(frozen=True)
class Case:
    number: int
    name: str
    expected: str
    make: Make
    says: str = ""
    truth: Values | None = even
    unit: float = 1.0               # scale of the stored values, in the phantom's values
    air: int = -1024
    tolerance: float = 6.0          # in the phantom's values, less than half a voxel
    browser: str | None = None      # None: same as the server
    browser_says: str | None = None
    options: tuple[str, ...] = ()   # of diaphane-scan
    # returns what else is wrong with the volume besides the comparison with the phantom
    check: Callable[[Volume], str] = lambda volume: ""


def _ct(slices: list[Slice], **of_series) -> Make:
    series = Series(**of_series)
    return lambda folder: write(folder, [dataset(series, one) for one in slices])


def _both(*makes: Make) -> Make:
    def make(folder: Path) -> None:
        for number, one in enumerate(makes):
            one(folder / f"D{number}")
    return make


def _mr(slices: list[Slice], **of_series) -> Make:
    return _ct([replace(one, intercept=0.0) for one in slices], sop_class=MR, values=lifted, **of_series)


def _places(n: int, gap: float, missing: set[int]) -> list[float]:
    return [i * gap for i in range(n) if i not in missing]


def _each(slices: list[Slice], change: Callable[[int], dict]) -> list[Slice]:
    return [replace(one, **change(i)) for i, one in enumerate(slices)]


def _turned(degrees: float) -> tuple[float, ...]:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (c, s, 0.0, 0.0, 0.0, -1.0)


def oblique() -> tuple[float, ...]:
    """Returns the orientation of slices that are rotated about all three axes."""
    a, b = math.radians(25), math.radians(-35)
    row = (math.cos(a), math.sin(a) * math.cos(b), math.sin(a) * math.sin(b))
    column = (-math.sin(a), math.cos(a) * math.cos(b), math.cos(a) * math.sin(b))
    return (*row, *column)


def _one_file(series: Series, slices: list[Slice], frames=None) -> Make:
    return lambda folder: write(folder, [enhanced(series, slices, frames)])


def _shuffled(slices: list[Slice]) -> list[Slice]:
    return [slices[(7 * i + 3) % len(slices)] for i in range(len(slices))]


_FRAMES = Series(ENHANCED_CT)
_FRAMES_MR = Series(ENHANCED_MR, values=lifted)
_SCOUT = {"ImageType": ["ORIGINAL", "PRIMARY", "LOCALIZER"]}
_PET = [replace(one, intercept=0.0, slope=0.5 + 0.05 * i) for i, one in enumerate(stack())]
_SMALL_FRAMES = stack(20, rows=20, columns=24)
# Smaller images cannot be compressed with JPEG 2000.
_J2K_FRAMES = pixels.compressed_frames(_FRAMES, stack(20, rows=32, columns=32), JPEG2000Lossless)


def _scouts_inside(folder: Path) -> None:
    write(folder, [dataset(Series(), one) for one in stack()])
    scouts = [dataset(Series(extra=_SCOUT), one) for one in stack(1, orientation=SAGITTAL, rows=40)]
    write(folder, scouts + [dataset(Series(), one) for one in stack(1, orientation=_turned(30))], first_number=900)


def _twice(folder: Path) -> None:
    slices = _each(stack(), lambda i: {"uid": f"2.25.900{i}"})
    _both(_ct(slices), _ct(slices[3:6]))(folder)


def _two_patients(folder: Path) -> None:
    _both(_ct(stack()), _ct(stack(18), patient="two"))(folder)


def _has_phases(count: int) -> Callable[[Volume], str]:
    return lambda volume: "" if len(volume.phases) == count else f"{len(volume.phases)} phases"


def _multi_frame_without_places(folder: Path) -> None:
    ds = enhanced(Series(CT), stack())
    del ds.PerFrameFunctionalGroupsSequence, ds.SharedFunctionalGroupsSequence
    write(folder, [ds])


CASES: list[Case] = [
    Case(1, "regular CT", "built", _ct(stack())),
    Case(1, "regular MR", "built", _mr(stack()), truth=lifted, air=-1),
    Case(2, "jitter of 1.5 %", "built", _ct(stack([2.0 * i + (0.03 if i % 2 and i < 19 else 0) for i in range(20)])),
         "slice positions deviated by up to 0.03 mm"),
    Case(3, "oblique", "built", _ct(stack(orientation=oblique()), bits=16)),
    Case(3, "rows from below, columns from the left", "built", _ct(stack(orientation=(-1.0, 0, 0, 0, 1.0, 0), origin=(9, -8, 20)))),
    Case(4, "gantry tilt", "built", _ct(stack(tilt=18.5)), "gantry tilt of 18.5 degrees corrected"),
    Case(4, "gantry tilt the other way, oblique", "built", _ct(stack(tilt=-12.0, orientation=oblique())),
         "gantry tilt of 12.0 degrees corrected"),
    Case(5, "2 of 40 missing", "built", _ct(stack(_places(40, 1.5, {7, 22}))),
         "2 slices were missing and interpolated from the neighbouring slices"),
    Case(5, "a hole of 2 of 45", "built", _ct(stack(_places(45, 1.0, {30, 31}))), "2 slices were missing"),
    Case(5, "3 of 20 missing", "refused: missing_slices", _ct(stack(_places(20, 2, {3, 9, 14}))),
         "3 slices are missing within the series. Try copying the files from the disc again"),
    Case(5, "a hole of 3 of 100", "refused: missing_slices", _ct(stack(_places(100, 1, {50, 51, 52}))), "3 slices are missing"),
    Case(6, "2 mm, then 3.3 mm", "built", _ct(stack([2.0 * i for i in range(10)] + [20 + 3.3 * i for i in range(10)])),
         "varied from 2.00 to 3.30 mm"),
    Case(6, "2.5 mm, then 5 mm", "built", _ct(stack([2.5 * i for i in range(10)] + [25 + 5 * i for i in range(8)])),
         "varied from 2.50 to 5.00 mm"),
    Case(6, "1 mm, then 9 mm", "refused: varying_spacing", _ct(stack([float(i) for i in range(10)] + [10 + 9.0 * i for i in range(10)])),
         "varies too much"),
    Case(7, "three slices there twice", "built", _twice, "3 slices were duplicated; one copy of each was kept"),
    Case(8, "two phases", "built", _both(_ct(stack()), _ct(stack())), check=_has_phases(2)),
    Case(8, "three b-values, interleaved", "built", _mr([one for one in stack() for _ in range(3)]), truth=lifted, air=-1,
         check=_has_phases(3)),
    Case(8, "two phases of few slices", "refused: too_few_slices", _both(_ct(stack(12)), _ct(stack(12))), "has 12"),
    Case(9, "scouts alone", "refused: scout", _ct(stack(2), extra=_SCOUT), "an overview image that was used to plan the scan"),
    Case(9, "scouts in a good series", "built", _scouts_inside, "2 overview images were skipped"),
    Case(10, "rotating projections", "refused: views_not_slices",
         _ct([replace(stack(1)[0], orientation=_turned(10 * i)) for i in range(30)]), "views"),
    Case(10, "maximum intensity projections", "refused: views_not_slices",
         _ct(stack(), extra={"ImageType": ["DERIVED", "SECONDARY", "PROJECTION IMAGE", "MIP"]}), "rendered views of a scan, not slices"),
    Case(11, "one position repeated", "refused: one_position", _ct(stack([0.0] * 20)), "same position"),
    Case(12, "enhanced CT, frames in no order", "built", _one_file(_FRAMES, _shuffled(stack()))),
    Case(12, "enhanced CT, tilted", "built", _one_file(_FRAMES, stack(tilt=10.0)), "gantry tilt of 10.0 degrees corrected"),
    Case(12, "enhanced MR, a scale for each frame", "built",
         _one_file(_FRAMES_MR, _each(stack(), lambda i: {"slope": 0.2 + 0.01 * i, "intercept": 0.0})),
         "converted to a single one", truth=lifted, unit=0.39, air=-1),
    Case(12, "enhanced CT, RLE", "built", pixels.compressed_frames(_FRAMES, _SMALL_FRAMES), truth=even),
    *[Case(12, f"enhanced CT, JPEG 2000 in pieces, {offsets} offsets", "built",
           pixels.in_pieces(_J2K_FRAMES, 3, offsets), truth=even)
      for offsets in ("basic", "extended")],
    Case(12, "enhanced CT, JPEG 2000 in pieces, no offsets", "refused: unsupported_compression",
         pixels.in_pieces(_J2K_FRAMES, 3), "fragments of the compressed images", browser="built"),
    Case(12, "enhanced MR of two stacks", "2 x built",
         _one_file(_FRAMES_MR, _each(stack(20) + stack(18, orientation=SAGITTAL), lambda i: {"intercept": 0.0}),
                   [{"stack": 1}] * 20 + [{"stack": 2}] * 18), truth=lifted, air=-1),
    Case(12, "enhanced CT of two times", "built",
         _one_file(_FRAMES, stack() + stack(), [{"time": 1}] * 20 + [{"time": 2}] * 20), check=_has_phases(2)),
    Case(12, "enhanced MR, cine", "refused: cine",
         _one_file(_FRAMES_MR, [replace(one, intercept=0.0) for one in stack([0.0] * 20)]), "a video of a single place"),
    Case(13, "multi-frame with no positions", "refused: no_position", _multi_frame_without_places,
         "does not specify their positions"),
    Case(13, "slices with no position", "refused: no_position", _ct(stack(), extra={"ImagePositionPatient": None}),
         "position in the body is missing"),
    Case(13, "slices with no orientation", "refused: no_position", _ct(stack(), extra={"ImageOrientationPatient": None}),
         "position in the body is missing"),
    Case(14, "4 of 24 with another matrix", "built", _ct(_each(stack(24), lambda i: {"rows": 32} if i >= 20 else {})),
         "4 slices of a different size were skipped"),
    Case(14, "half and half in pixel spacing", "refused: mixed",
         _ct(_each(stack(24), lambda i: {"pixel": (0.9, 0.9)} if i % 2 else {})), "different sizes"),
    Case(15, "PET, a scale for each slice", "built", _ct(_PET, sop_class=PT, values=lifted),
         "the slices had different value scales", truth=lifted, unit=0.5 + 0.05 * 19, air=-1),
    Case(16, "padding in CT", "built", pixels.padded(Series(signed=True), [replace(o, intercept=0.0) for o in stack()], -2000)),
    Case(16, "padding in MR", "built", pixels.padded(Series(MR, values=lifted), [replace(o, intercept=0.0) for o in stack()], 60000),
         truth=lifted, air=0),
    Case(17, "signed", "built", _ct(_each(stack(), lambda i: {"intercept": 0.0}), signed=True)),
    Case(17, "12 of 16 bits, overlays above them", "built", pixels.dirty_bits(stack(), signed=False)),
    Case(17, "12 of 16 bits, signed", "built", pixels.dirty_bits(stack(), signed=True)),
    Case(18, "MONOCHROME1 in CT", "built", pixels.displayed_inverted(stack())),
    Case(18, "MONOCHROME1 in MR", "built", pixels.negative(Series(MR, values=lifted), [replace(o, intercept=0.0) for o in stack()]),
         "the inverted (negative) image was converted back", truth=lifted, air=0),
    *[Case(18, kind, "refused: screenshots", pixels.coloured(stack(), kind), "screenshots")
      for kind in ("RGB", "YBR_FULL", "PALETTE COLOR")],
    *[Case(19, name, "built", make, tolerance=tolerance, browser=browser)
      for name, make, tolerance, browser in pixels.transfer_syntaxes(stack(20, rows=32, columns=32))],
    Case(19, "MPEG-2", "refused: unsupported_compression", pixels.unsupported(stack()), "MPEG-2"),
    Case(20, "no preamble", "built", pixels.beheaded(stack(), keep_meta=True)),
    *[Case(20, f"no meta header, {name}", "built", pixels.beheaded(stack(), keep_meta=False, syntax=syntax))
      for name, syntax in (("explicit", "1.2.840.10008.1.2.1"), ("implicit", "1.2.840.10008.1.2"),
                           ("big endian", "1.2.840.10008.1.2.2"))],
    Case(21, "one of 30 cut off", "built", pixels.cut_off(stack(30), {9}), "1 slice was missing"),
    Case(21, "three of 30 cut off", "refused: missing_slices", pixels.cut_off(stack(30), {5, 9, 17}), "3 slices are missing"),
    *[Case(22, name, "not listed", _ct(stack(), sop_class=sop_class), truth=None)
      for name, sop_class in (("secondary capture", "1.2.840.10008.5.1.4.1.1.7"), ("report", "1.2.840.10008.5.1.4.1.1.88.22"),
                              ("PDF", "1.2.840.10008.5.1.4.1.1.104.1"), ("RT dose", "1.2.840.10008.5.1.4.1.1.481.2"),
                              ("structure set", "1.2.840.10008.5.1.4.1.1.481.3"), ("segmentation", "1.2.840.10008.5.1.4.1.1.66.4"),
                              ("dose report", "1.2.840.10008.5.1.4.1.1.88.67"))],
    Case(23, "two patients in one series", "2 x built", _two_patients),
    Case(24, "15 slices", "refused: too_few_slices", _ct(stack(15)), "Too few slices"),
    Case(24, "20 slices of 0.9 mm", "refused: too_few_slices", _ct(stack(20, gap=0.9)), "Too few slices", browser="refused: too_short"),
    Case(25, "over the quota", "refused: over_quota", _ct(stack()), "larger than allowed", browser="built",
         options=("--most-voxels", str(20 * 24 * 20 - 1))),
]


