"""`./diaphane figures`: writes docs/figures.md from the reports in docs/figures/, which `./diaphane bench NAME --json FILE`
writes.

A report that was entered by hand may also have "scope" (what was measured), "notes" (a list of sentences) and "load" as text. A
result may have a "range" of two numbers instead of a value, an "interval_95" and a "note"."""

from __future__ import annotations

import json
import math
import re
import textwrap
from pathlib import Path

from . import paths
from .console import CliError, say

FOLDER = paths.REPO / "docs" / "figures"
PAGE = paths.REPO / "docs" / "figures.md"

# The machine of all reports whose caption does not name one.
MACHINE = "AMD EPYC, 2 cores"

INTRODUCTION = """\
# Figures

`./diaphane figures` writes this page from the reports in [figures/](figures), which also hold the
commands and all other results. [Performance](performance.md) says how to update it. Values are
medians, and ± is the standard deviation of the runs. A target has the unit of its value. The
machine is an AMD EPYC with 2 cores unless a caption names another.
"""

# Shows only the results that have a target.
TARGETS = "targets"

# Benches whose reports are only in the folder.
NOT_SHOWN = ("body", "cluster", "contract", "controls", "copies", "denoiser", "disc-to-picture", "edge", "edge-attacks", "exact-walk", "first-picture",
               "frame-rate", "growth", "hostile", "image", "ingest", "ingest-scale", "latency", "link", "live-sessions", "load",
               "many", "page-load", "render", "scan-folder", "slice-interpolation", "slices", "soak", "stability", "startup",
               "still-codecs", "tests", "video")

# For each other bench: what it measures, a pattern for the names of the results to show, and words that the description already
# contains and that are removed from the names.
SECTIONS: dict[str, tuple[str, str, str]] = {
    "peers": ("Time until the cranium scene at 512 x 512 has an error of 0.05 in other renderers.", r"time to error|(AGAVE|Mitsuba): time per", r": time to error 0.05"),
    "convergence": ("Time until the true error (RMSE) is 0.05, by the exact walk.", r"^(cranium|curves|bounces|dense).*exact, low.*: to RMSE",
                    r", exact, low-discrepancy points: to RMSE 0.05"),
    "kernels": ("", TARGETS, ""),
    "schedule": ("Concurrent sessions by scheduling policy.",
                 r"marginal-gain: mean|slowdown with round|one session, switch|decision|64 mixed, marginal-gain: queueing.*p95", ""),
    "phases": ("A beating heart of 20 phases of 256^3, played.", TARGETS, r"20 phases of 256\^3 at |: phases per second"),
    "pacs": ("1,000 slices of 512 x 512 in Orthanc.", TARGETS, ", 1000 slices"),
    "backup": ("Of 20 scans of 15 MB.", r".", ", 20 scans of 15 MB"),
    "heads": ("Recognition of heads (95% interval).", r"sensitivity, n = (4|72|12)$|phantom: ", ""),
    "abuse": ("What ordinary users notice of an attack by 250 connections, 16 guests of a link and ten accounts at once.", r"^p95|failed", ""),
    "studies": ("Simulated crowds of 43 (validation: 16). p-values test the coverage of intervals.", TARGETS, r" binomial test of the coverage, corrected"),
    "cluster-plan": ("8,000 simulated GPUs, 100,000 sessions.", r"place.*lost to imbalance|robin: lost|plan for 8", ""),
}


def run() -> int:
    PAGE.write_text(page(reports(FOLDER)), encoding="utf-8")
    say(f"Written: {PAGE.relative_to(paths.REPO)}")
    return 0


def reports(folder: Path) -> dict[str, dict]:
    """Returns all reports in the folder by file name."""
    found = {}
    for file in sorted(folder.glob("*.json")):
        try:
            found[file.name] = json.loads(file.read_text(encoding="utf-8"))
        except json.JSONDecodeError as error:
            raise CliError(f"{file}: not valid JSON: {error}") from error
        missing = {"bench", "machine", "results"} - set(found[file.name])
        if missing:
            raise CliError(f"{file}: missing {', '.join(sorted(missing))}")
    return found


def page(found: dict[str, dict]) -> str:
    benches = {report["bench"] for report in found.values()}
    parts = [INTRODUCTION]
    for bench in [*(name for name in SECTIONS if name in benches), *sorted(benches - set(SECTIONS) - set(NOT_SHOWN))]:
        about, pattern, redundant = SECTIONS.get(bench, ("", "", ""))
        parts.append(f"\n## {bench}\n" + (_wrapped(about) if about else ""))
        more = []
        for name, report in found.items():
            if report["bench"] == bench:
                shown = [result for result in report["results"] if _is_shown(result, pattern)]
                if shown:
                    parts.append(_report(name, report, shown, redundant))
                else:
                    more.append(f"[{name}](figures/{name})")
        if more:
            parts.append("\n" + _wrapped(f"More results: {', '.join(more)}"))
    return "".join(parts)


def _is_shown(result: dict, pattern: str) -> bool:
    return result.get("target") is not None if pattern == TARGETS else bool(re.search(pattern, result["name"]))


def _report(name: str, report: dict, shown: list[dict], redundant: str) -> str:
    targets = any(result.get("target") is not None for result in shown)
    lines = ["|Figure|Value|Target|", "|---|---|---|"] if targets else ["|Figure|Value|", "|---|---|"]
    for result in shown:
        lines.append(f"|{_written(result['name'], redundant)}|{_value(result)}|" + (f"{_target(result)}|" if targets else ""))
    notes = [*report.get("notes", []), *(result["note"] for result in shown if result.get("note"))]
    return "\n".join(["", _wrapped(_caption(name, report)), *lines, ""]) + ("\n" + _wrapped(" ".join(notes)) if notes else "")


def _caption(name: str, report: dict) -> str:
    """Returns where, when and under which load the report was measured."""
    machine = report["machine"]
    gpus = machine.get("gpu") or []
    cores = f", {machine['cores']} cores" if "cores" in machine else ""
    hardware = f"{len(gpus)} {gpus[0]}" if len(gpus) > 1 else gpus[0] if gpus else machine["cpu"] + cores
    load = report.get("load")
    runs = max((result.get("runs", 1) for result in report["results"]), default=1)
    facts = [f"[{name}](figures/{name})", hardware if hardware != MACHINE else None, report.get("date"), f"load {load[0]:g}–{load[1]:g}" if isinstance(load, list) else load,
            f"{runs} runs" if runs > 1 else None, report.get("scope")]
    return ", ".join(part for part in facts if part) + ":"


def _value(result: dict) -> str:
    unit = (result.get("unit") or "").removeprefix("1")    # 60 1/s becomes 60/s
    if unit and unit[0] not in "%/":
        unit = " " + unit
    if "range" in result:
        low, high = result["range"]
        return f"{_number(low, 4)}–{_number(high, 4)}{unit}"
    spread = f"±{_number(result['spread'], 2)}" if result.get("spread") else ""
    interval = " ({:g}–{:g})".format(*result["interval_95"]) if "interval_95" in result else ""
    return f"{_number(result['value'], 4)}{spread}{unit}{interval}"


def _target(result: dict) -> str:
    if result.get("target") is None:
        return ""
    return f"{_number(result['target'], 4)}: {'met' if result['met'] else '**missed**'}"


def _number(value: float, digits: int) -> str:
    """Formats a number with this many significant digits, but never fewer than the digits before
    the point."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    written = f"{value:,.{decimals}f}"
    return written.rstrip("0").rstrip(".") if decimals else written


def _written(name: str, redundant: str) -> str:
    """Returns the name of a result without the words of the description, capitalised."""
    short = re.sub(redundant, "", name) if redundant else name
    return _sizes(re.sub(r"\b(cpu|cuda)\b", lambda engine: engine[0].upper(), short))


def _sizes(text: str) -> str:
    """Replaces `512 x 512` by `512×512`."""
    return re.sub(r"(?<=\d) x (?=\d)", "×", text)


def _wrapped(text: str) -> str:
    return textwrap.fill(_sizes(text), 100, break_long_words=False, break_on_hyphens=False) + "\n"
