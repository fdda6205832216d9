"""The whole of the portal: a disc of several series becomes a picture, loses its face, is found by somebody else, and goes."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from playwright.sync_api import expect

from harness import TestStack
from person import PASSWORD, Person
from picture import wait_for_samples


@pytest.fixture
def disc(cranium: Path, tmp_path: Path) -> Path:
    """A good series, one that is too short, one of which most is damaged, and what else lies on a disc."""
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


def test_a_disc_becomes_a_picture_loses_its_face_is_found_and_goes(stack: TestStack, visit, disc: Path, pictures: Path):
    anna = Person.arrives(stack, visit(wide=True), "anna")
    page = anna.page
    anna.choose_folder(disc)
    expect(page.get_by_text("One series can be shown")).to_be_visible()
    page.screenshot(path=pictures / "portal-disc.png")
    page.get_by_label("Your name for this scan").fill("From my disc")
    page.get_by_role("button", name="Upload", exact=True).click()
    expect(anna.card("From my disc")).to_have_attribute("data-state", "ready")
    data_set = anna.card("From my disc").get_attribute("data-id")

    # The face goes.
    anna.open_scan("From my disc")
    page.get_by_role("button", name="Share this scan").click()
    page.get_by_role("link", name="Cut and make anonymous").click()
    expect(page.get_by_text("This scan shows a head")).to_be_visible()
    wait_for_samples(stack, page, 2)
    page.get_by_role("button", name="Cut for good…").click()
    page.get_by_label("I have looked at it from all sides").check()
    page.get_by_role("button", name="Cut it now, for good").click()
    expect(page.get_by_role("heading", name="It is done")).to_be_visible()

    # Everybody may see the rest.
    page.get_by_role("link", name="Look at it, and share it").click()
    expect(page.locator("canvas[data-samples]")).to_be_visible()
    page.get_by_role("button", name="Share this scan").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Part of the body").select_option("head")
    dialog.get_by_role("button", name="Save", exact=True).click()
    expect(dialog.get_by_text("Saved.")).to_be_visible()
    dialog.get_by_role("button", name="Put it into the gallery").click()
    expect(dialog.get_by_text("It is in the gallery.")).to_be_visible()
    dialog.get_by_role("button", name="Close").click()

    # Somebody else finds it, looks, and saves how he looked.
    bert = Person.arrives(stack, visit(small=True), "bert")
    bert.page.get_by_role("link", name="Gallery").click()
    bert.page.get_by_label("Words of the title").fill("my disc")
    bert.page.get_by_role("link", name="Look at From my disc").click()
    expect(bert.page.locator("canvas[data-samples]")).to_be_visible()
    bert.page.get_by_role("button", name="Saved presets").click()
    dialog = bert.page.get_by_role("dialog")
    dialog.get_by_label("Name of the new preset").fill("Without a face")
    dialog.get_by_role("button", name="Save the picture as it is now").click()
    expect(dialog.get_by_role("button", name="Show Without a face")).to_be_visible()
    dialog.get_by_role("button", name="Close").click()

    # The first deletes the account, and everything is gone.
    page.goto(stack.url + "/account")
    page.get_by_role("button", name="Delete my account…").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Current password").fill(PASSWORD)
    dialog.get_by_role("button", name="Delete everything").click()
    expect(page.get_by_role("heading", name="Create your account")).to_be_visible()
    expect(bert.page.get_by_text("There is no such scan, or it belongs to somebody else.")).to_be_visible()
    stack.wait_until(lambda: not (stack.data_dir / "volumes" / data_set).exists(), what="the volume's end")
    stack.wait_until(lambda: not (stack.data_dir / "cache" / "thumbnails" / data_set).exists(), what="the pictures' end")
    for table, column in (("data_sets", "id"), ("presets", "data_set_id"), ("ingest_jobs", "data_set_id"), ("disposals", "id")):
        stack.wait_until(lambda t=table, c=column: stack.psql(f"SELECT count(*) FROM {t} WHERE {c} = %s", data_set) == [(0,)],
                         what=f"nothing of it in {table}")
    assert stack.psql("SELECT count(*) FROM users WHERE email_key = %s", anna.email) == [(0,)]
    left = [str(path) for path in stack.data_dir.rglob("*") if data_set in path.name]
    assert left == []
    bert.page.goto(stack.url + "/gallery")
    expect(bert.page.get_by_role("link", name="Look at From my disc")).not_to_be_visible()
