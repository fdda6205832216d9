"""Marks: making them in the picture and in slices, changing and undoing them, what hides them, saving them, and showing them to others."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from harness import TestStack
from person import Person
from picture import wait_for_samples
from test_in_picture import open_scan
from test_pages import check_page
from test_take_away import hide_message
from test_videos import VIDEO_PATIENCE_MS, ask_for_ten_frames, taking

MARKS = ".stage > .mark-area [data-mark]"


def window(page: Page) -> Locator:
    opened = page.get_by_role("dialog", name="Marks", exact=True)
    if not opened.is_visible():
        page.get_by_role("button", name="Marks", exact=True).click()
    expect(opened).to_be_visible()
    return opened


def at(page: Page, x: float, y: float, area: str = ".stage > .mark-area") -> tuple[float, float]:
    box = page.locator(area).bounding_box()
    return box["x"] + x * box["width"], box["y"] + y * box["height"]


def press(page: Page, kind: str, x: float, y: float, *, to: tuple[float, float] | None = None) -> None:
    """Makes a mark by pressing a point of the picture (0 to 1), and perhaps dragging to another one."""
    before = page.locator(MARKS).count()
    window(page).get_by_role("button", name=kind, exact=True).click()
    page.mouse.move(*at(page, x, y))
    page.mouse.down()
    if to:
        page.mouse.move(*at(page, *to), steps=4)
    page.mouse.up()
    expect(page.locator(MARKS)).to_have_count(before + 1)


def name_it(page: Page, text: str) -> None:
    window(page).get_by_label("Text", exact=True).fill(text)


def opens(stack: TestStack, page: Page, scan: str) -> None:
    open_scan(stack, page, scan, 1280, 800)
    hide = page.get_by_role("button", name="Hide the tips")
    if hide.is_visible():
        hide.click()


def test_marks_are_made_changed_undone_and_saved(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "marks")
    scan = person.has_scan(cranium, "Head")
    opens(stack, page, scan)
    undo = window(page).get_by_role("button", name="Undo", exact=True)
    expect(undo).to_be_disabled()
    assert float(undo.evaluate("(button) => getComputedStyle(button).opacity")) < 0.5, "it looks as if it could be pressed"
    press(page, "Arrow", 0.5, 0.5, to=(0.7, 0.3))
    name_it(page, "The frontal bone")
    press(page, "Circle", 0.45, 0.65, to=(0.52, 0.65))
    window(page).get_by_role("radio", name="Green").check()
    expect(page.locator(MARKS + "[data-kind=circle]")).to_have_attribute("data-colour", "3")
    # By keys: the cross starts in the middle.
    window(page).get_by_role("button", name="Text", exact=True).click()
    expect(page.locator(".picker")).to_be_focused()
    page.keyboard.press("Shift+ArrowUp")
    page.keyboard.press("Enter")
    expect(page.locator(MARKS)).to_have_count(3)
    name_it(page, "Here")
    page.screenshot(path=pictures / "marks-made.png")
    check_page(page)

    # Nothing is made beside the head.
    window(page).get_by_role("button", name="Text", exact=True).click()
    page.mouse.click(*at(page, 0.97, 0.5))
    expect(page.get_by_text("There is nothing of the scan at this point.")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator(".mark-maker")).to_have_count(0)

    # A mark is moved by the mouse and by keys, deleted, and all of it undone.
    handle = page.locator(".mark-area [data-handle=mark-3]")
    before = handle.bounding_box()
    page.mouse.move(*middle(before))
    page.mouse.down()
    page.mouse.move(before["x"] + 60, before["y"] + 30, steps=4)
    page.mouse.up()
    stack.wait_until(lambda: handle.bounding_box()["x"] > before["x"] + 30, what="the moved mark")
    moved = handle.bounding_box()
    handle.focus()
    page.keyboard.press("Shift+ArrowRight")
    stack.wait_until(lambda: handle.bounding_box()["x"] > moved["x"] + 5, what="the mark moved by a key")
    page.keyboard.press("Delete")
    expect(page.locator(MARKS)).to_have_count(2)
    for _ in range(3):
        page.keyboard.press("Control+z")
    stack.wait_until(lambda: abs(handle.bounding_box()["x"] - before["x"]) < 2, what="the mark at its first place")

    # From behind, the marks on the face are dashed. They stay at their points.
    seen = page.locator(MARKS + "[data-look=plain]")
    expect(seen).to_have_count(3)
    page.locator(".stage > canvas").focus()
    for _ in range(36):
        page.keyboard.press("ArrowRight")
    expect(page.locator(MARKS + "[data-look=faint]")).to_have_count(3)
    page.screenshot(path=pictures / "marks-behind.png")
    for _ in range(36):
        page.keyboard.press("ArrowLeft")
    expect(seen).to_have_count(3)

    # In the slices they appear on and near their plane, and are made there as well.
    page.keyboard.press("v")
    window(page).get_by_role("button", name="Choose The frontal bone").click()
    axial = page.locator(".slice-pane[data-plane=axial]")
    expect(axial.locator("[data-kind=arrow][data-look=plain]")).to_have_count(1)
    axial.locator("canvas").focus()
    for _ in range(10):
        page.keyboard.press("PageUp")
    expect(axial.locator("[data-kind=arrow]")).to_have_count(0)
    window(page).get_by_role("button", name="Choose The frontal bone").click()
    window(page).get_by_role("button", name="Circle", exact=True).click()
    page.mouse.click(*at(page, 0.8, 0.3, ".slice-pane[data-plane=sagittal] canvas"))
    expect(page.locator(".slice-pane[data-plane=sagittal] [data-kind=circle][data-look=plain].mark-chosen")).to_have_count(1)
    page.get_by_role("radio", name="Ruler").check()
    page.mouse.move(*at(page, 0.3, 0.75, ".slice-pane[data-plane=coronal] canvas"))
    page.mouse.down()
    page.mouse.move(*at(page, 0.6, 0.75, ".slice-pane[data-plane=coronal] canvas"), steps=4)
    page.mouse.up()
    page.screenshot(path=pictures / "marks-slices.png")
    page.keyboard.press("v")

    # Saved under a name, changed afterwards, and there after the tab is closed.
    saved = window(page)
    expect(saved.get_by_text("Not saved yet: 4 marks and 1 measurement.")).to_be_visible()
    saved.get_by_label("Name", exact=True).fill("Before surgery")
    saved.get_by_role("button", name="Save", exact=True).click()
    expect(saved.get_by_text("Saved as Before surgery.")).to_be_visible()
    saved.get_by_role("button", name="Choose Here").click()
    name_it(page, "Here too")
    contents = f"SELECT content FROM annotations WHERE data_set_id = '{scan}'"
    stack.wait_until(lambda: "Here too" in stack.psql(contents)[0][0], what="the saved change")
    page.screenshot(path=pictures / "marks-saved.png")
    page.reload()
    expect(page.locator(MARKS)).to_have_count(4)
    page.evaluate("sessionStorage.clear()")
    other = page.context.new_page()
    page.close()
    opens(stack, other, scan)
    expect(other.locator(MARKS)).to_have_count(4)
    assert "1 measurement" in window(other).inner_text()

    # Hidden, shared, renamed and deleted.
    saved = window(other)
    saved.get_by_role("checkbox", name="Before surgery").click()
    expect(other.locator(MARKS)).to_have_count(0)
    stack.wait_until(lambda: stack.psql(f"SELECT shown FROM annotations WHERE data_set_id = '{scan}'")[0][0] is False, what="the hidden set")
    saved.get_by_role("checkbox", name="Before surgery").click()
    expect(other.locator(MARKS)).to_have_count(4)
    saved.get_by_role("checkbox", name="Everyone who can open this scan sees it").click()
    expect(saved.get_by_text("Shared marks are visible to everyone")).to_be_visible()
    saved.get_by_role("button", name="Rename Before surgery").click()
    saved.get_by_label("New name").fill("Then")
    saved.get_by_role("button", name="Rename", exact=True).click()
    expect(saved.get_by_role("checkbox", name="Then")).to_be_checked()
    with_marks_in_a_preset_a_link_and_a_picture(stack, other, scan)
    saved = window(other)
    saved.get_by_role("button", name="Delete Then").click()
    saved.get_by_role("button", name="Delete", exact=True).last.click()
    expect(other.locator(MARKS)).to_have_count(0)
    assert stack.psql(contents) == []


#: How far the middle of the first circle is below the upper edge of the head, in heights of the head.
HEIGHT = """() => {
  const canvas = document.querySelector(".stage > canvas"), box = canvas.getBoundingClientRect();
  const copy = new OffscreenCanvas(canvas.width, canvas.height), context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const bright = (row) => context.getImageData(0, row, canvas.width, 1).data.some((value, i) => i % 4 === 0 && value > 140);
  const rows = Array.from({ length: canvas.height }, (_, row) => row).filter(bright);
  const top = rows[0], bottom = rows.at(-1);
  const circle = document.querySelector(".stage > .mark-area [data-kind=circle] circle").getBoundingClientRect();
  const y = ((circle.y + circle.height / 2 - box.y) / box.height) * canvas.height;
  return (y - top) / (bottom - top);
}"""


def test_two_windows_keep_the_marks_of_each_other(stack: TestStack, visit, cranium: Path):
    first = visit(wide=True)
    person = Person.arrives(stack, first, "twice")
    scan = person.has_scan(cranium, "Head")
    opens(stack, first, scan)
    press(first, "Text", 0.5, 0.5)
    name_it(first, "Both")
    saved = window(first)
    saved.get_by_label("Name", exact=True).fill("Ours")
    saved.get_by_role("button", name="Save", exact=True).click()
    expect(saved.get_by_text("Saved as Ours.")).to_be_visible()
    second = first.context.new_page()
    opens(stack, second, scan)
    expect(second.locator(MARKS)).to_have_count(1)
    contents = f"SELECT content FROM annotations WHERE data_set_id = '{scan}'"
    for page, text in ((first, "The first window"), (second, "The second window")):
        window(page).get_by_role("button", name="Choose Both").click()
        name_it(page, text)
        stack.wait_until(lambda: text in stack.psql(contents)[0][0], what="the saved change")
    # Both had changed one mark, so it is kept in both forms, also in the window that saved last.
    assert "The first window" in stack.psql(contents)[0][0]
    expect(second.locator(MARKS)).to_have_count(2)


def height_in_head(page: Page) -> float:
    return page.evaluate(HEIGHT)


def middle(box: dict) -> tuple[float, float]:
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def with_marks_in_a_preset_a_link_and_a_picture(stack: TestStack, page: Page, scan: str) -> None:
    """Only if the user wants it."""
    page.get_by_role("button", name="Saved presets").click()
    dialog = page.get_by_role("dialog", name="Saved presets")
    for name, chosen in (("Bare", False), ("Marked", True)):
        dialog.get_by_label("Name of the new preset").fill(name)
        box = dialog.get_by_role("checkbox", name="Include 4 marks and 1 measurement")
        if not chosen:
            expect(box).not_to_be_checked()
        box.set_checked(chosen)
        dialog.get_by_role("button", name="Save the current view").click()
        expect(dialog.get_by_text(f"Saved as {name}.")).to_be_visible()
    dialog.get_by_role("button", name="Close").last.click()
    kept = dict(stack.psql(f"SELECT name, annotations FROM presets WHERE data_set_id = '{scan}'"))
    assert kept["Bare"] is None and len(json.loads(kept["Marked"])["marks"]["items"]) == 4

    page.get_by_role("button", name="Save or share", exact=True).click()
    dialog = page.get_by_role("dialog", name="Save or share")
    link = dialog.get_by_label("Link", exact=True)
    stack.wait_until(lambda: link.input_value() != "", what="the link")
    bare = link.input_value()
    dialog.get_by_role("checkbox", name="Include 4 marks and 1 measurement").check()
    stack.wait_until(lambda: link.input_value() != bare, what="the link with marks")
    marked = link.input_value()
    sizes = []
    for drawn in (True, False):
        dialog.get_by_role("checkbox", name="Draw 4 marks into the picture").set_checked(drawn)
        with page.expect_download() as download:
            dialog.get_by_role("button", name="Save the picture").click()
        sizes.append(Path(download.value.path()).read_bytes())
    assert sizes[0] != sizes[1]
    dialog.get_by_role("button", name="Close").last.click()

    # The link shows its marks besides those that are shown already.
    page.goto("about:blank")
    page.goto(marked)
    expect(page.locator(MARKS)).to_have_count(8)
    page.get_by_role("button", name="Saved presets").click()
    page.get_by_role("button", name="Show Bare").click()
    page.get_by_role("dialog", name="Saved presets").get_by_role("button", name="Close").last.click()
    expect(page.locator(MARKS)).to_have_count(4)


def green_pixels(rgb: bytes) -> int:
    """Counts the pixels in the colour of the marks, which no part of a head has."""
    red, green, blue = np.moveaxis(np.frombuffer(rgb, np.uint8).reshape(-1, 3).astype(int), 1, 0)
    return int(((green - red > 25) & (green - blue > 25)).sum())


def rgb_of(file: Path, number: int = 0) -> bytes:
    """Decodes one frame of a video, or a picture."""
    return subprocess.run(["ffmpeg", "-v", "error", "-i", file, "-vf", f"select=eq(n\\,{number})", "-frames:v", "1", "-f", "rawvideo",
                           "-pix_fmt", "rgb24", "-"], check=True, capture_output=True).stdout


@pytest.mark.nightly
def test_marks_are_drawn_into_videos_and_large_pictures(stack: TestStack, visit, cranium: Path, pictures: Path, tmp_path: Path):
    page = visit(small=True)
    scan = Person.arrives(stack, page, "filmmarks").has_scan(cranium, "Head")
    open_scan(stack, page, scan, 900, 700)
    press(page, "Arrow", 0.5, 0.5, to=(0.5, 0.3))
    window(page).get_by_role("radio", name="Green").check()
    name_it(page, "Größe 5 mm")
    press(page, "Circle", 0.42, 0.6, to=(0.46, 0.6))
    window(page).get_by_role("button", name="Close Marks").click()

    def saved(order: Locator, button: str, name: str) -> Path:
        expect(order.get_by_role("checkbox", name="Draw 2 marks into the")).to_be_checked()
        page.screenshot(path=pictures / f"marks-{name}-dialog.png")
        with page.expect_download(timeout=VIDEO_PATIENCE_MS) as download:
            order.get_by_role("button", name=button).click()
        path = tmp_path / name
        download.value.save_as(path)
        hide_message(page)
        return path

    dialog = taking(page, "turntable")
    ask_for_ten_frames(dialog)
    video = saved(dialog, "Save the video", "video")
    front, back = (green_pixels(rgb_of(video, number)) for number in (0, 5))
    assert front > 300 and 0 < back < front, f"{front}, {back}: behind the head, the marks are faint and dashed"
    dialog = taking(page, "picture")
    dialog.get_by_label("Size").select_option("other")
    dialog.get_by_label("Width").fill("32")
    dialog.get_by_label("Height").fill("4112")
    dialog.get_by_label("Quality", exact=True).select_option("quick")
    drawn = green_pixels(rgb_of(saved(dialog, "Save the picture", "picture")))
    # The lines of a large picture are as thick as on the screen, in proportion to its height.
    assert drawn > 5 * front, (front, drawn)


def test_a_visitor_with_a_link_sees_the_shared_marks(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    scan = Person.arrives(stack, page, "linkmarks").has_scan(cranium, "Head")
    opens(stack, page, scan)
    for name, place in (("Shared", 0.4), ("Private", 0.6)):
        press(page, "Text", 0.5, place)
        name_it(page, name)
        saved = window(page)
        saved.get_by_label("Name", exact=True).fill(name)
        saved.get_by_role("button", name="Save", exact=True).click()
        expect(saved.get_by_text(f"Saved as {name}.")).to_be_visible()
    row = page.locator(".mark-sets > li", has_text="Shared").first
    row.get_by_role("checkbox", name="Everyone who can open this scan sees it").click()
    expect(row.get_by_text("also without an account through a link")).to_be_visible()
    page.screenshot(path=pictures / "marks-shared.png")
    window(page).get_by_role("button", name="Close Marks").click()
    page.get_by_role("button", name="Share this scan").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Create link").click()
    link = dialog.get_by_label("Your new link").input_value()
    visitor = visit(small=True)
    visitor.goto(link)
    visitor.get_by_role("button", name="View the scan").click()
    wait_for_samples(stack, visitor, 1)
    expect(visitor.locator(MARKS)).to_have_text("Shared")
    visitor.screenshot(path=pictures / "marks-visitor.png")
    # The visitor can hide them, but not change them.
    row = window(visitor).locator(".mark-sets > li")
    expect(row).to_have_count(1)
    expect(row.get_by_role("button")).to_have_count(0)
    row.get_by_role("checkbox", name="Shared").click()
    expect(visitor.locator(MARKS)).to_have_count(0)
    visitor.close()


def test_marks_and_hands_in_a_live_session(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna = Person.arrives(stack, visit(), "annamarks")
    anna.has_scan(cranium, "Head")
    anna.open_scan("Head")
    owner = anna.page
    wait_for_samples(stack, owner, 1)
    if owner.get_by_role("button", name="Hide the tips").is_visible():
        owner.get_by_role("button", name="Hide the tips").click()
    press(owner, "Arrow", 0.6, 0.5, to=(0.8, 0.3))
    name_it(owner, "Look here")
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("button", name="Create link").click()
    link = owner.get_by_label("Link to share").input_value()
    owner.get_by_role("dialog", name="View together").get_by_role("button", name="Close").click()
    phone = visit(phone=True)
    phone.goto(link)
    phone.get_by_label("Your name (visible to others in this session)").fill("Bob")
    phone.get_by_role("button", name="Join", exact=True).click()
    wait_for_samples(stack, phone, 1)
    # Bob sees the mark that was there before, and its changes.
    expect(phone.locator(MARKS)).to_have_text("Look here")
    name_it(owner, "And here")
    expect(phone.locator(MARKS)).to_have_text("And here")

    # Bob makes one with a finger while following, and Anna keeps it.
    window(phone).get_by_role("button", name="Circle", exact=True).tap()
    window(phone).get_by_role("button", name="Close Marks").tap()
    window(phone).get_by_role("button", name="Circle", exact=True).tap()
    phone.screenshot(path=pictures / "marks-phone-tool.png")
    x, y = at(phone, 0.5, 0.25)
    phone.touchscreen.tap(x, y)
    expect(phone.locator(MARKS)).to_have_count(2)
    expect(owner.locator(MARKS)).to_have_count(2)
    expect(window(owner).get_by_text("by Bob")).to_be_visible()
    window(owner).get_by_role("button", name="Keep a copy of Circle").click()
    expect(owner.locator(MARKS)).to_have_count(3)
    owner.screenshot(path=pictures / "marks-live-owner.png")
    phone.screenshot(path=pictures / "marks-live-phone.png")
    # Both circles are at the same place of the picture, which the phone shows smaller and with borders.
    assert abs(height_in_head(owner) - height_in_head(phone)) < 0.08

    # Turned off, the marks of guests vanish from the others, and their authors are notified.
    owner.get_by_role("button", name="View together").click()
    switch = owner.get_by_role("checkbox", name="Guests can point and make marks")
    switch.uncheck()
    expect(owner.locator(MARKS)).to_have_count(2)
    expect(window(phone).get_by_text("The presenter has turned off the marks of guests")).to_be_visible()
    switch.check()
    expect(owner.locator(MARKS)).to_have_count(3)
    owner.get_by_role("dialog", name="View together").get_by_role("button", name="Close").click()

    # Bob raises a hand, and Anna lowers it. The next time she lets Bob present.
    window(phone).get_by_role("button", name="Close Marks").tap()
    hand = phone.get_by_role("button", name="Raise your hand")
    hand.tap()
    expect(owner.get_by_text("Hand raised: Bob")).to_be_visible()
    owner.screenshot(path=pictures / "hands-owner.png")
    phone.screenshot(path=pictures / "hands-phone.png")
    owner.get_by_role("button", name="Lower the hand of Bob").click()
    expect(owner.get_by_text("Hand raised: Bob")).to_have_count(0)
    hand.tap()
    phone.get_by_role("button", name="Lower your hand").tap()
    hand.tap()
    owner.get_by_role("button", name="Make presenter: Bob").click()
    expect(owner.get_by_text("Bob is presenting")).to_be_visible()
    expect(owner.get_by_text("Hand raised: Bob")).to_have_count(0)

    # The marks of Bob go too.
    phone.close()
    expect(owner.locator(MARKS)).to_have_count(2)
