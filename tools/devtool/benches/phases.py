"""How fast the phases of a scan play, with `diaphane-renderd-bench phases` on each available engine."""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..console import CliError, say

ABOUT = "how fast a beating heart of 20 phases at 256^3 plays (--engine cpu|cuda)"
PROGRAMS = ("diaphane-renderd-bench",)
NO_DEVICE = 69

# Voxels along an edge, phases, picture size and seconds. Two cores show half of a picture of 1280 x 720 while it moves.
PLANS = {"cpu": ("256", "20", "640x360", "20"), "cuda": ("256", "20", "1920x1080", "20")}
QUICK = ("32", "4", "64x36", "0.2")
LEAST = {"cpu": 5, "cuda": 25}      # phases per second


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--engine", choices=("cpu", "cuda"), help="rendering engine (default: the CPU, and CUDA if a device is available)")
    parser.add_argument("--cube", help="edge length of the volume in voxels")
    parser.add_argument("--phases", help="number of phases")
    parser.add_argument("--size", help="picture size WxH")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "phases", help="output directory for JSON (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    options.out.mkdir(parents=True, exist_ok=True)
    results = []
    for engine in [options.engine] if options.engine else ["cpu", "cuda"]:
        report = _play(engine, quick, options)
        if report is None:
            if options.engine:
                raise CliError("no CUDA device is available", NO_DEVICE)
            continue
        results += results_of(report, quick)
    say(f"Reports: {options.out}")
    return results


def _play(engine: str, quick: bool, options: argparse.Namespace) -> dict | None:
    cube, phases, size, seconds = QUICK if quick else PLANS[engine]
    path = options.out / f"phases-{engine}.json"
    done = subprocess.run(
        [str(paths.build_dir() / "bin" / "diaphane-renderd-bench"), "phases", "--engine", engine, "--cube", options.cube or cube,
         "--phases", options.phases or phases, "--size", options.size or size, "--seconds", seconds, "--json", str(path)],
        stdout=None, stderr=subprocess.PIPE, text=True)
    if done.returncode == NO_DEVICE and engine == "cuda":
        return None
    if done.returncode != 0:
        raise CliError(f"diaphane-renderd-bench exited with {done.returncode}: {done.stderr.strip()}")
    return json.loads(path.read_text(encoding="utf-8"))


def results_of(report: dict, quick: bool) -> list[Result]:
    """Returns the phases per second, which have a limit only at full size, and the time to prepare a phase."""
    engine = report["engine"]
    what = f"{engine}, {report['phases']} phases of {report['cube']}^3 at {report['width']} x {report['height']}"
    least = {} if quick else {"at_least": LEAST[engine]}
    return [result(f"{what}: phases per second", [report["per_second"]], "/s", **least),
            result(f"{what}: preparing a phase again", [report["prepare_ms"]], "ms")]
