"""Every hostile upload of tests/hostile through a real ingestd whose children have 1 GB and 10 s."""

from __future__ import annotations

import sys

from .. import paths
from ..bench import Result, result
from ..bench_stack import running
from ..says import say

ABOUT = "hostile uploads: each with its expected and its real end, the seconds and the memory of its child"


def measure(quick: bool) -> list[Result]:
    sys.path.insert(0, str(paths.REPO / "tests"))
    from harness import TestStack
    from hostile import run

    with running(engine="cpu", **run.LIMITS) as stack:
        found = run.outcomes(TestStack(stack), timeout=600)
    say(run.table(found))
    return [result("hostile uploads", [len(found)], "uploads"),
            result("not refused, or not as they should be", [sum(bool(o.fault) for o in found)], "uploads", at_most=0),
            result("the slowest child", [max(o.seconds for o in found)], "s", at_most=run.SECONDS),
            result("the largest child (resident)", [max(o.peak_mb for o in found)], "MB", at_most=run.MEMORY_MB)]
