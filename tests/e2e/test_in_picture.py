"""Direct manipulation in the picture: clipping, lights and focus, with mouse, touch and keyboard, checked on the resulting
pictures."""

from __future__ import annotations

import pytest

import hashlib
import json
import math
import re
from pathlib import Path

from playwright.sync_api import Locator, Page, expect

from harness import TestStack
from person import Person
from picture import ALIKE, FINE_ERROR, SIDE, difference, facts, pixels, placed, wait_for_samples
from test_pages import check_page
from test_settings import GROUND, Hands, halves, look_from_the_front


def open_viewer(stack: TestStack, page: Page, cranium: Path, name: str, width: int, height: int) -> Hands:
    person = Person.arrives(stack, page, name)
    return open_scan(stack, page, person.has_scan(cranium, "Head"), width, height)


def open_scan(stack: TestStack, page: Page, scan: str, width: int, height: int) -> Hands:
    page.set_viewport_size({"width": width, "height": height})
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 1)
    hands = Hands(stack, page)
    stack.wait_until(lambda: hands.kept()[0], what="the first scene")
    return hands


def test_the_headrest_is_hidden_and_one_switch_shows_it(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit()
    hands = open_viewer(stack, page, cranium, "headrest", 640, 480)
    page.get_by_role("button", name="Hide the tips").click()
    expect(page.get_by_text("The table, headrest or frame is hidden.").first).to_be_visible()
    cuts = hands.window("Cuts and slices")  # leaves less room for the picture
    expect(cuts).to_be_focused()
    switch = cuts.get_by_label("Show the table, headrest or frame")
    hands.act(switch.check)
    hands.act(switch.uncheck)
    hands.settle()  # the camera has made room for the window
    body = hands.picture()
    hands.act(switch.check)
    both = hands.picture()
    page.screenshot(path=pictures / "headrest.png")
    assert covered(both) > 1.1 * covered(body), (covered(both), covered(body))
    # Another look keeps it, and the window's reset hides it again.
    for key in ("4", "1"):
        page.locator("canvas").focus()
        hands.act(lambda key=key: page.keyboard.press(key))
        expect(switch).to_be_checked()
    hands.act(cuts.get_by_role("button", name="Remove all cuts and slices").click)
    expect(switch).not_to_be_checked()
    assert difference(body, hands.picture()) < ALIKE
    # The note shows it, too, but never covers the handles of an open window.
    expect(page.get_by_role("button", name="Show it")).to_have_count(0)
    cuts.get_by_role("button", name="Close Cuts and slices").click()
    hands.act(page.get_by_role("button", name="Show it").click)
    hands.window("Cuts and slices")
    expect(switch).to_be_checked()
    assert covered(hands.picture()) > 1.1 * covered(body)


def covered(picture: bytes) -> float:
    """Returns the share of the picture that is brighter than the background."""
    return sum(max(picture[i:i + 3]) > GROUND for i in range(0, len(picture), 3)) / (len(picture) / 3)


def middle(box: dict) -> tuple[float, float]:
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def pull(page: Page, handle: Locator, right: float, down: float) -> None:
    x, y = middle(placed(handle))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=8)
    page.mouse.up()


def keep_handles(hands: Hands, window: str) -> None:
    """Keeps the window's handles in the picture and closes the window."""
    frame = hands.window(window)
    frame.get_by_label("Keep showing the handles when this window is closed").check()
    frame.get_by_role("button", name=f"Close {window}").click()


def sharpness(picture: bytes, x0: int, y0: int, side: int) -> float:
    """Returns how much neighbouring pixels differ in a square, which is more for sharp edges."""
    def grey(x: int, y: int) -> float:
        at = 3 * (y * SIDE + x)
        return sum(picture[at:at + 3]) / 3

    total = 0.0
    for y in range(y0, y0 + side):
        for x in range(x0, x0 + side):
            total += abs(grey(x + 1, y) - grey(x, y)) + abs(grey(x, y + 1) - grey(x, y))
    return total / side / side


def test_cuts_and_lights_can_be_dragged_in_the_picture(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    hands = open_viewer(stack, page, cranium, "hanna", 720, 440)
    page.get_by_role("button", name="Hide the tips").click()
    look_from_the_front(hands)
    begun = hands.kept()[0]

    # With the mouse: cuts away the patient's left, on the right of the picture, up to the middle.
    keep_handles(hands, "Cuts and slices")
    handle = page.locator('[data-handle="x-high"]')
    before = middle(placed(handle))
    box = page.locator("canvas").bounding_box()
    hands.act(lambda: pull(page, handle, box["x"] + box["width"] / 2 - before[0], 0))
    after = middle(placed(handle))
    assert abs(after[0] - (box["x"] + box["width"] / 2)) < 6 and abs(after[1] - before[1]) < 25, (before, after)
    cut = hands.picture()
    page.screenshot(path=pictures / "picture-cut.png")
    left, right = halves(cut)
    assert left > 4 * right, (left, right)
    # With the keyboard: a millimetre per key, ten with Shift. Then everything is undone.
    value = float(handle.get_attribute("aria-valuenow"))
    hands.act(lambda: handle.press("ArrowLeft"))
    hands.act(lambda: handle.press("Shift+ArrowDown"))
    assert abs(float(handle.get_attribute("aria-valuenow")) - (value - 11)) <= 1
    while hands.kept()[0] != begun:
        hands.act(lambda: page.keyboard.press("Control+z"))

    # A plane: one handle moves it, the other rotates it.
    cuts = hands.window("Cuts and slices")
    cuts.get_by_text("Planes", exact=True).click()
    hands.act(cuts.get_by_role("button", name="Add plane").click)
    hands.type(cuts, "Angle to the patient’s left", "50")
    cuts.get_by_role("button", name="Close Cuts and slices").click()
    tip, base = page.locator('[data-handle="tilt-0"]'), page.locator('[data-handle="plane-0"]')
    offset = float(base.get_attribute("aria-valuenow"))
    hands.act(lambda: pull(page, base, 30, 0))
    assert float(base.get_attribute("aria-valuenow")) > offset + 5
    hands.act(lambda: pull(page, tip, 0, -40))
    assert float(tip.get_attribute("aria-valuenow")) > 5
    page.screenshot(path=pictures / "picture-plane.png")
    check_page(page)
    while hands.kept()[0] != begun:
        hands.act(lambda: page.keyboard.press("Control+z"))

    # A single light, dragged to the left of the picture and to its right.
    light = hands.window("Light")
    for name in ("Rim light", "Surrounding light"):
        hands.act(lambda: light.get_by_label(f"Turn on {name}").uncheck())
    keep_handles(hands, "Light")
    lamp = page.locator('[data-handle="light-0"]')
    radius = 0.4 * min(box["width"], box["height"])
    for side in (-1, 1):
        x, y = middle(placed(lamp))
        to = (box["x"] + box["width"] / 2 + side * 0.95 * radius, box["y"] + box["height"] / 2)
        hands.act(lambda: pull(page, lamp, to[0] - x, to[1] - y))
        left, right = halves(hands.picture())
        assert (left > 1.3 * right) if side < 0 else (right > 1.3 * left), (side, left, right)
        page.screenshot(path=pictures / f"picture-light{side}.png")
    said = lamp.get_attribute("aria-valuetext")
    hands.act(lambda: lamp.press("ArrowLeft"))
    assert lamp.get_attribute("aria-valuetext") != said


@pytest.mark.nightly
def test_the_chosen_point_is_in_focus(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    hands = open_viewer(stack, page, cranium, "fokke", 720, 440)
    lens = hands.window("Lens and quality")
    hands.type(lens, "Aperture radius", "30")
    wide = hands.kept()[0]
    at = (0.68, 0.57)  # the ear, which has edges, beside the window

    def pick(x: float, y: float) -> None:
        lens.get_by_role("button", name="Choose the focus point").click()
        picker = page.get_by_role("button", name="Click or tap the point that should be in focus.")
        expect(picker).to_be_focused()
        box = picker.bounding_box()
        page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])

    # The background has no depth. Escape ends the mode.
    pick(0.99, 0.45)
    expect(page.get_by_text("There is only background at that point.")).to_be_visible()
    page.keyboard.press("Escape")
    picker = page.get_by_role("button", name="Click or tap the point that should be in focus.")
    expect(picker).to_have_count(0)
    assert hands.kept()[0] == wide
    hands.act(lambda: pick(*at))
    expect(picker).to_have_count(0)
    distance = float(lens.get_by_label("Focus distance (value)").input_value())
    near = hands.picture(FINE_ERROR)
    page.screenshot(path=pictures / "picture-focus.png")
    # At another depth, it is blurred.
    hands.type(lens, "Focus distance", str(round(distance * 1.6)))
    blurred = hands.picture(FINE_ERROR)
    x, y, side = round(at[0] * SIDE) - 8, round(at[1] * SIDE) - 8, 16
    assert sharpness(near, x, y, side) > 1.2 * sharpness(blurred, x, y, side), (sharpness(near, x, y, side), sharpness(blurred, x, y, side))
    # With the keyboard: moves the mark up and back, and accepts it with Enter. The distance is as before.
    lens.get_by_role("button", name="Choose the focus point").press("Enter")
    expect(picker).to_be_focused()
    page.keyboard.press("Shift+ArrowUp")
    page.keyboard.press("Shift+ArrowDown")
    hands.act(lambda: page.keyboard.press("Enter"))
    assert abs(float(lens.get_by_label("Focus distance (value)").input_value()) - distance) < 0.5
    for _ in range(3):
        hands.act(lambda: page.keyboard.press("Control+z"))
    assert hands.kept()[0] == wide


@pytest.mark.nightly
def test_undo_restores_the_picture_exactly(stack: TestStack, visit, cranium: Path):
    page = visit(small=True)
    hands = open_viewer(stack, page, cranium, "retour", 320, 240)
    begun = hands.kept()[0]

    def lossless() -> str:
        """Waits until each tile has been verified."""
        def there() -> bool:
            page.wait_for_timeout(100)
            return page.locator("canvas[data-lossless]").count() == 1 and facts(page).input_seq >= hands.kept()[1]

        stack.wait_until(there, timeout=240, what="the lossless picture")
        return hashlib.sha256(pixels(page)).hexdigest()

    before = lossless()
    hands.act(lambda: page.keyboard.press("4"))
    page.get_by_role("application").focus()
    hands.act(lambda: page.keyboard.press("ArrowLeft"))
    hands.picture()
    page.reload()  # The steps survive it.
    wait_for_samples(stack, page, 1)
    expect(page.get_by_role("button", name="Undo", exact=True)).to_have_attribute("aria-disabled", "false")
    while hands.kept()[0] != begun:
        hands.act(lambda: page.keyboard.press("Control+z"))
    assert lossless() == before


COVERED = """() => [...document.querySelectorAll(".viewer-title :is(a, button), .viewer-tools button, .menu button")].filter((tool) => {
    const box = tool.getBoundingClientRect();
    if (box.width === 0) return false;
    const top = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
    return !tool.contains(top);
}).map((tool) => tool.getAttribute("aria-label"))"""


def check_tools(page: Page) -> None:
    """Checks that nothing covers the tools at the top or the menu."""
    page.wait_for_function(f"({COVERED})().length === 0")
    check_page(page)


def look_focus_and_share_by_taps(hands: Hands) -> None:
    """On a phone: another look, the focus, and a link to share."""
    page = hands.page
    old, look = hands.picture(), page.locator("[data-preset=airways]")
    hands.act(look.tap)
    expect(look).to_have_attribute("aria-pressed", "true")
    assert difference(old, hands.picture()) > 2
    hands.act(page.locator("[data-preset=bone]").tap)
    page.get_by_role("button", name="Lens and quality", exact=True).tap()
    lens = page.get_by_role("dialog", name="Lens and quality", exact=True)
    lens.get_by_role("button", name="Choose the focus point").tap()
    box = page.locator("canvas").bounding_box()
    x, y = middle(box)
    hands.act(lambda: page.touchscreen.tap(x, y - 0.12 * box["height"]))
    expect(page.get_by_role("button", name="Click or tap the point that should be in focus.")).to_have_count(0)
    # The forehead, above the orbits: in front of the middle of the volume, and not at the eye.
    camera = json.loads(hands.kept()[0])["camera"]
    distance = math.dist([camera["eye"].get(axis, 0) for axis in "xyz"], [camera["target"].get(axis, 0) for axis in "xyz"])
    assert 0.5 * distance < camera["focalDistance"] < distance, (camera, distance)
    lens.get_by_role("button", name="Close Lens and quality").tap()
    page.get_by_role("button", name="View together").tap()
    share = page.get_by_role("dialog")
    share.get_by_role("button", name="Create link").tap()
    expect(share.get_by_label("Link to share")).to_have_value(re.compile(r"^http.*/join#.+"))
    share.get_by_role("button", name="Disable link").tap()
    expect(share.get_by_text("Link disabled. Everyone using it has been disconnected.")).to_be_visible()
    share.get_by_role("button", name="Close").last.tap()
    expect(share).to_have_count(0)


@pytest.mark.nightly
def test_nothing_covers_the_tools_and_a_finger_moves_a_light(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(phone=True)
    hands = open_viewer(stack, page, cranium, "vinger", 390, 844)
    hint = page.get_by_role("complementary", name="Tip 1 of 3")
    expect(hint).to_be_visible()
    check_tools(page)
    page.screenshot(path=pictures / "hint-phone.png")
    # Three hints above the middle of the picture, which never appear again.
    said, box = hint.bounding_box(), page.locator("canvas").bounding_box()
    assert said["y"] + said["height"] < box["y"] + 0.25 * box["height"]
    page.get_by_role("button", name="Next").click()
    page.get_by_role("button", name="Next").click()
    page.get_by_role("button", name="Got it").click()
    expect(page.get_by_role("complementary")).to_have_count(0)

    look_focus_and_share_by_taps(hands)
    light = hands.window("Light")
    lamp = page.locator('[data-handle="light-0"]')
    expect(lamp).to_be_visible()
    check_tools(page)
    page.screenshot(path=pictures / "light-phone.png")
    x, y = middle(placed(lamp))
    touch = page.context.new_cdp_session(page)

    def finger() -> None:
        for kind, right in (("touchStart", 0), ("touchMove", 15), ("touchMove", 40), ("touchEnd", None)):
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [] if right is None else [{"x": x + right, "y": y}]})

    hands.act(finger)
    assert abs(middle(placed(lamp))[0] - (x + 40)) < 6
    # A built-in texture, and a file that is not an image.
    light.get_by_text("More", exact=True).click()
    hands.act(light.get_by_role("button", name="Ring", exact=True).click)
    expect(light.get_by_role("button", name="Ring", exact=True)).to_have_attribute("aria-pressed", "true")
    hands.picture()
    light.get_by_label("Use your own picture as a light pattern").set_input_files({"name": "note.png", "mimeType": "image/png", "buffer": b"no picture"})
    expect(light.get_by_role("alert")).to_contain_text("can’t read that file as a picture")
    page.screenshot(path=pictures / "texture-phone.png")
    light.get_by_role("button", name="Close Light").click()

    # A low window, like that of a laptop beside another one.
    page.set_viewport_size({"width": 720, "height": 440})
    page.reload()
    wait_for_samples(stack, page, 1)
    expect(page.get_by_role("complementary")).to_have_count(0)
    for _ in range(4):
        page.keyboard.press("-")  # so that the handles of the box are below the tools
    page.get_by_role("button", name="Show the quality").click()
    check_tools(page)
    page.screenshot(path=pictures / "quality-low.png")
    page.get_by_role("region", name="Quality").get_by_role("button", name="Close").click()
    for window in ("Light", "Lens and quality", "Cuts and slices"):
        hands.window(window)
        check_tools(page)
        page.screenshot(path=pictures / f"low-{window.split()[0]}.png")
