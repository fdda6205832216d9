"""The judgement of pictures that `./diaphane bench looks` makes."""

from __future__ import annotations

import numpy as np
from devtool.benches.support.picture_judge import judge, subject_in


def subject(height: int, width: int) -> np.ndarray:
    """A rectangle in the middle of a picture of 100 by 100 pixels."""
    inside = np.zeros((100, 100), bool)
    top, left = (100 - height) // 2, (100 - width) // 2
    inside[top:top + height, left:left + width] = True
    return inside


def faults(inside: np.ndarray, burnt: float = 0, black: float = 0) -> list[str]:
    picture = np.full((100, 100, 3), 120, np.uint8)
    pixels = np.argwhere(inside)
    picture[tuple(pixels[:round(burnt * len(pixels))].T)] = 255
    picture[tuple(pixels[len(pixels) - round(black * len(pixels)):].T)] = 3
    return judge("scan", "skin", picture, inside).faults()


def test_a_good_picture_has_no_fault():
    assert faults(subject(70, 40)) == []
    assert faults(subject(40, 70)) == []
    assert faults(subject(60, 60), burnt=0.004, black=0.04) == []


def test_burnt_out_and_black_pixels_are_faults_only_in_the_subject():
    assert faults(subject(60, 60), burnt=0.01) == ["1.0% burnt out"]
    assert faults(subject(60, 60), black=0.06) == ["6.0% black"]
    outside = np.zeros((100, 100, 3), np.uint8)
    outside[subject(60, 60)] = 120
    assert judge("scan", "skin", outside, subject(60, 60)).faults() == []


def test_a_subject_fills_at_least_half_of_the_picture():
    assert faults(subject(40, 40)) == ["fills 40%"]
    assert faults(subject(95, 60)) == ["fills 95%"]
    assert faults(np.zeros((100, 100), bool)) == ["fills 0%"]


def test_the_subject_is_what_differs_from_the_background():
    across = np.linspace(-1, 1, 100) ** 2
    picture = np.tile(0.03 - 0.01 * (across[:, None] + across[None, :]), (3, 1, 1))
    expected = subject(60, 40)
    picture[0, expected] = 0.05
    assert np.array_equal(subject_in(picture), expected)
