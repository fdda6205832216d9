"""Ratings, choices, words, and the score of the System Usability Scale (Brooke 1996)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import export, intervals
from .intervals import Estimate

SUS = [f"sus-{i}" for i in range(1, 11)]


@dataclass(frozen=True)
class Choice:
    option: dict[str, str]
    count: int
    n: int
    interval: tuple[float, float]


def is_sus(document: dict[str, Any]) -> bool:
    ratings = {step["id"]: (step["low"], step["high"]) for step in export.steps(document, "rating")}
    return all(ratings.get(name) == (1, 5) for name in SUS)


def sus_scores(document: dict[str, Any]) -> np.ndarray:
    """Returns the scores from 0 to 100 of the participants who answered all ten statements."""
    given = [export.answers(document, name) for name in SUS]
    whole = set.intersection(*(set(one) for one in given))
    # Odd statements are in favour, even ones are against.
    return np.array([2.5 * sum(one[number]["rating"] - 1 if i % 2 == 0 else 5 - one[number]["rating"] for i, one in enumerate(given))
                     for number in sorted(whole)])


def rating(document: dict[str, Any], step: str) -> Estimate:
    return intervals.means(np.array([value["rating"] for value in export.answers(document, step).values()], float))


def choices(document: dict[str, Any], step: dict[str, Any]) -> list[Choice]:
    given = list(export.answers(document, step["id"]).values())
    counts = {option["id"]: sum(option["id"] in value["choice"] for value in given) for option in step["options"]}
    return [Choice(option["text"], counts[option["id"]], len(given), intervals.share(counts[option["id"]], len(given))) for option in step["options"]]


def words(document: dict[str, Any], step: str) -> list[tuple[int, str]]:
    return [(number, value["words"].strip()) for number, value in sorted(export.answers(document, step).items()) if value["words"].strip()]
