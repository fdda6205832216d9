"""Section 6.1 of the thesis: which colours are more comfortable, and whether others agree."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import export, intervals
from .intervals import Estimate

#: The probability of adopting a difference of any material that has none.
SIGNIFICANCE = 0.01
#: Ratings of 0 and 1 have the same weight, because the inverse of 0 does not exist.
LEAST_RATING = 1
#: Channels of the looks by the material that the page's comfort slider changes.
ADOPTED = {"bone": ("bone", "spongy bone", "enamel"), "blood": ("blood", "vessels", "veins", "arteries", "muscle")}


@dataclass(frozen=True)
class Material:
    """The colours that participants gave one channel. Differences are in steps of sRGB (0 to 255)."""

    step: str
    channel: str
    name: dict[str, str]
    reference: np.ndarray
    plain: Estimate
    weighted: Estimate
    p_value: float
    effect: bool = False

    def colour(self, times: float) -> np.ndarray:
        """Returns the reference plus the weighted difference this many times, within the range of colours."""
        return np.clip(self.reference + times * self.weighted.mean, 0, 255)


@dataclass(frozen=True)
class Ordering:
    """How often pictures were placed on the side of the reference where their comfort belongs."""

    step: str
    pictures: list[tuple[str, int, int]] = field(default_factory=list)    # id, comfort, number of participants who agreed
    n: int = 0
    sides: dict[int, Estimate] = field(default_factory=dict)              # -1 and 1: share of the pictures of this side


def rgb(colour: str) -> np.ndarray:
    return np.array([int(colour[i:i + 2], 16) for i in (1, 3, 5)], float)


def ratings_before(document: dict[str, Any], step: str) -> dict[int, float] | None:
    """Returns the ratings of the last rating step before a step, or None if there is none."""
    found = None
    for one in export.steps(document):
        if one["id"] == step:
            break
        found = one["id"] if one["kind"] == "rating" else found
    return None if found is None else {number: value["rating"] for number, value in export.answers(document, found).items()}


def weights_of(ratings: np.ndarray) -> np.ndarray:
    return 1 / np.maximum(ratings, LEAST_RATING)


def materials(document: dict[str, Any], rng: np.random.Generator | None = None) -> list[Material]:
    found = []
    for step in export.steps(document, "colours"):
        answers = export.answers(document, step["id"])
        ratings = ratings_before(document, step["id"])
        for material in step["materials"]:
            chosen = {number: one for number, value in answers.items() for one in value["colours"]
                      if one["channel"] == material["channel"] and (ratings is None or number in ratings)}
            if not chosen:
                continue
            differences = np.array([rgb(one["to"]) - rgb(one["from"]) for one in chosen.values()])
            weights = weights_of(np.array([ratings[number] for number in chosen], float)) if ratings else np.ones(len(chosen))
            found.append(Material(step["id"], material["channel"], material["name"],
                                  np.mean([rgb(one["from"]) for one in chosen.values()], axis=0),
                                  intervals.means(differences, rng=rng), intervals.means(differences, weights, rng=rng),
                                  intervals.hotelling(differences, weights)))
    effects = intervals.holm([one.p_value for one in found], SIGNIFICANCE)
    return [Material(**{**one.__dict__, "effect": effect}) for one, effect in zip(found, effects, strict=True)]


def adoptable(found: list[Material]) -> dict[str, list[float]] | None:
    """Returns the differences for the page's comfort slider, if bone and blood both have an effect."""
    made = {}
    for name, channels in ADOPTED.items():
        fitting = [one for channel in channels for one in found if one.channel.lower() == channel]
        if not fitting or not fitting[0].effect:
            return None
        made[name] = [round(float(value), 1) for value in fitting[0].weighted.mean]
    return made


def orderings(document: dict[str, Any], rng: np.random.Generator | None = None) -> list[Ordering]:
    found = []
    for step in export.steps(document, "order"):
        comfort = {one["id"]: one["comfort"] for one in step["pictures"]}
        reference = next((name for name, value in comfort.items() if value == 0), None)
        if reference is None:
            continue
        orders = [value["order"] for value in export.answers(document, step["id"]).values()]
        agreed = {name: np.array([(order.index(name) > order.index(reference)) == (value > 0) for order in orders], float)
                  for name, value in comfort.items() if value != 0}
        sides = {side: intervals.means(np.mean([agreed[name] for name in agreed if comfort[name] * side > 0], axis=0), rng=rng)
                 for side in (-1, 1) if orders and any(comfort[name] * side > 0 for name in agreed)}
        pictures = sorted(((name, comfort[name], int(row.sum())) for name, row in agreed.items()), key=lambda one: one[1])
        found.append(Ordering(step["id"], pictures, len(orders), sides))
    return found
