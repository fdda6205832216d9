"""The table of stiff and extreme cases, with `diaphane-renderd-bench stability` on each available engine."""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..console import CliError, say

ABOUT = "extreme cases compared with analytic values: largest deviation and verdict (--engine cpu|cuda)"
PROGRAMS = ("diaphane-renderd-bench",)
NO_DEVICE = 69


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--engine", choices=("cpu", "cuda"), help="rendering engine (default: the CPU, and CUDA if a device is available)")
    parser.add_argument("--only", default="", metavar="WORDS", help="only cases whose name contains this text")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "stability", help="output directory for CSV and JSON (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    options.out.mkdir(parents=True, exist_ok=True)
    results = []
    for engine in [options.engine] if options.engine else ["cpu", "cuda"]:
        stem = options.out / f"stability-{engine}"
        done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-renderd-bench"), "stability", "--engine", engine,
                               *(["--quick"] if quick else []), "--only", options.only,
                               "--json", f"{stem}.json", "--csv", f"{stem}.csv"], stdout=None, stderr=subprocess.PIPE, text=True)
        if done.returncode == NO_DEVICE and engine == "cuda":
            if options.engine:
                raise CliError("no CUDA device is available", NO_DEVICE)
            continue
        if done.returncode not in (0, 1):
            raise CliError(f"diaphane-renderd-bench exited with {done.returncode}: {done.stderr.strip()}")
        rows = json.loads(Path(f"{stem}.json").read_text(encoding="utf-8"))["rows"]
        wrong = [row["case"] for row in rows if not row["passed"]]
        results += [result(f"{engine}: cases", [len(rows)], ""), result(f"{engine}: failed", [len(wrong)], "", at_most=0),
                    result(f"{engine}: non-finite values", [sum(row["non_finite"] for row in rows)], "", at_most=0)]
    say(f"Tables: {options.out}")
    return results
