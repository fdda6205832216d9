"""A patient who uses only the keyboard: from signing in to uploading, viewing and sharing a scan, and signing out. At each step,
something has the focus, shows it, and is inside the window."""

from __future__ import annotations

import pytest

import re
from pathlib import Path

from playwright.sync_api import Locator, Page, expect

from harness import TestStack
from person import PASSWORD, Person
from picture import facts, wait_for_samples
from test_upload import Dam

# The visible focus indicator: a frame around the element, or around what it fills (a card).
FOCUS = """() => {
    const e = document.activeElement;
    if (!e || e === document.body || e === document.documentElement) return { name: null };
    const frame = (style) => style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
    const style = getComputedStyle(e);
    const box = e.getBoundingClientRect();
    return {
        name: `${e.tagName} ${e.getAttribute("aria-label") ?? e.textContent.trim().slice(0, 40)}`,
        seen: e.matches("h1, h2, main") || frame(style) || frame(getComputedStyle(e, "::after")) || style.boxShadow.includes("inset"),
        within: box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth,
    };
}"""


def focus(page: Page) -> str | None:
    """Returns the name of the focused element, or None if nothing in the page has the focus."""
    found = page.evaluate(FOCUS)
    if found["name"] is None:
        return None
    assert found["seen"], f"nothing shows that {found['name']} has the focus"
    assert found["within"], f"{found['name']} has the focus outside of the window"
    return found["name"]


def go_to(page: Page, wanted: Locator, key: str = "Tab") -> None:
    """Uses only the given key. After the last element of a page, the focus goes to the browser itself once, and then back to the
    page."""
    expect(wanted).to_be_visible()
    passed: list[str | None] = []
    while not wanted.evaluate("(e) => e === document.activeElement"):
        page.keyboard.press(key)
        passed.append(focus(page))
        assert len(passed) < 120 and passed.count(None) < 3, f"{wanted} is not reached by {key}: {passed}"
    assert focus(page) is not None


def press(page: Page, wanted: Locator, key: str = "Enter") -> None:
    go_to(page, wanted)
    page.keyboard.press(key)


@pytest.mark.nightly
def test_uploading_viewing_sharing_and_signing_out_work_by_keyboard(stack: TestStack, visit, cranium: Path):
    page = visit()
    person = Person.arrives(stack, page, "keys")
    page.context.clear_cookies()

    # Signing in.
    page.goto(stack.url)
    press(page, page.get_by_role("link", name="Sign in"))
    go_to(page, page.get_by_label("Email address"))
    page.keyboard.type(person.email)
    go_to(page, page.get_by_label("Password", exact=True))
    page.keyboard.type(PASSWORD)
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="My scans")).to_be_focused()

    # A scan from a folder: Enter opens the browser's own chooser.
    press(page, page.get_by_role("link", name="Add a scan").first)
    expect(page.get_by_role("heading", name="Add a scan")).to_be_focused()
    with page.expect_file_chooser() as chooser:
        press(page, page.locator("button", has_text="Choose a folder"))
    chooser.value.set_files(cranium)
    go_to(page, page.get_by_label("Your name for this scan"))
    page.keyboard.type("Key head")
    dam = Dam(page)
    press(page, page.get_by_role("button", name="Upload", exact=True))
    expect(page.get_by_role("heading", name="My scans")).to_be_focused()

    # Paused and resumed. Cancelling is not confirmed.
    card = person.card("Key head")
    dam.wait(stack)
    expect(card).to_contain_text(re.compile(r"[1-9]\d?%"))
    press(page, page.get_by_role("button", name="Pause the upload of Key head"))
    expect(card).to_contain_text(re.compile(r"Paused at [1-9]\d?%\."))
    go_on = page.get_by_role("button", name="Resume the upload of Key head")
    expect(go_on).to_be_focused()  # at the position of the pressed button
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Pause the upload of Key head")).to_be_focused()
    cancel = page.get_by_role("button", name="Cancel the upload of Key head")
    press(page, cancel)
    press(page, page.get_by_role("dialog").get_by_role("button", name="Keep uploading"))
    expect(page.get_by_role("dialog")).to_have_count(0)
    expect(cancel).to_be_focused()
    dam.opens()
    expect(card).to_have_attribute("data-state", "ready")

    # The keys rotate the picture at once.
    press(page, page.get_by_role("link", name="Open Key head"))
    expect(page.locator("canvas")).to_be_focused()
    at = wait_for_samples(stack, page, 1)
    page.keyboard.press("ArrowRight")
    wait_for_samples(stack, page, 1, input_seq=at.input_seq + 1)
    assert facts(page).epoch > at.epoch

    # Shared with a friend. The dialog keeps the focus and returns it.
    share = page.get_by_role("button", name="Share this scan")
    press(page, share)
    dialog = page.get_by_role("dialog")
    go_to(page, dialog.get_by_label("Email address"))
    page.keyboard.type("friend@example.org")
    page.keyboard.press("Enter")
    expect(dialog.get_by_text("Shared with friend@example.org.")).to_be_visible()
    for _ in range(30):
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement === document.body || document.activeElement.closest('dialog') !== null")
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    expect(share).to_be_focused()

    # The account, and signing out.
    press(page, page.get_by_role("link", name="My scans"))
    expect(page.get_by_role("heading", name="My scans")).to_be_focused()
    press(page, page.get_by_role("link", name=re.compile("^Your account")))
    expect(page.get_by_role("heading", name="Your account")).to_be_focused()
    remove = page.get_by_role("button", name="Delete my account…")
    press(page, remove)
    expect(dialog).to_be_visible()
    page.keyboard.press("Escape")
    expect(remove).to_be_focused()
    press(page, page.get_by_role("button", name="Sign out", exact=True).first)
    expect(page.get_by_role("heading", name="Sign in")).to_be_focused()


@pytest.mark.nightly
def test_deleting_a_scan_by_keyboard_moves_the_focus_to_the_title(stack: TestStack, visit, cranium: Path):
    page = visit()
    person = Person.arrives(stack, page, "keys")
    person.has_scan(cranium, "Unwanted head")
    press(page, page.get_by_role("button", name="Delete Unwanted head"))
    press(page, page.get_by_role("dialog").get_by_role("button", name="Delete"))
    expect(person.card("Unwanted head")).to_have_count(0)
    expect(page.get_by_role("heading", name="My scans")).to_be_focused()
