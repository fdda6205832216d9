"""Sends every hostile upload of tests/hostile through a real ingestd whose children have 1 GB and 10 s."""

from __future__ import annotations

import sys

from .. import paths
from ..bench import Result, result
from ..bench_stack import running
from ..console import say

ABOUT = "hostile uploads: expected and actual result, time and memory of each child process"


def measure(quick: bool) -> list[Result]:
    sys.path.insert(0, str(paths.REPO / "tests"))
    from harness import TestStack
    from hostile import run

    with running(engine="cpu", **run.LIMITS) as stack:
        found = run.outcomes(TestStack(stack), timeout=600)
    say(run.table(found))
    return [result("hostile uploads", [len(found)], "uploads"),
            result("not refused as expected", [sum(bool(o.fault) for o in found)], "uploads", at_most=0),
            result("slowest child", [max(o.seconds for o in found)], "s", at_most=run.SECONDS),
            result("largest child, resident memory", [max(o.peak_mb for o in found)], "MB", at_most=run.MEMORY_MB)]
