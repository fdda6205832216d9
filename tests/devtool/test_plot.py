"""Plots and the tables of `./diaphane bench convergence`."""

import math
import xml.etree.ElementTree as ElementTree

import pytest

from devtool import bench
from devtool.benches import convergence
from devtool.benches.support import plot
from devtool.console import CliError


def report(exponent=-0.5, ratio=1.0):
    points = [{"samples": n, "milliseconds": 2.0 * n, "milliseconds_spread": 0.1, "rmse": 0.4 * n ** exponent,
               "rmse_spread": 0.01, "estimate": None if n < 2 else ratio * 0.4 * n ** exponent,
               "ratio": None if n < 2 else ratio, "dropped": 0, "non_finite": 0} for n in (1, 2, 4, 64, 128)]
    curve = {"name": "tracking, independent points <&>", "walk": "tracking", "points": "independent", "mis": "both",
             "slope": exponent, "to_target": {"samples": 64, "milliseconds": 128, "how": "between"}, "curve": points}
    return {"scene": "a", "engine": "cpu", "device": "2 CPU threads", "volume": "made", "width": 8, "height": 8,
            "target": 0.05, "curves": [curve, {"name": "exact", "left_out": "not here"}]}


def test_a_plot_is_well_formed_and_holds_every_point():
    marked = marks(convergence.plot_of(report()))
    assert [len(places) for places in marked] == [5, 5], "a curve in each panel; the estimate has no marks"
    places = marked[0]
    assert places == sorted(places), "more samples to the right, less error further down"
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in zip(places, places[1:])]
    assert max(slopes) - min(slopes) < 0.02, "a power law is a straight line"


def marks(svg: str) -> list[list[tuple[float, float]]]:
    """Returns the places of the marks of each curve."""
    name = "{http://www.w3.org/2000/svg}"
    curves = [group for group in ElementTree.fromstring(svg).iter(f"{name}g") if group.get("id") == "curve"]
    return [places for curve in curves if (places := [(float(use.get("x")), float(use.get("y"))) for use in curve.iter(f"{name}use")])]


def test_infinite_and_missing_values_are_not_drawn():
    lines = [plot.Line("x", [(1, math.inf), (2, None), (0, 1), (4, 0.5)])]
    assert [len(places) for places in marks(plot.svg("t", [plot.Panel("p", "x", "y", lines)], []))] == [1]
    ElementTree.fromstring(plot.svg("t", [plot.Panel("p", "x", "y", [])], []))


def test_slope_and_estimate_are_compared_with_their_bounds():
    met = {r.name.rpartition(": ")[2]: r.met for r in convergence.results_of(report())}
    assert met["slope, distance from -0.5"] and met["estimate, deviation from the truth"]
    assert not {r.name.rpartition(": ")[2]: r.met for r in convergence.results_of(report(exponent=-0.4))}["slope, distance from -0.5"]
    assert not {r.name.rpartition(": ")[2]: r.met for r in convergence.results_of(report(ratio=0.85))}["estimate, deviation from the truth"]


def test_the_table_has_a_line_for_each_point():
    lines = convergence.csv_of([report(), report()]).splitlines()
    assert len(lines) == 1 + 2 * 5
    assert len({line.count(",") for line in lines}) == 1


def test_a_measurement_without_options_accepts_none():
    with pytest.raises(CliError):
        bench.run("startup", None, True, ["--engine", "cpu"])
