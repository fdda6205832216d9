"""The scheduler's policies on traces of interaction, simulated and with the real renderer."""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

from .. import paths
from ..bench import Result
from ..bench_volumes import cranium
from ..console import CliError, say

ABOUT = "scheduling policies: time to 5% error, input to first frame, fairness (--real, --simulate, --policy, --sessions, --trace)"
PROGRAMS = ("diaphane-renderd-bench",)
NO_DEVICE = 69
SCENES = paths.REPO / "tests" / "scenes"
BASELINE, THESIS, OURS = "round-robin", "error-proportional", "marginal-gain"

# At a sixteenth of a viewport's sides, a sample takes a millisecond on two cores, about as long as a full one on a GPU.
REAL_SIZES = {"cpu": 0.0625, "cuda": 1.0}


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--real", action="store_true", help="run only on the real renderer, in real time")
    parser.add_argument("--simulate", action="store_true", help="run only the simulation (default: both)")
    parser.add_argument("--policy", help=f"{OURS}, {THESIS}, {BASELINE}, free-for-all; comma-separated (default: all)")
    parser.add_argument("--sessions", help="numbers of sessions, comma-separated (default: 2,4,16,64,256, on the real CPU: 2,4,16)")
    parser.add_argument("--trace", help="interactive, mixed, idle, or a file; comma-separated (default: all)")
    parser.add_argument("--seconds", type=float, help="length of a trace in seconds (default: 30 simulated, 8 real)")
    parser.add_argument("--seeds", type=int, help="number of traces per kind and size (default: 5 simulated, 3 real)")
    parser.add_argument("--costs", default="h200", help="costs of the simulated device: h200, cpu2, or a file written by --real")
    parser.add_argument("--fleet", default="10000:1000", metavar="N:M", help="also simulate N sessions on M devices (empty = skip)")
    parser.add_argument("--engine", choices=("cpu", "cuda"), default="cpu", help="engine of the real renderer")
    parser.add_argument("--scale", type=float, help="scale of the viewports, to suit slow devices (default: 1/16 on the real CPU, else 1)")
    parser.add_argument("--volume", help="directory of the volume store, or made:N (default: the sample scan)")
    parser.add_argument("--no-plots", action="store_true", help="draw no figure-9.svg")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "schedule", help="output directory for JSON, CSV and figure-9.svg (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    options.out.mkdir(parents=True, exist_ok=True)
    results = []
    if not options.no_plots:
        _figure9(options.out)
    if options.simulate or not options.real:
        results += _results(_run("simulated", _simulated(quick, options), options.out), "simulated")
    if options.real or not options.simulate:
        results += _results(_run("real", _real(quick, options), options.out), f"real, {options.engine}")
    say(f"JSON, CSV and pictures: {options.out}")
    return results


def _figure9(out: Path) -> None:
    from .support import figure9

    file = out / "figure-9.json"
    say(_bench("--figure9", str(file)))
    situations = json.loads(file.read_text(encoding="utf-8"))
    (out / "figure-9.svg").write_text(figure9.svg(situations), encoding="utf-8")
    (out / "figure-9.md").write_text(figure9.table(situations), encoding="utf-8")


def _shared(options: argparse.Namespace, sessions: str, seconds: float, seeds: int) -> list[str]:
    words = ["--sessions", options.sessions or sessions, "--seconds", str(options.seconds or seconds),
             "--seeds", str(options.seeds or seeds), "--trace", options.trace or "interactive,mixed,idle"]
    return words + (["--policy", options.policy] if options.policy else [])


def _simulated(quick: bool, options: argparse.Namespace) -> list[str]:
    words = _shared(options, "2,16" if quick else "2,4,16,64,256", 5 if quick else 30, 2 if quick else 5)
    if options.fleet and not quick:
        sessions, _, devices = options.fleet.partition(":")
        words += ["--fleet-sessions", sessions, "--fleet-devices", devices or "1"]
    return [*words, "--costs", options.costs, "--scale", str(options.scale or 1.0)]


def _real(quick: bool, options: argparse.Namespace) -> list[str]:
    every = "2,4,16" if options.engine == "cpu" else "2,4,16,64,256"
    words = _shared(options, "2" if quick else every, 1 if quick else 8, 1 if quick else 3)
    volume = options.volume or ("made:64" if quick else cranium() or "made:256")
    return [*words, "--real", "--engine", options.engine, "--volume", volume, "--scenes", str(SCENES),
            "--scale", str(options.scale or REAL_SIZES[options.engine]), "--costs-out", str(options.out / "costs.json")]


def _run(name: str, words: list[str], out: Path) -> dict:
    file = out / f"schedule-{name}.json"
    say(_bench(*words, "--json", str(file), "--csv", str(out / f"schedule-{name}.csv")))
    return json.loads(file.read_text(encoding="utf-8"))


def _bench(*words: str) -> str:
    command = [str(paths.build_dir() / "bin" / "diaphane-renderd-bench"), "schedule", *words]
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if done.returncode == NO_DEVICE:
        raise CliError("no CUDA device is available", NO_DEVICE)
    if done.returncode != 0:
        raise CliError(f"diaphane-renderd-bench schedule exited with {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def _results(report: dict, how: str) -> list[Result]:
    """Returns the results for the targets whose rows were measured."""
    rows = {(row["trace"], row["sessions"], row["policy"]): row["figures"] for row in report["rows"]}
    results = []
    for (trace, sessions, policy), figures in rows.items():
        if policy == OURS:
            mean = figures["to 5% mean"]
            results.append(Result(f"{how}: {sessions} {trace}, mean time to 5% error", mean["value"], "ms", mean["spread"]))
    for other, at_least in ((BASELINE, 2.0), (THESIS, 1.0)):
        ours, theirs = rows.get(("mixed", 16, OURS)), rows.get(("mixed", 16, other))
        if ours and theirs:
            ratio = theirs["to 5% mean"]["value"] / max(ours["to 5% mean"]["value"], 1e-9)
            results.append(Result(f"{how}: 16 mixed, time to 5% error: slowdown with {other}", ratio, "times", 0, at_least, ratio >= at_least))
    for trace in ("mixed", "interactive"):
        if (trace, 64, OURS) in rows:
            queue = rows[(trace, 64, OURS)]["queue p95"]
            bound = 33.0 if trace == "mixed" else None
            results.append(Result(f"{how}: 64 {trace}, queueing before the first frame, p95", queue["value"], "ms", queue["spread"],
                                  bound, None if bound is None else queue["value"] <= bound))
    for (trace, sessions, policy), figures in rows.items():
        if policy == OURS and trace == "mixed":
            lost = figures["switching"]
            results.append(Result(f"{how}: {sessions} mixed, switching overhead", lost["value"], "%", lost["spread"], 2.0, lost["value"] <= 2.0))
    for decision in report["decisions"]:
        if decision["policy"] == OURS:
            us = 1e6 * decision["seconds"]
            results.append(Result(f"{how}: time per decision, 256 sessions", us, "us", 1e6 * decision["spread"], 10.0, us <= 10.0))
    return results
