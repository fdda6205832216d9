"""Judges a picture in numbers: burnt-out and black areas, and how much of the picture the subject fills."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np

MOST_BURNT, MOST_BLACK = 0.005, 0.05
LEAST_FILLED, MOST_FILLED = 0.5, 0.85
#: 8-bit values: burnt out is white, and black is below 1% of the luminance of white.
BURNT, BLACK = 254, 25
#: Pixels outside the body at each side of the picture are noise.
OUTLYING = 0.001


@dataclass(frozen=True)
class Judged:
    """One finished picture. All are shares: of the subject's pixels, and of the picture's height and width."""

    scan: str
    preset: str
    burnt: float
    black: float
    height: float
    width: float

    def faults(self) -> list[str]:
        filled = max(self.height, self.width)
        return [words for wrong, words in (
            (self.burnt > MOST_BURNT, f"{self.burnt:.1%} burnt out"),
            (self.black > MOST_BLACK, f"{self.black:.1%} black"),
            (not LEAST_FILLED <= filled <= MOST_FILLED, f"fills {filled:.0%}"),
        ) if wrong]


def judge(scan: str, preset: str, picture: np.ndarray, subject: np.ndarray) -> Judged:
    """`picture` is 8-bit RGB as it is shown, and `subject` true where the scan is."""
    if not subject.any():
        return Judged(scan, preset, 0, 0, 0, 0)
    inside = picture[subject]
    # By the luminance of sRGB, weighted after the transfer curve, which is close enough near black.
    grey = inside @ np.array([0.2126, 0.7152, 0.0722])
    return Judged(scan, preset, float((inside.min(axis=1) >= BURNT).mean()), float((grey < BLACK).mean()),
                  _extent(subject.sum(axis=1)), _extent(subject.sum(axis=0)))


def subject_in(radiance: np.ndarray) -> np.ndarray:
    """Returns where a picture differs from its background, which a preset makes darker with the square of the distance from the
    middle. `radiance` has channel, row, column, and background at its border."""
    height, width = radiance.shape[1:]
    off_centre = 0.5 * (np.linspace(-1, 1, height)[:, None] ** 2 + np.linspace(-1, 1, width)[None, :] ** 2)
    border = np.ones((height, width), bool)
    border[1:-1, 1:-1] = False
    differs = np.zeros((height, width), bool)
    for channel in radiance:
        slope, middle = np.polyfit(off_centre[border], channel[border], 1)
        background = middle + slope * off_centre
        differs |= np.abs(channel - background) > 0.03 * np.abs(background) + 2e-4
    return differs


def _extent(counts: np.ndarray) -> float:
    """Returns the share of rows or columns between the outlying pixels at both ends."""
    passed = np.cumsum(counts) / counts.sum()
    first, last = np.searchsorted(passed, [OUTLYING, 1 - OUTLYING])
    return float((last - first + 1) / len(counts))


def read_ppm(data: bytes) -> np.ndarray:
    """Returns row, column, RGB in 8 bits."""
    magic, size, _most, pixels = data.split(b"\n", 3)
    width, height = map(int, size.split())
    assert magic == b"P6"
    return np.frombuffer(pixels, np.uint8).reshape(height, width, 3)


def read_exr(data: bytes) -> np.ndarray:
    """Reads what diaphane-render writes: 32-bit B, G and R, in ZIP blocks of 16 rows. Returns channel, row, column."""
    at, attributes = 8, {}
    while data[at]:
        name, kind_and_rest = data[at:].split(b"\0", 1)
        kind = kind_and_rest.split(b"\0", 1)[0]
        at += len(name) + len(kind) + 2
        length = struct.unpack_from("<I", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + length]
        at += 4 + length
    _left, _top, right, bottom = struct.unpack("<4i", attributes[b"dataWindow"])
    width, height = right + 1, bottom + 1
    assert attributes[b"compression"] == b"\3"
    picture = np.empty((3, height, width), np.float32)
    for offset in struct.unpack_from(f"<{(height + 15) // 16}Q", data, at + 1):
        top, size = struct.unpack_from("<2i", data, offset)
        rows = min(16, height - top)
        packed = data[offset + 8:offset + 8 + size]
        if size < rows * width * 12:
            # Differences of bytes, then the even and the odd bytes apart (OpenEXR's ZIP).
            steps = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
            steps[1:] -= 128
            halves = (np.cumsum(steps) % 256).astype(np.uint8)
            middle = (len(halves) + 1) // 2
            plain = np.empty_like(halves)
            plain[0::2], plain[1::2] = halves[:middle], halves[middle:]
            packed = plain.tobytes()
        picture[:, top:top + rows] = np.frombuffer(packed, "<f4").reshape(rows, 3, width).transpose(1, 0, 2)
    return picture
