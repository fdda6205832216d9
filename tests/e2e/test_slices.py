"""The slices beside the picture, held against the stored voxels by numpy."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from playwright.sync_api import Locator, Page, expect

from harness import REPO, TestStack
from person import Person

AXE = REPO / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
PLANES = ("axial", "sagittal", "coronal")


@dataclass
class Plane:
    """Where the slices of one plane lie: from the volume's header alone, for volumes along the patient's axes."""

    voxels: np.ndarray  # slice, row, column
    width: float  # mm of a pixel
    height: float

    @staticmethod
    def of(folder: Path) -> dict[str, Plane]:
        header = json.loads((folder / "volume.json").read_text())
        direction = np.array(header["direction"]).reshape(3, 3)
        voxels = np.fromfile(folder / "voxels.i16", "<i2").reshape(header["size"][::-1]).transpose(2, 1, 0)  # x, y, z
        order = [int(np.argmax(np.abs(direction[k]))) for k in range(3)]  # the voxel axis along each of the patient's
        patient = voxels.transpose(order)
        for k in range(3):
            if direction[k][order[k]] < 0:
                patient = np.flip(patient, k)
        x, y, z = (header["spacing"][order[k]] for k in range(3))
        return {"axial": Plane(patient.transpose(2, 1, 0), x, y), "coronal": Plane(np.flip(patient, 2).transpose(1, 2, 0), x, z),
                "sagittal": Plane(np.flip(patient, 2).transpose(0, 2, 1), y, z)}

    def per_mm(self, box: dict) -> float:
        _, rows, columns = self.voxels.shape
        return 0.94 * min(box["width"] / (columns * self.width), box["height"] / (rows * self.height))

    def place(self, box: dict, column: int, row: int) -> tuple[float, float]:
        """Of a pixel's middle in the view, CSS pixels."""
        _, rows, columns = self.voxels.shape
        mm = self.per_mm(box)
        return (box["width"] / 2 + (column - (columns - 1) / 2) * self.width * mm, box["height"] / 2 + (row - (rows - 1) / 2) * self.height * mm)


class Reader:
    """Somebody before the slices of one scan."""

    def __init__(self, stack: TestStack, page: Page, scan: str):
        self.page = page
        self.planes = Plane.of(stack.data_dir / "volumes" / scan)
        page.goto(f"{stack.url}/view/{scan}")
        expect(page.locator(".stage > canvas[data-samples]")).to_be_visible()

    def pane(self, plane: str) -> Locator:
        return self.page.locator(f".slice-pane[data-plane={plane}]")

    def canvas(self, plane: str) -> Locator:
        return self.pane(plane).locator("canvas")

    def index(self, plane: str) -> int:
        expect(self.canvas(plane)).to_have_attribute("data-came", "true")
        return int(self.canvas(plane).get_attribute("data-index"))

    def at(self, plane: str, column: int, row: int) -> tuple[float, float]:
        """In the page."""
        box = self.canvas(plane).bounding_box()
        x, y = self.planes[plane].place(box, column, row)
        return box["x"] + x, box["y"] + y

    def grey(self, plane: str, column: int, row: int) -> list[int]:
        x, y = self.planes[plane].place(self.canvas(plane).bounding_box(), column, row)
        return self.canvas(plane).evaluate(
            "(canvas, [x, y]) => [...canvas.getContext('2d').getImageData(x * devicePixelRatio, y * devicePixelRatio, 1, 1).data]", [x, y])

    def set_window(self, centre: int, width: int) -> None:
        for label, value in (("Centre", centre), ("Width", width)):
            field = self.page.get_by_label(label, exact=True)
            field.fill(str(value))
            field.press("Enter")

    def window(self) -> tuple[int, int]:
        return tuple(int(self.page.get_by_label(label, exact=True).input_value()) for label in ("Centre", "Width"))

    def says(self, plane: str, value: int) -> None:
        expect(self.pane(plane).locator(".slice-value")).to_have_text(f"{value} HU".replace("-", "−"))

    def shows_what_the_formula_says(self, plane: str, spots: list[tuple[int, int]]) -> None:
        centre, width = self.window()
        for column, row in spots:
            value = int(self.planes[plane].voxels[self.index(plane), row, column])
            expected = 255 * min(1, max(0, (value - centre) / width + 0.5))
            red, green, blue, alpha = self.grey(plane, column, row)
            assert red == green == blue and alpha == 255
            assert abs(red - expected) <= 0.5, (plane, column, row, value, red, expected)


def spots_of(plane: Plane, count: int) -> list[tuple[int, int]]:
    random = np.random.default_rng(5)
    _, rows, columns = plane.voxels.shape
    return [(int(random.integers(columns)), int(random.integers(rows))) for _ in range(count)]


def test_slices_show_the_voxels_of_the_file_and_the_crosshair_links_them(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)  # so wide that a voxel is no smaller than a pixel of the screen
    person = Person.arrives(stack, page, "sasha")
    scan = person.has_scan(cranium, "Head")
    reader = Reader(stack, page, scan)
    page.keyboard.press("v")
    for plane in PLANES:
        # The middle of the volume.
        slices = reader.planes[plane].voxels.shape[0]
        assert abs(reader.index(plane) - (slices - 1) / 2) <= 0.5
    page.screenshot(path=pictures / "four-up.png")

    # Values under the pointer, and what is drawn of them.
    for plane in PLANES:
        spots = spots_of(reader.planes[plane], 6)
        for column, row in spots:
            page.mouse.move(*reader.at(plane, column, row))
            reader.says(plane, int(reader.planes[plane].voxels[reader.index(plane), row, column]))
        reader.shows_what_the_formula_says(plane, spots)

    # The window, typed and dragged; what is no number is put back.
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

    # The crosshair links: Shift and moving in one slice goes through that place in the others.
    _, rows, columns = reader.planes["axial"].voxels.shape
    column, row = columns // 4, rows // 3
    page.keyboard.down("Shift")
    page.mouse.move(*reader.at("axial", column - 1, row))
    page.mouse.move(*reader.at("axial", column, row))
    page.keyboard.up("Shift")
    expect(reader.canvas("sagittal")).to_have_attribute("data-index", str(column))
    expect(reader.canvas("coronal")).to_have_attribute("data-index", str(row))
    here = int(reader.planes["axial"].voxels[reader.index("axial"), row, column])
    page.mouse.move(5, 5)  # no pointer on a slice: the crosshair's
    for plane in PLANES:
        reader.index(plane)
        reader.says(plane, here)

    # The wheel goes through the slices.
    before = reader.index("axial")
    page.mouse.move(*reader.at("axial", column, row))
    page.mouse.wheel(0, 120)
    expect(reader.canvas("axial")).to_have_attribute("data-index", str(before + 1))
    reader.says("axial", int(reader.planes["axial"].voxels[before + 1, row, column]))


def test_keys_alone_read_slices_and_a_checker_finds_no_fault(stack: TestStack, visit, cranium: Path):
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

    page.keyboard.press("m")
    expect(page.locator(".slice-pane")).to_have_count(1)
    expect(axial).to_be_focused()
    page.keyboard.press("m")
    expect(page.locator(".slice-pane")).to_have_count(3)
    page.keyboard.press("r")
    expect(axial).to_have_attribute("data-index", str(begun))
    page.keyboard.press("v")
    expect(page.locator(".slice-pane")).to_have_count(0)


def test_on_a_phone_slices_come_one_at_a_time(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(phone=True)
    person = Person.arrives(stack, page, "pia")
    reader = Reader(stack, page, person.has_scan(cranium, "Head"))
    page.get_by_role("button", name="Show the slices (V)").tap()
    reader.index("axial")
    expect(page.locator(".slice-pane")).to_have_count(1)
    page.screenshot(path=pictures / "phone-axial.png")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.get_by_role("radio", name="Coronal").check()
    reader.index("coronal")
    expect(page.locator(".slice-pane")).to_have_count(1)
    # A tap with the crosshair, then the slice through that place.
    page.get_by_role("radio", name="Crosshair").check()
    page.touchscreen.tap(*reader.at("coronal", 20, 12))
    page.get_by_role("radio", name="Sagittal").check()
    expect(reader.canvas("sagittal")).to_have_attribute("data-index", "20")
    reader.shows_what_the_formula_says("sagittal", spots_of(reader.planes["sagittal"], 6))
    page.get_by_role("radio", name="3D").check()
    expect(page.locator(".slice-pane")).to_have_count(0)
    expect(page.locator(".stage > canvas")).to_be_visible()
    page.screenshot(path=pictures / "phone-3d.png")
