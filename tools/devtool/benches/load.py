"""Many viewers of the real gateway and a real renderd: the time from an input to the first frame that shows it, and its parts."""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from .. import paths
from ..bench import Result, result
from ..bench_volumes import cranium
from ..console import CliError, say

ABOUT = "many concurrent viewers, some of whom drag: input to frame (p50, p95, p99) and where the time goes (--sessions, --moving, --find)"
PROGRAMS = ("diaphane-load", "diaphane-renderd", "diaphane-gateway")
# The load for a machine without a GPU: two cores trace a viewport of this size in some
# milliseconds.
CPU_SESSIONS, CPU_SIZE = 8, "160x90"


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--sessions", type=int, help=f"number of concurrent sessions (default: 200 on CUDA, {CPU_SESSIONS} on the CPU)")
    parser.add_argument("--moving", type=int, default=0, help="number of users who move the camera at any moment (default: the share of 32 in 200)")
    parser.add_argument("--seconds", type=float, default=10, help="measured seconds per run")
    parser.add_argument("--repeats", type=int, default=3, help="number of runs")
    parser.add_argument("--size", help=f"size of the pictures (default: 1280x720 on CUDA, {CPU_SIZE} on the CPU)")
    parser.add_argument("--engine", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("--codec", choices=("jpeg", "h264", "mpeg1"), default="jpeg", help="codec that the viewers prefer")
    parser.add_argument("--preset", default="bone", help="preset of the pictures")
    parser.add_argument("--recording", type=Path, metavar="FILE", help="recorded interaction that the users play, of the scan in --volume (default: they turn the scan)")
    parser.add_argument("--find", action="store_true", help="also find the maximum number of sessions with a p95 of at most 100 ms")
    parser.add_argument("--volume", help="directory of a stored volume (default: the sample scan)")
    parser.add_argument("--log-dir", type=Path, help="directory in which to keep the logs of the programs")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    on_cpu = options.engine == "cpu"
    volume = options.volume or cranium()
    if not volume:
        raise CliError("the sample scan is missing: install the Debian package invesalius-examples, or give --volume")
    program = paths.build_dir() / "bin" / "diaphane-load"
    with tempfile.NamedTemporaryFile(suffix=".json") as report:
        words = ["--bin-dir", program.parent, "--volume", volume, "--engine", options.engine, "--codec", options.codec,
                 "--sessions", options.sessions or (2 if quick else CPU_SESSIONS if on_cpu else 200), "--moving", options.moving,
                 "--size", options.size or ("" if options.recording else CPU_SIZE if on_cpu else "1280x720"), "--preset", options.preset,
                 "--recording", options.recording or "",
                 "--seconds", 2 if quick else options.seconds, "--warm-up", 1 if quick else 4,
                 "--repeats", 1 if quick else options.repeats, "--json", report.name, *(["--find"] if options.find else []),
                 *(["--log-dir", options.log_dir] if options.log_dir else [])]
        done = subprocess.run([str(program), "bench", *map(str, words)], check=False)
        if done.returncode != 0:
            raise CliError(f"diaphane-load exited with {done.returncode}")
        written = json.loads(Path(report.name).read_text(encoding="utf-8"))
    say("")
    return results_of(written, options.repeats, 100 if not on_cpu else None)


def results_of(report: dict, repeats: int, bound: float | None) -> list[Result]:
    """Returns the results of the requested runs, followed by those of a search."""
    runs = report["runs"][:repeats]
    name = f"{runs[0]['sessions']} sessions, {runs[0]['moving']} moving, {runs[0]['width']} x {runs[0]['height']}"

    def each(*keys: str) -> list[float]:
        values = []
        for run in runs:
            for key in keys:
                run = run[key]
            values.append(run)
        return values

    results = [result(f"{name}: input to frame, {p}", each("input_to_frame_ms", p), "ms", bound if p == "p95" else None)
               for p in ("p50", "p95", "p99")]
    results += [result(f"{name}: {words}", each("mean_ms", key), "ms") for key, words in (
        ("from_oldest_input", "frame latency from its oldest input, mean"), ("render", "of which rendering"),
        ("encode", "of which encoding"), ("wait_in_renderd", "of which waiting in renderd"), ("send", "of which transport"))]
    results += [result(f"{name}: frame rate of a moving session", each("moving_frames_per_second"), "1/s"),
                result(f"{name}: bytes per frame", each("moving_frame_bytes"), "bytes"),
                result(f"{name}: traffic to all viewers", each("megabytes_per_second"), "MB/s"),
                result(f"{name}: device busy", each("device", "busy"), "of the time")]
    results += [result(f"{name}: {part}, all lanes together", each("device", part), "of the time")
                for part in ("rendering", "scenes", "pictures")]
    results += [result(f"{name}: CPU, {program}", each("cores", program), "cores")
                for program in ("renderd", "gateway", "redis", "viewers")]
    if "largest_held" in report:
        results.append(result("maximum sessions with p95 up to 100 ms", [report["largest_held"]], "sessions"))
    return results
