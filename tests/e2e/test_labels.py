"""Labels of a scan: a file of structures is added to a scan, and the structures are listed, shown and named."""

from __future__ import annotations

import gzip
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, expect

from harness import TestStack
from person import Person
from picture import SIDE, pixels

#: Voxels towards the patient's left, back and head, and their distances in mm.
SIZE = (48, 40, 32)
STEP = (1.0, 1.5, 2.0)
#: Where the first voxel lies, in mm to the left, the back and the head.
ORIGIN = (-20.0, 35.0, -400.0)
#: As a careless program writes it into a header.
CANARY = "Jane Canary"
LEFT, RIGHT = 3, 8


def nifti(values: np.ndarray, origin: tuple[float, ...] = ORIGIN) -> bytes:
    """A file whose axes run to the left, to the back and to the head."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *values.shape, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, *{np.int16: (4, 16), np.uint8: (2, 8)}[values.dtype.type])
    struct.pack_into("<4f", header, 76, 1, *STEP)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[148:148 + len(CANARY)] = CANARY.encode()
    struct.pack_into("<h", header, 254, 1)
    x, y, z = origin
    # In the frame of NIfTI (right, front, head), row by row.
    struct.pack_into("<12f", header, 280, -STEP[0], 0, 0, -x, 0, -STEP[1], 0, -y, 0, 0, STEP[2], z)
    header[344:347] = b"n+1"
    return bytes(header) + values.tobytes(order="F")


def phantom() -> np.ndarray:
    """A block of bone in air."""
    values = np.full(SIZE, -1000, np.int16)
    values[6:42, 6:34, 4:28] = 1200
    return values


def halves() -> np.ndarray:
    """The two halves of the block as labels, on a part of the scan's grid that has a margin around the block."""
    values = np.zeros((38, 30, 26), np.uint8)
    values[:19], values[19:] = RIGHT, LEFT
    return values


#: Where the first voxel of the labels lies.
PART = tuple(o + first * step for o, first, step in zip(ORIGIN, (5, 5, 3), STEP))


@pytest.fixture
def person(stack: TestStack, visit, tmp_path: Path) -> Person:
    person = Person.arrives(stack, visit(), "lara")
    (tmp_path / "scan.nii").write_bytes(nifti(phantom()))
    person.page.goto(stack.url + "/add")
    person.page.get_by_label("Choose files").set_input_files([tmp_path / "scan.nii"])
    person.page.get_by_label("Your name for this scan").fill("block")
    person.page.get_by_role("button", name="Upload", exact=True).click()
    expect(person.card("block")).to_have_attribute("data-state", "ready")
    return person


def open_dialog(person: Person) -> Locator:
    person.card("block").get_by_role("button", name="Labels of block").click()
    dialog = person.page.get_by_role("dialog", name="Labels of block")
    expect(dialog).to_be_visible()
    return dialog


def add_labels(person: Person, file: Path) -> Locator:
    dialog = open_dialog(person)
    dialog.get_by_test_id("label-file").set_input_files(file)
    return dialog


def wait_redness(person: Person, low: float, high: float) -> None:
    """Waits until the picture is on average this much redder than blue."""

    def fits() -> bool:
        shown = np.frombuffer(pixels(person.page), np.uint8).reshape(SIDE, SIDE, 3).astype(float)
        person.page.wait_for_timeout(50)  # lets the page's events arrive
        return low <= (shown[..., 0] - shown[..., 2]).mean() <= high

    person.stack.wait_until(fits, timeout=120, what=f"a redness from {low} to {high}")


def test_labels_are_added_listed_shown_and_named(person: Person, tmp_path: Path, pictures: Path):
    page, stack = person.page, person.stack
    scan = person.card("block").get_attribute("data-id")
    folder = stack.data_dir / "volumes" / scan
    (tmp_path / "labels.nii.gz").write_bytes(gzip.compress(nifti(halves(), PART)))
    dialog = add_labels(person, tmp_path / "labels.nii.gz")
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    page.screenshot(path=pictures / "labels-dialog.png")
    dialog.get_by_role("button", name="Close").last.click()
    expect(person.card("block").get_by_text("2 labels")).to_be_visible()
    assert CANARY.encode() not in (folder / "label_set").read_bytes() and CANARY not in (folder / "volume.json").read_text()

    person.open_scan("block")
    page.get_by_role("navigation", name="Picture settings").get_by_role("button", name="Labels").click()
    rows = page.locator(".label-list li")
    expect(rows).to_have_count(2)
    # 19 x 30 x 26 voxels of 3 mm3.
    expect(rows.first).to_contain_text("44.5 ml")
    page.get_by_label("Show the structures in colour").check()
    rows.first.get_by_role("button", name=f"Structure {LEFT}", exact=True).click()
    page.get_by_label("Colour", exact=True).fill("#e01010")
    wait_redness(person, 8, 255)
    page.screenshot(path=pictures / "labels-window.png")

    page.get_by_role("button", name="What is this?").click()
    picker = page.locator(".picker")
    box = picker.bounding_box()
    # The patient's left is on the right of the picture, beside the window.
    picker.click(position={"x": box["width"] * 0.76, "y": box["height"] * 0.45})
    expect(page.get_by_role("status").filter(has_text=f"Structure {LEFT}")).to_be_visible()
    page.screenshot(path=pictures / "labels-named.png")
    page.get_by_role("button", name="Done").click()

    page.get_by_role("button", name=f"Show only Structure {LEFT}").click()
    wait_redness(person, 8, 255)
    page.screenshot(path=pictures / "labels-solo.png")
    page.get_by_role("button", name=f"Show only Structure {LEFT}").click()
    page.get_by_label(f"Show Structure {LEFT}").uncheck()
    wait_redness(person, -255, 0)
    page.screenshot(path=pictures / "labels-hidden.png")
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_label(f"Show Structure {LEFT}")).to_be_checked()
    wait_redness(person, 8, 255)


def test_labels_of_another_scan_are_refused_and_earlier_ones_stay(person: Person, tmp_path: Path, pictures: Path):
    (tmp_path / "labels.nii").write_bytes(nifti(halves(), PART))
    (tmp_path / "elsewhere.nii").write_bytes(nifti(halves(), (900.0, 900.0, 900.0)))
    (tmp_path / "letter.txt").write_text("no labels")
    dialog = add_labels(person, tmp_path / "elsewhere.nii")
    expect(dialog.get_by_text(re.compile("These labels do not belong to this scan"))).to_be_visible()
    person.page.screenshot(path=pictures / "labels-refused.png")
    expect(dialog.get_by_text("This scan has no labels.")).to_be_visible()
    dialog.get_by_test_id("label-file").set_input_files(tmp_path / "letter.txt")
    expect(dialog.get_by_text("This isn’t a file of labels.")).to_be_visible()
    dialog.get_by_test_id("label-file").set_input_files(tmp_path / "labels.nii")
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    dialog.get_by_test_id("label-file").set_input_files(tmp_path / "elsewhere.nii")
    expect(dialog.get_by_text(re.compile("These labels do not belong to this scan"))).to_be_visible()
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    dialog.get_by_role("button", name="Remove the labels").click()
    expect(dialog.get_by_text("This scan has no labels.")).to_be_visible()
