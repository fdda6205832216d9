"""Log-log plots as SVG, readable on light and dark pages."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass, field
from typing import Sequence

import matplotlib
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

# Colours that are distinct on white and on near-black, and different in lightness where hues are
# similar.
COLOURS = ("#d1495b", "#2e86ab", "#3c9d5d", "#b8860b", "#8e5bb5", "#7a7a7a", "#d2691e", "#1b998b")
_GREY = "#888888"
STYLE = {"svg.fonttype": "none", "svg.hashsalt": "diaphane", "font.size": 8, "legend.frameon": False, "axes.grid": True, "grid.alpha": 0.4,
         "axes.spines.top": False, "axes.spines.right": False, "lines.markersize": 4, "savefig.transparent": True,
         **dict.fromkeys(("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"), _GREY)}


@dataclass(frozen=True)
class Line:
    name: str
    points: Sequence[tuple[float, float | None]]
    colour: int = 0
    dashed: bool = False
    marks: bool = True


@dataclass(frozen=True)
class Panel:
    title: str
    x: str
    y: str
    lines: Sequence[Line] = field(default_factory=tuple)
    level: float | None = None      # a horizontal line at a target


@matplotlib.rc_context(STYLE)
def svg(title: str, panels: Sequence[Panel], legend: Sequence[tuple[str, int, bool]]) -> str:
    """Draws the panels side by side. `legend` has name, colour and whether the line is dashed."""
    figure = Figure(figsize=(4.3 * len(panels), 3.5 + 0.17 * len(legend)), layout="constrained")
    figure.suptitle(title)
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels):
        axes.set(title=panel.title, xlabel=panel.x, ylabel=panel.y, xscale="log", yscale="log")
        for line in panel.lines:
            drawn = [point for point in line.points if all(part and math.isfinite(part) for part in point)]
            axes.plot(*zip(*drawn), **_look(line.colour, line.dashed), marker="o" if line.marks else None, gid="curve")
        if panel.level:
            axes.axhline(panel.level, color=_GREY, linestyle=":")
    figure.legend(handles=[Line2D([], [], label=name, **_look(colour, dashed)) for name, colour, dashed in legend], loc="outside lower left")
    return text_of(figure)


def text_of(figure: Figure) -> str:
    drawn = io.StringIO()
    figure.savefig(drawn, format="svg", metadata={"Date": None})
    return drawn.getvalue()


def _look(colour: int, dashed: bool) -> dict:
    return {"color": COLOURS[colour % len(COLOURS)], "linestyle": "--" if dashed else "-"}
