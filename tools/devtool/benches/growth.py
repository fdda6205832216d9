"""How the cost grows with the size of the volume and of the picture, with `diaphane-renderd-bench growth` on each available engine."""

from __future__ import annotations

import argparse
import json
import math
import subprocess
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..bench_volumes import cranium
from ..console import CliError, say

ABOUT = "how time and memory grow with volumes up to 1024^3 and pictures up to 3840 x 2160 (--engine cpu|cuda)"
PROGRAMS = ("diaphane-renderd-bench",)
NO_DEVICE = 69

# Voxels along an edge, the volume for all canvases, and the canvases. Larger ones take minutes on two cores.
PLANS = {"cpu": ("64,128,256", "256", "640x360,1280x720,1920x1080"),
         "cuda": ("256,512,1024", "512", "640x360,1280x720,1920x1080,3840x2160")}
QUICK = ("16,32", "32", "32x18,64x36")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--engine", choices=("cpu", "cuda"), help="rendering engine (default: the CPU, and CUDA if a device is available)")
    parser.add_argument("--scene", type=Path, default=paths.REPO / "tests" / "scenes" / "cranium.json", metavar="FILE")
    parser.add_argument("--cubes", help="edge lengths of the synthetic volumes in voxels, comma-separated")
    parser.add_argument("--canvas-cube", help="edge length of the volume that is rendered at every picture size")
    parser.add_argument("--canvases", help="picture sizes WxH, comma-separated")
    parser.add_argument("--size", help="picture size for the synthetic volumes (default: 512x512)")
    parser.add_argument("--walk", default="exact,tracking", help="exact, tracking; comma-separated")
    parser.add_argument("--seconds", type=float, help="approximate seconds per row until the target is reached (default: 2 on CUDA, 30 on the CPU)")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "growth", help="output directory for CSV and JSON (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    options.out.mkdir(parents=True, exist_ok=True)
    results = []
    for engine in [options.engine] if options.engine else ["cpu", "cuda"]:
        report = _grow(engine, quick, options)
        if report is None:
            if options.engine:
                raise CliError("no CUDA device is available", NO_DEVICE)
            continue
        results += results_of(report)
    say(f"Tables: {options.out}")
    return results


def _grow(engine: str, quick: bool, options: argparse.Namespace) -> dict | None:
    cubes, canvas_cube, canvases = QUICK if quick else PLANS[engine]
    stem = options.out / f"growth-{engine}"
    scan = None if quick else cranium()
    done = subprocess.run(
        [str(paths.build_dir() / "bin" / "diaphane-renderd-bench"), "growth", "--engine", engine, "--scene", str(options.scene),
         "--cubes", options.cubes or cubes, "--canvas-cube", options.canvas_cube or canvas_cube,
         "--canvases", options.canvases or canvases, "--size", options.size or ("32x32" if quick else "512x512"),
         "--walk", options.walk, "--repeats", "2" if quick else "5", *(["--volume", scan] if scan else []),
         "--seconds", str(options.seconds or (0.2 if quick else 2 if engine == "cuda" else 30)),
         "--json", f"{stem}.json", "--csv", f"{stem}.csv"], stdout=None, stderr=subprocess.PIPE, text=True)
    if done.returncode == NO_DEVICE and engine == "cuda":
        return None
    if done.returncode != 0:
        raise CliError(f"diaphane-renderd-bench exited with {done.returncode}: {done.stderr.strip()}")
    return json.loads(Path(f"{stem}.json").read_text(encoding="utf-8"))


def results_of(report: dict) -> list[Result]:
    """Returns the exponents with which time and memory grow with the voxels, at one canvas, and
    with the pixels, on one volume."""
    rows = [row for row in report["rows"] if "left_out" not in row]
    results = []
    for walk in dict.fromkeys(row["walk"] for row in rows):
        mine = [row for row in rows if row["walk"] == walk]
        one = (mine[0]["width"], mine[0]["height"])      # the canvas of the cubes comes first
        cubes = [row for row in mine if (row["width"], row["height"]) == one]
        groups = [("voxels", "of the voxel count", cubes, lambda row: math.prod(row["size"]))]
        for volume in dict.fromkeys(row["volume"] for row in mine):
            seen = [row for row in mine if row["volume"] == volume and (row["width"], row["height"]) != one]
            groups.append((volume, "of the pixel count", seen, lambda row: row["width"] * row["height"]))
        for name, of_what, group, size in groups:
            for key, words in (("pass_in_a_row_ms", "time per pass"), ("to_target", "time to the target")):
                power = _power([(size(row), _figure(row, key)) for row in group])
                if power is not None:
                    results.append(result(f"{report['engine']}, {walk}, {name}: {words}, exponent {of_what}", [power], ""))
    return results


def _figure(row: dict, key: str) -> float | None:
    value = row[key]
    return value["milliseconds"] if isinstance(value, dict) else value


def _power(points: list[tuple[float, float | None]]) -> float | None:
    """Returns the least-squares slope of log(y) over log(x), or None with fewer than two different x."""
    logs = [(math.log(x), math.log(y)) for x, y in points if y]
    if len({x for x, _ in logs}) < 2:
        return None
    mean_x, mean_y = (sum(c) / len(logs) for c in zip(*logs))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)
