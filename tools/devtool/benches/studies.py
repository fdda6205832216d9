"""Analyses simulated crowds whose answer is known (studies/diaphane_studies/simulate.py)."""

from __future__ import annotations

import concurrent.futures
import functools
import multiprocessing
import os
from collections import Counter
from typing import Callable

from .. import study
from ..bench import Result

ABOUT = "analysis of simulated studies: coverage of intervals, planted viewpoints that are found, and claims made of noise"
CROWDS, QUICK = 1000, 40
#: Probability that the bench misses a target of coverage by chance. Each interval gets its part of it.
SIGNIFICANCE = 0.01
WANTED = 95.0
PROGRAMS = None    # needs none


def measure(quick: bool) -> list[Result]:
    os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1"))    # one crowd per process at a time
    study.use_libraries()
    from diaphane_studies import simulate, trials

    crowds = QUICK if quick else CROWDS
    # Forked processes would inherit the threads of BLAS.
    with concurrent.futures.ProcessPoolExecutor(min(2, os.cpu_count() or 1), multiprocessing.get_context("spawn"), initializer=study.use_libraries) as pool:
        run = functools.partial(_count, pool, crowds)
        results = [*_coverage("Table 1", run(trials.comfort_trial), crowds), *_coverage("validation", run(trials.validation_trial), crowds, exact=True),
                   *_coverage("latency", run(trials.latency_trial), crowds)]
        results += _shares(run(trials.no_effect_trial), crowds, "no effect: ")
        results += _shares(run(trials.viewpoints_trial), crowds, "planted clusters: ")
        for kind in simulate.NOISE:
            results += _shares(run(functools.partial(trials.noise_trial, kind)), crowds, "noise without a claim: ")
    return results


def _count(pool: concurrent.futures.Executor, crowds: int, trial: Callable[[int], dict[str, bool]]) -> Counter[str]:
    held: Counter[str] = Counter()
    for outcome in pool.map(trial, range(crowds), chunksize=5):
        held.update({name: int(right) for name, right in outcome.items()})
    return held


def _coverage(what: str, held: Counter[str], crowds: int, exact: bool = False) -> list[Result]:
    """Returns the coverage of each interval, and the smallest p-value of the binomial tests, times their number."""
    from diaphane_studies import trials

    smallest = min(1.0, len(held) * min(trials.coverage_p_value(count, crowds, exact) for count in held.values()))
    return [*(Result(f"{what}: coverage, {name}", 100 * count / crowds, "%", runs=crowds) for name, count in held.items()),
            Result(f"{what}: binomial test of the coverage, corrected p-value", round(smallest, 4), "", 0, SIGNIFICANCE, smallest >= SIGNIFICANCE, crowds)]


def _shares(held: Counter[str], crowds: int, before: str) -> list[Result]:
    return [Result(before + name, 100 * count / crowds, "%", 0, WANTED, 100 * count / crowds >= WANTED, crowds) for name, count in held.items()]
