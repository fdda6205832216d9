"""Crowds of simulated participants with a known answer. They show that the analysis finds what is there, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import expit

from .viewpoints import unit

#: As many as in section 6.1 of the thesis, and in the validation of 6.1.3.
PARTICIPANTS, VALIDATORS = 43, 16
CENTRE, RADIUS = np.array([12.0, -30.0, 140.0]), 45.0


@dataclass(frozen=True)
class Published:
    """A material of Table 1 of the thesis. With the reference #fb0404 of the vessels, red could not change by +36, so that the
    simulated vessels are darker.
    """

    channel: str
    name: dict[str, str]
    reference: tuple[int, int, int]
    mean: tuple[float, float, float]
    deviation: tuple[float, float, float]
    weighted: tuple[float, float, float]


TABLE_1 = (Published("bone", {"en": "Bone", "de": "Knochen"}, (0xE8, 0xBA, 0x94), (-24, 5, 7), (55, 50, 67), (-30, 7, 6)),
           Published("vessels", {"en": "Vessels", "de": "Gefäße"}, (0x8C, 0x04, 0x04), (36, 20, 29), (62, 29, 53), (34, 21, 32)))
#: Probabilities of the ratings from 0 to 10.
RATINGS = np.array([1, 3, 7, 10, 13, 16, 17, 14, 10, 6, 3]) / 100


def document(template: str, title: str, steps: list[dict[str, Any]], people: list[dict[str, Any]]) -> dict[str, Any]:
    """Returns an export. `people` holds the answers of each participant by the ids of the steps."""
    kinds = {step["id"]: step["kind"] for step in steps}
    participants = [{"number": number, "language": ("en", "de")[number % 2], "seed": number, "state": "finished", "day": "2026-11-28", "recorded": False,
                     "answers": [{"step": step, "kind": kinds[step], "value": value, "duration_ms": 20_000} for step, value in answers.items()],
                     "recordings": []} for number, answers in enumerate(people, 1)]
    definition = {"version": 1, "template": template, "title": {"en": title}, "places": len(people), "ends_at": "2026-12-31T00:00:00Z", "record": False,
                  "steps": [{"id": "consent", "kind": "consent", "group": "", "text": {"en": "You may stop at any time."}}, *steps]}
    return {"format": "diaphane-study", "version": 1, "participants": participants,
            "study": {"id": "simulated", "definition": definition, "opened_at": "2026-11-28T08:00:00Z", "closed_at": None, "withdrawn": 0}}


def _step(name: str, kind: str, **fields: Any) -> dict[str, Any]:
    return {"id": name, "kind": kind, "group": "", "text": {"en": name}, **fields}


def _rating(name: str, low: int, high: int) -> dict[str, Any]:
    return _step(name, "rating", low=low, high=high, low_text={"en": "low"}, high_text={"en": "high"})


# Comfort

def _differences(material: Published, weights: np.ndarray, expected: float, variance: float, rng: np.random.Generator) -> np.ndarray:
    """Draws differences with the means and deviations of Table 1 from beta distributions between black and full colour. They
    depend on the weights such that the weighted means are those of Table 1, too.
    """
    columns = []
    for reference, mean, deviation, weighted in zip(material.reference, material.mean, material.deviation, material.weighted, strict=True):
        slope = (weighted - mean) * expected / variance
        share = (reference + mean + slope * (weights - expected)) / 255
        size = share * (1 - share) / ((deviation ** 2 - slope ** 2 * variance) / 255 ** 2) - 1
        columns.append(np.rint(255 * rng.beta(share * size, (1 - share) * size)) - reference)
    return np.column_stack(columns)


def comfort(rng: np.random.Generator, n: int = PARTICIPANTS, effect: bool = True) -> dict[str, Any]:
    """Returns a crowd with the distributions of Table 1, or one in which everybody keeps about the same colours."""
    from .comfort import weights_of

    known = weights_of(np.arange(11.0))
    expected, variance = float(RATINGS @ known), float(RATINGS @ known ** 2 - (RATINGS @ known) ** 2)
    ratings = rng.choice(11, n, p=RATINGS)
    people: list[dict[str, Any]] = [{"rating": {"rating": int(one)}, "colours": {"colours": []}} for one in ratings]
    for material in TABLE_1:
        differences = (_differences(material, weights_of(ratings.astype(float)), expected, variance, rng) if effect
                       else np.clip(np.rint(rng.normal(0, 1.5, (n, 3))), -4, 4))
        for one, difference in zip(people, differences, strict=True):
            to = np.clip(np.array(material.reference) + difference, 0, 255).astype(int)
            one["colours"]["colours"].append({"channel": material.channel, "from": "#{:02x}{:02x}{:02x}".format(*material.reference), "to": "#{:02x}{:02x}{:02x}".format(*to)})
    steps = [_rating("rating", 0, 10), _step("colours", "colours", materials=[{"channel": one.channel, "name": one.name} for one in TABLE_1])]
    return document("comfort", "Simulated comfort", steps, people)


def validation(rng: np.random.Generator, n: int = VALIDATORS, agreeing: tuple[float, float] = (0.63, 0.59)) -> dict[str, Any]:
    """Returns a crowd in which each picture is placed on its side of the reference with these probabilities: below, above."""
    comforts = (-2, -1, 0, 1, 2)
    names = [f"picture-{i + 1}" for i in range(5)]
    people = []
    for _ in range(n):
        places = {names[2]: 0.0}
        for name, value in zip(names, comforts, strict=True):
            if value:
                right = rng.random() < agreeing[int(value > 0)]
                places[name] = (value if right else -value) + rng.normal(0, 0.1)
        people.append({"order": {"order": sorted(places, key=places.__getitem__), "shown": [str(one) for one in rng.permutation(names)]}})
    return document("validation", "Simulated validation", [_step("order", "order", pictures=[{"id": a, "comfort": b} for a, b in zip(names, comforts, strict=True)])], people)


# Viewpoints

def near(direction: np.ndarray, degrees: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """Draws directions about one. Their deviation is the same along both axes across it."""
    tangent = rng.normal(size=(n, 3)) * np.radians(degrees)
    return unit(direction + tangent - (tangent @ direction)[:, None] * direction)


def _apart(k: int, degrees: float, rng: np.random.Generator) -> np.ndarray:
    """Draws k directions that are at least this far from each other."""
    while True:
        chosen = unit(rng.normal(size=(k, 3)))
        angles = np.degrees(np.arccos(np.clip(chosen @ chosen.T, -1, 1)))
        if angles[~np.eye(k, dtype=bool)].min(initial=180) >= degrees:
            return chosen


def _viewpoints(directions: np.ndarray, distances: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:
    people = []
    for direction, distance in zip(directions, distances, strict=True):
        eyes = [CENTRE + RADIUS * distance * direction, CENTRE + RADIUS * 6 * unit(rng.normal(size=3))]
        camera, start = ({"eye": eye.tolist(), "target": CENTRE.tolist(), "up": [0.0, 0.0, 1.0]} for eye in eyes)
        people.append({"viewpoint": {"camera": camera, "start": start}})
    view = {"data_set_id": "ds-simulated", "region": {"name": {"en": "Knee", "de": "Knie"}, "centre": CENTRE.tolist(), "radius": RADIUS}}
    return document("viewpoints", "Simulated viewpoints", [_step("viewpoint", "viewpoint", view=view)], people)


@dataclass(frozen=True)
class Planted:
    """Directions of the planted clusters, and the numbers of the participants whose views are planted outliers."""

    centres: np.ndarray
    outliers: frozenset[int]


def viewpoints(rng: np.random.Generator, n: int = PARTICIPANTS, k: int | None = None, outliers: int = 2) -> tuple[dict[str, Any], Planted]:
    """Returns a crowd with 3 to 5 clusters that are 60° apart, with a deviation of 8° to 12° and at least five views each, and some
    views from eight times as far away. These are at least 90° apart, because the thesis keeps views that two participants share.
    """
    k = k or int(rng.integers(3, 6))
    centres = _apart(k, 60, rng)
    sizes = 5 + rng.multinomial(n - outliers - 5 * k, rng.dirichlet(np.full(k, 2.0)))
    directions = np.vstack([*(near(one, rng.uniform(8, 12), size, rng) for one, size in zip(centres, sizes, strict=True)), _apart(outliers, 90, rng)])
    distances = np.exp(rng.normal(np.log(4), 0.15, n))
    distances[n - outliers:] *= 8
    order = rng.permutation(n)
    return _viewpoints(directions[order], distances[order], rng), Planted(centres, frozenset(int(i) + 1 for i in np.flatnonzero(order >= n - outliers)))


#: Crowds without several views: everybody at random, everybody about one view, and everybody around the body.
NOISE: dict[str, Callable[[int, np.random.Generator], np.ndarray]] = {
    "uniform": lambda n, rng: unit(rng.normal(size=(n, 3))),
    "one view": lambda n, rng: near(unit(rng.normal(size=3)), rng.uniform(10, 35), n, rng),
    "around": lambda n, rng: unit(np.column_stack([*(lambda angle: (np.cos(angle), np.sin(angle)))(rng.uniform(0, 2 * np.pi, n)), rng.normal(0, 0.2, n)])),
}


def noise(kind: str, rng: np.random.Generator, n: int = PARTICIPANTS) -> dict[str, Any]:
    return _viewpoints(NOISE[kind](n, rng), np.exp(rng.normal(np.log(4), 0.3, n)), rng)


# Latency

DELAYS = (0, 50, 100, 150, 200, 300, 400)
THRESHOLD, BETWEEN, SCALE, LAPSE = 160.0, 45.0, 25.0, 0.02


def accepting(delays: np.ndarray | float, thresholds: np.ndarray | float) -> np.ndarray:
    """Returns the probabilities with which participants accept delays."""
    return LAPSE / 2 + (1 - LAPSE) * expit((thresholds - delays) / SCALE)


def latency(rng: np.random.Generator, n: int = PARTICIPANTS) -> dict[str, Any]:
    """Returns a crowd in which half accept 160 ms: a delay is accepted by a logistic function whose threshold differs between
    participants.
    """
    people = []
    for _ in range(n):
        own = THRESHOLD + rng.normal(0, BETWEEN)
        trials = []
        for delay in rng.permutation(DELAYS):
            accepted = bool(rng.random() < accepting(delay, own))
            trials.append({"delay_ms": int(delay), "time_ms": int(4000 * np.exp(rng.normal(delay / 800, 0.35))), "error_degrees": round(float(rng.gamma(2, 4)), 2),
                           "acceptable": accepted, "rating": int(np.clip(np.rint(9 - delay / 60 + rng.normal(0, 1.3)), 0, 10))})
        people.append({"latency": {"trials": trials}})
    return document("latency", "Simulated latency", [_step("latency", "latency", delays_ms=list(DELAYS))], people)


# Questions

def sus(rng: np.random.Generator, n: int = PARTICIPANTS) -> dict[str, Any]:
    """Returns a crowd that answers the System Usability Scale, one choice and one question in words."""
    people = []
    for _ in range(n):
        liking = rng.normal(0.8, 0.6)
        one: dict[str, Any] = {f"sus-{i}": {"rating": int(np.clip(np.rint(3 + (liking if i % 2 else -liking) + rng.normal(0, 0.7)), 1, 5))} for i in range(1, 11)}
        one["device"] = {"choice": [str(rng.choice(["phone", "desktop"], p=[0.3, 0.7]))]}
        one["remarks"] = {"words": "I could turn it at once."}
        people.append(one)
    options = [{"id": "phone", "text": {"en": "A phone", "de": "Ein Telefon"}}, {"id": "desktop", "text": {"en": "A computer", "de": "Ein Computer"}}]
    steps = [*(_rating(f"sus-{i}", 1, 5) for i in range(1, 11)), _step("device", "choice", options=options, multiple=False), _step("remarks", "words")]
    return document("sus", "Simulated questions", steps, people)


CROWDS: dict[str, Callable[[np.random.Generator, int], dict[str, Any]]] = {
    "comfort": comfort, "validation": validation, "viewpoints": lambda rng, n: viewpoints(rng, n)[0], "noise": lambda rng, n: noise("uniform", rng, n),
    "latency": latency, "sus": sus}
