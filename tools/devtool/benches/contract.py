"""schemathesis on the whole contract against the live server, with every phase and operation, as an administrator."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..bench_stack import running
from ..console import say

ABOUT = "schemathesis against the live server: examples, coverage, fuzzing and stateful phases (--phases, --examples, --only)"
PROGRAMS = ("diaphane-api",)
PAGE = True


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--phases", help="phases, comma-separated (default: all four)")
    parser.add_argument("--examples", type=int, help="examples per operation (default: 30)")
    parser.add_argument("--only", help="only these operations, comma-separated")
    parser.add_argument("--seed", type=int, default=1)


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    sys.path[:0] = [str(paths.REPO / "tests"), str(paths.REPO / "tests" / "integration")]
    import contract_run
    from harness import TestStack

    phases = tuple(options.phases.split(",")) if options.phases else ("examples", "fuzzing") if quick else contract_run.PHASES
    only = tuple(options.only.split(",")) if options.only else ()
    results = []
    with running(engine="cpu", only=("postgres", "redis", "api", "edge")) as started, tempfile.TemporaryDirectory() as folder:
        for phase in phases:
            begun = time.monotonic()
            found = contract_run.run(TestStack(started), Path(folder), (phase,), options.examples or (3 if quick else 30), options.seed, only)
            say(found.output)
            results += [result(f"{phase}: cases", [found.cases], ""), result(f"{phase}: findings", [found.findings], "", at_most=0),
                        result(f"{phase}", [time.monotonic() - begun], "s")]
            if not found.well and not found.findings:
                results.append(result(f"{phase}: did not finish", [1], "", at_most=0))
    return results
