"""Looking around by mouse, by keys and by touch, on the pictures that come back."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Callable

from playwright.sync_api import expect

from fingers import Fingers
from harness import TestStack
from picture import SIDE, difference
from test_in_picture import middle, open_viewer
from test_settings import Hands


def seen(picture: bytes) -> tuple[float, float, float]:
    """What part of the picture is not background, and its middle in pixels of SIDE."""
    ground = picture[:3]
    places = [(n % SIDE, n // SIDE) for n in range(SIDE * SIDE) if max(abs(picture[3 * n + c] - ground[c]) for c in range(3)) > 12]
    count = max(1, len(places))
    return len(places) / SIDE / SIDE, sum(x for x, _ in places) / count, sum(y for _, y in places) / count


class Eye:
    """The camera of the scene that the page keeps."""

    def __init__(self, hands: Hands):
        camera = json.loads(hands.kept()[0])["camera"]
        self.eye, self.target, self.up = ([camera.get(name, {}).get(axis, 0.0) for axis in "xyz"] for name in ("eye", "target", "up"))

    @property
    def away(self) -> list[float]:
        return [a - b for a, b in zip(self.eye, self.target, strict=True)]

    @property
    def distance(self) -> float:
        return math.hypot(*self.away)

    def turned(self, other: Eye) -> float:
        """Degrees between the ways in which the two look."""
        dot = sum(a * b for a, b in zip(self.away, other.away, strict=True)) / self.distance / other.distance
        return math.degrees(math.acos(max(-1, min(1, dot))))

    def moved(self, other: Eye) -> float:
        return math.dist(self.target, other.target)

    def rolled(self, other: Eye) -> float:
        return math.dist(self.up, other.up)


def settled(hands: Hands) -> None:
    """What the page keeps, it keeps a moment later than it is."""
    def still() -> bool:
        before = hands.kept()
        hands.page.wait_for_timeout(300)
        return hands.kept() == before

    hands.stack.wait_until(still, what="a scene that stays")


def looked(hands: Hands, deed: Callable[[], None]) -> tuple[Eye, Eye, bytes, bytes]:
    """Eye and picture before and after."""
    before, picture = Eye(hands), hands.picture()
    hands.act(deed)
    settled(hands)
    return before, Eye(hands), picture, hands.picture()


def is_turn(hands: Hands, deed: Callable[[], None]) -> None:
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) > 4 and after.moved(before) < 1e-3 and abs(after.distance / before.distance - 1) < 1e-6
    assert difference(old, new) > 1, difference(old, new)


def is_pan(hands: Hands, deed: Callable[[], None]) -> None:
    """To the right."""
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) < 1e-3 and after.moved(before) > 4
    assert seen(new)[1] - seen(old)[1] > 1.5, (seen(old), seen(new))


def is_zoom(hands: Hands, deed: Callable[[], None], nearer: bool) -> None:
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) < 1e-3 and abs(math.log(after.distance / before.distance)) > 0.05
    assert (after.distance < before.distance) == nearer == (seen(new)[0] > seen(old)[0]), (before.distance, after.distance, seen(old), seen(new))


def is_roll(hands: Hands, deed: Callable[[], None]) -> None:
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) < 1e-3 and after.rolled(before) > 0.05
    assert difference(old, new) > 0.5, difference(old, new)


def is_home(hands: Hands, deed: Callable[[], None], home: Eye) -> None:
    _, after, _, _ = looked(hands, deed)
    assert after.moved(home) < 1e-3 and after.turned(home) < 1e-3 and after.rolled(home) < 1e-3 and abs(after.distance / home.distance - 1) < 1e-6


def test_one_looks_around_by_mouse_by_keys_and_by_touch(stack: TestStack, visit, cranium: Path):
    page = visit(small=True, touch=True)
    hands = open_viewer(stack, page, cranium, "manon", 480, 400)
    page.get_by_role("button", name="Hide the hints").click()
    home = Eye(hands)
    canvas = page.locator("canvas")
    x, y = middle(canvas.bounding_box())
    y -= 30  # above the looks

    def drag(right: float, down: float, button: str = "left", key: str = "") -> Callable[[], None]:
        def deed() -> None:
            if key:
                page.keyboard.down(key)
            page.mouse.move(x, y)
            page.mouse.down(button=button)
            page.mouse.move(x + right, y + down, steps=6)
            page.mouse.up(button=button)
            if key:
                page.keyboard.up(key)
        return deed

    def wheel() -> None:
        page.mouse.move(x, y)
        page.mouse.wheel(0, -240)

    is_turn(hands, drag(60, 0))
    is_pan(hands, drag(40, 0, key="Shift"))
    is_pan(hands, drag(40, 0, button="middle"))
    is_zoom(hands, wheel, nearer=True)
    is_zoom(hands, drag(0, 60, button="right"), nearer=False)
    is_roll(hands, drag(60, 0, key="Control"))
    is_home(hands, page.get_by_role("button", name="Reset the view").click, home)

    def keys(*names: str) -> Callable[[], None]:
        def deed() -> None:
            for name in names:
                page.keyboard.press(name)
        return deed

    canvas.focus()
    is_turn(hands, keys("ArrowRight"))
    is_pan(hands, keys(*["Shift+ArrowRight"] * 3))
    is_zoom(hands, keys("+", "+", "+"), nearer=True)
    is_zoom(hands, keys("-", "-"), nearer=False)
    is_roll(hands, keys(*["Control+ArrowRight"] * 3))
    is_home(hands, keys("r"), home)

    fingers = Fingers(page)
    is_turn(hands, lambda: fingers.drag([((x, y), (x + 60, y))]))
    is_pan(hands, lambda: fingers.drag([((x - 40, y), (x, y)), ((x + 40, y), (x + 80, y))]))
    is_zoom(hands, lambda: fingers.drag([((x - 30, y), (x - 60, y)), ((x + 30, y), (x + 60, y))]), nearer=True)
    is_home(hands, page.get_by_role("button", name="Reset the view").tap, home)

    # The looks: by hand, by a finger, by a digit.
    for choose, name in ((lambda: page.locator("[data-preset=bone]").click(), "bone"), (lambda: page.locator("[data-preset=muscle]").tap(), "muscle"),
                         (lambda: page.keyboard.press("1"), "skin")):
        old = hands.picture()
        hands.act(choose)
        expect(page.locator(f"[data-preset={name}]")).to_have_attribute("aria-pressed", "true")
        assert difference(old, hands.picture()) > 2
    # And the tools beside.
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    canvas.focus()
    page.keyboard.press("f")
    page.wait_for_function("document.fullscreenElement !== null")
    page.keyboard.press("f")
    page.wait_for_function("document.fullscreenElement === null")
