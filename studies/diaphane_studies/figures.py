"""The figures of the studies, as drawings of matplotlib that this module turns into SVG or PNG."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from scipy.cluster import hierarchy

from . import tours, viewpoints
from .comfort import Material
from .latency import Result as LatencyResult
from .latency import share_at
from .texts import Texts

#: Colours that people with colour blindness can tell apart (Okabe and Ito 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f6000", "#5e3c99")
INK, FAINT = "#24303a", "#d5dce2"
matplotlib.rcParams.update({"font.family": "DejaVu Sans", "font.size": 10, "text.color": INK, "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK,
                            "axes.edgecolor": "#8796a3", "axes.spines.top": False, "axes.spines.right": False, "svg.fonttype": "none", "svg.hashsalt": "diaphane"})


def _figure(width: float, height: float) -> Figure:
    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def written(figure: Figure, kind: str) -> bytes:
    out = io.BytesIO()
    figure.savefig(out, format=kind, dpi=160, metadata={"Date": None} if kind == "svg" else None)
    return out.getvalue()


def _hex(colour: np.ndarray) -> str:
    return "#{:02x}{:02x}{:02x}".format(*(int(round(value)) for value in colour))


def _bars(rows: Iterable[str], columns: list[str], colour: Callable[[int, int], np.ndarray], width: float) -> Figure:
    """Draws a table of bars of colour. Each has its colour's code below it."""
    rows = list(rows)
    figure = _figure(width, 0.9 + 1.05 * len(rows))
    axes = figure.subplots()
    for row in range(len(rows)):
        for column in range(len(columns)):
            shade = _hex(colour(row, column))
            axes.add_patch(Rectangle((column + 0.04, row + 0.06), 0.92, 0.66, facecolor=shade, edgecolor="#8796a3", linewidth=0.6))
            axes.text(column + 0.5, row + 0.86, shade, ha="center", va="center", fontsize=8.5, family="DejaVu Sans Mono")
    axes.set(xlim=(0, len(columns)), ylim=(len(rows), 0), xticks=np.arange(len(columns)) + 0.5, yticks=np.arange(len(rows)) + 0.4)
    axes.set_xticklabels(columns)
    axes.set_yticklabels(rows)
    axes.tick_params(length=0)
    axes.xaxis.tick_top()
    axes.spines[:].set_visible(False)
    return figure


def figure_20(materials: list[Material], t: Texts, names: list[str]) -> Figure:
    return _bars([t("reference"), t("comfortable")], names, lambda row, column: materials[column].colour(row), 2.2 + 2.1 * len(materials))


#: The five settings of comfort, as multiples of the weighted difference.
SETTINGS = (-2, -1, 0, 1, 2)


def lit_forms(count: int, rows: int = 270, columns: int = 180) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns a picture of one form per material: a bone, and vessels that wind around it. The first array is the number of the
    form at each pixel, or -1, the second is how brightly it is lit, and the third its highlight.
    """
    y, x = np.mgrid[-1.35:1.35:rows * 1j, -0.9:0.9:columns * 1j]
    height, owner, normals = np.full(x.shape, -np.inf), np.full(x.shape, -1), np.zeros((*x.shape, 3))
    for number in range(count):
        along = np.linspace(-1.2, 1.2, 240)
        turn = 4 * along + 2 * np.pi * number / max(count - 1, 1)
        if number == 0:
            centres, radii = np.column_stack([0 * along, 0.85 * along, 0 * along]), 0.2 + 0.14 * np.abs(along / 1.2) ** 6
        else:
            centres, radii = np.column_stack([0.5 * np.sin(turn), along, 0.5 * np.cos(turn)]), np.full(len(along), 0.11)
        for (cx, cy, cz), radius in zip(centres, radii, strict=True):
            rest = radius ** 2 - (x - cx) ** 2 - (y - cy) ** 2
            depth = np.sqrt(np.maximum(rest, 0))
            nearer = (rest > 0) & (cz + depth > height)
            height[nearer], owner[nearer] = (cz + depth)[nearer], number
            normals[nearer] = (np.stack([x - cx, y - cy, depth], axis=-1) / radius)[nearer]
    light = viewpoints.unit(np.array([-0.5, -0.6, 0.8]))
    halfway = viewpoints.unit(light + np.array([0.0, 0.0, 1.0]))
    return owner, 0.2 + 0.8 * np.maximum(normals @ light, 0), 0.3 * np.maximum(normals @ halfway, 0) ** 40


def _linear(srgb: np.ndarray) -> np.ndarray:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _srgb(linear: np.ndarray) -> np.ndarray:
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def picture_of(colours: list[np.ndarray], forms: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Returns the forms in these colours (of 255), as values of sRGB from 0 to 1 on white."""
    owner, brightness, gloss = forms
    lit = _linear(np.array([*colours, np.full(3, 255.0)]) / 255)[owner] * brightness[..., None] + gloss[..., None]
    return np.where((owner >= 0)[..., None], _srgb(np.clip(lit, 0, 1)), 1.0)


def figure_21(materials: list[Material], t: Texts, names: list[str]) -> Figure:
    """Draws one picture per setting, from the most uncomfortable on the left to the most comfortable on the right, with the
    colours of its materials below.
    """
    figure = _figure(8.2, 3.4 + 0.55 * len(materials))
    pictures, bars = figure.subplots(2, len(SETTINGS), height_ratios=(2.9, 0.55 * len(materials)))
    forms = lit_forms(len(materials))
    ends = {SETTINGS[0]: t("least_comfortable"), SETTINGS[-1]: t("most_comfortable"), 0: t("reference")}
    for picture, below, times in zip(pictures, bars, SETTINGS, strict=True):
        colours = [one.colour(times) for one in materials]
        picture.imshow(picture_of(colours, forms), interpolation="bilinear")
        picture.set_title(f"{times:+d}".replace("-", "−") if times else "0", fontsize=11)
        picture.set_xlabel(ends.get(times, ""), fontsize=8.5)
        for row, colour in enumerate(colours):
            below.add_patch(Rectangle((0, row + 0.04), 1, 0.52, facecolor=_hex(colour), edgecolor="#8796a3", linewidth=0.6))
            below.text(0.5, row + 0.78, _hex(colour), ha="center", va="center", fontsize=8, family="DejaVu Sans Mono")
        below.set(xlim=(0, 1), ylim=(len(materials), 0))
        for axes in (picture, below):
            axes.set(xticks=[], yticks=[])
            axes.spines[:].set_visible(False)
    bars[0].set_yticks(np.arange(len(materials)) + 0.3, names)
    bars[0].tick_params(length=0)
    figure.supxlabel(t("scale"), fontsize=10)
    return figure


# Viewpoints

def figure_25(result: viewpoints.Result, t: Texts) -> Figure:
    figure = _figure(8.2, 4.2)
    axes = figure.subplots()
    kept = set(result.kept.tolist())
    hierarchy.dendrogram(result.linkage, ax=axes, labels=[str(n) for n in result.views.numbers], leaf_font_size=8, color_threshold=0,
                         above_threshold_color=COLOURS[0], link_color_func=lambda _: COLOURS[0])
    axes.axhline(result.bound, color=COLOURS[1], linestyle=(0, (5, 3)), linewidth=1.2, label=t("bound"))
    outliers = {str(number) for i, number in enumerate(result.views.numbers) if i not in kept}
    for label in axes.get_xticklabels():
        if label.get_text() in outliers:
            label.set(color=COLOURS[1], fontweight="bold")
    axes.set(xlabel=t("participant"), ylabel=t("height"))
    axes.legend(frameon=False, loc="lower right", bbox_to_anchor=(1, 1))
    return figure


def _seen_from_above(axes: Axes, result: viewpoints.Result, t: Texts) -> None:
    """Prepares axes on which the body is seen from above its head, with the front at the bottom."""
    axes.add_patch(matplotlib.patches.Circle((0, 0), 1, facecolor="#e8eef3", edgecolor="#8796a3", linewidth=0.8))
    axes.text(0, 0, t("region"), ha="center", va="center", fontsize=8)
    reach = 1.15 * max(1.2, float(np.abs(result.views.directions[result.kept] * result.views.distances[result.kept, None]).max()))
    axes.set(xlim=(-reach, reach), ylim=(reach, -reach), xlabel=t("left_axis"), ylabel=t("back_axis"), aspect="equal")
    axes.invert_yaxis()
    axes.grid(color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


def figure_26(result: viewpoints.Result, t: Texts) -> Figure:
    """Draws the tour in the order in which the clusters were found, by their sizes, and in the order by angle, with the same curve."""
    figure = _figure(8.2, 4.5)
    found = sorted(result.clusters, key=lambda one: int(one.members[0]))
    for axes, clusters, title in zip(figure.subplots(1, 2), (found, result.clusters), (t("unordered"), t("ordered")), strict=True):
        eyes = tours.curve(np.array([one.direction for one in clusters]), np.array([one.distance for one in clusters]))
        _seen_from_above(axes, result, t)
        axes.plot(eyes[:, 0], eyes[:, 1], color=COLOURS[0], linewidth=1.6)
        for one in clusters:
            number = result.clusters.index(one)
            axes.plot(*(one.direction * one.distance)[:2], "o", color=COLOURS[number % len(COLOURS)], markersize=15, markeredgecolor="white")
            axes.annotate(str(number + 1), (one.direction * one.distance)[:2], ha="center", va="center", color="white", fontweight="bold", fontsize=9)
        axes.set_title(f"{title}, {t('length', value=t.number(tours.length_of(eyes), 1))}", fontsize=10)
    return figure


def figure_27(result: viewpoints.Result, t: Texts) -> Figure:
    """Draws the directions of all views on a map: the azimuth from the front to the left, and the elevation."""
    figure = _figure(8.2, 4.4)
    axes = figure.subplots()
    azimuth, elevation = angles_of(result.views.directions)
    kept = set(result.kept.tolist())
    away = [i for i in range(len(azimuth)) if i not in kept]
    owner = {int(result.kept[member]): number for number, one in enumerate(result.clusters) for member in one.members}
    shades = [COLOURS[owner[i] % len(COLOURS)] if i in owner else "#8796a3" for i in result.kept]
    axes.scatter(azimuth[result.kept], elevation[result.kept], s=34, c=shades, edgecolors="white", linewidths=0.6, zorder=2)
    if away:
        axes.scatter(azimuth[away], elevation[away], s=44, marker="x", c=INK, zorder=2, label=t("outlier"))
        axes.legend(frameon=False, loc="upper right", bbox_to_anchor=(1, 1.12))
    for number, one in enumerate(result.clusters):
        x, y = angles_of(one.direction[None])
        axes.scatter(x, y, s=300, c=COLOURS[number % len(COLOURS)], edgecolors=INK, linewidths=1.2, zorder=3)
        axes.annotate(str(number + 1), (x[0], y[0]), ha="center", va="center", color="white", fontweight="bold", zorder=4)
    ticks = (-180, -90, 0, 90, 180)
    axes.set(xlim=(-184, 184), ylim=(-94, 94), xticks=ticks, yticks=range(-90, 91, 45), xlabel=f"{t('azimuth')} (°)", ylabel=f"{t('elevation')} (°)")
    axes.set_xticklabels([f"{t.number(value)}\n{t(side)}" for value, side in zip(ticks, ("back", "right", "front", "left", "back"), strict=True)])
    axes.grid(color=FAINT, linewidth=0.6)
    return figure


def angles_of(directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the azimuth from the front towards the patient's left, and the elevation, in degrees. Axes are left, back, up."""
    return np.degrees(np.arctan2(directions[:, 0], -directions[:, 1])), np.degrees(np.arcsin(np.clip(directions[:, 2], -1, 1)))


# Latency

def figure_latency(result: LatencyResult, t: Texts) -> Figure:
    from . import intervals

    figure = _figure(8.2, 7.4)
    accepted, rating, seconds = figure.subplots(3, 1, sharex=True, height_ratios=(1.5, 1, 1))
    shares = result.accepted / result.trials
    ends = np.array([intervals.share(int(a), int(n)) for a, n in zip(result.accepted, result.trials, strict=True)])
    accepted.errorbar(result.delays, 100 * shares, yerr=100 * np.abs(ends.T - shares), fmt="o", color=COLOURS[0], ecolor="#7fb8d8", capsize=3)
    if result.parameters is not None:
        along = np.linspace(result.delays[0], result.delays[-1], 200)
        accepted.plot(along, 100 * share_at(along, result.parameters), color=COLOURS[1])
    for share, (value, low, high) in result.thresholds.items():
        if np.isfinite(value):
            accepted.plot([low, min(high, result.delays[-1])], [100 * share] * 2, color=COLOURS[2], linewidth=5, alpha=0.45, solid_capstyle="butt")
            accepted.annotate(f"{t.number(value)} ms", (value, 100 * share), xytext=(7, 6), textcoords="offset points", color=COLOURS[2], fontweight="bold")
    accepted.set(ylabel=f"{t('accepted')} (%)", ylim=(-4, 104))
    for axes, estimates, label in ((rating, result.ratings, t("rating")), (seconds, result.seconds, t("seconds"))):
        middle, lower, upper = (np.array([getattr(one, name)[0] for one in estimates]) for name in ("mean", "low", "high"))
        axes.errorbar(result.delays, middle, yerr=np.nan_to_num([middle - lower, upper - middle]).clip(0), fmt="o-", color=COLOURS[0], ecolor="#7fb8d8", capsize=3)
        axes.set_ylabel(label)
    rating.set_ylim(-0.4, 10.4)
    seconds.set_ylim(bottom=0)
    seconds.set_xlabel(t("delay"))
    for axes in (accepted, rating, seconds):
        axes.grid(color=FAINT, linewidth=0.6)
    return figure


def figure_sus(scores: np.ndarray, t: Texts) -> Figure:
    figure = _figure(8.2, 3)
    axes = figure.subplots()
    axes.hist(scores, bins=[*range(0, 101, 10)], color=COLOURS[0], edgecolor="white")
    axes.axvline(scores.mean(), color=COLOURS[1], linewidth=1.6, label=f"{t('mean')} {t.number(scores.mean(), 1)}")
    axes.set(xlim=(0, 100), xlabel=t("score"), ylabel=t("overview"))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(frameon=False)
    return figure
