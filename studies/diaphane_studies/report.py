"""Analyses an export: sections with tables and figures, and what the page may adopt."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from . import answers, comfort, export, figures, latency, tours, viewpoints
from .texts import Texts

Section = dict[str, Any]


def analyse(document: dict[str, Any], language: str = "en") -> dict[str, Any]:
    """Returns the sections and what is adoptable. Figures are drawings until `as_json` writes them."""
    t = Texts(language)
    try:
        materials = comfort.materials(document)
        views = _viewpoints(document)
        sections = [_overview(document, t), *_comfort(document, materials, t), *_validation(document, t), *(_viewpoint(step, result, t) for step, result in views),
                    *_latency(document, t), *_sus(document, t), *_ratings(document, t), *_choices(document, t), *_words(document, t)]
    except (KeyError, TypeError, IndexError, AttributeError) as error:
        # The message of the cause could quote an answer.
        raise export.ExportError(f"an answer of the export does not fit its step ({type(error).__name__})") from error
    made = [{"step": step["id"], "data_set_id": (step.get("view") or {}).get("data_set_id", ""), "views": tours.cameras(result)}
            for step, result in views if result and result.clusters]
    return {"sections": sections, "adoptable": {"comfort": comfort.adoptable(materials), "tours": made}}


def as_json(result: dict[str, Any]) -> dict[str, Any]:
    """Returns the result with the figures as SVG."""
    sections = [{**section, "figures": [{**figure, "svg": figures.written(figure["svg"], "svg").decode()} for figure in section["figures"]]}
                for section in result["sections"]]
    return {**result, "sections": sections}


def _section(name: str, title: str, notes: Sequence[str] = (), tables: Sequence[dict[str, Any]] = (),
             drawn: Sequence[tuple[str, str, Figure]] = ()) -> Section:
    return {"id": name, "title": title, "notes": list(notes), "tables": list(tables), "figures": [{"id": a, "title": b, "svg": c} for a, b, c in drawn]}


def _table(title: str, columns: list[str], rows: list[list[str]]) -> dict[str, Any]:
    return {"title": title, "columns": columns, "rows": rows}


def _name(step: dict[str, Any], t: Texts) -> str:
    """Returns the first line of a step's text, which names it in tables."""
    lines = export.text(step.get("text"), t.language).strip().splitlines()
    return (lines[0][:120] if lines else "") or step["id"]


def _overview(document: dict[str, Any], t: Texts) -> Section:
    states = [one["state"] for one in document["participants"]]
    rows = [[t("finished"), str(states.count("finished"))], [t("active"), str(len(states) - states.count("finished"))],
            [t("withdrawn"), str(document["study"].get("withdrawn", 0))]]
    return _section("participants", t("overview"), [t("level")], [_table(t("overview"), [t("state"), t("count")], rows)])


def _comfort(document: dict[str, Any], materials: list[comfort.Material], t: Texts) -> list[Section]:
    if not materials:
        return []
    names = [export.text(one.name, t.language) or one.channel for one in materials]
    rows = []
    for name, one in zip(names, materials, strict=True):
        for measure, estimate in ((t("difference"), one.plain), (t("weighted"), one.weighted)):
            for column, component in enumerate((t("red"), t("green"), t("blue"))):
                rows.append([name, measure, str(estimate.n), component, t.number(estimate.mean[column]), t.interval(estimate.low[column], estimate.high[column]),
                             t.number(estimate.deviation[column])])
    notes = [t("comfort_rule")] + [t("effect" if one.effect else "no_effect", name=name, p=t.p_value(one.p_value)) for name, one in zip(names, materials, strict=True)]
    if any(comfort.ratings_before(document, one.step) is None for one in materials):
        notes.insert(1, t("no_rating"))
    table = _table(t("table1"), [t("material"), t("measure"), t("n"), t("channel"), t("mean"), t("interval"), t("deviation")], rows)
    return [_section("comfort", t("comfort"), notes, [table], [("figure-20", t("figure20"), figures.figure_20(materials, t, names)),
                                                               ("figure-21", t("figure21"), figures.figure_21(materials, t, names))])]


def _validation(document: dict[str, Any], t: Texts) -> list[Section]:
    from . import intervals

    sections = []
    for found in comfort.orderings(document):
        rows = []
        for name, value, count in found.pictures:
            rows.append([f"{name} ({value:+d})".replace("-2)", "−2)").replace("-1)", "−1)"), t("below" if value < 0 else "above"), f"{count} / {found.n}",
                         t.percent(count / found.n if found.n else float("nan")), t.share_interval(*intervals.share(count, found.n))])
        for side, one in found.sides.items():
            rows.append([t("average"), t("below" if side < 0 else "above"), "", t.percent(float(one.mean[0])),
                         t.share_interval(max(float(one.low[0]), 0), min(float(one.high[0]), 1)) if one.low[0] == one.low[0] else "–"])
        sections.append(_section(f"validation-{found.step}", t("validation"), [t("validation_rule")],
                                 [_table(t("validation"), [t("picture"), t("expected"), t("agreed"), t("share"), t("interval")], rows)]))
    return sections


def _viewpoints(document: dict[str, Any]) -> list[tuple[dict[str, Any], viewpoints.Result | None]]:
    found = [(step, viewpoints.views_of(document, step)) for step in export.steps(document, "viewpoint")]
    return [(step, viewpoints.analyse(step["id"], views) if views is not None else None) for step, views in found]


def _viewpoint(step: dict[str, Any], result: viewpoints.Result | None, t: Texts) -> Section:
    region = ((step.get("view") or {}).get("region") or {}).get("name")
    title, name = t("viewpoint", name=export.text(region, t.language) or t("whole")), f"viewpoint-{step['id']}"
    if result is None or len(result.kept) < viewpoints.FEWEST:
        return _section(name, title, [t("too_few", n=viewpoints.FEWEST)])
    away = sorted(set(range(len(result.views.numbers))) - set(result.kept.tolist()))
    notes = [t("outliers", list=", ".join(str(result.views.numbers[i]) for i in away)) if away else t("no_outliers")]
    notes.append(t("several", k=len(result.clusters), p=t.p_value(result.p_several)) if result.several
                 else t("one", p=t.p_value(result.p_one)) if result.clusters else t("none"))
    drawn = [("figure-25", t("figure25"), figures.figure_25(result, t)), ("figure-27", t("figure27"), figures.figure_27(result, t))]
    if result.several:
        drawn.insert(1, ("figure-26", t("figure26"), figures.figure_26(result, t)))
    rows = []
    for number, one in enumerate(result.clusters, 1):
        azimuth, elevation = figures.angles_of(one.direction[None])
        rows.append([str(number), str(len(one.members)), f"{t.number(azimuth[0])}°", f"{t.number(elevation[0])}°", t.number(one.distance, 1), f"{t.number(one.spread)}°"])
    columns = [t("view"), t("n"), t("azimuth"), t("elevation"), t("distance"), t("spread")]
    return _section(name, title, notes, [_table(t("canonical"), columns, rows)] if rows else [], drawn)


def _latency(document: dict[str, Any], t: Texts) -> list[Section]:
    from . import intervals

    sections = []
    for step in export.steps(document, "latency"):
        found = latency.analyse(document, step["id"])
        if found is None:
            continue
        rows = []
        for i, delay in enumerate(found.delays):
            a, n = int(found.accepted[i]), int(found.trials[i])
            rows.append([t.number(delay), str(n), f"{t.percent(a / n)} {t.share_interval(*intervals.share(a, n))}",
                         *(f"{t.number(one.mean[0], 1)} {t.interval(one.low[0], one.high[0], 1)}" for one in (found.ratings[i], found.seconds[i], found.errors[i]))])
        tables = [_table(t("by_delay"), [t("delay"), t("n"), t("accepted"), t("rating"), t("seconds"), t("error")], rows)]
        notes = [t("latency_rule")]

        def delay_text(value: float, longest: float = found.delays[-1]) -> str:
            return t.number(value) if np.isfinite(value) else t("beyond", value=t.number(longest))

        if found.thresholds:
            tables.insert(0, _table(t("thresholds"), [t("threshold"), t("delay"), t("interval")],
                                    [[t("accepts", share=t.percent(share)), delay_text(value), f"[{delay_text(low)}; {delay_text(high)}]"]
                                     for share, (value, low, high) in found.thresholds.items()]))
        else:
            notes.append(t("no_threshold", p=t.p_value(found.p_value)))
        sections.append(_section(f"latency-{step['id']}", t("latency"), notes, tables, [(f"latency-{step['id']}", t("by_delay"), figures.figure_latency(found, t))]))
    return sections


def _sus(document: dict[str, Any], t: Texts) -> list[Section]:
    from . import intervals

    if not answers.is_sus(document) or not len(scores := answers.sus_scores(document)):
        return []
    one = intervals.means(scores)
    row = [str(one.n), t.number(one.mean[0], 1), t.interval(one.low[0], one.high[0], 1), t.number(one.deviation[0], 1)]
    return [_section("sus", t("sus"), [], [_table(t("sus"), [t("n"), t("score"), t("interval"), t("deviation")], [row])],
                     [("sus", t("score"), figures.figure_sus(scores, t))])]


def _ratings(document: dict[str, Any], t: Texts) -> list[Section]:
    rows = []
    for step in export.steps(document, "rating"):
        one = answers.rating(document, step["id"])
        if one.n:
            rows.append([_name(step, t), f"{step['low']}–{step['high']}", str(one.n), t.number(one.mean[0], 1), t.interval(one.low[0], one.high[0], 1),
                         t.number(one.deviation[0], 1)])
    columns = [t("question"), t("range"), t("n"), t("mean"), t("interval"), t("deviation")]
    return [_section("ratings", t("questions"), [], [_table(t("questions"), columns, rows)])] if rows else []


def _choices(document: dict[str, Any], t: Texts) -> list[Section]:
    tables = []
    for step in export.steps(document, "choice"):
        found = answers.choices(document, step)
        rows = [[export.text(one.option, t.language), f"{one.count} / {one.n}", t.percent(one.count / one.n), t.share_interval(*one.interval)] for one in found if one.n]
        if rows:
            tables.append(_table(_name(step, t), [t("option"), t("count"), t("share"), t("interval")], rows))
    return [_section("choices", t("choice"), [], tables)] if tables else []


def _words(document: dict[str, Any], t: Texts) -> list[Section]:
    tables = []
    for step in export.steps(document, "words"):
        if given := answers.words(document, step["id"]):
            tables.append(_table(_name(step, t), [t("participant"), t("answer")], [[str(number), text] for number, text in given]))
    return [_section("words", t("words"), [], tables)] if tables else []
