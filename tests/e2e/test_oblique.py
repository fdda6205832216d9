"""Tilted slices and slabs, compared with an interpolation in numpy, and what is measured in them and in the picture."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from playwright.sync_api import expect

from harness import TestStack
from person import Person
from slice_reader import Plane, Reader
from test_marks import MARKS, at, opens, window
from test_pages import check_page

DEGREES = 17


def interpolated(axial: Plane, spacing: np.ndarray, place: np.ndarray) -> float:
    """Returns the trilinear value at a place in mm from the middle of a volume along the patient's axes."""
    voxels = axial.voxels.transpose(2, 1, 0).astype(float)  # x, y, z
    index = np.clip(place / spacing + (np.array(voxels.shape) - 1) / 2, 0, np.array(voxels.shape) - 1)
    low = np.minimum(index.astype(int), np.array(voxels.shape) - 2)
    part = index - low
    value = 0.0
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, part, 1 - part))
        value += weight * voxels[tuple(low + corner)]
    return value


def test_tilted_slices_show_trilinear_values_and_can_be_measured(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "ottilie")
    reader = Reader(stack, page, person.has_scan(cranium, "Head"))
    page.keyboard.press("v")
    reader.index("axial")
    reader.canvas("axial").focus()
    for _ in range(DEGREES):
        page.keyboard.press(".")
    expect(reader.pane("sagittal").locator(".slice-title")).to_contain_text(f"tilted {DEGREES}.0°")
    expect(reader.pane("axial").locator(".slice-title")).not_to_contain_text("tilted")
    reader.index("sagittal")

    axial, sagittal = reader.planes["axial"], reader.planes["sagittal"]
    spacing = np.array([axial.width, axial.height, sagittal.height])
    step = spacing.min()
    angle = np.radians(DEGREES)
    right, down = np.array([-np.sin(angle), np.cos(angle), 0]), np.array([0, 0, -1.0])
    normal = np.array([np.cos(angle), np.sin(angle), 0])
    slices = int(reader.pane("sagittal").locator(".slice-slider").get_attribute("max")) + 1
    offset = (reader.index("sagittal") - (slices - 1) / 2) * step
    box = reader.in_size("sagittal").bounding_box()
    pixels = sagittal.per_mm(box)
    random = np.random.default_rng(3)
    differences = []
    while len(differences) < 12:
        x, y = (int(random.integers(int(0.35 * side), int(0.65 * side))) for side in (box["width"], box["height"]))
        exact = np.array([(x - box["width"] / 2) / (step * pixels), (y - box["height"] / 2) / (step * pixels)])
        column, row = np.round(exact)
        if np.abs(exact - (column, row)).max() > 0.3:
            continue  # near the border of a pixel, where the browser's rounding of the pointer decides
        page.mouse.move(box["x"] + x, box["y"] + y)
        text = reader.pane("sagittal").locator(".slice-value")
        expect(text).to_have_text(re.compile(r"HU, interpolated$"))
        got = int(text.text_content().split()[0].replace("−", "-"))
        differences.append(abs(got - interpolated(axial, spacing, column * step * right + row * step * down + offset * normal)))
    assert max(differences) <= 0.5 + 1e-3, differences  # the value is rounded
    page.screenshot(path=pictures / "oblique.png")

    # By mouse: a quarter of a turn around the crosshair in the coronal view.
    page.get_by_role("radio", name="Tilt").check()
    box = reader.in_size("coronal").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(middle[0] + 90, middle[1])
    page.mouse.down()
    page.mouse.move(middle[0] + 85, middle[1] + 30, steps=4)
    page.mouse.up()
    expect(reader.pane("axial").locator(".slice-title")).to_contain_text("tilted")
    page.screenshot(path=pictures / "oblique-handles.png")

    # A slab, and a ruler and an ellipse in it.
    field = page.get_by_label("Slab, mm", exact=True)
    field.fill("12")
    field.press("Enter")
    page.get_by_role("combobox", name="Values of the slab").select_option("maximum")
    expect(reader.pane("axial").locator(".slice-title")).to_contain_text("12 mm maximum")
    reader.index("axial")
    for tool, top in (("Ruler", 0.3), ("Ellipse", 0.5)):
        page.get_by_role("radio", name=tool).check()
        box = reader.canvas("axial").bounding_box()
        page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + top * box["height"])
        page.mouse.down()
        page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + (top + 0.12) * box["height"], steps=3)
        page.mouse.up()
    texts = reader.pane("axial").locator(".slice-measure text")
    expect(texts).to_have_count(2)
    expect(texts.first).to_have_text(re.compile(r"^\d+\.\d mm$"))
    expect(texts.last).to_contain_text("Mean")
    page.screenshot(path=pictures / "oblique-slab.png")
    said = texts.all_text_contents()
    page.reload()
    expect(texts).to_have_count(2)
    expect(texts.first).to_have_text(said[0])
    expect(texts.last).to_have_text(said[1])
    page.get_by_role("button", name="Undo the tilt").click()
    expect(reader.pane("axial").locator(".slice-title")).not_to_contain_text("tilted")
    page.get_by_role("button", name="Reset the slices").click()
    expect(reader.canvas("axial")).not_to_have_attribute("data-oblique", "")
    check_page(page)


def test_distances_and_angles_are_measured_in_the_picture_by_mouse_and_keys(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "metra")
    opens(stack, page, person.has_scan(cranium, "Head"))
    window(page).get_by_role("button", name="Ruler", exact=True).click()
    page.mouse.click(*at(page, 0.45, 0.4))
    expect(page.locator(".mark-message")).to_have_text("Now press point 2 of 2.")
    page.mouse.click(*at(page, 0.55, 0.55))
    ruler = page.locator(MARKS + "[data-kind=ruler] text")
    expect(ruler).to_have_text(re.compile(r"^[1-9]\d*\.\d mm$"))
    # By keys: three points from the middle of the picture.
    window(page).get_by_role("button", name="Angle", exact=True).click()
    expect(page.locator(".picker")).to_be_focused()
    for point, move in ((2, "Shift+ArrowUp"), (3, "Shift+ArrowRight")):
        page.keyboard.press("Enter")
        expect(page.locator(".mark-message")).to_have_text(f"Now press point {point} of 3.")
        page.keyboard.press(move)
    page.keyboard.press("Enter")
    expect(page.locator(MARKS + "[data-kind=angle] text")).to_have_text(re.compile(r"^[1-9]\d*\.\d°$"))
    page.screenshot(path=pictures / "measured-in-3d.png")
    check_page(page)
    # A ruler that lacks its second point is given up.
    window(page).get_by_role("button", name="Ruler", exact=True).click()
    page.mouse.click(*at(page, 0.5, 0.5))
    expect(page.locator(MARKS + "[data-kind=ruler]")).to_have_count(2)
    page.keyboard.press("Escape")
    expect(page.locator(MARKS + "[data-kind=ruler]")).to_have_count(1)
