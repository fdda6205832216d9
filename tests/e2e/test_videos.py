"""Files that a worker makes: videos, and pictures larger than a page can hold. Also the features that the renderer omitted."""

from __future__ import annotations

import base64
import json
import subprocess
import re
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from harness import TestStack, files_below
from devtool.ingest_cases.phantom import Series, dataset, markers, stack as slices, write
from person import Person
from picture import drag, last_input, listen, wait_for_picture, wait_for_samples, wait_said
from test_take_away import chunks, hide_message, live_answers, wait_for_sessions


#: Two cores that other tests keep busy take minutes for ten frames.
VIDEO_PATIENCE_MS = 400_000


@pytest.fixture(scope="module")
def marked(tmp_path_factory) -> Path:
    """A volume with a large ball at the patient's left (x rises to the left) and a small one at the right. Without the small one,
    the picture would be framed on the large one alone."""
    folder = tmp_path_factory.mktemp("marked")
    places = slices(20, 2.0, origin=(-16.8, -17.2, -20.0), rows=44, columns=48, intercept=-2000.0)
    left, right = markers((9.0, 0.0, 0.0), radius=4.0), markers((-9.0, 0.0, 0.0), radius=2.0)
    write(folder, [dataset(Series(values=lambda at: np.maximum(left(at), right(at))), one) for one in places])
    return folder


def probed(video: Path) -> dict:
    out = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_format", "-show_streams", "-of", "json", video],
                         check=True, capture_output=True)
    return json.loads(out.stdout)


def frame(video: Path, number: int, width: int, height: int) -> np.ndarray:
    """Returns the luma of one frame, rows from the top."""
    out = subprocess.run(["ffmpeg", "-v", "error", "-i", video, "-vf", f"select=eq(n\\,{number})", "-frames:v", "1", "-f", "rawvideo",
                          "-pix_fmt", "gray", "-"], check=True, capture_output=True)
    return np.frombuffer(out.stdout, np.uint8).reshape(height, width).astype(float)


def middle(luma: np.ndarray) -> float:
    """Returns where bright pixels are: -1 at the left edge, 1 at the right."""
    bright = np.clip(luma - np.percentile(luma, 50) - 8, 0, None)
    assert bright.sum() > 0
    across = np.linspace(-1, 1, luma.shape[1])
    return float((bright * across).sum() / bright.sum())


def opened_as_bone(stack: TestStack, page: Page, name: str, folder: Path, title: str) -> str:
    """Opens a scan with the look Bone and returns its id."""
    scan = Person.arrives(stack, page, name).has_scan(folder, title)
    page.goto(f"{stack.url}/view/{scan}")
    page.get_by_role("button", name="Bone", exact=True).click()
    wait_for_picture(stack, page, input_seq=1)
    return scan


def taking(page: Page, what: str):
    page.keyboard.press("s")
    dialog = page.get_by_role("dialog", name="Save or share")
    dialog.get_by_label("File type", exact=True).select_option(what)
    return dialog


def ask_for_ten_frames(dialog) -> None:
    dialog.get_by_label("Length in seconds").fill("1")
    dialog.get_by_label("Frames per second").select_option("10")
    dialog.get_by_label("Size").select_option("small")


def saved_video(stack: TestStack, page: Page, dialog, to: Path) -> Path:
    listen(page, ".shot-line")
    with page.expect_download(timeout=VIDEO_PATIENCE_MS) as download:
        dialog.get_by_role("button", name="Save the video").click()
        expect(page.locator("[data-shot=rendering]")).to_be_visible()
    assert re.fullmatch(r"diaphane-[\d-]+\.mp4", download.value.suggested_filename)
    video = to / "diaphane.mp4"
    download.value.save_as(video)
    wait_said(stack, page, "The video has been saved.")
    return video


def expect_plain_video(video: Path, frames: int, rate: int, seconds: float) -> tuple[int, int]:
    """Checks what a player finds, and that there is no personal data. Returns the size."""
    seen = probed(video)
    [pictures] = seen["streams"]
    assert (pictures["codec_name"], pictures["pix_fmt"]) == ("h264", "yuv420p")
    assert int(pictures["nb_read_frames"]) == frames and pictures["avg_frame_rate"] == f"{rate}/1"
    assert abs(float(seen["format"]["duration"]) - seconds) < 0.01
    tags = {name.lower() for part in (seen["format"], pictures) for name in part.get("tags", {})}
    assert not tags & {"title", "comment", "creation_time", "artist", "date", "encoder"}, tags
    data = video.read_bytes()
    assert 0 < data.find(b"moov") < data.find(b"mdat"), "a player could not begin before the end has come"
    return pictures["width"], pictures["height"]


@pytest.mark.nightly
def test_a_video_of_show_me_around_shows_all_sides(stack: TestStack, visit, marked: Path, tmp_path: Path):
    page = visit(small=True)
    opened_as_bone(stack, page, "rundgang", marked, "Around")
    dialog = taking(page, "around")
    ask_for_ten_frames(dialog)  # one second is too short for a turn around the whole scan
    dialog.get_by_role("button", name="Save the video").click()
    seconds = dialog.get_by_label("Length in seconds")
    expect(seconds).to_be_focused()
    expect(seconds).to_have_accessible_description("Enter a whole number of seconds between 12 and 60.")
    seconds.fill("12")
    video = saved_video(stack, page, dialog, tmp_path)
    width, height = expect_plain_video(video, frames=120, rate=10, seconds=12)
    sides = [middle(frame(video, n, width, height)) for n in range(0, 120, 10)]
    assert max(sides) > 0.1 and min(sides) < -0.1, sides  # the patient's left is at the viewer's right, and then at their left


def test_a_turntable_shows_the_back_after_half_a_turn(stack: TestStack, visit, marked: Path, pictures: Path, tmp_path: Path):
    page = visit(small=True)
    scan = opened_as_bone(stack, page, "toni", marked, "Erika Mustermann")

    dialog = taking(page, "turntable")
    page.screenshot(path=pictures / "video-dialog.png")
    # An invalid order is refused with a message, and nothing starts.
    dialog.get_by_label("Length in seconds").fill("61")
    dialog.get_by_role("button", name="Save the video").click()
    seconds = dialog.get_by_label("Length in seconds")
    expect(seconds).to_be_focused()
    expect(seconds).to_have_attribute("aria-invalid", "true")
    expect(seconds).to_have_accessible_description("Enter a whole number of seconds between 1 and 60.")
    ask_for_ten_frames(dialog)
    expect(dialog.get_by_text("We’ll render 10 pictures for this video.")).to_be_visible()
    video = saved_video(stack, page, dialog, tmp_path)
    page.screenshot(path=pictures / "video-saved.png")
    width, height = expect_plain_video(video, frames=10, rate=10, seconds=1)
    assert width == 640 and height % 2 == 0
    assert b"Mustermann" not in video.read_bytes() and scan.encode() not in video.read_bytes()
    front, side, back = (middle(frame(video, n, width, height)) for n in (0, 2, 5))
    # The patient's left is at the viewer's right, and after half a rotation at the viewer's left.
    assert front > 0.1 and back < -0.1 and abs(side) < abs(front), (front, side, back)
    wait_for_sessions(stack, page, 1)
    hide_message(page)

    # After cancelling, nothing is saved, the live picture responds meanwhile, and nothing is left behind.
    page.on("download", lambda _: pytest.fail("something was saved"))
    dialog = taking(page, "turntable")
    dialog.get_by_label("Length in seconds").fill("60")
    dialog.get_by_label("Frames per second").select_option("60")
    dialog.get_by_role("button", name="Save the video").click()
    line = page.locator("[data-shot=rendering]")
    expect(line.locator("progress[value]")).to_be_visible()
    page.screenshot(path=pictures / "video-rendering.png")
    live_answers(stack, page)
    line.get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("status").get_by_text("No video was saved.")).to_be_visible()
    wait_for_sessions(stack, page, 1)
    # The worker removes what it has written so far after the page has been told.
    stack.wait_until(lambda: not [path for path in files_below(stack.data_dir) if path.suffix == ".mp4"], what="the removal of the video")


@pytest.mark.nightly
def test_a_tour_moves_from_one_saved_preset_to_the_next(stack: TestStack, visit, marked: Path, pictures: Path, tmp_path: Path):
    page = visit(small=True)
    opened_as_bone(stack, page, "rudi", marked, "Tour")
    dialog = taking(page, "tour")
    expect(dialog.get_by_text("There are no saved presets for this scan yet.")).to_be_visible()
    dialog.get_by_role("button", name="Save the video").click()
    expect(dialog.get_by_role("alert")).to_have_text("Choose between 2 and 16 views for the tour.")
    page.keyboard.press("Escape")
    for name in ("From the front", "From the side"):
        page.get_by_role("button", name="Saved presets").click()
        page.get_by_label("Name of the new preset").fill(name)
        page.get_by_role("button", name="Save the current view").click()
        expect(page.get_by_text(f"Saved as {name}.")).to_be_visible()
        page.keyboard.press("Escape")
        drag(page, 110, 0)
        wait_for_samples(stack, page, 4, input_seq=last_input(page))
    dialog = taking(page, "tour")
    page.screenshot(path=pictures / "tour-dialog.png")
    dialog.get_by_role("checkbox", name="Current view").uncheck()
    ask_for_ten_frames(dialog)
    video = saved_video(stack, page, dialog, tmp_path)
    width, height = expect_plain_video(video, frames=10, rate=10, seconds=1)
    seen = [middle(frame(video, n, width, height)) for n in range(10)]
    assert abs(seen[0] - seen[-1]) > 0.05, "two views"
    steps = np.abs(np.diff(seen))
    assert steps.max() < 0.6 * abs(seen[0] - seen[-1]), f"no jump: {seen}"


@pytest.mark.nightly
def test_a_picture_too_large_for_one_frame_is_saved(stack: TestStack, visit, marked: Path, tmp_path: Path):
    page = visit(small=True)
    person = Person.arrives(stack, page, "lars")
    scan = person.has_scan(marked, "Erika Mustermann")
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 4)
    dialog = taking(page, "picture")
    dialog.get_by_label("Size").select_option("other")
    dialog.get_by_label("Width").fill("4112")
    dialog.get_by_label("Height").fill("272")    # bands of 240 and 32 rows
    dialog.get_by_label("Quality", exact=True).select_option("quick")
    with page.expect_download() as download:
        dialog.get_by_role("button", name="Save the picture").click()
    png = Path(download.value.path()).read_bytes()
    assert re.fullmatch(r"diaphane-[\d-]+\.png", download.value.suggested_filename)
    assert set(chunks(png)) == {"IHDR", "IDAT", "IEND"}
    assert b"Mustermann" not in png
    size = page.evaluate("""async (data) => {
        const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
        const picture = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        return [picture.width, picture.height];
    }""", base64.b64encode(png).decode())
    assert size == [4112, 272]


def test_optimisations_are_listed_in_plain_words(stack: TestStack, visit, marked: Path, pictures: Path):
    for phone in (False, True):
        page = visit(phone=phone)
        person = Person.arrives(stack, page, "karla")
        scan = person.has_scan(marked, "Facts")
        page.goto(f"{stack.url}/view/{scan}")
        wait_for_samples(stack, page, 4)
        if phone:
            page.get_by_role("button", name="Show the quality").click()
        page.get_by_text("Details", exact=True).click()
        page.get_by_role("button", name="Optimisations").click()
        expect(page.locator("[data-fact=left-out]")).to_contain_text("emission")
        expect(page.locator("[data-fact=compiled-in]")).not_to_be_empty()
        expect(page.get_by_text("of the volume is empty and is skipped")).to_be_visible()
        page.screenshot(path=pictures / f"kernel-{'phone' if phone else 'desk'}.png")
        page.keyboard.press("Escape")
        page.keyboard.press("s")
        dialog = page.get_by_role("dialog", name="Save or share")
        dialog.get_by_label("File type", exact=True).select_option("turntable")
        page.screenshot(path=pictures / f"video-dialog-{'phone' if phone else 'desk'}.png")
