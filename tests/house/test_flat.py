"""The soak's verdict on made series."""

from __future__ import annotations

import random

import pytest

from house import flat


def series(slope: float, noise: float, seed: int, count: int = 400) -> tuple[list[float], list[float]]:
    draws = random.Random(seed)
    times = [float(t) for t in range(count)]
    return times, [100 + slope * t + draws.gauss(0, noise) for t in times]


def test_noise_is_flat_and_a_leak_within_it_grows():
    assert flat.judge(*series(0, 3, 1), 0.04, 0).word == "flat"
    leak = flat.judge(*series(0.02, 3, 1), 0.04, 0)    # 8 in all; 4 may be
    assert leak.word == "grows" and leak.low < 8 < leak.high


def test_what_is_measured_too_shortly_is_unclear():
    assert flat.judge(*series(0, 30, 2, 40), 0.02, 0).word == "unclear"


def test_the_interval_holds_the_truth_as_often_as_it_says():
    held = sum((v := flat.judge(*series(0.01, 5, seed), 0.02, 0)).low <= 0.01 * 399 <= v.high for seed in range(1000))
    assert held >= 975    # of 990 expected; fewer has a chance below 1e-4


def test_too_few_samples_are_refused():
    with pytest.raises(ValueError):
        flat.judge([1.0] * 19, [1.0] * 19, 0.02, 0)
