"""Judges a picture in numbers: burnt-out and black areas, and how much of the picture the subject fills."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenEXR

MOST_BURNT, MOST_BLACK = 0.005, 0.05
LEAST_FILLED, MOST_FILLED = 0.5, 0.85
#: Limits of 8-bit values: burnt out is white, and black is below 1% of the luminance of white.
BURNT, BLACK = 254, 25
#: Share of the subject's pixels that counts as noise outside the body, at each side of the picture.
OUTLYING = 0.001


@dataclass(frozen=True)
class Judged:
    """The measures of one finished picture, as shares of the subject's pixels, and of the picture's
    height and width."""

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
    """Judges a picture. `picture` is 8-bit RGB as it is shown, and `subject` is true where the scan
    is."""
    if not subject.any():
        return Judged(scan, preset, 0, 0, 0, 0)
    inside = picture[subject]
    # Uses the luminance of sRGB, weighted after the transfer curve, which is accurate enough near black.
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


def read_exr(file: Path) -> np.ndarray:
    """Returns an EXR picture as an array of channel, row and column."""
    with OpenEXR.File(str(file), separate_channels=True) as picture:
        return np.stack([picture.channels()[name].pixels for name in "BGR"])
