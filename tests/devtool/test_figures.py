"""The page of figures: what `./diaphane figures` writes from docs/figures/, and from a fresh benchmark report."""

from __future__ import annotations

import json
import os
import re

import pytest

from devtool import bench, figures
from devtool.console import CliError

REPORTS = figures.reports(figures.FOLDER)
REPORT = {"bench": "made-up", "machine": {"cpu": "AMD EPYC", "cores": 2},
          "results": [{"name": "stop", "value": 0.333, "unit": "s", "spread": 0.0121, "target": 0.3, "met": False, "runs": 5}]}


def test_figures_page_is_up_to_date():
    assert figures.PAGE.read_text(encoding="utf-8") == figures.page(REPORTS), "run ./diaphane figures"


@pytest.mark.parametrize("name", REPORTS)
def test_every_result_has_a_value_and_a_verdict_on_its_target(name):
    for result in REPORTS[name]["results"]:
        assert ("value" in result) != ("range" in result), result
        assert (result.get("target") is None) == (result.get("met") is None), result


@pytest.mark.parametrize("name", [name for name, report in REPORTS.items() if report["bench"] not in figures.NOT_SHOWN])
def test_every_report_of_a_shown_bench_is_linked(name):
    assert f"(figures/{name})" in figures.page(REPORTS)


def test_every_section_has_a_report():
    assert {*figures.SECTIONS, *figures.NOT_SHOWN} == {report["bench"] for report in REPORTS.values()}


def test_a_missed_target_is_shown_with_value_spread_and_machine():
    page = figures.page({"a.json": REPORT})
    assert "|stop|0.333±0.012 s|0.3: **missed**|" in page
    assert "[a.json](figures/a.json), 5 runs:" in page


@pytest.mark.parametrize(("result", "shown"), [
    ({"value": 14850.0, "unit": "ms", "spread": 130}, "14,850±130 ms"),
    ({"value": 0.1317, "unit": "ms"}, "0.1317 ms"),
    ({"value": 31.8, "unit": "1/s"}, "31.8/s"),
    ({"value": 12.88, "unit": "%"}, "12.88%"),
    ({"range": [0.09, 0.23], "unit": "s"}, "0.09–0.23 s"),
    ({"value": 0.5, "unit": "", "interval_95": [0.4, 0.6]}, "0.5 (0.4–0.6)"),
    ({"value": 0, "unit": ""}, "0"),
])
def test_numbers_keep_their_significant_digits(result, shown):
    assert figures._value(result) == shown


def test_a_fresh_benchmark_report_becomes_a_section(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "getloadavg", lambda: (1.5, 1.0, 1.0))
    results = [bench.result("start", [1.0, 2.0, 3.0], "s", at_most=10), bench.result("slices", [7], "")]
    bench.write_report(tmp_path / "fresh.json", "fresh", "./diaphane bench fresh", 0.5, results)
    lines = (tmp_path / "fresh.json").read_text(encoding="utf-8").splitlines()
    assert sum('"name"' in line for line in lines) == 2, "one result per line"
    page = figures.page(figures.reports(tmp_path))
    assert "## fresh" in page and "|start|2±1 s|10: met|" in page
    assert re.search(r"load\s0\.5–1\.5,\s3\sruns", page)


def test_a_report_without_results_is_refused(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({"bench": "a", "machine": {}}), encoding="utf-8")
    with pytest.raises(CliError, match="missing results"):
        figures.reports(tmp_path)
