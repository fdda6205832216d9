"""Simulates where the operator would place a large fleet's workers and sessions, with the plan that it runs."""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

from .. import paths
from ..bench import Result
from ..console import CliError, say

ABOUT = "the operator's plan on 8,000 simulated devices: time lost to imbalance, moves, refusals and plan time (--sessions, --devices)"
PROGRAMS = ("diaphane-operator-bench",)
OURS = "load"
LENDING = "load-and-lending"


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--sessions", type=int, help="number of sessions (default: 100,000, with --quick: 1,000)")
    parser.add_argument("--devices", type=int, help="number of GPUs, eight per node (default: 8,000, with --quick: 80)")
    parser.add_argument("--seconds", type=int, help="simulated seconds after the ramp (default: 300, with --quick: 60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "cluster-plan", help="output directory for JSON and CSV (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    options.out.mkdir(parents=True, exist_ok=True)
    stem = options.out / "cluster-plan"
    sessions, devices, seconds = (1_000, 80, 60) if quick else (100_000, 8_000, 300)
    command = [str(paths.build_dir() / "bin" / "diaphane-operator-bench"), "--sessions", str(options.sessions or sessions),
               "--devices", str(options.devices or devices), "--seconds", str(options.seconds or seconds),
               "--seed", str(options.seed), "--json", f"{stem}.json", "--csv", f"{stem}.csv"]
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if done.returncode != 0:
        raise CliError(f"diaphane-operator-bench exited with {done.returncode}: {done.stderr.strip()}")
    say(done.stdout)
    say(f"Tables: {options.out}")
    return results_of(json.loads(Path(f"{stem}.json").read_text(encoding="utf-8")))


def results_of(report: dict) -> list[Result]:
    rows = {row["way"]: row for row in report["rows"]}
    results = []
    for way, row in rows.items():
        results += [Result(f"{way}: lost to imbalance", 100 * row["lost"], "%"),
                    Result(f"{way}: load, coefficient of variation", 100 * row["spread"], "%"),
                    Result(f"{way}: load, by node", 100 * row["spread_by_node"], "%"),
                    Result(f"{way}: mean load of sessions, coefficient of variation", 100 * row["spread_of_stays"], "%"),
                    Result(f"{way}: mean load of sessions, by node", 100 * row["spread_of_stays_by_node"], "%"),
                    Result(f"{way}: refused", 100 * row["refused"], "%"),
                    Result(f"{way}: sessions placed again", row["moves"], ""),
                    Result(f"{way}: nodes with more workers than GPUs", row["over"], "", 0, 0, row["over"] == 0)]
    results.append(Result(f"{LENDING}: device time lent", 100 * rows[LENDING]["lent"], "%"))
    ours = rows[OURS]
    results.append(Result("plan, p50", ours["plan_p50_ms"], "ms", 0, 50, ours["plan_p50_ms"] <= 50))
    results.append(Result("plan, p99", ours["plan_p99_ms"], "ms"))
    return results
