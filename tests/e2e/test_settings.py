"""The windows in which a user changes the picture, checked on the resulting pictures."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Callable

import pytest
from playwright.sync_api import Locator, Page, expect

from harness import TestStack
from person import Person
from picture import COMPARED_ERROR, FINE_ERROR, SIDE, kept_view, pixels, spread, wait_for_picture, wait_for_samples


class Hands:
    """A user of the windows of one picture."""

    def __init__(self, stack: TestStack, page: Page):
        self.stack, self.page = stack, page

    def window(self, name: str) -> Locator:
        frame = self.page.get_by_role("dialog", name=name, exact=True)
        # The menu appears together with the windows that this tab remembers, one of which the button would close.
        expect(self.page.locator("[data-opens]").first).to_be_attached()
        if frame.count() == 0:
            self.page.get_by_role("button", name=name, exact=True).click()
        return frame

    def kept(self) -> tuple[str, int]:
        """Returns the scene that the page would show after a reload, and the number of its input."""
        view = kept_view(self.page)
        return view.get("scene") or "", view.get("input_seq", 0)

    def act(self, deed: Callable[[], None]) -> None:
        """Waits until the page has another scene."""
        before = self.kept()[0]
        deed()

        def changed() -> bool:
            self.page.wait_for_timeout(50)
            return self.kept()[0] != before

        self.stack.wait_until(changed, what="another scene")

    def settle(self) -> None:
        """Waits until nothing is pending."""
        def still() -> bool:
            before = self.kept()
            self.page.wait_for_timeout(300)
            return self.kept() == before

        self.stack.wait_until(still, what="a scene that stays")

    def write(self, frame: Locator, label: str, text: str) -> None:
        field = frame.get_by_label(f"{label} (value)")
        field.fill(text)
        field.press("Enter")

    def type(self, frame: Locator, label: str, text: str) -> None:
        self.act(lambda: self.write(frame, label, text))

    def picture(self, error: float = COMPARED_ERROR) -> bytes:
        """Returns the picture of the current scene."""
        wait_for_picture(self.stack, self.page, input_seq=self.kept()[1], error=error)
        return pixels(self.page)


#: Brighter than the looks' background, which fades from its middle (about 60 of 255) to the corners.
GROUND = 70


def halves(picture: bytes) -> tuple[float, float]:
    """Returns how much brighter than the background the left and the right half are, as means over their pixels and colours."""
    sums = [0, 0]
    for at, value in enumerate(picture):
        if value > GROUND:
            sums[at // 3 % SIDE >= SIDE // 2] += value - GROUND
    return sums[0] / (SIDE * SIDE * 1.5), sums[1] / (SIDE * SIDE * 1.5)


def look_from_the_front(hands: Hands) -> None:
    """Turns the picture from the looks' view (25 degrees to the patient's left, 10 from above) to a level one from the front, in
    which a cut through the patient's middle is a vertical line."""
    picture = hands.page.locator("canvas")
    for key, times in (("ArrowRight", 5), ("ArrowUp", 2)):
        for _ in range(times):
            hands.act(lambda: picture.press(key))
    camera = json.loads(hands.kept()[0])["camera"]
    x, y, z = (camera["eye"].get(axis, 0) - camera["target"].get(axis, 0) for axis in "xyz")
    assert y < 0 and math.hypot(x, z) < 0.01 * abs(y), camera


@pytest.mark.nightly
def test_every_settings_panel_changes_the_picture_and_can_be_undone(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    person = Person.arrives(stack, page, "wilma")
    scan = person.has_scan(cranium, "Head")
    page.set_viewport_size({"width": 720, "height": 440})  # the smallest size at which windows are not sheets
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 1)
    hands = Hands(stack, page)
    stack.wait_until(lambda: hands.kept()[0], what="the first scene")
    begun = hands.kept()[0]
    undo = page.get_by_role("button", name="Undo", exact=True)
    expect(undo).to_have_attribute("aria-disabled", "true")

    # A single light, far to the left, then to the right.
    light = hands.window("Light")
    for name in ("Rim light", "Surrounding light"):
        hands.act(lambda: light.get_by_label(f"Turn on {name}").uncheck())
    light.get_by_text("More", exact=True).click()
    hands.type(light, "Angle to the right", "-80")
    hands.type(light, "Angle upwards", "0")
    left, right = halves(hands.picture())
    assert left > 1.3 * right, (left, right)
    lit_left = hands.kept()[0]
    hands.type(light, "Angle to the right", "80")
    left, right = halves(hands.picture())
    assert right > 1.3 * left, (left, right)
    page.screenshot(path=pictures / "lit-from-the-right.png")
    hands.act(undo.click)
    assert hands.kept()[0] == lit_left
    left, right = halves(hands.picture())
    assert left > 1.3 * right, (left, right)

    # Invalid values are refused with a message, and nothing changes.
    for typed in ("far", "999", ""):
        hands.write(light, "Angle upwards", typed)
        expect(light.get_by_role("alert")).to_have_text("Enter a value between −90° and 90°.")
    light.get_by_label("Angle upwards (value)").press("Escape")
    expect(light.get_by_role("alert")).to_have_count(0)
    assert hands.kept()[0] == lit_left
    hands.act(light.get_by_role("button", name="Reset the light").click)
    assert hands.kept()[0] == begun

    # Clipping keeps only the patient's left half, on the right of the picture.
    look_from_the_front(hands)
    cuts = hands.window("Cuts and slices")
    hands.type(cuts, "Patient’s right", "0")
    left, right = halves(hands.picture())
    assert right > 4 * left, (left, right)
    page.screenshot(path=pictures / "cut.png")
    hands.act(cuts.get_by_role("button", name="Remove all cuts and slices").click)

    # A slice alone: only grey.
    hands.act(cuts.get_by_label("Show the coronal slice").check)
    hands.act(cuts.get_by_label("Show only the slices").check)
    alone = hands.picture(FINE_ERROR)
    page.screenshot(path=pictures / "slice-alone.png")
    assert spread(alone) > 5
    assert all(max(alone[i:i + 3]) - min(alone[i:i + 3]) < 24 for i in range(0, len(alone), 3))
    hands.act(cuts.get_by_role("button", name="Remove all cuts and slices").click)

    # Materials: with the keyboard in the graph, over the renderer's histogram.
    look = hands.window("Materials")
    expect(look).to_be_focused()
    graph = look.get_by_role("application")
    expect(look.locator(".graph-histogram")).to_have_count(1)
    points = int(graph.get_attribute("data-points"))
    graph.focus()
    hands.act(lambda: page.keyboard.press("Insert"))
    hands.act(lambda: page.keyboard.press("Shift+ArrowDown"))
    expect(graph).to_have_attribute("data-points", str(points + 1))
    page.screenshot(path=pictures / "materials.png")

    # Undoes all steps with the keyboard.
    while undo.get_attribute("aria-disabled") == "false":
        hands.act(lambda: page.keyboard.press("Control+z"))
    assert hands.kept()[0] == begun
    page.keyboard.press("Escape")
    expect(look).to_have_count(0)
