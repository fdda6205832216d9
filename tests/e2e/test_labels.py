"""Labels of a scan: a file of structures is added to a scan, and the structures are listed, shown and named."""

from __future__ import annotations

import gzip
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, Route, expect

from harness import TestStack
from person import Person
from picture import SIDE, pixels
from slice_reader import Reader

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
    expect(dialog.get_by_text("You haven’t added any labels to this scan.")).to_be_visible()
    dialog.get_by_test_id("label-file").set_input_files(tmp_path / "letter.txt")
    expect(dialog.get_by_text("This isn’t a file of labels.")).to_be_visible()
    dialog.get_by_test_id("label-file").set_input_files(tmp_path / "labels.nii")
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    dialog.get_by_test_id("label-file").set_input_files(tmp_path / "elsewhere.nii")
    expect(dialog.get_by_text(re.compile("These labels do not belong to this scan"))).to_be_visible()
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    dialog.get_by_role("button", name="Remove the labels").click()
    expect(dialog.get_by_text("You haven’t added any labels to this scan.")).to_be_visible()


def corners() -> np.ndarray:
    """Two blocks as labels: one at the patient's left, in front and near the head, and one at the right, behind and near the feet."""
    values = np.zeros(SIZE, np.uint8)
    values[35:41, 7:11, 21:27], values[7:11, 25:33, 5:8] = LEFT, RIGHT
    return values


def in_planes(voxels: np.ndarray) -> dict[str, np.ndarray]:
    """Returns slice, row and column of an array towards the patient's left, back and head, as a radiologist sees them."""
    from_head = np.flip(voxels, 2)
    return {"axial": voxels.transpose(2, 1, 0), "coronal": from_head.transpose(1, 2, 0), "sagittal": from_head.transpose(0, 2, 1)}


def shows_labels(reader: Reader, plane: str, labels: np.ndarray, colours: dict[int, list[int]], strength: float) -> None:
    """Compares five places in every voxel of the shown slice with its label's colour over its grey."""
    centre, width = reader.window()
    index = reader.index(plane)
    grey = np.clip((reader.planes[plane].voxels[index] - centre) / width + 0.5, 0, 1) * 255
    canvas = reader.in_size(plane)
    box = canvas.evaluate("(canvas) => ({ width: canvas.clientWidth, height: canvas.clientHeight })")
    rows, columns = labels[index].shape
    (left, top), (right, bottom) = (reader.planes[plane].place(box, *corner) for corner in ((0, 0), (1, 1)))
    for across, down in ((0, 0), (-0.3, 0), (0.3, 0), (0, -0.3), (0, 0.3)):
        spots = [[left + (column + across) * (right - left), top + (row + down) * (bottom - top)] for row in range(rows) for column in range(columns)]
        seen = np.array(canvas.evaluate(
            """(canvas, spots) => {
              const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
              return spots.map(([x, y]) => [...data.slice(4 * (Math.floor(y * devicePixelRatio) * width + Math.floor(x * devicePixelRatio))).slice(0, 3)]);
            }""", spots)).reshape(rows, columns, 3)
        for number, colour in {0: None, **colours}.items():
            where = labels[index] == number
            expected = grey[where][:, None] if colour is None else (1 - strength) * grey[where][:, None] + strength * np.array(colour)
            # The grey, the colour and the opacity are rounded to one of 256.
            assert np.abs(seen[where] - expected).max(initial=0) <= 2, (plane, index, number, across, down)


def go_to(reader: Reader, column: int, row: int, slice_: int) -> None:
    """Moves the crosshair to a voxel towards the patient's left, back and head."""
    for plane, index in (("sagittal", column), ("coronal", row), ("axial", slice_)):
        reader.pane(plane).get_by_role("slider").fill(str(index))
        reader.stack.wait_until(lambda: reader.index(plane) == index or reader.page.wait_for_timeout(20), 60, f"{plane} slice {index}")


def test_slices_show_labels_exactly_and_name_what_is_pressed(person: Person, tmp_path: Path, pictures: Path):
    page = person.page
    scan = person.card("block").get_attribute("data-id")
    (tmp_path / "labels.nii").write_bytes(nifti(corners()))
    dialog = add_labels(person, tmp_path / "labels.nii")
    expect(dialog.get_by_text("This scan has 2 labels")).to_be_visible()
    reader = Reader(person.stack, page, scan)
    list_ = page.get_by_role("navigation", name="Picture settings").get_by_role("button", name="Labels")
    list_.click()
    row = {number: page.locator(f".label-list li[data-label='{number}']") for number in (LEFT, RIGHT)}
    colours = {number: [int(row[number].locator("circle").get_attribute("fill")[i:i + 2], 16) for i in (1, 3, 5)] for number in row}
    list_.click()
    page.get_by_role("button", name="Show the slices").click()
    switch = page.get_by_role("checkbox", name="Labels")
    expect(switch).to_be_checked()
    reader.set_window(100, 4000)
    planes = in_planes(corners())
    for smooth in (True, False):
        page.get_by_role("checkbox", name="Smooth").set_checked(smooth)
        for number, voxel in ((LEFT, (37, 8, 23)), (RIGHT, (8, 28, 6))):
            go_to(reader, *voxel)
            for plane in planes:
                expect(reader.pane(plane).locator(".slice-label")).to_have_text(f"Structure {number}")
                if not smooth:
                    shows_labels(reader, plane, planes[plane], colours, 0.5)
        page.screenshot(path=pictures / f"labels-in-slices-{'smooth' if smooth else 'sharp'}.png")

    page.get_by_label("Strength of the labels").fill("100")
    shows_labels(reader, "axial", planes["axial"], colours, 1)
    list_.click()
    page.mouse.click(*reader.at("axial", 9, 29))
    expect(row[RIGHT].get_by_label("Colour", exact=True)).to_be_visible()
    page.screenshot(path=pictures / "labels-in-slices-pressed.png")
    page.get_by_label(f"Show only Structure {LEFT}").click()
    shows_labels(reader, "axial", planes["axial"], {RIGHT: None}, 1)
    page.get_by_label(f"Show only Structure {LEFT}").click()
    list_.click()
    switch.uncheck()
    shows_labels(reader, "axial", planes["axial"], {RIGHT: None}, 1)
    expect(page.get_by_label("Strength of the labels")).to_be_hidden()


def test_an_interrupted_upload_resumes(person: Person, tmp_path: Path, pictures: Path):
    page, parts = person.page, "**/v1/uploads/*"
    (tmp_path / "halves.nii").write_bytes(nifti(halves(), PART))
    announced: list[str] = []
    page.on("request", lambda request: announced.append(request.url) if request.method == "POST" and request.url.endswith("/labels") else None)

    def lose(route: Route) -> None:
        route.abort() if route.request.method == "PATCH" else route.continue_()

    page.route(parts, lose)
    dialog = add_labels(person, tmp_path / "halves.nii")
    expect(dialog.get_by_role("status")).to_have_text("The connection was lost. The upload will resume automatically.")
    page.screenshot(path=pictures / "labels-interrupted.png")
    page.unroute(parts)
    expect(dialog.get_by_role("status")).to_contain_text("This scan has 2 labels")
    assert len(announced) == 1

    # The page is closed during the upload of another file, and the same file is chosen again.
    (tmp_path / "others.nii").write_bytes(nifti(np.where(halves() == LEFT, 5, halves()).astype(np.uint8), PART))
    page.route(parts, lose)
    dialog.get_by_test_id("label-file").set_input_files(tmp_path / "others.nii")
    expect(dialog.get_by_role("status")).to_contain_text("The connection was lost")
    page.reload()
    page.unroute(parts)  # only now, so that the closed page could not finish the upload
    with page.expect_request(lambda request: request.method == "HEAD" and "/v1/uploads/" in request.url):
        dialog = add_labels(person, tmp_path / "others.nii")
    expect(dialog.get_by_role("status")).to_contain_text("This scan has 2 labels")
    assert len(announced) == 2, "the second choice of the file is not another upload"


def test_a_rejected_file_can_be_sent_again_without_choosing_it(person: Person, tmp_path: Path):
    page, parts = person.page, "**/v1/uploads/*"
    (tmp_path / "halves.nii").write_bytes(nifti(halves(), PART))
    page.route(parts, lambda route: route.fulfill(status=400))
    dialog = add_labels(person, tmp_path / "halves.nii")
    expect(dialog.get_by_text("The server rejected the file. Try again.")).to_be_visible()
    page.unroute(parts)
    dialog.get_by_role("button", name="Try again").click()
    expect(dialog.get_by_role("status")).to_contain_text("This scan has 2 labels")
