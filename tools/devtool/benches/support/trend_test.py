"""Tests whether a series of measurements grows: the Theil-Sen slope with its confidence interval, compared with a limit. Pure."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from typing import Sequence

#: Quantile of the normal distribution for a two-sided confidence of 99%.
Z_99 = 2.576
FEWEST_BLOCKS, MOST_BLOCKS = 10, 20
#: Length of a block. Measurements are correlated over about half a minute (autocorrelation of
#: renderd's memory in a soak: 0.5 after 20 s, none after 40 s). The interval assumes independent
#: values, and means of 90 s are.
BLOCK_SECONDS = 90.0


@dataclass(frozen=True)
class Verdict:
    """The verdict on one series, in its unit. `growth` is slope times length, and lies between `low` and `high` with 99%
    confidence."""

    level: float
    growth: float
    low: float
    high: float
    allowed: float

    @property
    def word(self) -> str:
        """Returns the verdict: `flat` grows by no more than allowed, `grows` by more, and `unclear`
        was measured for too short a time."""
        return "flat" if self.high <= self.allowed else "grows" if self.low > self.allowed else "unclear"

    @property
    def trend(self) -> bool:
        """Whether it grows at all, according to the Mann-Kendall test at 0.5%, of which the interval is the inverse."""
        return self.low > 0


def judge(times: Sequence[float], values: Sequence[float], share: float, least: float) -> Verdict:
    """Judges the growth, which may be `share` of the level, and at least `least`. The slope is the
    median over all pairs of block means, so that a single peak has no effect. Its interval is
    that of P. K. Sen (J. Am. Stat. Assoc. 63, 1379, 1968)."""
    if len(times) != len(values) or len(times) < 2 * FEWEST_BLOCKS:
        raise ValueError(f"the trend test needs at least {2 * FEWEST_BLOCKS} samples, but got {len(times)}")
    length = times[-1] - times[0]
    blocks = max(FEWEST_BLOCKS, min(MOST_BLOCKS, int(length / BLOCK_SECONDS)))
    means = [_mean(times, values, block, blocks) for block in range(blocks)]
    slopes = sorted((y - before_y) / (x - before_x) for i, (before_x, before_y) in enumerate(means) for x, y in means[i + 1:])
    # The standard deviation of Kendall's S for independent, different values. It is smaller with equal values.
    spread = Z_99 * math.sqrt(blocks * (blocks - 1) * (2 * blocks + 5) / 18)
    rank = max(0, math.floor((len(slopes) - spread) / 2))
    level = statistics.fmean(y for _, y in means)
    return Verdict(level, statistics.median(slopes) * length, slopes[rank] * length, slopes[-1 - rank] * length, max(share * level, least))


def _mean(times: Sequence[float], values: Sequence[float], block: int, blocks: int) -> tuple[float, float]:
    begin, end = block * len(times) // blocks, (block + 1) * len(times) // blocks
    return statistics.fmean(times[begin:end]), statistics.fmean(values[begin:end])
