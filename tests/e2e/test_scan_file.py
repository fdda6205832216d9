"""The export of a scan as a file for other programs, in the dialog "Save or share"."""

from __future__ import annotations

import gzip
from pathlib import Path

import nibabel
import numpy as np
import trimesh
from playwright.sync_api import Locator, expect

from harness import TestStack
from person import Person
from picture import wait_for_picture
from test_labels import LEFT, ORIGIN, PART, STEP, add_labels, halves, nifti, person, phantom  # noqa: F401

TITLE = "Export the scan for other programs"
#: Time for the server to make a file while it renders, in ms.
PATIENCE_MS = 60_000


def open_export(person: Person) -> Locator:  # noqa: F811
    person.page.get_by_role("button", name="Save or share", exact=True).click()
    dialog = person.page.get_by_role("dialog", name="Save or share")
    part = dialog.get_by_role("region", name=TITLE)
    expect(part.get_by_text("The file may identify the patient")).to_be_visible()
    return part


def download(person: Person, part: Locator, name: str, into: Path) -> Path:  # noqa: F811
    expect(part.get_by_role("link", name="Download")).to_be_visible(timeout=PATIENCE_MS)
    with person.page.expect_download() as file:
        part.get_by_role("link", name="Download").click()
    assert file.value.suggested_filename == name
    path = into / name
    file.value.save_as(path)
    return path


def test_a_scan_and_its_parts_are_exported(stack: TestStack, person: Person, tmp_path: Path, pictures: Path):  # noqa: F811
    page = person.page
    (tmp_path / "labels.nii.gz").write_bytes(gzip.compress(nifti(halves(), PART)))
    dialog = add_labels(person, tmp_path / "labels.nii.gz")
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    dialog.get_by_role("button", name="Close").last.click()
    person.open_scan("block")
    wait_for_picture(stack, page)

    part = open_export(person)
    part.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "scan-file.png")
    part.get_by_role("button", name="Create the file").click()
    image = nibabel.load(download(person, part, "scan.nii.gz", tmp_path))
    assert np.array_equal(np.asarray(image.dataobj), phantom())
    x, y, z = ORIGIN
    expected = np.array([[-STEP[0], 0, 0, -x], [0, -STEP[1], 0, -y], [0, 0, STEP[2], z], [0, 0, 0, 1]])
    assert np.allclose(image.affine, expected)
    part.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "scan-file-ready.png")

    part.get_by_role("button", name="Delete the file").click()
    part.get_by_label("Format").select_option(label="3D model for printing (STL)")
    part.get_by_label("Part of the scan").select_option(label=f"Structure {LEFT}")
    part.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "scan-file-part.png")
    part.get_by_role("button", name="Create the file").click()
    mesh = trimesh.load(download(person, part, "surface.stl", tmp_path))
    assert mesh.is_watertight
    # Half of the block: 19 x 30 x 26 voxels, whose edges smoothing rounds.
    size = np.array((19, 30, 26)) * STEP
    assert np.abs(mesh.extents - size).max() < max(STEP)

    part.get_by_role("button", name="Delete the file").click()
    part.get_by_label("Format").select_option(label="3D model with colour (glTF)")
    value = part.get_by_label("Lowest value of the part")
    expect(value).to_have_value("1200")    # the upper quartile; the file does not say that the scan is a CT
    value.fill("bone")
    part.get_by_role("button", name="Create the file").click()
    expect(part.get_by_text("Enter a whole number between")).to_be_visible()
    page.screenshot(path=pictures / "scan-file-wrong.png")
    value.fill("1000")
    part.get_by_role("button", name="Create the file").click()
    model = trimesh.load(download(person, part, "surface.glb", tmp_path), force="mesh")
    assert model.is_watertight
    # The block of 36 x 28 x 24 voxels, in metres and with the head up.
    left, back, head = np.array((36, 28, 24)) * STEP / 1000
    assert np.abs(model.extents - (left, head, back)).max() < max(STEP) / 1000


def test_the_export_fits_a_phone(stack: TestStack, person: Person, pictures: Path):  # noqa: F811
    page = person.page
    person.open_scan("block")
    wait_for_picture(stack, page)
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("button", name="Save or share", exact=True).click()
    part = page.get_by_role("dialog").get_by_role("region", name=TITLE)
    part.get_by_label("Format").select_option(label="3D model for printing (STL)")
    part.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "scan-file-phone.png")
    assert page.get_by_role("dialog").evaluate("(dialog) => dialog.scrollWidth <= dialog.clientWidth"), "nothing is cut off"
