"""Compares the slices beside the picture, as a browser shows them, with the stored voxels in numpy."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from playwright.sync_api import Locator, Page, expect

from harness import TestStack

PLANES = ("axial", "sagittal", "coronal")
#: Runs in the page: whether a view is drawn in its present size, which it learns at the next frame of the browser.
IN_SIZE = """(canvas) => canvas.clientWidth > 0 && canvas.width === Math.round(canvas.clientWidth * devicePixelRatio)
    && canvas.height === Math.round(canvas.clientHeight * devicePixelRatio)"""


@dataclass
class Plane:
    """The position of the slices of one plane, from the volume's header alone, for volumes along the patient's axes."""

    voxels: np.ndarray  # slice, row, column
    width: float  # mm per pixel
    height: float

    @staticmethod
    def of(folder: Path) -> dict[str, Plane]:
        header = json.loads((folder / "volume.json").read_text())
        direction = np.array(header["direction"]).reshape(3, 3)
        voxels = np.fromfile(folder / "voxels.i16", "<i2").reshape(header["size"][::-1]).transpose(2, 1, 0)  # x, y, z
        order = [int(np.argmax(np.abs(direction[k]))) for k in range(3)]  # voxel axis along each of the patient's axes
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
        """Returns the centre of a pixel in the view, in CSS pixels."""
        _, rows, columns = self.voxels.shape
        mm = self.per_mm(box)
        return (box["width"] / 2 + (column - (columns - 1) / 2) * self.width * mm, box["height"] / 2 + (row - (rows - 1) / 2) * self.height * mm)


class Reader:
    """A user viewing the slices of one scan."""

    def __init__(self, stack: TestStack, page: Page, scan: str):
        self.stack, self.page = stack, page
        self.planes = Plane.of(stack.data_dir / "volumes" / scan)
        page.goto(f"{stack.url}/view/{scan}")
        expect(page.locator(".stage > canvas[data-samples]")).to_be_visible()

    def pane(self, plane: str) -> Locator:
        return self.page.locator(f".slice-pane[data-plane={plane}]")

    def canvas(self, plane: str) -> Locator:
        return self.pane(plane).locator("canvas")

    def in_size(self, plane: str) -> Locator:
        """Waits until a view that has just appeared or changed its size is drawn in that size, and understands the pointer there."""
        canvas = self.canvas(plane)
        self.stack.wait_until(lambda: canvas.evaluate(IN_SIZE) or self.page.wait_for_timeout(20), 120, f"the {plane} view in its size")
        return canvas

    def index(self, plane: str) -> int:
        expect(self.in_size(plane)).to_have_attribute("data-came", "true")
        return int(self.canvas(plane).get_attribute("data-index"))

    def at(self, plane: str, column: int, row: int) -> tuple[float, float]:
        """Returns the position in the page."""
        box = self.in_size(plane).bounding_box()
        x, y = self.planes[plane].place(box, column, row)
        return box["x"] + x, box["y"] + y

    def spot(self, plane: str, x: float, y: float) -> tuple[float, float]:
        """Returns the column and row at a position in the page, as fractions of pixels."""
        box = self.canvas(plane).bounding_box()
        area = self.canvas(plane).evaluate("(canvas) => ({ width: canvas.clientWidth, height: canvas.clientHeight })")
        one = self.planes[plane]
        (x0, y0), mm = one.place(area, 0, 0), one.per_mm(area)
        return (x - box["x"] - x0) / (one.width * mm), (y - box["y"] - y0) / (one.height * mm)

    def pixel(self, plane: str, x: float, y: float) -> list[int]:
        """Returns RGBA at a position of the view in CSS pixels."""
        return self.in_size(plane).evaluate(
            "(canvas, [x, y]) => [...canvas.getContext('2d').getImageData(x * devicePixelRatio, y * devicePixelRatio, 1, 1).data]", [x, y])

    def grey_at(self, plane: str, x: float, y: float) -> int:
        return self.pixel(plane, x, y)[0]

    def set_window(self, centre: int, width: int) -> None:
        for label, value in (("Centre", centre), ("Width", width)):
            field = self.page.get_by_label(label, exact=True)
            field.fill(str(value))
            field.press("Enter")

    def window(self) -> tuple[int, int]:
        return tuple(int(self.page.get_by_label(label, exact=True).input_value()) for label in ("Centre", "Width"))

    def sharp(self) -> None:
        """Shows each voxel as a rectangle."""
        self.page.get_by_role("checkbox", name="Smooth").uncheck()

    def says(self, plane: str, value: int) -> None:
        expect(self.pane(plane).locator(".slice-value")).to_have_text(f"{value} HU".replace("-", "−"))

    def shows_what_the_formula_says(self, plane: str, spots: list[tuple[int, int]]) -> None:
        centre, width = self.window()
        for column, row in spots:
            value = int(self.planes[plane].voxels[self.index(plane), row, column])
            expected = 255 * min(1, max(0, (value - centre) / width + 0.5))
            red, green, blue, alpha = self.pixel(plane, *self.planes[plane].place(self.canvas(plane).bounding_box(), column, row))
            assert red == green == blue and alpha == 255
            assert abs(red - expected) <= 0.5, (plane, column, row, value, red, expected)


    def region(self, plane: str, one: tuple[float, float], other: tuple[float, float]) -> tuple[np.ndarray, float]:
        """Returns the values in the ellipse between two corners in the page, and its area in mm²."""
        (left, top), (right, bottom) = self.spot(plane, *one), self.spot(plane, *other)
        across, down = abs(right - left) / 2, abs(bottom - top) / 2
        slice_ = self.planes[plane].voxels[self.index(plane)]
        row, column = np.mgrid[: slice_.shape[0], : slice_.shape[1]]
        inside = ((column - (left + right) / 2) / across) ** 2 + ((row - (top + bottom) / 2) / down) ** 2 <= 1
        return slice_[inside], np.pi * across * self.planes[plane].width * down * self.planes[plane].height

    def shows_interpolated_values(self, plane: str, count: int) -> None:
        """Compares device pixels with the values that numpy interpolates linearly between the voxels."""
        centre, width = self.window()
        slice_ = self.planes[plane].voxels[self.index(plane)].astype(float)
        box, random = self.canvas(plane).bounding_box(), np.random.default_rng(6)
        for _ in range(count):
            x, y = (int(random.integers(int(0.3 * side), int(0.7 * side))) for side in (box["width"], box["height"]))
            column, row = self.spot(plane, box["x"] + x + 0.5, box["y"] + y + 0.5)
            left, top = int(column), int(row)
            across, down = column - left, row - top
            value = (1 - down) * ((1 - across) * slice_[top, left] + across * slice_[top, left + 1]) + down * ((1 - across) * slice_[top + 1, left] + across * slice_[top + 1, left + 1])
            expected = 255 * min(1, max(0, (value - centre) / width + 0.5))
            # The value is rounded to an integer, and the grey to one of 256.
            assert abs(self.grey_at(plane, x, y) - expected) <= 0.51 + 0.5 * 255 / width, (plane, column, row, value)


def spots_of(plane: Plane, count: int) -> list[tuple[int, int]]:
    random = np.random.default_rng(5)
    _, rows, columns = plane.voxels.shape
    return [(int(random.integers(columns)), int(random.integers(rows))) for _ in range(count)]
