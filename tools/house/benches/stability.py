"""The table of stiff and extreme cases, by `diaphane-renderd-bench stability`, on each engine that there is."""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..says import HouseError, say

ABOUT = "stiff and extreme cases: samples, numbers that are not finite, largest deviation, verdict (--engine cpu|cuda)"
PROGRAMS = ("diaphane-renderd-bench",)
NO_DEVICE = 69


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--engine", choices=("cpu", "cuda"), help="default: the CPU, and CUDA where a device answers")
    parser.add_argument("--only", default="", metavar="WORDS", help="cases whose name holds this")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "stability", help="CSV and JSON go there")


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
                raise HouseError("no CUDA device answers", NO_DEVICE)
            continue
        if done.returncode not in (0, 1):
            raise HouseError(f"diaphane-renderd-bench ended with {done.returncode}: {done.stderr.strip()}")
        rows = json.loads(Path(f"{stem}.json").read_text(encoding="utf-8"))["rows"]
        wrong = [row["case"] for row in rows if not row["passed"]]
        results += [result(f"{engine}: cases", [len(rows)], ""), result(f"{engine}: wrong", [len(wrong)], "", at_most=0),
                    result(f"{engine}: numbers not finite", [sum(row["non_finite"] for row in rows)], "", at_most=0)]
    say(f"Tables: {options.out}")
    return results
