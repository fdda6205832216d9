"""The soak's verdict on synthetic series, and on its own counts."""

from __future__ import annotations

import math
import os
import random

import pytest

from devtool.benches import soak
from devtool.benches.support import trend_test


def series(slope: float, noise: float, seed: int, count: int = 400) -> tuple[list[float], list[float]]:
    draws = random.Random(seed)
    times = [float(t) for t in range(count)]
    return times, [100 + slope * t + draws.gauss(0, noise) for t in times]


def like_renderd(growth: float, seed: int) -> tuple[list[float], list[float]]:
    """Resident megabytes like those of a soak of 30 minutes after its first quarter: noise of 9.2 MB that is half correlated
    after 20 s, and a total growth of `growth`."""
    draws = random.Random(seed)
    kept = 0.5 ** (2 / 20)
    noise, values = draws.gauss(0, 9.2), []
    for i in range(675):
        values.append(224 + growth * i / 674 + noise)
        noise = kept * noise + math.sqrt(1 - kept * kept) * draws.gauss(0, 9.2)
    return [450.0 + 2 * i for i in range(675)], values


def allowed() -> float:
    return soak.memory_allowed("renderd", visits=6000, part=0.75)


def test_a_leak_is_detected_and_scatter_is_not():
    scatter = [trend_test.judge(*like_renderd(0, seed), 0, allowed()) for seed in range(400)]
    leaks = [trend_test.judge(*like_renderd(allowed(), seed), 0, allowed()) for seed in range(400)]
    # Two-sided 99%: 2 of 400 appear to grow by chance, and 2 leaks appear not to. More than 12 has a probability below 1e-6
    # (Poisson).
    assert sum(v.trend for v in scatter) <= 12 and sum(v.word == "flat" for v in leaks) <= 12
    # With 15 means, 2.3% of runs remain unclear and 2.2% of leaks unproven (of 1000). More than 24 of 400 has a probability below
    # 1e-4.
    assert sum(v.word == "flat" for v in scatter) >= 376 and sum(v.trend for v in leaks) >= 376
    twice = [trend_test.judge(*like_renderd(2 * allowed(), seed), 0, allowed()) for seed in range(100)]
    assert sum(v.word == "grows" for v in twice) >= 90         # 98 expected


def test_a_single_peak_is_not_growth():
    times, values = series(0, 1, 5)
    values[-20:] = [value + 50 for value in values[-20:]]
    assert not trend_test.judge(times, values, 0, 1).trend


def test_a_leak_within_noise_is_detected():
    noise = [trend_test.judge(*series(0, 3, seed), 0.04, 0).word for seed in range(100)]
    leaks = [trend_test.judge(*series(0.02, 3, seed), 0.04, 0) for seed in range(100)]    # 8 in total, of which 4 are permitted
    # 99% and 98.5% of 200. Fewer than 93 has a probability below 1e-3.
    assert noise.count("flat") >= 93 and [leak.word for leak in leaks].count("grows") >= 93


def test_too_short_a_measurement_is_inconclusive():
    assert trend_test.judge(*series(0, 30, 2, 40), 0.02, 0).word == "unclear"


def test_confidence_interval_has_its_nominal_coverage():
    held = sum((v := trend_test.judge(*series(0.01, 5, seed), 0.02, 0)).low <= 0.01 * 399 <= v.high for seed in range(1000))
    assert held >= 975    # 990 expected; fewer has a probability below 1e-4


def test_a_constant_does_not_grow():
    verdict = trend_test.judge([float(t) for t in range(100)], [30.0] * 100, 0, 2)
    assert (verdict.low, verdict.growth, verdict.high, verdict.word) == (0, 0, 0, "flat")


def test_too_few_samples_are_refused():
    with pytest.raises(ValueError):
        trend_test.judge([1.0] * 19, [1.0] * 19, 0.02, 0)


def test_grpc_executor_threads_are_counted_separately():
    ours = ["diaphane-render"] * 18 + ["event_engine", "timer_manager", "grpcpp_sync_ser"]
    assert soak.threads_of(ours + ["default-executo"] * 3 + ["resolver-execut"]) == {"threads": 21, soak.EXECUTOR: 4}
    assert soak.executor_bound() == 4 * os.sysconf("SC_NPROCESSORS_CONF")
