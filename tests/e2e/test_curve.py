"""Curves through the slices: the slice along a bent tube is a straight band, with the values of an independent computation."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from curve_reference import CurveReference
from harness import TestStack
from person import Person
from phantom import slice_file
from slice_reader import Reader
from test_pages import check_page

SIDE, SLICES, SPACING = 64, 40, 1.5
#: The tube is half of a ring in an axial slice.
LEVEL, RADIUS, THICK = 20, 24.0, 5.0
TUBE, AROUND = 600, 40


@pytest.fixture(scope="session")
def tube(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("tube") / "tube"
    folder.mkdir()
    z, y, x = np.ogrid[:SLICES, :SIDE, :SIDE]
    middle = (SIDE - 1) / 2
    right, down, up = (x - middle) * SPACING, (y - middle) * SPACING, (z - LEVEL) * SPACING
    ring = np.hypot(np.hypot(right, down) - RADIUS, up)
    ball = np.sqrt(right**2 + down**2 + up**2)
    values = np.select([(ring < THICK) & (down < 8), ball < 40], [TUBE, AROUND], -1000).astype(np.int16)
    for number, pixels in enumerate(values, 1):
        (folder / f"{number:03d}.dcm").write_bytes(slice_file(number, pixels, spacing=SPACING))
    return folder


class CurvePane:
    """The pane of the slice along the curve."""

    def __init__(self, reader: Reader):
        self.reader, self.page = reader, reader.page
        self.pane = self.page.locator(".curve-pane")
        self.canvas = self.pane.locator("canvas")

    def wait(self) -> None:
        expect(self.canvas).to_have_attribute("data-came", "true")
        drawn = """(canvas) => canvas.clientWidth > 0 && canvas.width === Math.round(canvas.clientWidth * devicePixelRatio)"""
        self.reader.stack.wait_until(lambda: self.canvas.evaluate(drawn) or self.page.wait_for_timeout(20), 120, "the curved slice in its size")

    def size(self) -> tuple[int, int, float]:
        return (*(int(self.canvas.get_attribute(name)) for name in ("data-columns", "data-rows")), float(self.canvas.get_attribute("data-pixel")))

    def at(self, column: float, row: float) -> tuple[float, float]:
        """Returns the position of a pixel in the page."""
        columns, rows, _ = self.size()
        box = self.canvas.bounding_box()
        scale = 0.94 * min(box["width"] / columns, box["height"] / rows)
        return (box["x"] + box["width"] / 2 + (column - (columns - 1) / 2) * scale, box["y"] + box["height"] / 2 + (row - (rows - 1) / 2) * scale)

    def value(self, column: int, row: int) -> int:
        """Points at a pixel and returns the value beside it."""
        _, rows, pixel = self.size()
        self.page.mouse.move(*self.at(column, row))
        along = f"{column * pixel:.1f} mm along, {(row - (rows - 1) / 2) * pixel:.1f} mm across".replace("-", "−")
        expect(self.pane.locator(".curve-position")).to_have_text(along)
        text = self.pane.locator(".slice-value")
        expect(text).to_have_text(re.compile(r"HU, interpolated$"))
        return int(text.text_content().split()[0].replace("−", "-"))


def points_of(reader: Reader, plane: str) -> Locator:
    return reader.pane(plane).locator(".slice-curve circle")


def ring() -> list[tuple[int, int]]:
    """The pixels of the axial slice that are nearest to points along the tube."""
    middle = (SIDE - 1) / 2
    return [(round(middle + RADIUS / SPACING * np.cos(angle)), round(middle - RADIUS / SPACING * np.sin(angle)))
            for angle in np.linspace(0, np.pi, 7)]


def choose_curve(page: Page) -> None:
    page.get_by_role("radio", name="Curve").check()
    expect(page.get_by_text("Press at least two points along a structure")).to_be_visible()


def test_a_bent_tube_becomes_a_straight_band(stack: TestStack, visit, tube: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "curt")
    reader = Reader(stack, page, person.has_scan(tube, "Tube"))
    page.keyboard.press("v")
    assert reader.index("axial") == LEVEL
    choose_curve(page)
    curve = CurvePane(reader)
    pixels = ring()
    for number, pixel in enumerate(pixels, 1):
        page.mouse.click(*reader.at("axial", *pixel))
        expect(points_of(reader, "axial")).to_have_count(number)
    expect(points_of(reader, "coronal")).to_have_count(len(pixels))
    curve.wait()
    page.screenshot(path=pictures / "curve.png")

    # The page computes where the pressed pixels lie, to less than a CSS pixel.
    middle = (SIDE - 1) / 2
    up = (LEVEL - (SLICES - 1) / 2) * SPACING
    points = np.array([[(column - middle) * SPACING, (row - middle) * SPACING, up] for column, row in pixels])
    exact = CurveReference(points)
    columns, rows, pixel = curve.size()
    assert pixel == SPACING
    assert abs((columns - 1) * pixel - exact.length) <= pixel + 2
    expect(curve.pane.locator(".slice-title")).to_contain_text("mm long")
    for angle in (0, 90):
        page.get_by_role("slider", name="Angle around the curve").fill(str(angle))
        expect(curve.pane.get_by_text(f"Angle {angle}°")).to_be_visible()
        curve.wait()
        far = round(9 / pixel)
        for column in range(2, columns - 2, 6):
            assert curve.value(column, (rows - 1) // 2) == TUBE
            for row in (far, -far):
                assert curve.value(column, (rows - 1) // 2 + row) == AROUND, (angle, column, row)
    page.screenshot(path=pictures / "curve-turned.png")

    # A press moves the crosshair of the other slices there.
    page.mouse.click(*curve.at((columns - 1) // 2, (rows - 1) // 2))
    expect(reader.canvas("coronal")).to_have_attribute("data-index", str(pixels[3][1]))
    check_page(page)

    # A slab, and back.
    field = page.get_by_label("Slab, mm", exact=True)
    field.fill("24")
    field.press("Enter")
    page.get_by_role("combobox", name="Values of the slab").select_option("minimum")
    expect(curve.pane.locator(".slice-title")).to_contain_text("24 mm minimum")
    curve.wait()
    assert curve.value((columns - 1) // 2, (rows - 1) // 2) == AROUND
    page.get_by_role("radio", name="Ruler").check()
    expect(curve.pane.get_by_text("Straightening stretches or squeezes")).to_be_visible()
    page.reload()
    expect(points_of(reader, "axial")).to_have_count(len(pixels))
    curve.wait()
    page.get_by_role("button", name="Remove the last point of the curve").click()
    expect(points_of(reader, "axial")).to_have_count(len(pixels) - 1)
    page.get_by_role("button", name="Delete the curve").click()
    expect(curve.pane).to_have_count(0)


def test_points_in_several_planes_are_set_dragged_and_removed_by_keys_and_mouse(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "kay")
    reader = Reader(stack, page, person.has_scan(cranium, "Head"))
    page.keyboard.press("v")
    reader.index("axial")
    choose_curve(page)
    curve = CurvePane(reader)
    for plane, key, times in (("axial", "Shift+ArrowRight", 6), ("sagittal", "Shift+ArrowUp", 5), ("coronal", "Shift+ArrowLeft", 9)):
        reader.canvas(plane).focus()
        page.keyboard.press("Enter")
        for _ in range(times):
            page.keyboard.press(key)
    page.keyboard.press("Enter")
    expect(points_of(reader, "axial")).to_have_count(4)
    curve.wait()
    curve.canvas.focus()
    status = curve.pane.locator("[role=status]")
    page.keyboard.press("ArrowRight")
    expect(status).to_contain_text("mm along")
    page.keyboard.press(".")
    expect(curve.pane.get_by_text("Angle 5°")).to_be_visible()
    page.keyboard.press("Backspace")
    expect(points_of(reader, "axial")).to_have_count(3)
    page.screenshot(path=pictures / "curve-keys.png")
    # By mouse: a new point follows the pointer until it is let go.
    title = curve.pane.locator(".slice-title")
    before = title.text_content()
    box = reader.in_size("sagittal").bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.4 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.6 * box["height"], steps=4)
    page.mouse.up()
    expect(points_of(reader, "sagittal")).to_have_count(4)
    expect(title).not_to_have_text(before)
    # The same point is moved, not a fifth one set.
    before = title.text_content()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.6 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.7 * box["height"], steps=4)
    page.mouse.up()
    expect(title).not_to_have_text(before)
    expect(points_of(reader, "sagittal")).to_have_count(4)


def test_a_phone_shows_the_slice_along_a_curve_below_the_others(stack: TestStack, visit, tube: Path, pictures: Path):
    page = visit(phone=True)
    person = Person.arrives(stack, page, "finn")
    reader = Reader(stack, page, person.has_scan(tube, "Tube"))
    page.get_by_role("button", name="Show the slices (V)").tap()
    reader.index("axial")
    choose_curve(page)
    for number, pixel in enumerate(ring()[::2], 1):
        page.touchscreen.tap(*reader.at("axial", *pixel))
        expect(points_of(reader, "axial")).to_have_count(number)
    curve = CurvePane(reader)
    curve.wait()
    columns, rows, _ = curve.size()
    page.screenshot(path=pictures / "curve-phone.png")
    page.touchscreen.tap(*curve.at(columns // 4, (rows - 1) // 2))
    expect(curve.pane.locator(".slice-value")).to_have_text(f"{TUBE} HU, interpolated")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
