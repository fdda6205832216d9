"""The README compares Diaphane with its peers by the measured figures of docs/figures/, and stays short."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

REPO = Path(__file__).resolve().parents[2]
README = (REPO / "README.md").read_text(encoding="utf-8")
OWN = "cranium, {}, exact, low-discrepancy points: to RMSE 0.05"
DIAPHANE = "Diaphane"


def _results(report: str) -> list[dict]:
    return json.loads((REPO / "docs" / "figures" / report).read_text(encoding="utf-8"))["results"]


def _as_written(result: dict) -> str:
    if "range" in result:
        return f"{result['range'][0]:g} to {result['range'][1]:g} {result['unit']}"
    if result["unit"] == "ms" and result["value"] > 500:
        return f"{result['value'] / 1000:g} s"
    return f"{result['value']:g} {result['unit']}"


def _measured() -> list[tuple[str, str]]:
    """Returns (renderer, its time to an error of 0.05 as the README writes it)."""
    peers = [(result["name"].split(":")[0], _as_written(result)) for report in ("peers-cpu.json", "peers-h200.json")
             for result in _results(report) if result["name"].endswith("time to error 0.05")]
    own = [(DIAPHANE, _as_written(result)) for report in ("convergence-cpu.json", "convergence-h200.json")
           for result in _results(report) if result["name"] in (OWN.format("cpu"), OWN.format("cuda"))]
    return peers + own


def _row(renderer: str) -> str:
    return next(line for line in README.splitlines() if line.startswith("|") and renderer in line.split("|")[1])


@pytest.mark.parametrize("renderer, time", _measured())
def test_readme_table_has_each_measured_time(renderer, time):
    assert time in _row(renderer)


def test_diaphane_and_four_peers_are_measured():
    assert {renderer for renderer, _ in _measured()} == {DIAPHANE, "Clara Viz", "Mitsuba", "Cycles", "pbrt-v4"}


def test_readme_is_short():
    assert len(README.splitlines()) <= 80
    assert len(README.split()) <= 600
