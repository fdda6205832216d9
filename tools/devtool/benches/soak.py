"""Fifty users come and go for half an hour. Memory, descriptors and threads must not grow."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import time
from contextlib import suppress
from pathlib import Path

from .. import logfiles, paths
from ..bench import Result, result
from ..bench_stack import folder, prepared
from ..bench_volumes import store_ball
from ..console import CliError, say
from ..users import ordinary_user
from .support import trend_test

ABOUT = "users who come, go, reload and lose their connection: memory, descriptors and threads over time (--minutes, --people)"
PROGRAMS = ("diaphane-gateway", "diaphane-renderd", "diaphane-load")
WATCHED = ("gateway", "renderd", "redis")
WARM_UP = 0.25    # share of the time: caches fill and the allocator settles

# Memory that a visit may leak. In operation, fifty slots are reused every ten minutes, which makes 300 visits per hour. In thirty
# days, a tenth of a pod's memory limit may be lost (helm/diaphane/values.yaml: renderd 16 GiB, gateway 1 GiB). This bench has as
# many visits as 18 hours of operation. Redis keeps the data of a visit, 2 kB, for a day, which makes 14 MB in total.
PER_VISIT_KB = {"renderd": 0.1 * 16 * 2**30 / 1e3 / (30 * 24 * 300), "gateway": 0.1 * 1 * 2**30 / 1e3 / (30 * 24 * 300), "redis": 2.0}
# Allowed growth of the other measures: a share of the level, and at least a number. A short run can only detect larger growth.
ALLOWED = {"descriptors": (0.05, 4), "threads": (0.05, 2), "device memory": (0.02, 64)}
ALLOWED_QUICK = {"memory": (0.25, 48.0), "descriptors": (0.5, 40), "threads": (0.1, 4), "device memory": (0.05, 128)}
UNITS = {"memory": "MB", "descriptors": "", "threads": "", "device memory": "MB"}

# gRPC's two executors start threads as needed and end none, up to `max_threads_ = max(1, 2 * gpr_cpu_num_cores())` each (grpc
# 1.51, src/core/lib/iomgr/executor.cc). They are compared with that limit, because the last thread may start after many minutes.
EXECUTOR = "threads of gRPC's executors"
EXECUTOR_NAMES = ("default-executo", "resolver-execut")    # the kernel truncates names to 15 characters


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--people", type=int, default=50)
    parser.add_argument("--scale", type=float, help="scale of the pictures, which are 160 x 90 to 1280 x 720 (default: 0.2 on the CPU)")
    parser.add_argument("--engine", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("--codec", choices=("jpeg", "h264", "mpeg1"), default="jpeg", help="codec that the viewers prefer")
    parser.add_argument("--seed", type=int, default=1, help="seed of the simulated behaviour")
    parser.add_argument("--series", type=Path, metavar="FILE", help="write all samples to this file as CSV")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    seconds = 24.0 if quick else 60 * options.minutes
    scale = options.scale or (0.1 if quick else 0.2 if options.engine == "cpu" else 1)
    with folder(ordinary_user()) as base:
        stack = prepared(base, options.engine, DIAPHANE_SLOTS=str(2 * options.people))
        stack.only = ("redis", "gateway", "renderd")
        with stack:
            data_set = store_ball(stack)
            before = descriptors(stack.pids["gateway"])
            report, series = _watched(stack, _people(stack, data_set, seconds, scale, options), 0.25 if quick else 2)
            left = _after(stack, before)
    if options.series:
        _write(options.series, series)
    return results_of(report, series, left, quick)


def _people(stack, data_set: str, seconds: float, scale: float, options: argparse.Namespace) -> subprocess.Popen:
    words = ["--redis", stack.settings.redis, "--stream-port", stack.ports["stream"],
             "--public-url", stack.settings.url, "--data-set", data_set, "--people", options.people, "--seconds", seconds,
             "--act-seconds", 1 if seconds < 120 else 4, "--scale", scale, "--seed", options.seed, "--codec", options.codec]
    return subprocess.Popen([str(paths.build_dir() / "bin" / "diaphane-load"), "soak", *map(str, words)],
                            stdout=subprocess.PIPE, text=True)


def _watched(stack, people: subprocess.Popen, every: float) -> tuple[dict, dict[tuple[str, str], list[tuple[float, float]]]]:
    """Returns the final report of the simulated users, and the resources that the programs used: (program, what) -> (seconds, value).
    """
    series: dict[tuple[str, str], list[tuple[float, float]]] = {}
    pids, begin, next_device = dict(stack.pids), time.monotonic(), 0.0
    while people.poll() is None:
        now = time.monotonic() - begin
        for program in WATCHED:
            try:
                measured = held(pids[program])
            except (OSError, KeyError) as gone:  # an exiting process has no memory
                people.kill()
                raise CliError(f"{program} exited after {now:.0f} s; last lines of its log:\n"
                                 + logfiles.tail(stack.log_path(program), 30)) from gone
            for what, value in measured.items():
                series.setdefault((program, what), []).append((now, value))
        if now >= next_device:
            next_device = now + 5
            for value in _device_memory():
                series.setdefault(("device", "device memory"), []).append((now, value))
        with suppress(subprocess.TimeoutExpired):
            people.wait(every)
    said = people.stdout.read()
    if people.returncode != 0:
        raise CliError(f"diaphane-load exited with {people.returncode}")
    if dict(stack.pids) != pids:
        raise CliError("a program was restarted during the run. Its log says why it exited")
    return json.loads(said), series


def memory_allowed(program: str, visits: int, part: float) -> float:
    """Returns the memory in MB that may be lost during `part` of the time with these visits."""
    return PER_VISIT_KB[program] * visits * part / 1e3


def executor_bound() -> int:
    return 2 * max(1, 2 * os.sysconf("SC_NPROCESSORS_CONF"))


def threads_of(names: list[str]) -> dict[str, int]:
    of_executor = sum(name in EXECUTOR_NAMES for name in names)
    return {"threads": len(names) - of_executor, EXECUTOR: of_executor}


def _thread_names(pid: int) -> list[str]:
    names = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        with suppress(OSError):  # it has just ended
            names.append((task / "comm").read_text(encoding="ascii", errors="replace").rstrip("\n"))
    return names


def held(pid: int) -> dict[str, float]:
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
    fields = dict(line.split(":", 1) for line in status.splitlines() if ":" in line)
    return {"memory": int(fields["VmRSS"].split()[0]) * 1024 / 1e6, "descriptors": descriptors(pid), **threads_of(_thread_names(pid))}


def descriptors(pid: int) -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))


def _device_memory() -> list[float]:
    with suppress(OSError, subprocess.SubprocessError, ValueError):
        done = subprocess.run(["nvidia-smi", "--query-gpu=memory.used", "--format=csv,noheader,nounits"], capture_output=True,
                              text=True, timeout=10, check=True)
        return [sum(float(line) for line in done.stdout.split())]
    return []


def _after(stack, before: int) -> int:
    """Returns how many more descriptors the gateway has than before the first visit, a while after the last one."""
    deadline = time.monotonic() + 10
    while (left := descriptors(stack.pids["gateway"]) - before) > 0 and time.monotonic() < deadline:
        time.sleep(0.2)
    return max(0, left)


def results_of(report: dict, series: dict, left: int, quick: bool) -> list[Result]:
    say(f"{report['visits']} visits, {report['pictures']} pictures opened, {report['frames']} frames; {report['drags']} drags, "
        f"{report['reloads']} reloads, {report['cuts']} cuts, {report['hides']} hidden, {report['resizes']} resized; "
        f"closed by the server: {report['closed'] or 'none'}; refused: {report['refused']}; opening p95 "
        f"{report['opening_ms']['p95']:.0f} ms")
    results = []
    for (program, what), samples in sorted(series.items()):
        if what == EXECUTOR:
            if any(value for _, value in samples):
                results.append(result(f"{program}: {what}", [max(value for _, value in samples)], "", at_most=executor_bound()))
            continue
        whole, samples = len(samples), samples[int(WARM_UP * len(samples)):]
        if len(samples) < 2 * trend_test.FEWEST_BLOCKS:
            continue
        if quick:
            share, least = ALLOWED_QUICK[what]
        elif what == "memory":
            share, least = 0.0, memory_allowed(program, report["visits"], len(samples) / whole)
        else:
            share, least = ALLOWED[what]
        verdict = trend_test.judge([t for t, _ in samples], [v for _, v in samples], share, least)
        say(f"{program}, {what}: {verdict.word}, level {verdict.level:.1f} {UNITS[what]}, grew by {verdict.growth:+.2f} "
            f"({verdict.low:+.2f} to {verdict.high:+.2f} with 99%), allowed {verdict.allowed:.2f}")
        # A short run cannot show that nothing grows, only that something grows fast.
        bound = verdict.low if quick else verdict.high
        results.append(Result(f"{program}: {what} growth, {'lower' if quick else 'upper'} bound (99%)", round(bound, 3), UNITS[what],
                              0.0, round(verdict.allowed, 3), bound <= verdict.allowed))
    results.append(result("users without a picture for 30 s", [report["no_picture"]], "", at_most=0))
    results.append(result("descriptors left open in the gateway", [left], "", at_most=5))
    results.append(result("frames", [report["frames"]], "", at_least=1))
    return results


def _write(file: Path, series: dict) -> None:
    lines = ["program,what,seconds,value"]
    lines += [f"{program},{what},{t:.1f},{value:.3f}" for (program, what), samples in sorted(series.items()) for t, value in samples]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
