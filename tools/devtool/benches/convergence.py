"""Error against run time with `diaphane-renderd-bench convergence`: true error, estimated error and time, as tables and plots."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..bench_volumes import volume_for
from ..console import CliError, say

ABOUT = "true and estimated error against run time, per estimator (--scene FILE --engine cpu|cuda --devices K)"
PROGRAMS = ("diaphane-renderd-bench",)
NO_DEVICE = 69
SCENES = paths.REPO / "tests" / "scenes"

# Two cores trace some million samples per second, and a GPU some billion.
SIZES = {"cpu": ("64x64", 256), "cuda": ("512x512", 1024)}


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", type=Path, action="append", metavar="FILE", help="scene file (repeatable; default: all scenes)")
    parser.add_argument("--engine", choices=("cpu", "cuda"), help="rendering engine (default: the CPU, and CUDA if a device is available)")
    parser.add_argument("--devices", type=int, default=1, metavar="K", help="render on K devices (on the CPU: K engines that share the threads)")
    parser.add_argument("--volume", help="directory of the volume store, or made:N (default: a volume that suits the scene)")
    parser.add_argument("--size", metavar="WxH")
    parser.add_argument("--most", type=int, metavar="N", help="samples of the last measured point, a power of two")
    parser.add_argument("--repeats", type=int)
    parser.add_argument("--walk", default="auto,tracking", help="auto, exact, tracking; comma-separated")
    parser.add_argument("--points", default="low-discrepancy,independent")
    parser.add_argument("--mis", default="both", help="both, light, scatter; comma-separated")
    parser.add_argument("--reference-seconds", type=float, help="maximum seconds for the reference of each scene")
    parser.add_argument("--no-plots", action="store_true")
    parser.add_argument("--plots-of", type=Path, metavar="FILE", help="measure nothing, and only draw the plots of a convergence-*.json")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "convergence", help="output directory for CSV, JSON and SVG (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    options.out.mkdir(parents=True, exist_ok=True)
    if options.plots_of:
        reports = json.loads(options.plots_of.read_text(encoding="utf-8"))
        for report in reports:
            _draw(report, options)
        return [figure for report in reports for figure in results_of(report)]
    scenes = options.scene or sorted(SCENES.glob("*.json"))
    results = []
    for engine in [options.engine] if options.engine else ["cpu", "cuda"]:
        reports = []
        for scene in scenes:
            report = _converge(scene, engine, quick, options)
            if report is None:
                if options.engine:
                    raise CliError("no CUDA device is available", NO_DEVICE)
                break
            reports.append(report)
            if not options.no_plots:
                _draw(report, options)
            results += results_of(report)
        if reports:
            (options.out / f"convergence-{engine}.json").write_text(json.dumps(reports, indent=1) + "\n", encoding="utf-8")
            (options.out / f"convergence-{engine}.csv").write_text(csv_of(reports), encoding="utf-8")
    say(f"Tables and plots: {options.out}")
    return results


def _draw(report: dict, options: argparse.Namespace) -> None:
    devices = report.get("devices", 1)
    stem = f"{report['scene']}-{report['engine']}" + (f"-{devices}" if devices > 1 else "")
    (options.out / f"{stem}.svg").write_text(plot_of(report), encoding="utf-8")


def _converge(scene: Path, engine: str, quick: bool, options: argparse.Namespace) -> dict | None:
    size, most = SIZES[engine]
    report = options.out / "report.json"
    cache = paths.REPO / "build" / "references"
    command = [str(paths.build_dir() / "bin" / "diaphane-renderd-bench"), "convergence", "--engine", engine,
               "--scene", str(scene), "--volume", options.volume or volume_for(scene),
               "--size", options.size or ("32x32" if quick else size), "--most", str(options.most or (64 if quick else most)),
               "--repeats", str(options.repeats or (3 if quick else 5)), "--walk", options.walk, "--points", options.points,
               "--mis", options.mis, "--cache", str(cache), "--json", str(report),
               "--reference-seconds", str(options.reference_seconds or (10 if quick else 90))]
    if options.devices > 1:
        command += ["--devices", str(options.devices)]
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if done.returncode == NO_DEVICE and engine == "cuda":
        return None
    if done.returncode != 0:
        raise CliError(f"{scene.name}: diaphane-renderd-bench exited with {done.returncode}: {done.stderr.strip()}")
    say(done.stdout)
    written = json.loads(report.read_text(encoding="utf-8"))
    os.unlink(report)
    return written


def results_of(report: dict) -> list[Result]:
    """Returns the time to the target, the slope, and the ratio of the estimate to the true error
    above 64 samples."""
    results = []
    for curve in _curves(report):
        name = f"{report['scene']}, {report['engine']}, {curve['name']}"
        if curve["to_target"]:
            how = "" if curve["to_target"]["how"] == "between" else f" ({curve['to_target']['how']})"
            results.append(result(f"{name}: to RMSE {report['target']:g}{how}", [curve["to_target"]["milliseconds"]], "ms"))
        if curve["slope"] is not None:
            if curve["points"] == "independent":
                results.append(result(f"{name}: slope, distance from -0.5", [abs(curve["slope"] + 0.5)], "", at_most=0.03))
            else:
                results.append(result(f"{name}: slope", [curve["slope"]], "", at_most=-0.47))
        ratios = [p["ratio"] for p in curve["curve"] if p["samples"] >= 64 and p["ratio"] is not None]
        if ratios:
            results.append(result(f"{name}: estimate, deviation from the truth", [max(abs(r - 1) for r in ratios)], "", at_most=0.1))
        bad = sum(p["dropped"] + p["non_finite"] for p in curve["curve"])
        if bad:
            results.append(result(f"{name}: non-finite samples", [bad], "", at_most=0))
    return results


def _curves(report: dict) -> list[dict]:
    return [curve for curve in report["curves"] if "left_out" not in curve]


def csv_of(reports: list[dict]) -> str:
    columns = ("samples", "milliseconds", "milliseconds_spread", "rmse", "rmse_spread", "estimate", "ratio", "dropped",
               "non_finite")
    lines = [",".join(("scene", "engine", "width", "height", "walk", "points", "mis", *columns))]
    for report in reports:
        for curve in _curves(report):
            head = (report["scene"], report["engine"], report["width"], report["height"], curve["walk"], curve["points"],
                    curve["mis"])
            lines += [",".join("" if v is None else f"{v:.6g}" if isinstance(v, float) else str(v)
                               for v in (*head, *(point[column] for column in columns))) for point in curve["curve"]]
    return "\n".join(lines) + "\n"


def plot_of(report: dict) -> str:
    from .support import plot

    title = f"{report['scene']} on {report['volume']}, {report['width']} x {report['height']}, {report['device']}"
    panels, legend = [], []
    for axis, words in (("samples", "samples a pixel"), ("milliseconds", "milliseconds")):
        lines = []
        for number, curve in enumerate(_curves(report)):
            lines += [plot.Line(curve["name"], [(p[axis], p["rmse"]) for p in curve["curve"]], number),
                      plot.Line(curve["name"], [(p[axis], p["estimate"]) for p in curve["curve"]], number, True, False)]
        panels.append(plot.Panel(f"error against {axis}", words, "relative RMSE", lines, report["target"]))
    for number, curve in enumerate(_curves(report)):
        slope = "" if curve["slope"] is None else f"; slope {curve['slope']:.2f}"
        to = curve["to_target"]
        reached = "" if not to else f"; {report['target']:g} in {to['milliseconds']:.3g} ms"
        legend.append((f"{curve['name']}{slope}{reached}", number, False))
    legend.append(("dashed, in the same colour: the error as the renderer estimates it itself", 5, True))
    return plot.svg(title, panels, legend)
