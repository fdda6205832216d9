"""Adding a scan: what is refused in which words, and an upload that is cut."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person


@pytest.fixture
def person(stack: TestStack, visit) -> Person:
    return Person.arrives(stack, visit(), "anna")


def some_slices(cranium: Path, folder: Path, count: int | None = None) -> list[Path]:
    folder.mkdir()
    return [Path(shutil.copy(path, folder)) for path in sorted(cranium.iterdir())[:count]]


def test_a_folder_without_dicom_is_refused_in_words(person: Person, tmp_path: Path):
    (tmp_path / "letter.pdf").write_bytes(b"%PDF-1.7 not a scan at all, and longer than a preamble" * 10)
    (tmp_path / "lies.dcm").write_text("its name says more than is true")
    person.choose_folder(tmp_path)
    expect(person.page.get_by_role("alert")).to_contain_text("None of the 2 files is a DICOM file")


def test_three_slices_are_refused_with_their_number(person: Person, cranium: Path, tmp_path: Path):
    some_slices(cranium, tmp_path / "few", 3)
    person.choose_folder(tmp_path / "few")
    expect(person.page.get_by_text("Too few slices: 3, and 16 are needed for a volume.")).to_be_visible()


def test_a_scout_alone_is_refused_as_a_scout(person: Person, cranium: Path, tmp_path: Path):
    for path in some_slices(cranium, tmp_path / "scout", 2):
        path.write_bytes(with_image_type(path.read_bytes(), b"ORIGINAL\\PRIMARY\\LOCALIZER"))
    person.choose_folder(tmp_path / "scout")
    expect(person.page.get_by_role("heading", name="Nothing here can become a volume")).to_be_visible()
    expect(person.page.get_by_text("This is a scout (a picture to plan the scan by), not a volume.")).to_be_visible()


def test_a_dropped_folder_is_looked_into(person: Person, cranium: Path, tmp_path: Path):
    disc = tmp_path / "disc"
    (disc / "DICOM").mkdir(parents=True)
    some_slices(cranium, disc / "DICOM" / "SE1")  # more files than a directory's reader gives at a time
    (disc / "readme.txt").write_text("start viewer.exe")
    page = person.page
    page.goto(person.stack.url + "/add")
    drop(page, disc)
    expect(page.get_by_text("One series can be shown")).to_be_visible()
    expect(page.get_by_text("108 slices")).to_be_visible()
    expect(page.get_by_text("1 file is not DICOM and left alone.")).to_be_visible()


def test_a_scan_over_the_quota_is_refused_with_both_sizes(person: Person, cranium: Path):
    person.stack.psql("UPDATE users SET quota_bytes = 5000000 WHERE email = %s", person.email)
    page = person.page
    person.choose_folder(cranium)
    page.get_by_role("button", name="Upload", exact=True).click()
    expect(page.get_by_role("alert")).to_have_text(
        re.compile(r"This scan needs \d+(\.\d)? MB, and 5(\.0)? MB of your space is free\. Delete a scan first\."))
    page.goto(person.stack.url + "/scans")
    expect(page.get_by_text("No scans yet")).to_be_visible()


def test_a_truncated_slice_in_the_middle_is_missed(person: Person, cranium: Path, tmp_path: Path):
    slices = some_slices(cranium, tmp_path / "torn")
    slices[50].write_bytes(slices[50].read_bytes()[:20_000])
    person.choose_folder(tmp_path / "torn")
    expect(person.page.get_by_text("1 slice is missing within the series; copy the disc again.")).to_be_visible()


def test_a_tiny_file_that_claims_a_huge_picture_stops_nothing(person: Person, cranium: Path, tmp_path: Path):
    slices = some_slices(cranium, tmp_path / "trap", 30)
    head = slices[0].read_bytes()
    rows = head.index(b"\x28\x00\x10\x00US\x02\x00")
    columns = head.index(b"\x28\x00\x11\x00US\x02\x00")
    lie = bytearray(head[:columns + 10])
    lie[rows + 8:rows + 10] = lie[columns + 8:columns + 10] = b"\xff\xff"
    (tmp_path / "trap" / "lie").write_bytes(bytes(lie))
    person.choose_folder(tmp_path / "trap")
    expect(person.page.get_by_text(re.compile("can be shown|Nothing here|hidden"))).not_to_have_count(0)


def test_a_cut_upload_goes_on_by_itself_and_after_a_reload(person: Person, cranium: Path):
    page = person.page
    offsets = watch_parts(page)
    cut = {"on": True}

    def maybe_cut(route):
        if route.request.method == "PATCH" and cut["on"] and route.request.headers.get("upload-offset") != "0":
            route.abort("connectionreset")
        else:
            route.continue_()

    page.route("**/v1/uploads/*", maybe_cut)
    person.upload(cranium, "Cut head")
    expect(person.card("Cut head")).to_contain_text("The upload goes on by itself")

    page.reload()
    expect(person.card("Cut head")).to_contain_text(re.compile(r"Interrupted at \d\d %"))
    cut["on"] = False
    offsets.clear()
    person.upload(cranium, "Cut head")
    expect(person.card("Cut head")).to_have_attribute("data-state", "ready", timeout=60_000)
    expect(person.card("Cut head")).to_have_count(1)  # the same data set went on
    assert offsets == ["8388608"]


def test_each_part_carries_its_checksum(person: Person, cranium: Path):
    checksums = []
    person.page.on("request", lambda request: checksums.append(request.headers.get("upload-checksum", ""))
                   if request.method == "PATCH" else None)
    person.has_scan(cranium, "Checked head")
    assert len(checksums) == 2
    assert all(re.fullmatch(r"sha1 [A-Za-z0-9+/]{27}=", checksum) for checksum in checksums)


def test_a_scan_is_deleted_after_a_question(person: Person, cranium: Path):
    person.has_scan(cranium, "Short-lived")
    page = person.page
    page.get_by_role("button", name="Delete Short-lived").click()
    expect(page.get_by_role("dialog")).to_contain_text("gone for good")
    page.keyboard.press("Escape")
    expect(person.card("Short-lived")).to_have_count(1)
    page.get_by_role("button", name="Delete Short-lived").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(person.card("Short-lived")).to_have_count(0)


def with_image_type(file: bytes, value: bytes) -> bytes:
    """The same file with another ImageType (0008,0008), of even length; explicit little endian."""
    at = file.index(b"\x08\x00\x08\x00CS")
    length = int.from_bytes(file[at + 6:at + 8], "little")
    return file[:at + 6] + len(value).to_bytes(2, "little") + value + file[at + 8 + length:]


def drop(page: Page, folder: Path) -> None:
    """As from a file manager onto the middle of the field: the browser itself opens the folder."""
    box = page.get_by_text("Drop a folder here").bounding_box()
    devtools = page.context.new_cdp_session(page)
    for kind in ("dragEnter", "dragOver", "drop"):
        devtools.send("Input.dispatchDragEvent", {
            "type": kind, "x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2,
            "data": {"items": [], "files": [str(folder)], "dragOperationsMask": 1}})
    devtools.detach()


def watch_parts(page: Page) -> list[str]:
    offsets: list[str] = []
    page.on("request", lambda request: offsets.append(request.headers["upload-offset"])
            if request.method == "PATCH" else None)
    return offsets
