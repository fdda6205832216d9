"""The results that `./diaphane bench schedule` derives from a report."""

from __future__ import annotations

from xml.etree import ElementTree

from devtool.benches import schedule
from devtool.benches.support import figure9

SITUATION = {"what": "2 nodes: 1 interacts & 2 rests", "begin": [1, 850], "turns": [[1, 2], [2, 851]], "shares": [0.9, 0.1],
             "expected": [0.96, 0.04]}


def figures(mean: float, queue: float = 10.0, switching: float = 1.0) -> dict:
    return {name: {"value": value, "spread": 0.5, "unit": "ms"}
            for name, value in (("to 5% mean", mean), ("queue p95", queue), ("switching", switching))}


def report(*rows: tuple) -> dict:
    return {"rows": [{"trace": trace, "sessions": sessions, "policy": policy, "figures": of} for trace, sessions, policy, of in rows],
            "decisions": [{"policy": "marginal-gain", "sessions": 256, "seconds": 4e-6, "spread": 1e-7}]}


def test_figure_9_is_valid_svg_with_a_cell_per_turn():
    picture = ElementTree.fromstring(figure9.svg([SITUATION, SITUATION]))
    texts = [text.text for text in picture.iter("{http://www.w3.org/2000/svg}text")]
    assert texts.count("1: 2") == 2 and texts.count("2: 851") == 2
    assert any("1: 1 interacts & 2 rests; shares of the turns 90%, 10%" in text for text in texts if text)
    assert figure9.table([SITUATION]).splitlines()[2] == "| 1 | 1: 2 |"


def test_each_target_is_compared_with_its_rows():
    results = {r.name: r for r in schedule._results(report(
        ("mixed", 16, "marginal-gain", figures(50)), ("mixed", 16, "round-robin", figures(120)),
        ("mixed", 16, "error-proportional", figures(45)), ("mixed", 64, "marginal-gain", figures(90, queue=34, switching=3))), "real")}
    assert results["real: 16 mixed, time to 5% error: slowdown with round-robin"].met
    assert not results["real: 16 mixed, time to 5% error: slowdown with error-proportional"].met
    assert not results["real: 64 mixed, queueing before the first frame, p95"].met
    assert not results["real: 64 mixed, switching overhead"].met
    assert results["real: time per decision, 256 sessions"].met


def test_rows_that_were_not_measured_have_no_target():
    assert all("times" != r.unit for r in schedule._results(report(("mixed", 2, "marginal-gain", figures(50))), "real"))
