"""Chapter 7 of the thesis: up to which delay of the picture participants accept it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats
from scipy.special import ndtr, ndtri, xlogy

from . import export, intervals
from .intervals import Estimate

#: The probability of claiming a threshold where acceptance does not depend on the delay.
SIGNIFICANCE = 0.01
LAPSES = np.array([0.0, 0.02, 0.05, 0.1])
_RESAMPLES = 599


@dataclass(frozen=True)
class Result:
    step: str
    n: int                                 # participants
    delays: np.ndarray
    accepted: np.ndarray
    trials: np.ndarray
    ratings: list[Estimate]
    seconds: list[Estimate]                # geometric means of the time for the task
    errors: list[Estimate]
    p_value: float                         # that acceptance does not depend on the delay
    parameters: np.ndarray | None          # threshold in ms, scale in ms, lapse rate
    thresholds: dict[float, tuple[float, float, float]]    # share -> value, low, high; infinite beyond the delays


def share_at(delays: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    """Returns the share that accepts a delay: a cumulative Gaussian between lapse / 2 and 1 - lapse / 2. The thresholds of people
    vary like a Gaussian. A logistic function put the delay that 75% accept 4 ms too high, and its interval covered too seldom.
    """
    threshold, scale, lapse = (parameters[..., i, None] for i in range(3))
    return lapse / 2 + (1 - lapse) * ndtr((threshold - delays) / scale)


def _likelihood(accepted: np.ndarray, trials: np.ndarray, shares: np.ndarray) -> np.ndarray:
    shares = np.clip(shares, 1e-9, 1 - 1e-9)
    return (accepted * np.log(shares) + (trials - accepted) * np.log(1 - shares)).sum(axis=-1)


def fit(delays: np.ndarray, accepted: np.ndarray, trials: np.ndarray) -> np.ndarray:
    """Returns the parameters of greatest likelihood for each row of counts: first on a grid, then on ever finer ones around the
    best. All rows are fitted together, which is a hundred times as fast as an optimiser per resample.
    """
    width = float(delays[-1] - delays[0])
    grid = np.stack(np.meshgrid(np.linspace(delays[0] - width / 2, delays[-1] + width / 2, 41), np.geomspace(width / 60, width, 16), LAPSES,
                                indexing="ij"), axis=-1).reshape(-1, 3)
    shares = np.clip(share_at(delays, grid), 1e-9, 1 - 1e-9)
    likelihood = accepted @ np.log(shares).T + (trials - accepted) @ np.log(1 - shares).T
    best = grid[likelihood.argmax(axis=1)]
    steps = np.stack(np.meshgrid(np.linspace(-1, 1, 7), np.linspace(-1, 1, 7), indexing="ij"), axis=-1).reshape(-1, 2)
    reach, factor = width / 20, np.log(60) / 15
    for _ in range(6):
        near = np.repeat(best[:, None], len(steps), axis=1)
        near[..., 0] += reach * steps[:, 0]
        near[..., 1] *= np.exp(factor * steps[:, 1])
        likelihood = _likelihood(accepted[:, None], trials[:, None], share_at(delays, near))
        best = near[np.arange(len(best)), likelihood.argmax(axis=1)]
        reach, factor = reach * 0.45, factor * 0.45
    return best


def threshold_at(share: float, parameters: np.ndarray) -> np.ndarray:
    threshold, scale, lapse = parameters[..., 0], parameters[..., 1], parameters[..., 2]
    return threshold - scale * ndtri((share - lapse / 2) / (1 - lapse))


def _p_value(delays: np.ndarray, accepted: np.ndarray, trials: np.ndarray, best: np.ndarray) -> float:
    """Returns the p-value of the likelihood ratio test against a share that is the same at all delays."""
    common = accepted.sum() / trials.sum()
    constant = float(xlogy(accepted, common).sum() + xlogy(trials - accepted, 1 - common).sum())
    gain = 2 * (float(_likelihood(accepted, trials, share_at(delays, best))) - constant)
    return float(stats.chi2.sf(max(gain, 0), 2))


def thresholds(delays: np.ndarray, accepted: np.ndarray, trials: np.ndarray, rng: np.random.Generator,
               shares: tuple[float, ...] = (0.5, 0.75)) -> tuple[np.ndarray, dict[float, tuple[float, float, float]]]:
    """Returns the parameters, and thresholds with percentile intervals that are expanded for the number of participants
    (Hesterberg 2015). `accepted` and `trials` have one row per participant, because a resample draws whole participants.
    """
    n = len(trials)
    best = fit(delays, accepted.sum(axis=0)[None], trials.sum(axis=0)[None])[0]
    counts = rng.multinomial(n, np.full(n, 1 / n), _RESAMPLES).astype(float)
    drawn = fit(delays, counts @ accepted, counts @ trials)
    tail = stats.norm.cdf(-np.sqrt(n / (n - 1)) * stats.t.ppf((1 + intervals.LEVEL) / 2, n - 1))
    found = {}
    for share in shares:
        values = threshold_at(share, drawn)
        low, high = np.quantile(values, [tail, 1 - tail])
        beyond = [float(value) if value <= delays[-1] else float("inf") for value in (threshold_at(share, best), low, high)]
        found[share] = (beyond[0], max(beyond[1], 0.0), beyond[2])
    return best, found


def analyse(document: dict[str, Any], step: str, rng: np.random.Generator | None = None) -> Result | None:
    rng = rng or np.random.default_rng(1)
    people = [value["trials"] for value in export.answers(document, step).values() if value["trials"]]
    if not people:
        return None
    delays = np.array(sorted({trial["delay_ms"] for trials in people for trial in trials}), float)
    accepted, trials = np.zeros((len(people), len(delays))), np.zeros((len(people), len(delays)))
    for row, one in enumerate(people):
        for trial in one:
            column = int(np.searchsorted(delays, trial["delay_ms"]))
            accepted[row, column] += bool(trial["acceptable"])
            trials[row, column] += 1

    def by_delay(value: Callable[[dict[str, Any]], float]) -> list[np.ndarray]:
        """Returns each participant's mean at each delay."""
        return [np.array([np.mean(own) for one in people if (own := [value(trial) for trial in one if trial["delay_ms"] == delay])])
                for delay in delays]

    ratings = [intervals.means(column, rng=rng) for column in by_delay(lambda trial: trial["rating"])]
    logs = [intervals.means(column, rng=rng) for column in by_delay(lambda trial: np.log(max(trial["time_ms"], 1) / 1000))]
    seconds = [Estimate(one.n, *(np.exp(value) for value in (one.mean, one.deviation, one.low, one.high))) for one in logs]
    errors = [intervals.means(column, rng=rng) for column in by_delay(lambda trial: trial["error_degrees"])]
    total = accepted.sum(axis=0), trials.sum(axis=0)
    if len(delays) < 3 or len(people) < intervals.FEWEST:
        return Result(step, len(people), delays, *total, ratings, seconds, errors, 1.0, None, {})
    best, found = thresholds(delays, accepted, trials, rng)
    p_value = _p_value(delays, *total, best)
    if p_value > SIGNIFICANCE:
        return Result(step, len(people), delays, *total, ratings, seconds, errors, p_value, None, {})
    return Result(step, len(people), delays, *total, ratings, seconds, errors, p_value, best, found)
