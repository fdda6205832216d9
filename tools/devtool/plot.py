"""Log-log plots as SVG without a library: small files that are readable on light and dark pages."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from html import escape
from typing import Sequence

WIDTH, HEIGHT = 430, 330            # of one panel
LEFT, RIGHT, TOP, BOTTOM = 62, 14, 34, 46
ROW = 17                            # of the legend

# Distinct on white and on near-black, and different in lightness where hues are similar.
COLOURS = ("#d1495b", "#2e86ab", "#3c9d5d", "#b8860b", "#8e5bb5", "#7a7a7a", "#d2691e", "#1b998b")

STYLE = """<style>
 text { font: 11px system-ui, sans-serif; fill: #333 } .title { font-weight: 600; font-size: 12px }
 .grid { stroke: #8886; stroke-width: .6 } .axis { stroke: #888 } .line { fill: none; stroke-width: 1.8 }
 .dashed { stroke-dasharray: 4 3; stroke-width: 1.3 } .level { stroke: #888; stroke-dasharray: 1 3 }
 @media (prefers-color-scheme: dark) { text { fill: #ddd } }
</style>"""


@dataclass(frozen=True)
class Line:
    name: str
    points: Sequence[tuple[float, float]]
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


def svg(title: str, panels: Sequence[Panel], legend: Sequence[tuple[str, int, bool]]) -> str:
    """Draws the panels side by side. `legend` has name, colour and whether the line is dashed."""
    width, height = WIDTH * len(panels), 24 + HEIGHT + ROW * len(legend) + 8
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
             f'height="{height}" role="img" aria-label="{escape(title, quote=True)}">', STYLE,
             f'<text class="title" x="10" y="17">{escape(title)}</text>']
    for number, panel in enumerate(panels):
        parts.append(f'<g transform="translate({number * WIDTH} 20)">{_panel(panel)}</g>')
    for number, (name, colour, dashed) in enumerate(legend):
        y = 24 + HEIGHT + ROW * number + 8
        parts.append(f'<path class="line{" dashed" if dashed else ""}" stroke="{_colour(colour)}" d="M20 {y - 4}h30"/>'
                     f'<text x="58" y="{y}">{escape(name)}</text>')
    return "\n".join([*parts, "</svg>", ""])


def _colour(number: int) -> str:
    return COLOURS[number % len(COLOURS)]


def _panel(panel: Panel) -> str:
    points = [p for line in panel.lines for p in line.points if _drawn(p)]
    if not points:
        return f'<text x="{LEFT}" y="{TOP}">{escape(panel.title)}: nothing to draw</text>'
    ys = [y for _, y in points] + ([panel.level] if panel.level else [])
    across, up = _Axis([x for x, _ in points]), _Axis(ys)

    def place(x: float, y: float) -> tuple[float, float]:
        return (LEFT + across.share(x) * (WIDTH - LEFT - RIGHT),
                HEIGHT - BOTTOM - up.share(y) * (HEIGHT - TOP - BOTTOM))

    low, high = HEIGHT - BOTTOM, TOP
    parts = [f'<text class="title" x="{LEFT}" y="{TOP - 10}">{escape(panel.title)}</text>',
             f'<text text-anchor="middle" x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 10}">{escape(panel.x)}</text>',
             f'<text text-anchor="middle" transform="translate(14 {(low + high) / 2}) rotate(-90)">'
             f'{escape(panel.y)}</text>']
    for value in across.ticks():
        x = place(value, ys[0])[0]
        parts.append(f'<path class="grid" d="M{x:.1f} {low}V{high}"/>'
                     f'<text text-anchor="middle" x="{x:.1f}" y="{low + 15}">{_figure(value)}</text>')
    for value in up.ticks():
        y = place(points[0][0], value)[1]
        parts.append(f'<path class="grid" d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}"/>'
                     f'<text text-anchor="end" x="{LEFT - 6}" y="{y + 4:.1f}">{_figure(value)}</text>')
    if panel.level:
        y = place(points[0][0], panel.level)[1]
        parts.append(f'<path class="level" d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}"/>'
                     f'<text text-anchor="end" x="{WIDTH - RIGHT - 2}" y="{y - 4:.1f}">{_figure(panel.level)}</text>')
    parts.append(f'<path class="axis" fill="none" d="M{LEFT} {high}V{low}H{WIDTH - RIGHT}"/>')
    for line in panel.lines:
        places = [place(*p) for p in line.points if _drawn(p)]
        if not places:
            continue
        path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
        parts.append(f'<path class="line{" dashed" if line.dashed else ""}" stroke="{_colour(line.colour)}" d="M{path}"/>')
        if line.marks:
            parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.4" fill="{_colour(line.colour)}"/>' for x, y in places]
    return "".join(parts)


def _drawn(point: tuple[float | None, float | None]) -> bool:
    return all(part is not None and math.isfinite(part) and part > 0 for part in point)


def _figure(value: float) -> str:
    return f"{value:g}" if 1e-4 <= value < 1e6 else f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")


class _Axis:
    """A logarithmic axis, slightly wider than its values."""

    def __init__(self, values: Sequence[float]) -> None:
        low, high = math.log10(min(values)), math.log10(max(values))
        margin = max((high - low) * 0.05, 0.03)
        self.low, self.high = low - margin, high + margin

    def share(self, value: float) -> float:
        return (math.log10(value) - self.low) / (self.high - self.low)

    def ticks(self) -> list[float]:
        decades = range(math.floor(self.low), math.ceil(self.high) + 1)
        for steps in ((1,), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 7)):
            found = [s * 10.0 ** d for d in decades for s in steps if self.low <= math.log10(s * 10.0 ** d) <= self.high]
            if len(found) >= 3:
                break
        return found[::max(1, len(found) // 8)]
