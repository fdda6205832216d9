"""Distances and angles between points of the 3D picture: saved with the scan, in presets, links and pictures, and in live sessions."""

from __future__ import annotations

import json
import re
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from picture import wait_for_samples
from test_marks import MARKS, at, opens, press, window

KINDS = ("ruler", "angle")


def measured(page: Page) -> dict[str, list[str]]:
    """Returns the readings of the shown measurements, by kind."""
    return {kind: page.locator(f"{MARKS}[data-kind={kind}]").all_text_contents() for kind in KINDS}


def measure_an_angle(page: Page, *points: tuple[float, float]) -> None:
    before = page.locator(MARKS).count()
    window(page).get_by_role("button", name="Angle", exact=True).click()
    for point in points:
        page.mouse.click(*at(page, *point))
    expect(page.locator(MARKS)).to_have_count(before + 1)
    expect(page.locator(f"{MARKS}[data-kind=angle]").last).to_contain_text("°")    # its third point


def close(page: Page, name: str) -> None:
    page.get_by_role("dialog", name=name).get_by_role("button", name="Close").last.click()


def test_distances_and_angles_in_3d_stay_with_the_scan_and_are_shared(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    scan = Person.arrives(stack, page, "lengths").has_scan(cranium, "Head")
    opens(stack, page, scan)
    press(page, "Ruler", 0.45, 0.4, to=(0.55, 0.4))
    expect(page.locator(f"{MARKS}[data-kind=ruler]")).to_contain_text("mm")    # its second point
    measure_an_angle(page, (0.45, 0.6), (0.5, 0.5), (0.55, 0.6))
    readings = measured(page)
    (distance,), (angle,) = readings["ruler"], readings["angle"]
    assert re.search(r"\d+\.\d mm", distance) and re.search(r"\d+\.\d°", angle), readings
    page.screenshot(path=pictures / "measures-in-3d.png")

    # With the scan: in another tab, which remembers nothing.
    saved = window(page)
    saved.get_by_label("Name", exact=True).fill("Sizes")
    saved.get_by_role("button", name="Save", exact=True).click()
    expect(saved.get_by_text("Saved as Sizes.")).to_be_visible()
    other = page.context.new_page()
    page.close()
    opens(stack, other, scan)
    expect(other.locator(MARKS)).to_have_count(2)
    assert measured(other) == readings

    # In a preset and a link.
    other.get_by_role("button", name="Saved presets").click()
    dialog = other.get_by_role("dialog", name="Saved presets")
    dialog.get_by_label("Name of the new preset").fill("Sized")
    dialog.get_by_role("checkbox", name="Include 2 marks").check()
    dialog.get_by_role("button", name="Save the current view").click()
    expect(dialog.get_by_text("Saved as Sized.")).to_be_visible()
    close(other, "Saved presets")
    (kept,), = stack.psql(f"SELECT annotations FROM presets WHERE data_set_id = '{scan}'")
    assert {item["kind"] for item in json.loads(kept)["marks"]["items"]} == {"RULER", "ANGLE"}
    other.get_by_role("button", name="Save or share", exact=True).click()
    dialog = other.get_by_role("dialog", name="Save or share")
    link = dialog.get_by_label("Link", exact=True)
    stack.wait_until(lambda: link.input_value() != "", what="the link")
    bare = link.input_value()
    dialog.get_by_role("checkbox", name="Include 2 marks").check()
    stack.wait_until(lambda: link.input_value() != bare, what="the link with marks")
    marked = link.input_value()

    # In a picture.
    sizes = []
    for drawn in (True, False):
        dialog.get_by_role("checkbox", name="Draw 2 marks into the picture").set_checked(drawn)
        with other.expect_download() as download:
            dialog.get_by_role("button", name="Save the picture").click()
        sizes.append(Path(download.value.path()).read_bytes())
    assert sizes[0] != sizes[1]
    close(other, "Save or share")
    other.goto("about:blank")
    other.goto(marked)
    expect(other.locator(MARKS)).to_have_count(4)
    assert measured(other) == {kind: 2 * readings[kind] for kind in KINDS}

    # In a live session.
    opens(stack, other, scan)
    other.get_by_role("button", name="View together").click()
    other.get_by_role("button", name="Create link").click()
    joined = visit(small=True)
    joined.goto(other.get_by_label("Link to share").input_value())
    joined.get_by_label("Your name (visible to others in this session)").fill("Bob")
    joined.get_by_role("button", name="Join", exact=True).click()
    wait_for_samples(stack, joined, 1)
    expect(joined.locator(f"{MARKS}[data-kind=ruler]").first).to_be_visible()
    assert {kind: set(texts) for kind, texts in measured(joined).items()} == {kind: set(texts) for kind, texts in readings.items()}
    joined.screenshot(path=pictures / "measures-live.png")
