"""Labels from DICOM: a segmentation and a structure set are added through the page to a scan that the page uploaded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, expect

from devtool.ingest_cases.phantom import Series, dataset, stack as slices, write
from dicom_labels import segmentation, structure_set
from harness import TestStack
from person import Person

ROWS, COLUMNS, COUNT = 44, 48, 24
PLACES = slices(COUNT, 2.0, origin=(-16.8, -17.2, -24.0), rows=ROWS, columns=COLUMNS, intercept=-2000.0)
FRAME = "1.2.826.0.1.3680043.2.1143.77"
#: As a careless program writes it into every text of a file.
CANARY = "Jane Canary"


def block(places: np.ndarray) -> np.ndarray:
    """Bone in air."""
    inside = (np.abs(places) < (12.0, 11.0, 16.0)).all(-1)
    return np.where(inside, 1200.0, -1000.0)


@pytest.fixture
def person(stack: TestStack, visit, tmp_path: Path) -> Person:
    person = Person.arrives(stack, visit(), "sara")
    write(tmp_path / "disc", [dataset(Series(values=block, extra={"FrameOfReferenceUID": FRAME}), one) for one in PLACES])
    person.page.goto(stack.url + "/add")
    person.uploads_scan(tmp_path / "disc", "block")
    return person


def add(person: Person, file: Path) -> Locator:
    person.card("block").get_by_role("button", name="Labels of block").click()
    dialog = person.page.get_by_role("dialog", name="Labels of block")
    dialog.get_by_test_id("label-file").set_input_files(file)
    return dialog


def listed(person: Person) -> Locator:
    person.open_scan("block")
    person.page.get_by_role("navigation", name="Picture settings").get_by_role("button", name="Labels").click()
    return person.page.locator(".label-list li")


def is_kept_private(person: Person) -> bool:
    folder = person.stack.data_dir / "volumes" / person.card("block").get_attribute("data-id")
    return CANARY.encode() not in (folder / "label_set").read_bytes() and CANARY not in (folder / "volume.json").read_text()


def test_a_segmentation_is_added_with_its_names_and_exact_volumes(person: Person, tmp_path: Path, pictures: Path):
    masks = {name: np.zeros((COUNT, ROWS, COLUMNS), bool) for name in ("Tumour", "Vessel")}
    masks["Tumour"][5:15, 10:30, 8:24] = True
    masks["Vessel"][4:20, 20:24, 30:34] = True
    segmentation(tmp_path / "labels.dcm", PLACES, masks, FRAME, CANARY)
    dialog = add(person, tmp_path / "labels.dcm")
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    dialog.get_by_role("button", name="Close").last.click()
    assert is_kept_private(person)
    rows = listed(person)
    expect(rows).to_have_count(3)
    expect(rows.last).to_contain_text("Bone")       # found by the server
    # 10 x 20 x 16 and 16 x 4 x 4 voxels of 0.8 x 0.7 x 2 mm.
    expect(rows.filter(has_text="Tumour")).to_contain_text("3.58 ml")
    expect(rows.filter(has_text="Vessel")).to_contain_text("0.29 ml")
    person.page.get_by_label("Show the structures in colour").check()
    person.page.wait_for_timeout(1500)
    person.page.screenshot(path=pictures / "dicom-seg.png")


def test_a_structure_set_is_added_and_one_of_another_scan_is_refused(person: Person, tmp_path: Path, pictures: Path):
    # 16 columns, 20 rows and 10 slices, from the middle between two voxels to the next.
    x, y = (-16.8 + 7.5 * 0.7, -16.8 + 23.5 * 0.7), (-17.2 + 9.5 * 0.8, -17.2 + 29.5 * 0.8)
    outline = [[[(x[0], y[0], z), (x[1], y[0], z), (x[1], y[1], z), (x[0], y[1], z)] for z in (-24.0 + 2 * i for i in range(5, 15))]]
    structure_set(tmp_path / "foreign.dcm", {"Liver": outline[0]}, "1.2.3.4", CANARY)
    dialog = add(person, tmp_path / "foreign.dcm")
    expect(dialog.get_by_role("alert")).to_be_visible()
    person.page.screenshot(path=pictures / "dicom-rtstruct-refused.png")
    dialog.get_by_role("button", name="Close").last.click()
    structure_set(tmp_path / "labels.dcm", {"Liver": outline[0]}, FRAME, CANARY)
    dialog = add(person, tmp_path / "labels.dcm")
    expect(dialog.get_by_text("This scan has 1 label")).to_be_visible()
    dialog.get_by_role("button", name="Close").last.click()
    assert is_kept_private(person)
    rows = listed(person)
    expect(rows).to_have_count(2)
    expect(rows.last).to_contain_text("Bone")
    expect(rows.first).to_contain_text("Liver")
    expect(rows.first).to_contain_text("3.58 ml")
