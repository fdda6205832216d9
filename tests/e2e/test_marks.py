"""Marks: making them in the picture and in slices, changing and undoing them, what hides them, saving them, and showing them to others."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import Locator, Page, expect

from harness import TestStack
from person import Person
from picture import drag, wait_for_samples
from test_in_picture import open_scan
from test_pages import check_page

OPEN = "Marks"


def window(page: Page) -> Locator:
    opened = page.get_by_role("dialog", name=OPEN, exact=True)
    if not opened.is_visible():
        page.get_by_role("button", name=OPEN, exact=True).click()
    expect(opened).to_be_visible()
    return opened


def press(page: Page, kind: str, x: float, y: float, *, to: tuple[float, float] | None = None) -> None:
    """Makes a mark by pressing a point of the picture (0 to 1), and perhaps dragging to another one."""
    before = page.locator(".mark-area [data-mark]").count()
    window(page).get_by_role("button", name=kind, exact=True).click()
    box = page.locator(".stage > .mark-area").bounding_box()
    page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
    page.mouse.down()
    if to:
        page.mouse.move(box["x"] + to[0] * box["width"], box["y"] + to[1] * box["height"], steps=4)
    page.mouse.up()
    expect(page.locator(".mark-area [data-mark]")).to_have_count(before + 1)


def test_marks_are_made_changed_undone_and_kept(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True)
    person = Person.arrives(stack, page, "marks")
    scan = person.has_scan(cranium, "Head")
    open_scan(stack, page, scan, 1280, 800)
    hide = page.get_by_role("button", name="Hide the tips")
    if hide.is_visible():
        hide.click()
    press(page, "Arrow", 0.5, 0.5, to=(0.7, 0.3))
    window(page).get_by_label("Text", exact=True).fill("The frontal bone")
    press(page, "Circle", 0.45, 0.65, to=(0.52, 0.65))
    press(page, "Text", 0.55, 0.35)
    window(page).get_by_label("Text", exact=True).fill("Here")
    page.screenshot(path=pictures / "marks-made.png")
    marks = page.locator(".mark-area [data-mark]")
    expect(marks).to_have_count(3)
