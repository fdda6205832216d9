"""The most important journey in Firefox. All other tests of pages use Chromium."""

from __future__ import annotations

import secrets
from pathlib import Path

import pytest

from firefox import Firefox
from harness import TestStack
from person import PASSWORD
from picture import difference, spread
from seeds import give_scan, write_person


@pytest.fixture
def firefox(tmp_path: Path):
    browser = Firefox(tmp_path)
    yield browser
    browser.close()


def sign_in(stack: TestStack, firefox: Firefox, email: str) -> None:
    firefox.goto(stack.url + "/sign-in")
    firefox.field("Email address").send_keys(email)
    firefox.first("input[type=password]").send_keys(PASSWORD)
    firefox.button("Sign in").click()
    firefox.heading("My scans")


def wait_for_samples(stack: TestStack, firefox: Firefox, samples: int, after_epoch: int = -1) -> int:
    """Waits for a picture of at least this many samples, of a later epoch than the given one. Returns its epoch."""
    canvas = firefox.first(".stage > canvas[data-samples]")

    def enough() -> list[int]:
        now = firefox.data(canvas)
        return [int(now["epoch"])] if int(now["samples"]) >= samples and int(now["epoch"]) > after_epoch else []

    return stack.wait_until(enough, timeout=120, what=f"a picture of {samples} samples")[0]


@pytest.mark.nightly
@pytest.mark.parametrize("codecs", ["", "JPEG", "MPEG1"], ids=["best", "jpeg", "mpeg1"])
def test_firefox_shows_and_turns_a_scan(stack: TestStack, firefox: Firefox, cranium: Path, pictures: Path, codecs: str):
    email = f"fay-{secrets.token_hex(4)}@example.org"
    write_person(stack.psql, email, password=PASSWORD)
    give_scan(stack, email, cranium, "Head")

    sign_in(stack, firefox, email)
    firefox.evaluate("if (arguments[0]) localStorage.setItem('diaphane.codecs', arguments[0])", codecs)
    firefox.screenshot(pictures / "firefox-scans.png")

    firefox.link("Open Head").click()
    before = wait_for_samples(stack, firefox, 4)
    canvas = firefox.first(".stage > canvas")
    first = firefox.pixels(canvas)
    firefox.screenshot(pictures / f"firefox-viewer-{codecs or 'best'}.png")
    assert spread(first) > 5

    firefox.drag(canvas, 220, 60)
    wait_for_samples(stack, firefox, 4, after_epoch=before)
    # The first steps of the drag change less.
    stack.wait_until(lambda: difference(first, firefox.pixels(canvas)) > 2, timeout=120, what="the turned picture")
    firefox.screenshot(pictures / f"firefox-turned-{codecs or 'best'}.png")

    firefox.button("Show the slices (V)").click()
    for plane in ("axial", "sagittal", "coronal"):
        pane = firefox.first(f".slice-pane[data-plane={plane}] canvas[data-came=true]")
        # A view is drawn once the page knows its size, which may be after the slice has come.
        stack.wait_until(lambda pane=pane: spread(firefox.pixels(pane)) > 5, timeout=120, what=f"the {plane} slice")
    firefox.screenshot(pictures / f"firefox-slices-{codecs or 'best'}.png")

    firefox.goto(stack.url + "/scans")
    firefox.button("Sign out").click()
    firefox.heading("Sign in to Diaphane")
    firefox.goto(stack.url + "/scans")
    firefox.heading("Sign in to Diaphane")
    assert firefox.faults() == []


@pytest.mark.nightly
def test_firefox_uploads_a_folder(stack: TestStack, firefox: Firefox, cranium: Path, pictures: Path):
    email = f"fay-{secrets.token_hex(4)}@example.org"
    write_person(stack.psql, email, password=PASSWORD)
    sign_in(stack, firefox, email)

    firefox.link("Add a scan").click()
    firefox.choose_files(firefox.first("input[type=file]"), sorted(cranium.iterdir()))
    firefox.text("1 image series can be shown")
    firefox.text("108 slices")
    firefox.screenshot(pictures / "firefox-add.png")
    title = firefox.field("Your name for this scan")
    title.clear()
    title.send_keys("My head")
    firefox.button("Upload").click()
    firefox.heading("My scans")
    firefox.first("article.card[data-state=ready]")
    firefox.link("Open My head")
    assert firefox.faults() == []
