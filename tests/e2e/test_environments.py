"""A user lights a scan by an environment of their own: upload, rotation, sharing by a preset, and deletion."""

from __future__ import annotations

import json
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from panoramas import exr, hdr
from test_in_picture import open_viewer
from test_settings import Hands, halves

#: Light from the left alone. The middle of a panorama is forward, and the patient is seen from the front.
BRIGHT = range(8, 24)


def from_the_left(x: int, y: int) -> tuple[float, float, float]:
    return (8.0, 7.0, 6.0) if x in BRIGHT else (0.02, 0.02, 0.03)


def environment_of(hands: Hands) -> dict:
    return json.loads(hands.kept()[0])["lights"][-1]["environment"]


def turn_off_all_lights(light, hands: Hands) -> None:
    for switch in light.get_by_role("checkbox", name="Turn on").all():
        if switch.is_checked():
            hands.act(switch.uncheck)


def share(hands: Hands) -> float:
    """Returns how bright the left half of the picture is, compared with the right one."""
    left, right = halves(hands.picture())
    return left / right


def test_an_environment_of_ones_own_lights_the_scan(stack: TestStack, visit, cranium: Path, pictures: Path, tmp_path: Path):
    page: Page = visit(small=True)
    hands = open_viewer(stack, page, cranium, "hedy", 720, 440)
    page.get_by_role("button", name="Hide the tips").click()
    light = hands.window("Light")
    turn_off_all_lights(light, hands)
    hands.act(lambda: light.get_by_label("Add light").select_option("environment"))
    upload = light.get_by_label("Add an environment (.hdr or .exr)")

    damaged = tmp_path / "broken.exr"
    damaged.write_bytes(exr(64, 32, from_the_left)[:-9])
    upload.set_input_files(damaged)
    expect(light.get_by_role("alert")).to_have_text("That file is damaged. Export or download it again.")

    good = tmp_path / "Window left.hdr"
    good.write_bytes(hdr(64, 32, from_the_left))
    hands.act(lambda: upload.set_input_files(good))
    expect(light.get_by_role("button", name="Window left", exact=True)).to_have_attribute("aria-pressed", "true")
    stored = environment_of(hands)["stored"]
    hands.type(light, "Brightness", "6")
    left, right = halves(hands.picture())
    page.screenshot(path=pictures / "environment-left.png")
    assert left > 1.3 * right, (left, right)
    hands.type(light, "Rotation", "180")
    left, right = halves(hands.picture())
    page.screenshot(path=pictures / "environment-right.png")
    assert right > 1.3 * left, (left, right)

    page.reload()
    light = hands.window("Light")
    light.locator("[data-light]").last.get_by_role("button").click()
    light.get_by_label("Environment name").fill("Window")
    light.get_by_label("Environment name").press("Enter")
    expect(light.get_by_role("button", name="Window", exact=True)).to_be_visible()
    page.screenshot(path=pictures / "environment-panel.png")
    light.get_by_role("button", name="Delete Window").click()
    expect(light.get_by_text("Permanently delete “Window”?")).to_be_visible()
    hands.act(lambda: light.get_by_role("button", name="Delete Window").click())
    assert not environment_of(hands).get("stored")
    # The previous scene still refers to it, as a preset or link of somebody else might.
    hands.act(lambda: page.get_by_role("button", name="Undo").click())
    assert environment_of(hands)["stored"] == stored
    expect(page.get_by_role("status").get_by_text("The environment of this view no longer exists. An even light takes its place.")).to_be_visible()
    stack.wait_until(lambda: 0.7 < share(hands) < 1.4, what="the even light")
    page.screenshot(path=pictures / "environment-gone.png")
