"""Whether a series of measurements grows: a slope with its confidence, held against what may be. Pure."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from typing import Sequence

BLOCKS = 10
#: Student's t at 99.5%, 8 degrees of freedom (ten means, two parameters): two-sided confidence of 99%.
T_99 = 3.355


@dataclass(frozen=True)
class Verdict:
    """Of one series, in its unit. `growth` is slope times length; it lies between `low` and `high` with 99% confidence."""

    level: float
    growth: float
    low: float
    high: float
    allowed: float

    @property
    def word(self) -> str:
        """`flat`: it does not grow by more than is allowed; `grows`: it does; `unclear`: measured too shortly to say."""
        return "flat" if self.high <= self.allowed else "grows" if self.low > self.allowed else "unclear"


def judge(times: Sequence[float], values: Sequence[float], share: float, least: float) -> Verdict:
    """Allowed is `share` of the level, at least `least`. Samples that follow one another are alike, so the slope is that of
    the means of ten blocks, whose own scatter gives its error."""
    if len(times) != len(values) or len(times) < 2 * BLOCKS:
        raise ValueError(f"a verdict needs {2 * BLOCKS} samples, there are {len(times)}")
    xs, ys = [], []
    for block in range(BLOCKS):
        begin, end = block * len(times) // BLOCKS, (block + 1) * len(times) // BLOCKS
        xs.append(statistics.fmean(times[begin:end]))
        ys.append(statistics.fmean(values[begin:end]))
    level = statistics.fmean(ys)
    mean_x = statistics.fmean(xs)
    square = sum((x - mean_x) ** 2 for x in xs)
    slope = sum((x - mean_x) * (y - level) for x, y in zip(xs, ys)) / square
    left = sum((y - level - slope * (x - mean_x)) ** 2 for x, y in zip(xs, ys))
    length = times[-1] - times[0]
    error = T_99 * math.sqrt(left / (BLOCKS - 2) / square) * length
    growth = slope * length
    return Verdict(level, growth, growth - error, growth + error, max(share * level, least))
