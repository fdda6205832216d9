"""Every attack of tests/integration/edge_attacks.py on every route in every role, at a running edge with the real API behind it."""

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
from ..says import say

ABOUT = "the edge's attacks by route and role: sent, refused, answered, misses; an ordinary client meanwhile (--routes, --roles, --each)"
PROGRAMS = ("diaphane-api", "diaphane-gateway")
PAGE = True


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--routes", help="operations, groups of them or pages, with commas (default: all)")
    parser.add_argument("--roles", help="with commas (default: all)")
    parser.add_argument("--each", type=int, help="attacks at a route and role, others at the next (default: all of the list)")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "edge-attacks", help="CSV and JSON go there")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    sys.path[:0] = [str(paths.REPO / "tests"), str(paths.REPO / "tests" / "integration")]
    from api_client import person
    from attack_plan import ROLES, Cell, Tally, all_of_them, cells, printed, routes, some_of, table
    from attack_run import run
    from edge_help import Undisturbed
    from harness import TestStack
    from who_may_world import known_hash

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
        stored = known_hash(stack)
        # A group at a time: what may not change is compared before and after it.
        for group in dict.fromkeys(one.group for one in chosen):
            here = cells([one for one in chosen if one.group == group], roles)
            found = run(stack, stored, here, choice, 3 if quick else 12, anew=not quick)
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
            result("misses", [len(misses)], "", at_most=0), result("faults of programs or of the ordinary client", [len(faults)], "", at_most=0),
            result("the ordinary client's answers", [3 * len(watched.ordinary.seconds)], ""),
            result("the ordinary client, p99", [watched.ordinary.p99() * 1000], "ms", at_most=500),
            result("api grew by", [getattr(watched, "grown_mb", float("nan"))], "MB", at_most=100),
            result("attacks a second", [sent / (time.monotonic() - begun)], "1/s")]
