"""Runs every attack of tests/integration/edge_attacks.py on every route in every role against a running edge with the real API.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
import time
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..bench_stack import running
from ..console import say

ABOUT = "attacks on the edge per route and role, and their effect on an ordinary client (--routes, --roles, --each)"
PROGRAMS = ("diaphane-api", "diaphane-gateway")
PAGE = True


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--routes", help="operations, groups of operations, or pages; comma-separated (default: all)")
    parser.add_argument("--roles", help="roles, comma-separated (default: all)")
    parser.add_argument("--each", type=int, help="number of attacks per route and role, in turn (default: the whole list)")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "edge-attacks", help="output directory for CSV and JSON (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    sys.path[:0] = [str(paths.REPO / "tests"), str(paths.REPO / "tests" / "integration")]
    from api_client import person
    from attack_plan import ROLES, Cell, Tally, all_of_them, cells, printed, routes, some_of, table
    from attack_run import run
    from edge_helpers import Undisturbed
    from harness import TestStack

    wanted = options.routes.split(",") if options.routes else None
    roles = tuple(options.roles.split(",")) if options.roles else ROLES
    chosen = [one for one in routes() if wanted is None or one.name in wanted or one.group in wanted]
    choice = some_of(4) if quick else some_of(options.each) if options.each else all_of_them
    tallies: dict[Cell, Tally] = {}
    misses: list[str] = []
    begun = time.monotonic()
    with running(engine="cpu", only=("postgres", "redis", "api", "gateway", "edge")) as started:
        stack = TestStack(started)
        watched = Undisturbed(stack, person(stack))
        # One group at a time, because protected data is compared before and after it.
        for group in dict.fromkeys(one.group for one in chosen):
            here = cells([one for one in chosen if one.group == group], roles)
            found = run(stack, here, choice, 3 if quick else 12, renew=not quick)
            tallies |= found.tallies
            misses += found.misses
            say(f"{group}: {sum(one.sent for one in found.tallies.values())} sent, {len(found.misses)} misses, {time.monotonic() - begun:.0f} s")
        faults = watched.faults()
    rows = table(tallies)
    say(printed(rows))
    for miss in [*misses, *faults]:
        say(f"MISS {miss}")
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "edge-attacks.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    (options.out / "edge-attacks.json").write_text(json.dumps({"rows": rows, "misses": misses, "faults": faults}, indent=1) + "\n", encoding="utf-8")
    say(f"Tables: {options.out}")
    sent = sum(one.sent for one in tallies.values())
    return [result("routes", [len(chosen)], ""), result("attacks sent", [sent], ""),
            result("refused", [sum(one.refused for one in tallies.values())], ""), result("answered", [sum(one.answered for one in tallies.values())], ""),
            result("attacks not handled as expected", [len(misses)], "", at_most=0), result("faults of the programs or the ordinary client", [len(faults)], "", at_most=0),
            result("answers to the ordinary client", [3 * len(watched.ordinary.seconds)], ""),
            result("latency of the ordinary client, p99", [watched.ordinary.p99() * 1000], "ms", at_most=500),
            result("memory growth of api", [getattr(watched, "grown_mb", float("nan"))], "MB", at_most=100),
            result("attacks per second", [sent / (time.monotonic() - begun)], "1/s")]
