"""Adding a scan: refusals with their messages, and interrupted uploads."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person

#: Bytes of the first part of an upload (frontend/src/api/upload.ts).
FIRST_PART = str(1 << 20)


@pytest.fixture
def person(stack: TestStack, visit) -> Person:
    return Person.arrives(stack, visit(), "anna")


def some_slices(cranium: Path, folder: Path, count: int | None = None) -> list[Path]:
    folder.mkdir()
    return [Path(shutil.copy(path, folder)) for path in sorted(cranium.iterdir())[:count]]


def test_a_folder_without_dicom_is_refused_with_a_message(person: Person, tmp_path: Path):
    (tmp_path / "letter.pdf").write_bytes(b"%PDF-1.7 not a scan at all, and longer than a preamble" * 10)
    (tmp_path / "lies.dcm").write_text("its name says more than is true")
    person.choose_folder(tmp_path)
    expect(person.page.get_by_role("alert")).to_contain_text("None of these 2 files is a DICOM file")


def test_three_slices_are_refused_with_their_number(person: Person, cranium: Path, tmp_path: Path):
    some_slices(cranium, tmp_path / "few", 3)
    person.choose_folder(tmp_path / "few")
    expect(person.page.get_by_text("There are only 3 slices. At least 16 are needed to show depth.")).to_be_visible()


def test_a_lone_scout_is_refused_with_a_message(person: Person, cranium: Path, tmp_path: Path):
    for path in some_slices(cranium, tmp_path / "scout", 2):
        path.write_bytes(with_image_type(path.read_bytes(), b"ORIGINAL\\PRIMARY\\LOCALIZER"))
    person.choose_folder(tmp_path / "scout")
    expect(person.page.get_by_role("heading", name="No scan found that can be shown")).to_be_visible()
    expect(person.page.get_by_text("This is an overview image that was used to plan the scan.")).to_be_visible()


def test_a_dropped_folder_is_scanned(person: Person, cranium: Path, tmp_path: Path):
    disc = tmp_path / "disc"
    (disc / "DICOM").mkdir(parents=True)
    some_slices(cranium, disc / "DICOM" / "SE1")  # more files than a directory reader returns at a time
    (disc / "readme.txt").write_text("start viewer.exe")
    page = person.page
    page.goto(person.stack.url + "/add")
    drop(page, disc)
    expect(page.get_by_text("1 image series can be shown")).to_be_visible()
    expect(page.get_by_text("108 slices")).to_be_visible()
    expect(page.get_by_text("1 file is not a DICOM file and was ignored.")).to_be_visible()


def test_a_scan_over_the_quota_is_refused_with_both_sizes(person: Person, cranium: Path):
    person.stack.psql("UPDATE users SET quota_bytes = 5000000 WHERE email = %s", person.email)
    page = person.page
    person.choose_folder(cranium)
    page.get_by_role("button", name="Upload", exact=True).click()
    expect(page.get_by_role("alert")).to_have_text(
        re.compile(r"This scan needs \d+(\.\d)? MB of storage, but you have only 5(\.0)? MB left\. Delete another scan first\."))
    page.goto(person.stack.url + "/scans")
    expect(page.get_by_text("No scans yet")).to_be_visible()


def test_truncated_slices_are_reported_as_missing(person: Person, cranium: Path, tmp_path: Path):
    slices = some_slices(cranium, tmp_path / "torn")
    for torn in slices[50:54]:  # one more missing slice than is interpolated
        torn.write_bytes(torn.read_bytes()[:20_000])
    person.choose_folder(tmp_path / "torn")
    expect(person.page.get_by_text("4 slices are missing from this series. Try copying the files from the disc again.")).to_be_visible()


def test_a_tiny_file_with_a_huge_claimed_size_is_skipped(person: Person, cranium: Path, tmp_path: Path):
    slices = some_slices(cranium, tmp_path / "trap", 30)
    head = slices[0].read_bytes()
    rows = head.index(b"\x28\x00\x10\x00US\x02\x00")
    columns = head.index(b"\x28\x00\x11\x00US\x02\x00")
    lie = bytearray(head[:columns + 10])
    lie[rows + 8:rows + 10] = lie[columns + 8:columns + 10] = b"\xff\xff"
    (tmp_path / "trap" / "lie").write_bytes(bytes(lie))
    person.choose_folder(tmp_path / "trap")
    expect(person.page.get_by_text(re.compile("can be shown|can’t be shown"))).not_to_have_count(0)


def test_an_interrupted_upload_resumes_also_after_a_reload(person: Person, cranium: Path):
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
    expect(person.card("Cut head")).to_contain_text("The upload will resume automatically")

    page.reload()
    expect(person.card("Cut head")).to_contain_text(re.compile(r"Interrupted at [1-9]\d?%"))
    expect(person.card("Cut head").locator(".chip, .card-working")).to_have_count(0)  # it does not look busy
    expect(person.card("Cut head")).to_contain_text("Choose the same folder again")
    cut["on"] = False
    offsets.clear()
    person.choose_folder(cranium)
    expect(page.get_by_text(re.compile(r"was interrupted at [1-9]\d?%\. It will resume where it stopped"))).to_be_visible()
    page.get_by_role("button", name="Resume upload").click()
    expect(person.card("Cut head")).to_have_attribute("data-state", "ready")
    expect(person.card("Cut head")).to_have_count(1)  # the same data set was resumed
    assert offsets[0] == FIRST_PART and offsets == sorted(set(offsets), key=int)  # each part once


class Dam:
    """Lets the first part of each upload pass and holds the others back until it is opened."""

    def __init__(self, page: Page):
        self.page, self.held, self.open = page, [], False
        page.route("**/v1/uploads/*", self.maybe_hold)

    def maybe_hold(self, route) -> None:
        if self.open or route.request.method != "PATCH" or route.request.headers.get("upload-offset") == "0":
            route.continue_()
        else:
            self.held.append(route)

    def wait(self, stack: TestStack, uploads: int = 1) -> None:
        """Waits until the first part of each upload is stored, after which the browser sends the next one."""
        stack.wait_until(lambda: self.page.wait_for_timeout(50) or len(self.held) >= uploads, 120, "the second part")

    def opens(self) -> None:
        self.open = True
        for route in self.held:
            try:
                route.continue_()
            except Exception:  # noqa: BLE001 - what the page has given up meanwhile
                pass


def test_an_upload_can_be_paused_resumed_and_cancelled(person: Person, cranium: Path):
    page, stack = person.page, person.stack
    dam = Dam(page)
    person.upload(cranium, "Paused head")
    card = person.card("Paused head")
    dam.wait(stack)
    expect(card).to_contain_text(re.compile(r"[1-9]\d?%"))
    upload = stack.data_dir / "uploads" / f"{card.get_attribute('data-id')}.tar"
    page.get_by_role("button", name="Pause the upload of Paused head").click()
    expect(card).to_contain_text(re.compile(r"Paused at [1-9]\d?%\."))
    dam.opens()
    offsets = watch_parts(page)
    # On other pages it continues, and the bar on every page shows it.
    page.get_by_role("link", name="Add a scan").first.click()
    expect(page.get_by_role("link", name=re.compile("1 upload, "))).to_be_visible()
    page.get_by_role("link", name=re.compile("1 upload, ")).click()
    assert offsets == []
    page.get_by_role("button", name="Resume the upload of Paused head").click()
    expect(card).to_have_attribute("data-state", "ready")
    assert offsets[0] == FIRST_PART and offsets == sorted(set(offsets), key=int)  # each part once
    stack.wait_until(lambda: not upload.exists(), what="the removal of the original")  # ingest does that last

    dam = Dam(page)
    person.upload(cranium, "Unwanted head")
    card = person.card("Unwanted head")
    dam.wait(stack)
    expect(card).to_contain_text(re.compile(r"[1-9]\d?%"))
    upload = stack.data_dir / "uploads" / f"{card.get_attribute('data-id')}.tar"
    assert upload.exists()
    page.get_by_role("button", name="Cancel the upload of Unwanted head").click()
    page.get_by_role("dialog").get_by_role("button", name="Keep uploading").click()
    page.get_by_role("button", name="Cancel the upload of Unwanted head").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel upload").click()
    expect(card).to_have_count(0)
    stack.wait_until(lambda: not upload.exists(), what="the file's disposal")


def test_parallel_uploads_are_shown_in_other_windows(person: Person, cranium: Path, tmp_path: Path):
    page = person.page
    dam = Dam(page)
    person.upload(cranium, "First head")
    some_slices(cranium, tmp_path / "other", 80)
    # With the page's own links: the upload continues while the user views other pages.
    page.get_by_role("link", name="Add a scan").first.click()
    page.get_by_label("Choose a folder").set_input_files(tmp_path / "other")
    page.get_by_label("Your name for this scan").fill("Second head")
    page.get_by_role("button", name="Upload", exact=True).click()
    for title in ("First head", "Second head"):
        expect(person.card(title)).to_contain_text(re.compile(r"[1-9]\d?%"))
    dam.wait(person.stack, uploads=2)  # both at once

    second = page.context.new_page()
    second.goto(person.stack.url + "/scans")
    for title in ("First head", "Second head"):
        expect(second.locator("article.card", has_text=title)).to_contain_text(re.compile(r"[1-9]\d?%, in another window"))
    second.goto(person.stack.url + "/add")
    second.get_by_label("Choose a folder").set_input_files(cranium)
    second.get_by_role("button", name="Resume upload").click()
    expect(second.get_by_role("alert")).to_contain_text("being uploaded in another window")
    second.close()

    dam.opens()
    for title in ("First head", "Second head"):
        expect(person.card(title)).to_have_attribute("data-state", "ready")


def test_a_full_disk_is_reported_and_the_upload_resumes(person: Person, cranium: Path):
    """A limit on the size of the server's files simulates a full disk: a part is written up to it, then refused."""
    page, stack = person.page, person.stack
    limit_files(stack, "9000000")
    try:
        person.upload(cranium, "Large head")
        expect(person.card("Large head")).to_contain_text("The server has run out of space. What you have uploaded so far is kept")
        scan = person.card("Large head").get_attribute("data-id")
        upload = stack.data_dir / "uploads" / f"{scan}.tar"

        def accepted() -> int:
            """The bytes of the parts before the refused one. On a slow machine, these are more than the first."""
            return stack.psql("SELECT received FROM uploads WHERE data_set_id = %s", scan)[0][0]

        # Nothing of the refused part is left, except while the page tries again.
        stack.wait_until(lambda: upload.stat().st_size == accepted(), what="the removal of the refused part")
        assert int(FIRST_PART) <= accepted() < 9_000_000
    finally:
        limit_files(stack, "unlimited")
    # A minute is long for a test, and users who do not want to wait have these two buttons.
    page.get_by_role("button", name="Pause the upload of Large head").click()
    page.get_by_role("button", name="Resume the upload of Large head").click()
    expect(person.card("Large head")).to_have_attribute("data-state", "ready")


def test_each_part_carries_its_checksum(person: Person, cranium: Path):
    checksums = []
    person.page.on("request", lambda request: checksums.append(request.headers.get("upload-checksum", ""))
                   if request.method == "PATCH" else None)
    person.uploads_scan(cranium, "Checked head")
    assert len(checksums) >= 3  # of 14 MB, the first part has at most 1 MiB and the others at most 8
    assert all(re.fullmatch(r"sha1 [A-Za-z0-9+/]{27}=", checksum) for checksum in checksums)


def test_deleting_a_scan_asks_for_confirmation(person: Person, cranium: Path):
    person.has_scan(cranium, "Short-lived")
    page = person.page
    page.get_by_role("button", name="Delete Short-lived").click()
    expect(page.get_by_role("dialog")).to_contain_text("permanently delete")
    page.keyboard.press("Escape")
    expect(person.card("Short-lived")).to_have_count(1)
    page.get_by_role("button", name="Delete Short-lived").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(person.card("Short-lived")).to_have_count(0)


def test_a_corrected_scan_shows_the_figures_on_request(person: Person, cranium: Path):
    scan = person.has_scan(cranium, "Leaning head")
    person.stack.psql("UPDATE data_sets SET repairs = ARRAY['straightened 18.5 degrees (gantry tilt)'] WHERE id = %s", scan)
    page, card = person.page, person.card("Leaning head")
    page.reload()
    expect(card).to_contain_text("We corrected this scan: it was tilted.")
    figures = card.get_by_text("Gantry tilt of 18.5° corrected.")
    expect(figures).not_to_be_visible()
    card.get_by_text("Details", exact=True).click()
    expect(figures).to_be_visible()
    expect(page.get_by_role("heading", name="My scans")).to_be_visible()  # the card's link was not followed


def with_image_type(file: bytes, value: bytes) -> bytes:
    """Returns the file with another ImageType (0008,0008) of even length, in explicit little endian."""
    at = file.index(b"\x08\x00\x08\x00CS")
    length = int.from_bytes(file[at + 6:at + 8], "little")
    return file[:at + 6] + len(value).to_bytes(2, "little") + value + file[at + 8 + length:]


def drop(page: Page, folder: Path) -> None:
    """Drops as from a file manager onto the middle of the field. The browser itself opens the folder."""
    box = page.get_by_text("Drop a folder or a ZIP file here").bounding_box()
    devtools = page.context.new_cdp_session(page)
    for kind in ("dragEnter", "dragOver", "drop"):
        devtools.send("Input.dispatchDragEvent", {
            "type": kind, "x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2,
            "data": {"items": [], "files": [str(folder)], "dragOperationsMask": 1}})
    devtools.detach()


def limit_files(stack: TestStack, most_bytes: str) -> None:
    """Limits the size of api's files. The hard limit stays."""
    command = ["prlimit", "--pid", str(stack.pids["api"]), f"--fsize={most_bytes}:"]
    subprocess.run(command, check=True, **stack.stack.run_as.popen())


def watch_parts(page: Page) -> list[str]:
    offsets: list[str] = []
    page.on("request", lambda request: offsets.append(request.headers.get("upload-offset", ""))
            if request.method == "PATCH" else None)
    return offsets


def test_dropping_a_file_opens_the_upload_page_and_cards_can_be_renamed(person: Person, cranium: Path):
    page = person.page
    page.goto(person.stack.url + "/scans")
    expect(page.get_by_text("No scans yet")).to_be_visible()
    page.evaluate("""() => {
        const data = new DataTransfer();
        data.items.add(new File(["Hello"], "letter.txt"));
        const event = new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true });
        document.body.dispatchEvent(event);
        if (!event.defaultPrevented) throw new Error("the browser would leave the page");
    }""")
    expect(page.get_by_text("This file isn’t a DICOM file.")).to_be_visible()
    person.choose_folder(cranium)
    # The description of this series names the patient, so the suggestion has only the kind of scan and the date.
    expect(page.get_by_label("Your name for this scan")).to_have_value(re.compile(r"^CT, .*2018$"))
    page.get_by_role("button", name="Upload", exact=True).click()
    page.locator("article.card").get_by_role("button", name="Rename CT").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Title").fill("My head in spring")
    dialog.get_by_role("button", name="Save").click()
    expect(person.card("My head in spring")).to_be_visible()


def test_an_archive_is_uploaded_as_its_folder_would_be(person: Person, cranium: Path, tmp_path: Path, pictures: Path):
    page = person.page
    page.goto(person.stack.url + "/add")
    archive = Path(shutil.make_archive(str(tmp_path / "disc"), "zip", cranium))
    (tmp_path / "half.zip").write_bytes(archive.read_bytes()[:archive.stat().st_size // 2])
    chooser = page.get_by_label("Choose files")
    chooser.set_input_files(tmp_path / "half.zip")
    expect(page.get_by_role("alert")).to_contain_text("“half.zip” is damaged or incomplete")
    page.screenshot(path=pictures / "archive-damaged.png")
    page.get_by_role("button", name="Choose other files").click()
    page.screenshot(path=pictures / "archive-choose.png")
    chooser.set_input_files([archive, tmp_path / "half.zip"])
    expect(page.get_by_role("heading", name="1 image series can be shown")).to_be_visible()
    page.screenshot(path=pictures / "archive-found.png")
    watched = watch_parts(page)
    page.get_by_label("Your name for this scan").fill("From an archive")
    page.get_by_role("button", name="Upload", exact=True).click()
    expect(person.card("From an archive")).to_have_attribute("data-state", "ready", timeout=120_000)
    assert watched
    assert "Mustermann" not in page.content()
    # The page recognises the folder as what was uploaded from the archive, and the server stores the same volume.
    person.has_scan(cranium, "From a folder")
    sizes = person.stack.psql("SELECT size_x, size_y, size_z, volume_bytes FROM data_sets WHERE owner_id = (SELECT id FROM users WHERE email_key = %s)",
                              person.email)
    assert len(sizes) == 2 and sizes[0] == sizes[1]


def test_all_series_upload_with_one_click_and_scans_can_be_sorted(person: Person, cranium: Path, tmp_path: Path):
    import pydicom
    from pydicom.uid import generate_uid

    page = person.page
    (tmp_path / "disc").mkdir()
    some_slices(cranium, tmp_path / "disc" / "one")
    series = generate_uid()
    for source in some_slices(cranium, tmp_path / "disc" / "two", 80):
        slices = pydicom.dcmread(source)
        slices.SeriesInstanceUID = series
        slices.SOPInstanceUID = slices.file_meta.MediaStorageSOPInstanceUID = generate_uid()
        slices.SeriesNumber = 2
        slices.save_as(source)
    person.choose_folder(tmp_path / "disc")
    titles = page.get_by_label("Your name for this scan")
    expect(titles).to_have_count(2)
    titles.nth(0).fill("Earlier, 2 Jan 2023")
    titles.nth(1).fill("Later, 4 May 2024")
    page.get_by_role("button", name="Upload all 2").click()
    expect(page.get_by_text("The upload has started.")).to_have_count(2)
    page.get_by_role("link", name="My scans").first.click()
    for title in ("Earlier", "Later"):
        expect(person.card(title)).to_have_attribute("data-state", "ready")
    # Not the sample, which other tests may have published.
    cards = page.locator("article.card[data-state=ready] h3").filter(has_text=re.compile("Earlier|Later"))
    page.get_by_label("Sort by").select_option("title")
    expect(cards.nth(0)).to_contain_text("Earlier")
    expect(cards.nth(1)).to_contain_text("Later")
    page.get_by_label("Sort by").select_option("date")
    page.reload()
    expect(page.get_by_label("Sort by")).to_have_value("date")
    expect(cards.nth(0)).to_contain_text("2024")
    expect(cards.nth(1)).to_contain_text("2023")
