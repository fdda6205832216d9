"""Information beside the picture: the visible side, its quality, names, the histogram, the looks."""

from __future__ import annotations

import base64
import re
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from picture import SHRINK, difference, spread, wait_for_samples
from test_controls import Eye, answered
from test_in_picture import open_viewer
from test_settings import Hands

#: The patient's axes (scene.proto) by the sign of the component towards the eye: below 0, above 0.
SIDES = (("the patient’s right", "R", "the patient’s left", "L"), ("the front", "A", "the back", "P"), ("below", "I", "above", "S"))
SIDE = 24


def check_cube(hands: Hands) -> str:
    """Checks that the cube shows the side from which the camera looks. Returns its letter."""
    away = Eye(hands).away
    axis = max(range(3), key=lambda n: abs(away[n]))
    low, low_letter, high, high_letter = SIDES[axis]
    side, letter = (high, high_letter) if away[axis] > 0 else (low, low_letter)
    expect(hands.page.locator(".cube")).to_have_attribute("aria-label", f"Viewed from {side}")
    expect(hands.page.locator(".cube-letter").last).to_have_text(letter)
    return letter


def check_plot(hands: Hands) -> None:
    """Checks that the error falls, in the plot and as text, and that samples and seconds are shown."""
    page = hands.page
    panel = page.get_by_role("region", name="Quality", exact=True)
    panel.get_by_text("Details", exact=True).click()
    wait_for_samples(hands.stack, page, 4, input_seq=hands.kept()[1])
    line = panel.locator(".plot-line")
    expect(line).to_have_attribute("points", re.compile(r"\d \d"))  # two points or more
    places = [tuple(map(float, at.split(","))) for at in line.get_attribute("points").split()]
    assert places[-1][0] > places[0][0] and places[-1][1] > places[0][1], places  # y points down
    expect(panel.get_by_role("img", name="Noise level over time, both axes logarithmic")).to_be_visible()
    expect(panel.locator("[data-fact=error]")).to_contain_text("%")
    expect(panel.locator("[data-fact=time]")).to_contain_text(re.compile(r"\d (ms|s|min)$"))
    panel.get_by_role("button", name="Noise level?").click()
    expect(panel.get_by_text("Four times as many samples halve the noise level")).to_be_visible()


def check_histogram(page: Page, look) -> None:
    """Linear or logarithmic, and the same in a window that is opened again."""
    drawn = look.locator(".graph-histogram")
    logarithmic = drawn.get_attribute("points")
    look.get_by_label("Histogram scale").select_option("linear")
    expect(drawn).not_to_have_attribute("points", logarithmic)
    even = drawn.get_attribute("points")
    look.get_by_role("button", name="Close Materials").click()
    page.get_by_role("button", name="Materials", exact=True).click()
    expect(drawn).to_have_attribute("points", even)
    look.get_by_text("More", exact=True).click()
    look.get_by_label("Histogram scale").select_option("logarithmic")
    expect(drawn).to_have_attribute("points", logarithmic)


def rename(hands: Hands, frame, old: str, new: str) -> None:
    field = frame.get_by_label("Name", exact=True)
    expect(field).to_have_value(old)
    field.fill(new)
    hands.act(lambda: field.press("Enter"))
    expect(frame.get_by_role("button", name=new, exact=True)).to_be_visible()


def test_orientation_quality_participants_and_looks_are_shown(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    hands = open_viewer(stack, page, cranium, "tilda", 1000, 640)
    page.get_by_role("button", name="Hide the tips").click()
    begun = hands.kept()[0]

    # A full rotation, and from above.
    canvas, seen = page.locator("canvas"), set()
    canvas.focus()
    for key in ["ArrowRight"] * 4 + ["ArrowDown"] * 3:
        seen.add(check_cube(hands))
        for _ in range(5):
            page.keyboard.press(key)
    seen.add(check_cube(hands))
    assert len(seen) >= 3, seen
    hands.act(page.get_by_role("button", name="Reset the view").click)
    check_plot(hands)

    # Every look has a picture of this scan, and all are different.
    images = page.locator(".preset-picture img")
    expect(images).to_have_count(6)
    decoded = "(images) => images.every((image) => image.complete && image.naturalWidth > 0)"
    stack.wait_until(lambda: images.evaluate_all(decoded) or page.wait_for_timeout(50), what="the pictures of the looks")
    looks = [base64.b64decode(image.evaluate(SHRINK, SIDE)) for image in images.all()]
    assert all(spread(look) > 5 for look in looks)
    assert min(difference(a, b) for n, a in enumerate(looks) for b in looks[:n]) > 1

    look = hands.window("Materials")
    look.get_by_text("More", exact=True).click()
    expect(look.get_by_text("Where materials overlap, the more opaque one determines")).to_be_visible()
    check_histogram(page, look)
    rename(hands, look, "Skin", "<b>Bone & more</b>")
    look.get_by_role("button", name="Close Materials").click()

    light = hands.window("Light")
    light.get_by_text("More", exact=True).click()
    rename(hands, light, "Main light", "Lamp at the door")
    # A custom picture before a light: black on the left, white on the right.
    picture = page.evaluate("""async () => {
        const canvas = new OffscreenCanvas(64, 32), context = canvas.getContext("2d");
        context.fillRect(0, 0, 64, 32);
        context.fillStyle = "white";
        context.fillRect(32, 0, 32, 32);
        const bytes = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
        return btoa(String.fromCharCode(...bytes));
    }""")
    own = light.get_by_label("Use your own picture as a light pattern")
    answered(hands, "a texture of one's own", lambda: own.set_input_files({"name": "window.png", "mimeType": "image/png", "buffer": base64.b64decode(picture)}))
    expect(light.locator(".texture-own[data-chosen]")).to_be_visible()
    page.screenshot(path=pictures / "told.png")
    undo = page.get_by_role("button", name="Undo", exact=True)
    while undo.get_attribute("aria-disabled") == "false":
        hands.act(undo.click)  # Ctrl+Z would undo in the text field
    assert hands.kept()[0] == begun
