"""Compares the chart's dashboard queries with what programs export at /metrics."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

DASHBOARD = Path(__file__).resolve().parents[1] / "helm" / "diaphane" / "files" / "dashboard.json"
#: Labels that the scraper adds, not the program.
_SCRAPED = {"namespace", "pod", "instance", "job"}


def asked() -> Iterator[tuple[str, str, set[str]]]:
    """Yields the panel of each query, a metric in it, and the labels in its filters and, for the first metric of a query, in its
    aggregations and legend."""
    for panel in json.loads(DASHBOARD.read_text(encoding="utf-8"))["panels"]:
        assert panel["targets"], panel["title"]
        for target in panel["targets"]:
            found = re.findall(r"\b(diaphane_[a-z0-9_]+)(?:\{([^}]*)\})?", target["expr"])
            assert found, target["expr"]
            grouped = {one.strip() for by in re.findall(r"\bby \(([^)]*)\)", target["expr"]) for one in by.split(",")}
            named = set(re.findall(r"\{\{(\w+)\}\}", target["legendFormat"]))
            for number, (metric, chosen) in enumerate(found):
                labels = set(re.findall(r"(\w+)\s*[=!]~?", chosen)) | (grouped | named if number == 0 else set())
                yield panel["title"], metric, labels - _SCRAPED


def said(text: str) -> dict[str, set[str]]:
    """Returns the names of an exposition's samples with their labels."""
    out: dict[str, set[str]] = {}
    for name, labels in re.findall(r"^([a-z_0-9]+)(?:\{(.*)\})? \S+$", text, re.MULTILINE):
        out.setdefault(name, set()).update(re.findall(r'(\w+)="', labels))
    return out


def unanswered(prefixes: tuple[str, ...], text: str) -> list[str]:
    """Returns queries about metrics with these prefixes that the programs do not export."""
    there = said(text)
    return [f"{title}: {metric} {sorted(labels)}" for title, metric, labels in asked()
            if metric.startswith(prefixes) and not (metric in there and labels <= there[metric])]
