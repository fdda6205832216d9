"""The whole portal: a disc with several series becomes a picture, is anonymised, found by another user, and deleted."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from playwright.sync_api import expect

from harness import TestStack
from person import PASSWORD, Person
from picture import wait_for_samples


@pytest.fixture
def disc(cranium: Path, tmp_path: Path) -> Path:
    """A valid series, a short one, a mostly damaged one, and other files of a disc."""
    import pydicom
    from pydicom.uid import generate_uid

    folder = tmp_path / "DISC"
    shutil.copytree(cranium, folder / "SER1")
    files = sorted((folder / "SER1").iterdir())
    for number, (name, count) in enumerate((("SER2", 5), ("SER3", 20)), 2):
        (folder / name).mkdir()
        series = generate_uid()
        for source in files[:count]:
            slices = pydicom.dcmread(source)
            slices.SeriesInstanceUID = series
            slices.SOPInstanceUID = slices.file_meta.MediaStorageSOPInstanceUID = generate_uid()
            slices.SeriesNumber = number
            if name == "SER3":
                slices.SOPClassUID = slices.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.7"  # a screenshot
                slices.Modality = "OT"
            slices.save_as(folder / name / source.name)
    (folder / "AUTORUN.INF").write_text("[autorun]\nopen=viewer.exe\n")
    (folder / "README.TXT").write_text("This disc was made for you.")
    return folder


def test_a_scan_is_uploaded_anonymised_published_and_deleted(stack: TestStack, visit, disc: Path, pictures: Path):
    anna = Person.signs_up_and_in(stack, visit(wide=True), "anna")
    page = anna.page
    anna.choose_folder(disc)
    expect(page.get_by_text("1 image series can be shown")).to_be_visible()
    page.screenshot(path=pictures / "portal-disc.png")
    page.get_by_label("Your name for this scan").fill("From my disc")
    page.get_by_role("button", name="Upload", exact=True).click()
    expect(anna.card("From my disc")).to_have_attribute("data-state", "ready")
    data_set = anna.card("From my disc").get_attribute("data-id")

    # Removing the face.
    anna.open_scan("From my disc")
    page.get_by_role("button", name="Share this scan").click()
    page.get_by_role("link", name="Cut and anonymise").click()
    expect(page.get_by_text("This scan shows a head")).to_be_visible()
    wait_for_samples(stack, page, 2)
    page.get_by_role("button", name="Cut permanently…").click()
    expect(page.get_by_text("also sees its title, its description and the names of its presets")).to_be_visible()
    page.get_by_label("I have looked at it from all sides").check()
    page.get_by_role("button", name="Cut permanently", exact=True).click()
    expect(page.get_by_role("heading", name="The cut is finished")).to_be_visible()

    # Publishing the rest.
    page.get_by_role("link", name="View and share the scan").click()
    expect(page.locator("canvas[data-samples]")).to_be_visible()
    page.get_by_role("button", name="Share this scan").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Body part").select_option("head")
    dialog.get_by_role("button", name="Save", exact=True).click()
    expect(dialog.get_by_text("Saved.")).to_be_visible()
    dialog.get_by_role("button", name="Add to the gallery").click()
    expect(dialog.get_by_text("The scan is now in the gallery.")).to_be_visible()
    dialog.get_by_role("button", name="Close").click()

    # Another user finds it, views it, and saves their look.
    bert = Person.arrives(stack, visit(small=True), "bert")
    bert.page.get_by_role("link", name="Gallery").click()
    bert.page.get_by_label("Words in the title").fill("my disc")
    bert.page.get_by_role("link", name="View From my disc").click()
    expect(bert.page.locator("canvas[data-samples]")).to_be_visible()
    bert.page.get_by_role("button", name="Saved presets").click()
    dialog = bert.page.get_by_role("dialog")
    dialog.get_by_label("Name of the new preset").fill("Without a face")
    dialog.get_by_role("button", name="Save the current view").click()
    expect(dialog.get_by_role("button", name="Show Without a face")).to_be_visible()
    dialog.get_by_role("button", name="Close").click()

    # The owner deletes the account, and everything is gone.
    page.goto(stack.url + "/account")
    page.get_by_role("button", name="Delete my account…").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Current password").fill(PASSWORD)
    dialog.get_by_role("button", name="Delete account").click()
    expect(page.get_by_text("Your account and all its data have been deleted.")).to_be_visible()
    expect(bert.page.get_by_role("status").get_by_text("This scan doesn’t exist, or you don’t have access to it.")).to_be_visible()
    stack.wait_until(lambda: not (stack.data_dir / "volumes" / data_set).exists(), what="the volume's end")
    stack.wait_until(lambda: not (stack.data_dir / "cache" / "thumbnails" / data_set).exists(), what="the pictures' end")
    for table, column in (("data_sets", "id"), ("presets", "data_set_id"), ("ingest_jobs", "data_set_id"), ("disposals", "id")):
        stack.wait_until(lambda t=table, c=column: stack.psql(f"SELECT count(*) FROM {t} WHERE {c} = %s", data_set) == [(0,)],
                         what=f"nothing of it in {table}")
    assert stack.psql("SELECT count(*) FROM users WHERE email_key = %s", anna.email) == [(0,)]

    def left() -> list[str]:
        return [place for place, _, names in os.walk(stack.data_dir) if data_set in " ".join((place, *names))]

    stack.wait_until(lambda: left() == [], what="no file of it, wherever it may be")
    bert.page.goto(stack.url + "/gallery")
    expect(bert.page.get_by_role("link", name="View From my disc")).not_to_be_visible()
