"""The slices beside the picture, compared with the stored voxels in numpy."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from playwright.sync_api import expect

from touch import Fingers
from harness import REPO, TestStack
from person import Person
from slice_reader import PLANES, Reader, spots_of

AXE = REPO / "frontend" / "node_modules" / "axe-core" / "axe.min.js"


def test_slices_show_the_voxels_of_the_file_and_the_crosshair_links_them(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)  # wide enough that a voxel covers at least one pixel
    person = Person.arrives(stack, page, "sasha")
    scan = person.has_scan(cranium, "Head")
    reader = Reader(stack, page, scan)
    page.keyboard.press("v")
    for plane in PLANES:
        # The middle of the volume.
        slices = reader.planes[plane].voxels.shape[0]
        assert abs(reader.index(plane) - (slices - 1) / 2) <= 0.5
    page.screenshot(path=pictures / "four-up.png")

    # Smooth at first, and the value under the pointer is the voxel's.
    for plane in PLANES:
        reader.shows_interpolated_values(plane, 40)
    reader.sharp()
    page.screenshot(path=pictures / "four-up-sharp.png")

    # Values under the pointer, and how they are drawn.
    for plane in PLANES:
        spots = spots_of(reader.planes[plane], 6)
        for column, row in spots:
            page.mouse.move(*reader.at(plane, column, row))
            reader.says(plane, int(reader.planes[plane].voxels[reader.index(plane), row, column]))
        reader.shows_what_the_formula_says(plane, spots)

    # The window, typed and dragged. Invalid numbers are reverted.
    spots = spots_of(reader.planes["coronal"], 20)
    reader.set_window(300, 2000)
    reader.shows_what_the_formula_says("coronal", spots)
    page.get_by_label("Width", exact=True).fill("wide")
    page.get_by_label("Width", exact=True).press("Enter")
    assert reader.window() == (300, 2000)
    x, y = reader.at("coronal", 10, 10)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y - 20, steps=4)
    page.mouse.up()
    centre, width = reader.window()
    assert centre > 300 and width > 2000
    reader.shows_what_the_formula_says("coronal", spots)
    page.get_by_role("combobox", name="Window").select_option("bone")
    assert reader.window() == (400, 1800)
    reader.shows_what_the_formula_says("axial", spots_of(reader.planes["axial"], 20))

    # The linked crosshair: moving with Shift in one slice moves the others through that position.
    _, rows, columns = reader.planes["axial"].voxels.shape
    column, row = columns // 4, rows // 3
    page.keyboard.down("Shift")
    page.mouse.move(*reader.at("axial", column - 1, row))
    page.mouse.move(*reader.at("axial", column, row))
    page.keyboard.up("Shift")
    expect(reader.canvas("sagittal")).to_have_attribute("data-index", str(column))
    expect(reader.canvas("coronal")).to_have_attribute("data-index", str(row))
    here = int(reader.planes["axial"].voxels[reader.index("axial"), row, column])
    page.mouse.move(5, 5)  # without a pointer on a slice, the crosshair's value
    for plane in PLANES:
        reader.index(plane)
        reader.says(plane, here)

    # The wheel scrolls through the slices.
    before = reader.index("axial")
    page.mouse.move(*reader.at("axial", column, row))
    page.mouse.wheel(0, 120)
    expect(reader.canvas("axial")).to_have_attribute("data-index", str(before + 1))
    reader.says("axial", int(reader.planes["axial"].voxels[before + 1, row, column]))
    measured_by_mouse(reader)
    ellipse_by_mouse(reader, pictures)
    one_alone_by_mouse(reader)


def test_a_reload_keeps_the_slices_and_their_measurements(stack: TestStack, visit, cranium: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "renate")
    reader = Reader(stack, page, person.has_scan(cranium, "Head"))
    page.locator("[data-preset=bone]").click()
    page.keyboard.press("v")
    reader.set_window(300, 2000)
    page.get_by_role("radio", name="Ruler").check()
    page.mouse.move(*reader.at("sagittal", 5, 10))
    page.mouse.down()
    page.mouse.move(*reader.at("sagittal", 25, 10), steps=3)
    page.mouse.up()
    text = reader.pane("sagittal").locator(".slice-measure text")
    expect(text).to_have_text(re.compile(r"mm$"))
    length = text.text_content()

    page.reload()
    expect(reader.pane("sagittal").locator(".slice-measure text")).to_have_text(length)
    assert reader.window() == (300, 2000)
    expect(page.locator(".preset[aria-pressed=true]")).to_have_attribute("data-preset", "bone")


def pixel_mm(reader: Reader, plane: str) -> float:
    """Returns the size of a pixel. A mouse reports whole pixels, so each end is off by less than one."""
    return 1 / reader.planes[plane].per_mm(reader.canvas(plane).bounding_box())


def measured_by_mouse(reader: Reader) -> None:
    page, sagittal = reader.page, reader.planes["sagittal"]
    page.get_by_role("radio", name="Ruler").check()
    page.mouse.move(*reader.at("sagittal", 5, 10))
    page.mouse.down()
    page.mouse.move(*reader.at("sagittal", 25, 10), steps=3)
    page.mouse.up()
    text = reader.pane("sagittal").locator(".slice-measure text")
    expect(text).to_have_text(re.compile(r"^\d+\.\d mm$"))
    # The error is at most one pixel along the line and almost none across it. The length has one decimal.
    length, pixel = 20 * sagittal.width, pixel_mm(reader, "sagittal")
    bound = math.hypot(length + pixel, pixel) - length + 0.05
    assert abs(float(text.text_content().split()[0]) - length) <= bound, (text.text_content(), length, bound)

    page.get_by_role("radio", name="Angle").check()
    spots = ((5, 5), (30, 5), (30, 25))
    for spot in spots:
        page.mouse.click(*reader.at("axial", *spot))
    text = reader.pane("axial").locator(".slice-measure text")
    expect(text).to_have_text(re.compile(r"^\d+\.\d°$"))
    # Each end of an arm is less than a pixel off across it.
    axial, pixel = reader.planes["axial"], pixel_mm(reader, "axial")
    bound = math.degrees(math.atan(pixel / (25 * axial.width - pixel)) + math.atan(pixel / (20 * axial.height - pixel))) + 0.05
    assert abs(float(text.text_content()[:-1]) - 90) <= bound, (text.text_content(), bound)
    # Hidden on another slice, and shown again on its own.
    page.mouse.wheel(0, 120)
    expect(reader.pane("axial").locator(".slice-measure")).to_have_count(0)
    page.mouse.wheel(0, -120)
    expect(reader.pane("axial").locator(".slice-measure")).to_have_count(1)
    page.get_by_role("button", name="Delete the last measurement").click()
    expect(reader.pane("axial").locator(".slice-measure")).to_have_count(0)


def shows_region(reader: Reader, plane: str, one: tuple[float, float], other: tuple[float, float]) -> None:
    values, area = reader.region(plane, one, other)
    lines = reader.pane(plane).locator(".slice-measure tspan")
    expect(lines.nth(0)).to_have_text(f"Mean {values.mean():.1f} ± {values.std():.1f} HU".replace("-", "−"))
    expect(lines.nth(1)).to_have_text(f"{values.min()} to {values.max()} HU".replace("-", "−"))
    expect(lines.nth(2)).to_have_text(re.compile(rf"^{area:,.{1 if area < 100 else 0}f} mm², {len(values):,} pixels$"))


def ellipse_by_mouse(reader: Reader, pictures: Path) -> None:
    """Drawn from corner to corner, moved by its centre and resized by its ends."""
    page = reader.page
    page.get_by_role("radio", name="Ellipse").check()
    x, y = (round(n) for n in reader.at("axial", 60, 60))

    def drag(start: tuple[int, int], end: tuple[int, int]) -> None:
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move(*end, steps=4)
        page.mouse.up()

    drag((x, y), (x + 90, y + 70))
    shows_region(reader, "axial", (x, y), (x + 90, y + 70))
    page.screenshot(path=pictures / "ellipse.png")
    drag((x + 45, y + 35), (x + 65, y + 15))
    shows_region(reader, "axial", (x + 20, y - 20), (x + 110, y + 50))
    drag((x + 110, y + 15), (x + 80, y + 25))
    shows_region(reader, "axial", (x + 20, y - 20), (x + 80, y + 50))
    expect(reader.pane("axial").locator(".slice-measure")).to_have_count(1)
    page.get_by_role("button", name="Delete the last measurement").click()


def test_the_colours_of_the_look_cover_the_grey_and_follow_the_look(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "olga")
    reader = Reader(stack, page, person.has_scan(cranium, "Head"))
    page.locator("[data-preset=bone]").click()
    page.keyboard.press("v")
    reader.sharp()
    plane = reader.planes["axial"]
    reader.set_window(500, 4000)
    # A pixel of hard bone and one of air.
    slice_ = plane.voxels[reader.index("axial")]
    bone = tuple(int(n) for n in np.argwhere(slice_ > 1100)[0][::-1])
    air = tuple(int(n) for n in np.argwhere(slice_ < -900)[0][::-1])

    def colour(spot: tuple[int, int]) -> list[int]:
        return reader.pixel("axial", *plane.place(reader.canvas("axial").bounding_box(), *spot))[:3]

    grey = colour(bone)
    assert len(set(grey)) == 1
    page.get_by_role("checkbox", name="Colours").check()
    stack.wait_until(lambda: len(set(colour(bone))) > 1, what="the colours of bone")
    assert len(set(colour(air))) == 1
    half = colour(bone)
    page.get_by_role("slider", name="Strength of the colours").fill("100")
    stack.wait_until(lambda: colour(bone) != half, what="stronger colours")
    full = colour(bone)
    # Half the strength is halfway between the grey and the colour, each rounded.
    assert all(abs(h - (g + f) / 2) <= 1 for h, g, f in zip(half, grey, full)), (half, grey, full)
    page.screenshot(path=pictures / "overlay.png")
    page.locator("[data-preset=airways]").evaluate("(button) => button.click()")  # another one covers the row of looks
    stack.wait_until(lambda: len(set(colour(bone))) == 1, what="a look without bone")
    page.reload()
    expect(page.get_by_role("checkbox", name="Colours")).to_be_checked()
    expect(page.get_by_role("checkbox", name="Smooth")).not_to_be_checked()


def one_alone_by_mouse(reader: Reader) -> None:
    """A double click maximises one slice and restores all. Settings are kept."""
    page, window = reader.page, reader.window()
    page.get_by_role("radio", name="Window").check()
    page.mouse.dblclick(*reader.at("axial", 20, 20))
    expect(page.locator(".slice-pane")).to_have_count(1)
    expect(page.locator(".stage > canvas")).to_be_hidden()
    reader.shows_what_the_formula_says("axial", spots_of(reader.planes["axial"], 6))
    page.mouse.dblclick(*reader.at("axial", 20, 20))
    expect(page.locator(".slice-pane")).to_have_count(3)
    assert reader.window() == window
    expect(page.locator(".stage > canvas")).to_be_visible()
    # Panned with the middle button and zoomed with the right one, the point under the hand stays.
    x, y = reader.at("coronal", 30, 20)
    page.mouse.move(x, y)
    page.mouse.down(button="middle")
    page.mouse.move(x + 40, y + 20, steps=4)
    page.mouse.up(button="middle")
    page.mouse.down(button="right")
    page.mouse.move(x + 40, y - 40, steps=4)
    page.mouse.up(button="right")
    page.mouse.move(x + 40, y + 20)
    reader.says("coronal", int(reader.planes["coronal"].voxels[reader.index("coronal"), 20, 30]))
    page.get_by_role("button", name="Reset the slices").click()
    reader.shows_what_the_formula_says("coronal", spots_of(reader.planes["coronal"], 6))


def test_slices_work_by_keyboard_and_pass_the_accessibility_check(stack: TestStack, visit, cranium: Path):
    page = visit()
    person = Person.arrives(stack, page, "kai")
    reader = Reader(stack, page, person.has_scan(cranium, "Head"))
    page.keyboard.press("v")
    for plane in PLANES:
        reader.index(plane)
    page.evaluate(AXE.read_text())
    found = page.evaluate("axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'], resultTypes: ['violations'] })")
    assert [(one["id"], [node["html"] for node in one["nodes"]]) for one in found["violations"]] == []

    axial = reader.canvas("axial")
    for _ in range(60):  # by Tab alone
        if axial.evaluate("(c) => c === document.activeElement"):
            break
        page.keyboard.press("Tab")
    expect(axial).to_be_focused()
    begun = reader.index("axial")
    last = reader.planes["axial"].voxels.shape[0] - 1
    for key, index in (("ArrowDown", begun + 1), ("PageDown", min(last, begun + 11)), ("Home", 0), ("End", last), ("PageUp", max(0, last - 10))):
        page.keyboard.press(key)
        expect(axial).to_have_attribute("data-index", str(index))
    expect(reader.pane("axial").get_by_role("status")).to_contain_text(f"Axial {index + 1}/{last + 1}")

    # A ruler: a point, five pixels of the crosshair, a point.
    page.get_by_role("radio", name="Ruler").focus()
    page.keyboard.press("Space")
    axial.focus()
    sagittal = reader.index("sagittal")
    page.keyboard.press("Enter")
    for _ in range(5):
        page.keyboard.press("Shift+ArrowRight")
    expect(reader.canvas("sagittal")).to_have_attribute("data-index", str(sagittal + 5))
    page.keyboard.press("Enter")
    expect(reader.pane("axial").locator(".slice-measure text")).to_have_text(f"{5 * reader.planes['axial'].width:.1f} mm")
    page.keyboard.press("Delete")
    expect(reader.pane("axial").locator(".slice-measure")).to_have_count(0)
    ellipse_by_keys(reader)

    page.keyboard.press("m")
    expect(page.locator(".slice-pane")).to_have_count(1)
    expect(axial).to_be_focused()
    page.keyboard.press("m")
    expect(page.locator(".slice-pane")).to_have_count(3)
    page.keyboard.press("r")
    expect(axial).to_have_attribute("data-index", str(begun))
    page.keyboard.press("v")
    expect(page.locator(".slice-pane")).to_have_count(0)


def ellipse_by_keys(reader: Reader) -> None:
    """Two corners at the crosshair, and then its lower end is picked up and put down."""
    page, axial, plane = reader.page, reader.canvas("axial"), reader.planes["axial"]
    page.get_by_role("radio", name="Ellipse").focus()
    page.keyboard.press("Space")
    axial.focus()

    def press(*keys: str) -> None:
        for key in keys:
            page.keyboard.press(key)

    size = reader.pane("axial").locator(".slice-measure tspan").nth(2)
    press("Enter", *["Shift+ArrowRight"] * 8, *["Shift+ArrowDown"] * 6, "Enter")
    expect(size).to_contain_text(f"{math.pi * 4 * plane.width * 3 * plane.height:.1f} mm²")
    press(*["Shift+ArrowLeft"] * 4, "Enter")
    expect(reader.pane("axial").get_by_role("status")).to_contain_text("Picked up")
    press("Shift+ArrowDown", "Shift+ArrowDown", "Enter", "Shift+ArrowDown")
    expect(size).to_contain_text(f"{math.pi * 4 * plane.width * 4 * plane.height:.1f} mm²")
    press("Delete")


def test_a_phone_shows_one_slice_view_at_a_time(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(phone=True)
    person = Person.arrives(stack, page, "pia")
    reader = Reader(stack, page, person.has_scan(cranium, "Head"))
    page.get_by_role("button", name="Show the slices (V)").tap()
    reader.index("axial")
    expect(page.locator(".slice-pane")).to_have_count(1)
    page.screenshot(path=pictures / "phone-axial.png")
    no_label_covers_another(reader, "axial")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    ellipse_by_finger(reader, pictures)
    reader.sharp()
    page.get_by_role("radio", name="Coronal").check()
    reader.index("coronal")
    expect(page.locator(".slice-pane")).to_have_count(1)
    # A tap with the crosshair selects the slices through that position.
    page.get_by_role("radio", name="Crosshair").check()
    page.touchscreen.tap(*reader.at("coronal", 20, 12))
    page.get_by_role("radio", name="Sagittal").check()
    expect(reader.canvas("sagittal")).to_have_attribute("data-index", "20")
    reader.shows_what_the_formula_says("sagittal", spots_of(reader.planes["sagittal"], 6))
    read_by_fingers(reader)
    page.get_by_role("radio", name="3D").check()
    expect(page.locator(".slice-pane")).to_have_count(0)
    expect(page.locator(".stage > canvas")).to_be_visible()
    page.screenshot(path=pictures / "phone-3d.png")


def no_label_covers_another(reader: Reader, plane: str) -> None:
    labels = reader.pane(plane).locator(".slice-letter, .slice-title, .slice-facts, .slice-scale, .slice-slider")
    boxes = [label.bounding_box() for label in labels.all()]
    assert len(boxes) == 8
    for i, a in enumerate(boxes):
        for b in boxes[:i]:
            apart = a["x"] + a["width"] <= b["x"] or b["x"] + b["width"] <= a["x"] or a["y"] + a["height"] <= b["y"] or b["y"] + b["height"] <= a["y"]
            assert apart, (a, b)
    # The bar is as long as it says.
    bar = reader.pane(plane).locator(".slice-scale")
    number, unit = bar.text_content().split()
    length = float(number) * {"mm": 1, "cm": 10}[unit] * reader.planes[plane].per_mm(reader.canvas(plane).bounding_box())
    assert abs(bar.bounding_box()["width"] - length) < 1


def ellipse_by_finger(reader: Reader, pictures: Path) -> None:
    page, fingers = reader.page, Fingers(reader.page)
    page.get_by_role("radio", name="Ellipse").check()
    x, y = (round(n) for n in reader.at("axial", 60, 60))
    fingers.drag([((x, y), (x + 80, y + 60))])
    shows_region(reader, "axial", (x, y), (x + 80, y + 60))
    fingers.drag([((x + 40, y + 30), (x + 20, y + 40))])
    shows_region(reader, "axial", (x - 20, y + 10), (x + 60, y + 70))
    page.screenshot(path=pictures / "phone-ellipse.png")
    page.get_by_role("button", name="Delete the last measurement").tap()


def read_by_fingers(reader: Reader) -> None:
    """One finger makes it darker, two pan and zoom, three scroll through the slices."""
    page, plane = reader.page, reader.planes["sagittal"]
    fingers = Fingers(page)
    _, rows, columns = plane.voxels.shape
    spot = (columns // 2, rows // 2)
    x, y = reader.at("sagittal", *spot)
    page.get_by_role("radio", name="Window").check()
    centre, width = reader.window()
    fingers.drag([((x, y), (x + 30, y + 40))])
    assert reader.window()[0] < centre and reader.window()[1] > width
    reader.shows_what_the_formula_says("sagittal", spots_of(plane, 6))

    before = reader.index("sagittal")
    fingers.drag([((x + right, y), (x + right, y + 66)) for right in (-40, 0, 40)])
    expect(reader.canvas("sagittal")).to_have_attribute("data-index", str(before + 5))  # 12 pixels each
    reader.shows_what_the_formula_says("sagittal", spots_of(plane, 6))

    reader.set_window(30, 120)  # where the voxels have many grey values
    # Both fingers move 50 px to the right, and the voxels below them follow. Then the distance doubles around a fixed voxel.
    fingers.drag([((x - 20, y), (x + 30, y)), ((x + 20, y), (x + 70, y))])
    fingers.drag([((x + 30, y), (x + 10, y)), ((x + 70, y), (x + 90, y))])
    grown = 2 * plane.per_mm(reader.canvas("sagittal").bounding_box())
    box = reader.canvas("sagittal").bounding_box()
    index, (window_centre, window_width) = reader.index("sagittal"), reader.window()
    for column in range(spot[0] - 8, spot[0] + 9, 4):
        for row in range(spot[1] - 6, spot[1] + 7, 3):
            at = (x + 50 - box["x"] + (column - spot[0]) * plane.width * grown, y - box["y"] + (row - spot[1]) * plane.height * grown)
            value = int(plane.voxels[index, row, column])
            expected = 255 * min(1, max(0, (value - window_centre) / window_width + 0.5))
            assert abs(reader.grey_at("sagittal", *at) - expected) <= 0.5, (column, row, value)
