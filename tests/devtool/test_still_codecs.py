"""The results that `./diaphane bench still-codecs` reads from Google Benchmark."""

from __future__ import annotations

from devtool.benches.still_codecs import results_of


def aggregate(name: str, kind: str, milliseconds: float) -> dict:
    return {"run_name": f"{name}/iterations:1/repeats:5", "aggregate_name": kind, "repetitions": 5, "cpu_time": milliseconds, "bytes": 3390.0}


def test_a_row_has_its_bytes_and_the_median_with_its_spread():
    size, time = results_of([aggregate("png-1", "mean", 9), aggregate("png-1", "median", 2), aggregate("png-1", "stddev", 0.5)])
    assert (size.name, size.value) == ("png-1: bytes", 3390)
    assert (time.name, time.value, time.spread, time.runs) == ("png-1: time", 2, 0.5, 5)
