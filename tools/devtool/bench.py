"""`./diaphane bench`: measurements in a common form. A measurement is a module in benches/ with ABOUT and measure(quick). One
with its own options has add_options(parser) and measure(quick, options). PROGRAMS names the programs to build (default: all, None:
none)."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import pkgutil
import platform
import statistics
import subprocess
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Callable, Sequence

from . import benches, build, install, paths
from .console import CliError, say


@dataclass(frozen=True)
class Result:
    """One figure. `value` is the median and `spread` the standard deviation of `runs` runs, both in `unit`. The spread of a
    single run is 0. `target` and `met` are None for a figure without a target."""

    name: str
    value: float
    unit: str
    spread: float = 0.0
    target: float | None = None
    met: bool | None = None
    runs: int = 1


def result(name: str, runs: Sequence[float], unit: str, at_most: float | None = None, at_least: float | None = None) -> Result:
    """Returns the median of the runs, compared with a limit if there is one."""
    value = statistics.median(runs)
    spread = statistics.stdev(runs) if len(runs) > 1 else 0.0
    if at_most is not None:
        return Result(name, value, unit, spread, at_most, value <= at_most, len(runs))
    if at_least is not None:
        return Result(name, value, unit, spread, at_least, value >= at_least, len(runs))
    return Result(name, value, unit, spread, runs=len(runs))


def percentile(runs: Sequence[float], percent: float) -> float:
    ordered = sorted(runs)
    return ordered[min(len(ordered) - 1, int(len(ordered) * percent / 100))]


def run(name: str | None, json_file: Path | None, quick: bool, rest: Sequence[str] = (), print_help: Callable[[], None] = lambda: None) -> int:
    if name is None and rest in (["-h"], ["--help"]):
        print_help()
        return 0
    known = {module.name.replace("_", "-"): module.name for module in pkgutil.iter_modules(benches.__path__)
             if not module.ispkg}
    if name is None:
        for shown, module in sorted(known.items()):
            say(f"  {shown:<16} {importlib.import_module(f'{benches.__name__}.{module}').ABOUT}")
        return 0
    if name not in known:
        raise CliError(f"unknown benchmark '{name}'; choose one of: {', '.join(sorted(known))}", 64)
    bench = importlib.import_module(f"{benches.__name__}.{known[name]}")
    options = _own_options(bench, name, rest)
    install.enter_venv("bench")
    if (programs := getattr(bench, "PROGRAMS", ())) is not None:
        build.build_programs(*programs)
    if getattr(bench, "PAGE", False):
        build.build_page()
    load = os.getloadavg()[0]
    results = bench.measure(quick, options) if options else bench.measure(quick)
    _print(results)
    if json_file:
        write_report(json_file, name, " ".join(["./diaphane bench", name, *(["--quick"] if quick else []), *rest]), load, results)
    return 0 if all(result.met is not False for result in results) else 2


def write_report(file: Path, name: str, command: str, load_before: float, results: list[Result]) -> None:
    """Writes the results in the form that docs/figures/ holds, one result per line."""
    head = {"bench": name, "command": command, "date": time.strftime("%Y-%m-%d"), "machine": machine(),
            "load": [round(load_before, 1), round(os.getloadavg()[0], 1)]}
    lines = [json.dumps(asdict(result), ensure_ascii=False) for result in results]
    text = json.dumps(head, indent=1, ensure_ascii=False)[:-2] + ',\n "results": [\n  ' + ",\n  ".join(lines) + "\n ]\n}\n"
    file.write_text(text, encoding="utf-8")


def _own_options(bench: ModuleType, name: str, rest: Sequence[str]) -> argparse.Namespace | None:
    """Parses the options after the name. Rejects them for a measurement without options."""
    parser = argparse.ArgumentParser(prog=f"./diaphane bench {name}", description=f"{bench.ABOUT[0].upper()}{bench.ABOUT[1:]}.")
    if not hasattr(bench, "add_options"):
        if rest and set(rest) <= {"-h", "--help"}:
            parser.parse_args(list(rest))
        if rest:
            raise CliError(f"unknown arguments: {' '.join(rest)} (benchmark {name} has no options of its own)", 64)
        return None
    bench.add_options(parser)
    return parser.parse_args(list(rest))


def machine() -> dict:
    """Describes the machine of the measurement."""
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
