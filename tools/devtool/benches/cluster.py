"""The operator and placement at their design size, with a real control plane, kwok's nodes and renderd's own heartbeat scripts.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from pathlib import Path

from .. import kubernetes, paths
from ..bench import Result
from ..console import CliError, say
from . import cluster_plan

ABOUT = "1,000 nodes with 8 GPUs each (kwok): fill, idle, restart, cold start, and 45 placements per second (--part place|fill|listed|cold|plan, --nodes)"
PROGRAMS = ("diaphane-operator", "diaphane-operator-bench")
PARTS = ("place", "fill", "listed", "cold", "plan")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--part", choices=PARTS, help="run only this part (default: all parts in turn; fill takes the longest)")
    parser.add_argument("--nodes", type=int, help="number of nodes with 8 GPUs each (default: 1000, with --quick: 20)")
    parser.add_argument("--rate", type=float, default=45, help="new sessions per second (default: 45)")
    parser.add_argument("--seconds", type=float, help="seconds of placing sessions (default: 60, with --quick: 10)")
    parser.add_argument("--most", type=float, default=600, help="maximum seconds of filling, after which the bench continues with the workers it has (default: 600)")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "cluster", help="output directory for JSON and CSV (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    options.out.mkdir(parents=True, exist_ok=True)
    parts = (options.part,) if options.part else PARTS
    if set(parts) & {"fill", "listed", "cold"} and (missing := kubernetes.missing()):
        raise CliError(f"not built: {', '.join(missing)}. Run ./diaphane test cluster to build them")
    sys.path[:0] = [str(paths.REPO / "tests" / "cluster")]
    nodes = options.nodes or (20 if quick else 1000)
    results = []
    for part in parts:
        results += _PARTS[part](quick, options, nodes)
    return results


def _write(options: argparse.Namespace, part: str, found: dict) -> None:
    (options.out / f"{part}.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    with open(options.out / f"{part}.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("what", "value"), *((key, value) for key, value in found.items() if isinstance(value, (int, float)))])
    say(f"Tables: {options.out}")


def _place(quick: bool, options: argparse.Namespace, nodes: int) -> list[Result]:
    from scale_run import place

    found = place(nodes * 8, options.rate, options.seconds or (10 if quick else 60))
    _write(options, "place", found)
    return placed(found)


def placed(found: dict) -> list[Result]:
    over = found["over_committed"]
    return [Result(f"placed among {found['workers']} warm workers, p50", found["p50_ms"], "ms", 0, 20, found["p50_ms"] <= 20),
            Result("placed, p99", found["p99_ms"], "ms", 0, 376, found["p99_ms"] <= 376),
            Result("workers with more sessions than slots", over, "", 0, 0, over == 0),
            Result("refused despite free slots", found["refused"], "", 0, 0, found["refused"] == 0),
            Result("sessions per worker, coefficient of variation", 100 * found["spread"], "%", 0, 10, found["spread"] <= 0.1),
            Result("one round of all heartbeats", found["beats_s"], "s"),
            Result("operator's read of Redis, p50", found["look_p50_ms"], "ms")]


def _fill(quick: bool, options: argparse.Namespace, nodes: int) -> list[Result]:
    from scale_run import fill

    found = fill(nodes, options.most, 15 if quick else 60)
    _write(options, "fill", found)
    return filled(found)


def filled(found: dict) -> list[Result]:
    over, idle = found["over_committed_nodes"], 100 * found["idle_cpu_share"]
    return [Result(f"workers ready of {found['wanted']}", found["ready"], "", 0, found["wanted"], found["ready"] == found["wanted"]),
            Result("time to fill", found["fill_s"], "s"),
            Result("time from filled to idle", found["settled_s"], "s"),
            Result("nodes with more workers than GPUs", over, "", 0, 0, over == 0),
            Result("operator memory, idle", found["rss_idle_mb"], "MB", 0, 200, found["rss_idle_mb"] <= 200),
            Result("operator CPU, idle", idle, "%", 0, 20, idle <= 20),
            Result("after a restart: all listed", found["listed_s"], "s"),
            Result("after a restart: first action", found["acting_s"], "s", 0, 10, found["acting_s"] <= 10)]


def _listed(quick: bool, options: argparse.Namespace, nodes: int) -> list[Result]:
    from scale_run import listed

    # As many sessions as the limit allows, 10,000, on as many nodes as they need.
    found = listed(8 * options.nodes if options.nodes else 160 if quick else 10_000)
    _write(options, "listed", found)
    return restarted(found)


def restarted(found: dict) -> list[Result]:
    over = found["over_committed_nodes"]
    return [Result(f"{found['workers']} existing workers, new operator: all listed", found["listed_s"], "s"),
            Result("first missing pod created", found["acting_s"], "s", 0, 10, found["acting_s"] <= 10),
            Result("pods created in the next 20 s", found["pods_after_20_s"], ""),
            Result("operator memory", found["memory_mb"], "MB", 0, 200, found["memory_mb"] <= 200),
            Result("nodes with more workers than GPUs", over, "", 0, 0, over == 0)]


def _cold(quick: bool, options: argparse.Namespace, nodes: int) -> list[Result]:
    from scale_run import cold

    found = cold(4 if quick else 30)
    _write(options, "cold", found)
    over = found["over_committed_nodes"]
    return [Result("no free slot: placed on a new worker, p50", found["p50_s"], "s"), Result("no free slot: placed on a new worker, p99", found["p99_s"], "s"),
            Result("nodes with more workers than GPUs", over, "", 0, 0, over == 0)]


def _plan(quick: bool, options: argparse.Namespace, nodes: int) -> list[Result]:
    return cluster_plan.measure(quick, argparse.Namespace(sessions=None, devices=None, seconds=None, seed=1, out=options.out))


_PARTS = {"place": _place, "fill": _fill, "listed": _listed, "cold": _cold, "plan": _plan}
