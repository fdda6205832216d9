"""`./diaphane bench`: measurements, all in one form. A measurement is a module in benches/ with ABOUT and measure(quick);
one with options of its own has add_options(parser) and measure(quick, options)."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import pkgutil
import platform
import statistics
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Sequence

from . import benches, build, install, paths
from .says import HouseError, say


@dataclass(frozen=True)
class Result:
    """One figure. `spread` is the standard deviation of the runs (0 for one run), in `unit` like `value`;
    `target` is None where there is none, and then so is `met`."""

    name: str
    value: float
    unit: str
    spread: float = 0.0
    target: float | None = None
    met: bool | None = None


def result(name: str, runs: Sequence[float], unit: str, at_most: float | None = None, at_least: float | None = None) -> Result:
    """The median of the runs, against a bound when there is one."""
    value = statistics.median(runs)
    spread = statistics.stdev(runs) if len(runs) > 1 else 0.0
    if at_most is not None:
        return Result(name, value, unit, spread, at_most, value <= at_most)
    if at_least is not None:
        return Result(name, value, unit, spread, at_least, value >= at_least)
    return Result(name, value, unit, spread)


def percentile(runs: Sequence[float], percent: float) -> float:
    ordered = sorted(runs)
    return ordered[min(len(ordered) - 1, int(len(ordered) * percent / 100))]


def run(name: str | None, json_file: Path | None, quick: bool, rest: Sequence[str] = ()) -> int:
    known = {module.name.replace("_", "-"): module.name for module in pkgutil.iter_modules(benches.__path__)}
    if name is None:
        for shown, module in sorted(known.items()):
            say(f"  {shown:<14} {importlib.import_module(f'{benches.__name__}.{module}').ABOUT}")
        return 0
    if name not in known:
        raise HouseError(f"no bench '{name}'; there are: {', '.join(sorted(known))}", 64)
    bench = importlib.import_module(f"{benches.__name__}.{known[name]}")
    options = _own_options(bench, name, rest)
    if not in_venv():
        install.ensure("bench")
        return again_in_venv()
    build.build_programs(*getattr(bench, "PROGRAMS", ()))
    if getattr(bench, "PAGE", False):
        build.build_page()
    results = bench.measure(quick, options) if options else bench.measure(quick)
    _print(results)
    if json_file:
        written = {"bench": name, "machine": machine(), "results": [asdict(result) for result in results]}
        json_file.write_text(json.dumps(written, indent=1) + "\n", encoding="utf-8")
    return 0 if all(result.met is not False for result in results) else 2


def _own_options(bench: ModuleType, name: str, rest: Sequence[str]) -> argparse.Namespace | None:
    """What stands after the name, for a measurement that has options; for others nothing may."""
    if not hasattr(bench, "add_options"):
        if rest:
            raise HouseError(f"bench {name} has no options of its own: {' '.join(rest)}", 64)
        return None
    parser = argparse.ArgumentParser(prog=f"./diaphane bench {name}", description=bench.ABOUT)
    bench.add_options(parser)
    return parser.parse_args(list(rest))


def in_venv() -> bool:
    return Path(sys.prefix).resolve() == paths.VENV.resolve()


def again_in_venv() -> int:
    """The same command with the libraries of .tools/venv (WebSocket client, Protobuf)."""
    os.execv(paths.VENV_PYTHON, [str(paths.VENV_PYTHON), str(paths.TOOLS / "house"), *sys.argv[1:]])


def machine() -> dict:
    """What the figures were taken on."""
    return {"cpu": _cpu(), "cores": len(os.sched_getaffinity(0)),
            "memory_gb": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9, 1),
            "gpu": _output("nvidia-smi", "--query-gpu=name", "--format=csv,noheader").splitlines() or None,
            "system": f"{platform.system()} {platform.release()}",
            "commit": _output("git", "-C", str(paths.REPO), "rev-parse", "--short=12", "HEAD").strip() or None}


def _cpu() -> str:
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()


def _output(*command: str) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=20).stdout
    except (OSError, subprocess.SubprocessError):
        return ""


def _print(results: list[Result]) -> None:
    width = max([len(r.name) for r in results] + [4])
    say(f"{'':<{width}}  {'value':>12} {'spread':>10}  {'unit':<12} {'target':>10}")
    for r in results:
        target = "" if r.target is None else f"{r.target:>10.4g} {'met' if r.met else 'MISSED'}"
        say(f"{r.name:<{width}}  {r.value:>12.5g} {r.spread:>10.3g}  {r.unit:<12} {target}".rstrip())
