"""Whether a series of measurements grows: Theil and Sen's slope with its confidence, held against what may be. Pure."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from typing import Sequence

#: Two-sided confidence of 99%.
Z_99 = 2.576
FEWEST_BLOCKS, MOST_BLOCKS = 10, 20
#: What programs hold is alike for about half a minute (renderd's memory, by its autocorrelation in a soak: 0.5 after 20 s,
#: none after 40 s). The interval takes what it is given as independent: means of 90 s are.
BLOCK_SECONDS = 90.0


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

    @property
    def trend(self) -> bool:
        """It grows at all: what Mann and Kendall's test says at 0.5%, of which the interval is the inverse."""
        return self.low > 0


def judge(times: Sequence[float], values: Sequence[float], share: float, least: float) -> Verdict:
    """Allowed is `share` of the level, at least `least`. The slope is the median of those between any two of the blocks' means,
    so that a single peak moves nothing; its interval is P. K. Sen's (J. Am. Stat. Assoc. 63, 1379, 1968)."""
    if len(times) != len(values) or len(times) < 2 * FEWEST_BLOCKS:
        raise ValueError(f"a verdict needs {2 * FEWEST_BLOCKS} samples, there are {len(times)}")
    length = times[-1] - times[0]
    blocks = max(FEWEST_BLOCKS, min(MOST_BLOCKS, int(length / BLOCK_SECONDS)))
    means = [_mean(times, values, block, blocks) for block in range(blocks)]
    slopes = sorted((y - before_y) / (x - before_x) for i, (before_x, before_y) in enumerate(means) for x, y in means[i + 1:])
    # The spread of Kendall's S among independent values, all different; of equal ones it is less.
    spread = Z_99 * math.sqrt(blocks * (blocks - 1) * (2 * blocks + 5) / 18)
    rank = max(0, math.floor((len(slopes) - spread) / 2))
    level = statistics.fmean(y for _, y in means)
    return Verdict(level, statistics.median(slopes) * length, slopes[rank] * length, slopes[-1 - rank] * length, max(share * level, least))


def _mean(times: Sequence[float], values: Sequence[float], block: int, blocks: int) -> tuple[float, float]:
    begin, end = block * len(times) // blocks, (block + 1) * len(times) // blocks
    return statistics.fmean(times[begin:end]), statistics.fmean(values[begin:end])
