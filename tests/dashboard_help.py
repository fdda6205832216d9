"""What the chart's dashboard asks Prometheus for, held against what programs say at /metrics."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

DASHBOARD = Path(__file__).resolve().parents[1] / "helm" / "diaphane" / "files" / "dashboard.json"
#: Put there by whoever scrapes, not by the program.
_SCRAPED = {"namespace", "pod", "instance", "job"}


def asked() -> Iterator[tuple[str, str, set[str]]]:
    """Of each query its panel, a metric of it, and the labels by which that is chosen and, of the query's first, summed and named."""
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
    """Of an exposition each sample's name, with the labels that it has."""
    out: dict[str, set[str]] = {}
    for name, labels in re.findall(r"^([a-z_0-9]+)(?:\{(.*)\})? \S+$", text, re.MULTILINE):
        out.setdefault(name, set()).update(re.findall(r'(\w+)="', labels))
    return out


def unanswered(prefixes: tuple[str, ...], text: str) -> list[str]:
    """Queries about metrics of these programs that they do not answer."""
    there = said(text)
    return [f"{title}: {metric} {sorted(labels)}" for title, metric, labels in asked()
            if metric.startswith(prefixes) and not (metric in there and labels <= there[metric])]
