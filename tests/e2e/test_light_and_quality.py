"""The cube turns the picture, the curve of the error is saved, and lights and scattering have all that the renderer offers."""

from __future__ import annotations

import json
import math
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from picture import wait_for_samples
from test_controls import Eye
from test_in_picture import open_viewer
from test_settings import Hands

MOST_LIGHTS = 64


def saved(page: Page, format_name: str) -> str:
    with page.expect_download() as download:
        page.get_by_role("button", name=f"Save the curve as {format_name}").click()
    assert download.value.suggested_filename.endswith(f".{format_name.lower()}")
    return Path(download.value.path()).read_text()


def check_cube(hands: Hands) -> None:
    before = Eye(hands)
    hands.act(hands.page.get_by_role("button", name="View from above").click)
    hands.settle()
    above = Eye(hands)
    assert above.away[2] / above.distance > 0.999 and math.isclose(above.distance, before.distance, rel_tol=1e-6)
    hands.act(lambda: hands.page.get_by_role("button", name="Undo").click())
    assert Eye(hands).turned(before) < 0.1


def check_curve(hands: Hands, pictures: Path) -> None:
    page = hands.page
    page.get_by_role("region", name="Quality", exact=True).get_by_text("Details", exact=True).click()
    wait_for_samples(hands.stack, page, 6, input_seq=hands.kept()[1])
    table = saved(page, "CSV").splitlines()
    assert any("root mean square" in line for line in table if line.startswith("# "))
    assert "samples,seconds,error" in table
    rows = [tuple(map(float, line.split(","))) for line in table[table.index("samples,seconds,error") + 1:]]
    assert len(rows) >= 2 and rows[-1][0] > rows[0][0] and rows[-1][1] > rows[0][1] and rows[-1][2] < rows[0][2], rows
    document = json.loads(saved(page, "JSON"))
    # The page waits 2 s for the worker's curve, which begins before the first picture that was shown. It may have come by now.
    assert document["format"] == "diaphane-error-curve" and document["points"][0]["samples"] <= rows[0][0]
    assert "CPU threads" in document["device"]
    drawing = saved(page, "SVG")
    assert "Rendering time in s" in drawing and "Slope" in drawing
    (pictures / "error-curve.svg").write_text(drawing)
    page.screenshot(path=pictures / "error-curve.png")
    expect(page.get_by_text("Too many requests")).to_have_count(0)


def lights_of(hands: Hands) -> list[dict]:
    return json.loads(hands.kept()[0])["lights"]


def check_lights(hands: Hands, pictures: Path) -> None:
    light = hands.window("Light")
    add = light.get_by_label("Add light")
    hands.act(lambda: add.select_option("box"))
    light.get_by_text("More", exact=True).click()
    hands.type(light, "Width relative to height", "2")
    box = lights_of(hands)[-1]["box"]
    assert math.isclose(box["u"]["x"], 2 * box["v"]["y"], rel_tol=1e-6)
    hands.act(lambda: add.select_option("rectangle"))
    hands.type(light, "Target to the right", "80")
    normal_before = lights_of(hands)[-1]["rectangle"]["u"]
    page = hands.page
    page.screenshot(path=pictures / "light-target.png")
    hands.act(lambda: light.get_by_role("button", name="Aim at the centre").click())
    assert lights_of(hands)[-1]["rectangle"]["u"] != normal_before
    while len(lights_of(hands)) < MOST_LIGHTS:
        hands.act(lambda: add.select_option("sphere"))
    add.select_option("sphere")
    expect(light.get_by_role("alert")).to_have_text("A picture can have at most 64 lights. Remove one before you add another.")
    assert len(lights_of(hands)) == MOST_LIGHTS
    page.screenshot(path=pictures / "light-too-many.png")
    light.get_by_role("button", name="Close Light").click()


def check_exposure(hands: Hands, pictures: Path) -> None:
    """64 lights would burn the picture out, which automatic exposure prevents."""
    lens = hands.window("Lens and quality")
    expect(lens.get_by_text("EV darker than set")).to_be_visible()
    hands.page.screenshot(path=pictures / "exposure-automatic.png")
    adapted = hands.picture()
    hands.act(lens.get_by_label("Adjust the exposure automatically").uncheck)
    expect(lens.get_by_text("EV darker than set")).to_have_count(0)
    assert sum(hands.picture()) > 1.2 * sum(adapted)
    hands.page.screenshot(path=pictures / "exposure-by-hand.png")
    hands.act(lens.get_by_label("Adjust the exposure automatically").check)
    lens.get_by_role("button", name="Close Lens and quality").click()


def check_scattering(hands: Hands, pictures: Path) -> None:
    lens = hands.window("Lens and quality")
    lens.get_by_text("More", exact=True).click()
    lens.get_by_role("combobox", name="Shading").select_option("phase")
    expect(lens.get_by_label("Forward scattering (g) (value)")).to_have_count(0)
    hands.act(lambda: lens.get_by_label("Scattering in volumes").select_option("henyey"))
    hands.type(lens, "Forward scattering (g)", "-0.3")
    assert json.loads(hands.kept()[0])["phase"]["g"] == -0.3
    hands.page.screenshot(path=pictures / "scattering.png")
    hands.act(lambda: lens.get_by_label("Scattering in volumes").select_option("isotropic"))
    assert json.loads(hands.kept()[0])["phase"].get("g", 0) == 0


def test_cube_curve_lights_and_scattering(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    hands = open_viewer(stack, page, cranium, "ines", 1000, 640)
    page.get_by_role("button", name="Hide the tips").click()
    check_cube(hands)
    check_curve(hands, pictures)
    check_lights(hands, pictures)
    check_exposure(hands, pictures)
    check_scattering(hands, pictures)
