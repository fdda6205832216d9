"""Analyses many simulated crowds, each with its own seed. `./diaphane bench studies` and the tests use it."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import stats

from . import comfort, export, latency, simulate, viewpoints

#: Degrees within which a planted cluster counts as found.
NEAR = 15.0


def comfort_trial(seed: int) -> dict[str, bool]:
    """Returns for each figure of Table 1 whether its interval covers it."""
    rng = np.random.default_rng([1, seed])
    found = comfort.materials(simulate.comfort(rng), rng)
    covered = {}
    for material, truth in zip(found, simulate.TABLE_1, strict=True):
        for kind, estimate, means in (("difference", material.plain, truth.mean), ("weighted", material.weighted, truth.weighted)):
            for column, mean in enumerate(means):
                covered[f"{truth.channel} {kind} {'rgb'[column]}"] = bool(estimate.low[column] <= mean <= estimate.high[column])
    return covered


def no_effect_trial(seed: int) -> dict[str, bool]:
    rng = np.random.default_rng([2, seed])
    return {"nothing adopted": not any(one.effect for one in comfort.materials(simulate.comfort(rng, effect=False), rng))}


def validation_trial(seed: int) -> dict[str, bool]:
    from . import intervals

    rng = np.random.default_rng([3, seed])
    [found] = comfort.orderings(simulate.validation(rng), rng)
    covered = {}
    for name, value, count in found.pictures:
        low, high = intervals.share(count, found.n)
        covered[f"{name} {value:+d}"] = low <= (0.63 if value < 0 else 0.59) <= high
    return covered


def viewpoints_trial(seed: int) -> dict[str, bool]:
    rng = np.random.default_rng([4, seed])
    document, planted = simulate.viewpoints(rng)
    result = _viewpoints(document, rng)
    outliers = {int(number) for number in result.views.numbers} - {int(number) for number in result.views.numbers[result.kept]}
    number = len(result.clusters) == len(planted.centres)
    angles = np.degrees(np.arccos(np.clip(planted.centres @ np.array([one.direction for one in result.clusters]).T, -1, 1))) if result.clusters else None
    place = number and angles is not None and bool((angles.min(axis=1) <= NEAR).all())
    return {"number and place": place, "planted outliers removed": planted.outliers <= outliers, "no other view removed": outliers <= planted.outliers}


def noise_trial(kind: str, seed: int) -> dict[str, bool]:
    rng = np.random.default_rng([5, list(simulate.NOISE).index(kind), seed])
    result = _viewpoints(simulate.noise(kind, rng), rng)
    # One common view is right for a crowd about one view, and wrong for the others.
    return {kind: len(result.clusters) <= (1 if kind == "one view" else 0)}


def _viewpoints(document: dict[str, Any], rng: np.random.Generator) -> viewpoints.Result:
    [step] = export.steps(document, "viewpoint")
    views = viewpoints.views_of(document, step)
    assert views is not None
    return viewpoints.analyse(step["id"], views, rng)


def latency_truth(share: float) -> float:
    """Returns the delay that this share of the simulated crowd accepts."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(61)
    delays = np.linspace(0, 400, 8001)
    shares = weights @ simulate.accepting(delays, (simulate.THRESHOLD + simulate.BETWEEN * nodes)[:, None]) / weights.sum()
    return float(np.interp(-share, -shares, delays))


def latency_trial(seed: int) -> dict[str, bool]:
    rng = np.random.default_rng([6, seed])
    result = latency.analyse(simulate.latency(rng), "latency", rng)
    assert result is not None
    covered = {}
    for share in (0.5, 0.75):
        _, low, high = result.thresholds.get(share, (0, np.inf, -np.inf))
        covered[f"threshold {share:.0%}"] = low <= latency_truth(share) <= high
    return covered


def coverage_p_value(covered: int, n: int, exact: bool, level: float = 0.95) -> float:
    """Returns the p-value that intervals cover as often as they claim. Those of Clopper and Pearson may cover more often."""
    return float(stats.binomtest(covered, n, level, alternative="less" if exact else "two-sided").pvalue)
