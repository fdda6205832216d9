"""Confidence intervals. All have a level of 95% unless another one is given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

LEVEL = 0.95
RESAMPLES = 1999
#: With fewer values, no interval is given.
FEWEST = 5


@dataclass(frozen=True)
class Estimate:
    """Means of columns with intervals, and the standard deviations of the columns. Without an interval, its ends are NaN."""

    n: int
    mean: np.ndarray
    deviation: np.ndarray
    low: np.ndarray
    high: np.ndarray


def means(values: np.ndarray, weights: np.ndarray | None = None, rng: np.random.Generator | None = None, level: float = LEVEL) -> Estimate:
    """Returns weighted means of the columns with intervals of the studentised bootstrap (Efron and Tibshirani 1993, 12.5).

    Colour differences are skewed, because a colour cannot leave its range. There, t and BCa intervals of 43 values cover
    too seldom. A resample draws participants together with their weights, and the standard error is that of a ratio of
    means.
    """
    values = np.atleast_2d(np.asarray(values, float).T).T
    n = len(values)
    weights = np.ones(n) if weights is None else np.asarray(weights, float)
    if n == 0:
        nothing = np.full(values.shape[1], np.nan)
        return Estimate(0, nothing, nothing, nothing, nothing)
    mean = weights @ values / weights.sum()
    # The deviation of the weighted values, as in Table 1 of the thesis. Without weights, it is the ordinary one.
    deviation = (values * (weights / weights.mean())[:, None]).std(axis=0, ddof=1) if n > 1 else np.full(values.shape[1], np.nan)
    if n < FEWEST:
        return Estimate(n, mean, deviation, np.full_like(mean, np.nan), np.full_like(mean, np.nan))
    rng = rng or np.random.default_rng(1)
    counts = rng.multinomial(n, np.full(n, 1 / n), RESAMPLES).astype(float)
    low, high = _studentised(values, weights, mean, counts, level)
    return Estimate(n, mean, deviation, low, high)


def _studentised(values: np.ndarray, weights: np.ndarray, mean: np.ndarray, counts: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    squares = (weights ** 2)[:, None]
    total = counts @ weights
    drawn = counts @ (weights[:, None] * values) / total[:, None]
    spread = counts @ (squares * values ** 2) - 2 * drawn * (counts @ (squares * values)) + drawn ** 2 * (counts @ squares)
    errors = np.sqrt(np.maximum(spread, 0)) / total[:, None]
    own = np.sqrt((squares * (values - mean) ** 2).sum(axis=0)) / weights.sum()
    with np.errstate(divide="ignore", invalid="ignore"):
        pivots = np.where(errors > 1e-9 * (1 + own), (drawn - mean) / errors, np.nan)
    low, high = mean.copy(), mean.copy()
    varied = own > 0
    if varied.any():
        ends = np.nanquantile(pivots[:, varied], [(1 - level) / 2, (1 + level) / 2], axis=0)
        low[varied] = mean[varied] - ends[1] * own[varied]
        high[varied] = mean[varied] - ends[0] * own[varied]
    return low, high


def share(count: int, n: int, level: float = LEVEL) -> tuple[float, float]:
    """Returns the interval of Clopper and Pearson (1934), which covers at least as often as it claims."""
    if n == 0:
        return float("nan"), float("nan")
    found = stats.binomtest(count, n).proportion_ci(level, method="exact")
    return float(found.low), float(found.high)


def hotelling(values: np.ndarray, weights: np.ndarray) -> float:
    """Returns the p-value of Hotelling's T² test that the weighted means of all columns are 0. The number of values is that of
    equal weights with the same error (Kish 1965). Directions in which nothing varies are left out, such as a colour component
    that nobody changed: they would make the test impossible, and say nothing about the others.
    """
    n = weights.sum() ** 2 / (weights ** 2).sum() if len(values) else 0
    if n <= 2:
        return 1.0
    mean = weights @ values / weights.sum()
    moved = weights[:, None] * (values - mean) / weights.sum()
    variances, directions = np.linalg.eigh(moved.T @ moved * n / (n - 1))
    varied = variances > variances.max() * len(variances) * np.finfo(float).eps
    columns = int(varied.sum())
    if columns == 0 or n <= columns + 1:
        return 1.0
    statistic = float(((mean @ directions[:, varied]) ** 2 / variances[varied]).sum())
    return float(stats.f.sf(statistic * (n - columns) / (columns * (n - 1)), columns, n - columns))


def holm(p_values: list[float], significance: float) -> list[bool]:
    """Returns which hypotheses are rejected if no true one may be with more than this probability (Holm 1979)."""
    rejected = [False] * len(p_values)
    for rank, index in enumerate(np.argsort(p_values)):
        if p_values[index] > significance / (len(p_values) - rank):
            break
        rejected[index] = True
    return rejected
