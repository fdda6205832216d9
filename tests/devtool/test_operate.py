"""docs/operate.md names everything that exists, and nothing else: alerts, conditions and reasons, Events, metrics, values,
columns."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

REPO = Path(__file__).resolve().parents[2]
CHART = REPO / "helm" / "diaphane"
PAGE = (REPO / "docs" / "operate.md").read_text(encoding="utf-8")
#: Text in backticks within a line, without code blocks.
NAMED = set(re.findall(r"`([^`\n]+)`", re.sub(r"```.*?```", "", PAGE, flags=re.DOTALL)))
VALUES = yaml.safe_load((CHART / "values.yaml").read_text(encoding="utf-8"))


def words_in(*files: str) -> set[str]:
    """Returns quoted words that begin with a capital letter."""
    text = "".join((REPO / "operator" / file).read_text(encoding="utf-8") for file in files)
    return {word for word in re.findall(r'"([A-Z][a-z]\w+)"', text)} - {"RenderFleet", "RenderWorker"}


def sources() -> str:
    folders = ("api", "common", "ingest", "renderd", "operator", "volume")
    files = [file for folder in folders for file in (REPO / folder).rglob("*.cpp") if not file.stem.endswith("_test")]
    return "\n".join(file.read_text(encoding="utf-8") for file in (*files, REPO / "pacs" / "diaphane_pacs" / "metrics.py"))


def alarms() -> set[str]:
    rules = yaml.safe_load((CHART / "files" / "rules.yaml").read_text(encoding="utf-8"))
    return {rule["alert"] for group in rules["groups"] for rule in group["rules"]}


def reasons() -> set[str]:
    """Returns the reasons of conditions and drains, and the names of conditions."""
    kinds = {"True", "False", "Unknown"}
    worker = yaml.safe_load((CHART / "crds" / "renderworkers.yaml").read_text(encoding="utf-8"))["spec"]["versions"][0]["schema"]["openAPIV3Schema"]
    return words_in("plan/status.cpp") - kinds | set(worker["properties"]["spec"]["properties"]["drain"]["properties"]["reason"]["enum"])


def events() -> set[str]:
    told = re.findall(r"events_\.record\(\{(.*?)\}", (REPO / "operator" / "act" / "carry_out.cpp").read_text(encoding="utf-8"), re.DOTALL)
    assert len(told) >= 4
    return {re.findall(r'"([A-Z]\w+)"', one.replace('"RenderFleet"', "").replace('"RenderWorker"', ""))[0] for one in told}


@pytest.mark.parametrize("there", [alarms, reasons, events], ids=lambda one: one.__name__)
def test_everything_in_the_code_is_documented(there):
    assert there() - NAMED == set()


def test_documented_alarms_conditions_and_reasons_exist():
    named = {one for one in NAMED if re.fullmatch(r"[A-Z][a-z]+(?:[A-Z]?[a-z]+)*", one)}
    assert len(named) > 30
    assert named - alarms() - reasons() - events() == set()


def test_documented_metrics_and_log_events_exist():
    text = sources()
    metrics = {one.partition("{")[0] for one in NAMED if one.startswith("diaphane_")}
    assert metrics and {one for one in metrics if f'"{one.rstrip("*")}' not in text} == set()
    said = {one for one in NAMED if re.fullmatch(r"[a-z]+(_[a-z]+)+", one)} - metrics | set(re.findall(r'"event":"(\w+)"', PAGE))
    assert len(said) > 4 and {one for one in said if f'"{one}"' not in text} == set()


def test_documented_values_exist_in_the_chart():
    named = {one.partition("=")[0] for one in NAMED if one.partition(".")[0] in VALUES and re.fullmatch(r"\w+(\.[\w*]+)+(=\w+)?", one)}
    named |= {one for one in re.findall(r"--set ([\w.]+)=", PAGE)}
    assert len(named) > 12

    def is_there(value, path: list[str]) -> bool:
        if not path:
            return True
        inner = list(value.values()) if path[0] == "*" else [value[path[0]]] if path[0] in (value or {}) else []
        return bool(inner) and all(is_there(one, path[1:]) for one in inner)
    assert {one for one in named if not is_there(VALUES, one.split("."))} == set()


@pytest.mark.parametrize("kind", ["renderfleets", "renderworkers"])
def test_documented_lists_match_kubectl_output(kind):
    resource = yaml.safe_load((CHART / "crds" / f"{kind}.yaml").read_text(encoding="utf-8"))["spec"]
    columns = ["NAME"] + [one["name"].upper() for one in resource["versions"][0]["additionalPrinterColumns"] if not one.get("priority")]
    heads = [line.split() for line in PAGE.splitlines() if re.match(r"NAME +[A-Z]+ +[A-Z]", line)]
    assert columns in heads
    assert set(resource["names"]["shortNames"]) & {"rf", "rw"}
