"""The cost of a lossless picture and of a frame: `diaphane-still-bench` on pictures of the cranium as it converges."""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from .. import paths
from ..bench import Result
from ..bench_volumes import cranium, volume_for
from ..console import CliError

ABOUT = "lossless tiles (PNG, WebP, the thesis's differences) and frames: bytes and time on real pictures"
PROGRAMS = ("diaphane-render", "diaphane-still-bench")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--size", help="size of the pictures (default: 1280x720)")
    parser.add_argument("--preset", default="bone", help="preset: skin, muscle, vessels, bone or airways")
    parser.add_argument("--samples", help="samples of the pictures, comma-separated, the last for the finished one (default: 1,4,16,64)")
    parser.add_argument("--pictures", nargs="+", type=Path, metavar="PPM", help="use these pictures instead of rendering new ones")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    with tempfile.TemporaryDirectory() as folder:
        pictures = options.pictures or _render(Path(folder), quick, options)
        said = _run("diaphane-still-bench", *map(str, pictures))
    return results_of(json.loads(said)["benchmarks"])


def results_of(rows: list[dict]) -> list[Result]:
    """Returns the results. `rows` contains Google Benchmark's aggregates of each codec."""
    results = []
    spread = {row["run_name"]: row["cpu_time"] for row in rows if row["aggregate_name"] == "stddev"}
    for row in rows:
        if row["aggregate_name"] == "median":
            name = row["run_name"].partition("/")[0]
            results.append(Result(f"{name}: bytes", row["bytes"], ""))
            results.append(Result(f"{name}: time", row["cpu_time"], "ms", spread[row["run_name"]], runs=row["repetitions"]))
    return results


def _render(folder: Path, quick: bool, options: argparse.Namespace) -> list[Path]:
    scan = cranium() or volume_for(Path())
    if not Path(scan).exists():
        raise CliError("the sample scan is missing: install the Debian package invesalius-examples, or give --pictures")
    pictures = []
    for samples in (options.samples or ("1,4" if quick else "1,4,16,64")).split(","):
        pictures.append(folder / f"{samples}.ppm")
        _run("diaphane-render", scan, "--preset", options.preset, "--estimator", "exact", "--quiet", "--samples", samples,
             "--size", options.size or ("320x180" if quick else "1280x720"), "--out", str(pictures[-1]))
    return pictures


def _run(program: str, *arguments: str) -> str:
    done = subprocess.run([str(paths.build_dir() / "bin" / program), *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise CliError(f"{program} exited with {done.returncode}: {done.stderr.strip()}")
    return done.stdout
