"""Browsers without some features, invalid files, and windows without size: each has a fallback or a message."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from harness import StackFactory, TestStack
from devtool import chromium, plan
from person import PATIENCE_MS, Person
from picture import ALIKE, difference, drag, facts, kept_view, pixels, spread, wait_for_samples

#: A browser with blocked storage, which throws on any access.
NO_STORAGE = """for (const name of ["localStorage", "sessionStorage"])
    Object.defineProperty(window, name, { get() { throw new DOMException("The operation is insecure.", "SecurityError"); } });"""
NO_CODECS = "for (const name of ['VideoDecoder', 'VideoFrame', 'EncodedVideoChunk', 'ImageDecoder']) delete window[name];"


@pytest.fixture(scope="module")
def owner(stack: TestStack, browser: Browser, cranium: Path):
    """A scan, and the cookies of its owner."""
    context = browser.new_context()
    context.set_default_timeout(PATIENCE_MS)
    person = Person.arrives(stack, context.new_page(), "otto")
    scan = person.has_scan(cranium, "Head")
    yield scan, context.cookies()
    context.close()


def opened(visit, stack: TestStack, owner, script: str = "") -> Page:
    scan, cookies = owner
    page = visit(small=True)
    page.context.add_cookies(cookies)
    if script:
        page.add_init_script(script)
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 2)
    return page


def turns(stack: TestStack, page: Page) -> None:
    before, picture = facts(page), pixels(page)
    drag(page, 120, 0)
    wait_for_samples(stack, page, 4, input_seq=before.input_seq + 1)
    # The first steps of the drag change less. Without storage, the page does not say which input was the last.
    stack.wait_until(lambda: difference(picture, pixels(page)) > 2 or page.wait_for_timeout(50), timeout=120, what="the turned picture")


def test_a_browser_that_blocks_storage_shows_and_changes_the_picture(stack: TestStack, visit, owner):
    page = opened(visit, stack, owner, NO_STORAGE)
    turns(stack, page)
    # Settings are kept while the page is open: colours, language, windows, preferences.
    page.get_by_role("button", name="Lens and quality", exact=True).click()
    lens = page.get_by_role("dialog", name="Lens and quality", exact=True)
    lens.get_by_text("More", exact=True).click()
    lens.get_by_label("Denoise early pictures").uncheck()
    expect(lens.get_by_label("Denoise early pictures")).not_to_be_checked()
    lens.get_by_role("button", name="Close Lens and quality").click()
    page.get_by_role("link", name="My scans").click()
    expect(page.get_by_role("heading", name="My scans")).to_be_visible()
    page.get_by_label("Language").select_option("de")
    expect(page.get_by_role("heading", name="Meine Aufnahmen")).to_be_visible()


def test_without_webcodecs_the_picture_is_decoded_another_way(stack: TestStack, visit, owner):
    page = opened(visit, stack, owner, NO_CODECS)
    assert page.evaluate("typeof VideoDecoder") == "undefined"
    turns(stack, page)
    assert spread(pixels(page)) > 5


@pytest.mark.nightly
def test_the_page_works_in_an_insecure_context(all_stacks: StackFactory, browser: Browser, cranium: Path, monkeypatch):
    """HTTP with a host name, as in a hospital's network: there is no WebCodecs, SubtleCrypto or clipboard."""
    monkeypatch.setattr(plan.Settings, "host", property(lambda _: "clinic.test"))
    stack = all_stacks.open(extra_env={"DIAPHANE_MAX_ERROR": "0.3"})
    way = f"--host-resolver-rules=MAP clinic.test:80 127.0.0.1:{stack.ports['edge']}"
    near = browser.browser_type.launch(executable_path=chromium.for_tests(), args=[*chromium.ARGS, way])
    page = near.new_context(viewport={"width": 320, "height": 240}).new_page()
    page.set_default_timeout(PATIENCE_MS)
    assert stack.url == "http://clinic.test"
    person = Person.signs_up_and_in(stack, page, "klinik")
    assert page.evaluate("[isSecureContext, typeof VideoDecoder, typeof crypto.subtle]") == [False, "undefined", "undefined"]
    scan = person.uploads_scan(cranium, "Head")
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 1)
    before = facts(page)
    page.locator("canvas").focus()
    page.keyboard.press("ArrowRight")
    wait_for_samples(stack, page, 4, input_seq=before.input_seq + 1)
    # Lossless pictures need hashes, which are computed in software.
    expect(page.locator("canvas[data-lossless]")).to_be_visible()
    near.close()
    all_stacks.shut(stack)


@pytest.mark.nightly
def test_the_picture_survives_a_lost_gpu_and_an_empty_window(stack: TestStack, visit, owner):
    page = opened(visit, stack, owner)
    wait_for_samples(stack, page, 8)
    whole = pixels(page)

    # As after a crash of the GPU process: the canvas is black, and the browser reports that it is usable again.
    page.locator("canvas").evaluate("""(canvas) => {
        canvas.getContext("2d").fillRect(0, 0, canvas.width, canvas.height);
        canvas.dispatchEvent(new Event("contextlost"));
        canvas.dispatchEvent(new Event("contextrestored"));
    }""")

    def there() -> bool:
        page.wait_for_timeout(100)
        return difference(whole, pixels(page)) < ALIKE

    stack.wait_until(there, timeout=120, what="the picture after the loss")
    expect(page.locator(".viewer-status")).to_have_attribute("data-phase", "live")

    stage = page.locator(".stage")
    stage.evaluate("(stage) => void (stage.style.display = 'none')")
    page.wait_for_timeout(300)
    assert page.evaluate("document.querySelector('canvas').clientWidth") == 0
    stage.evaluate("(stage) => void (stage.style.display = '')")
    stack.wait_until(there, timeout=120, what="the picture after a window of no size")
    page.set_viewport_size({"width": 1, "height": 1})
    page.wait_for_timeout(300)
    page.set_viewport_size({"width": 480, "height": 320})
    stack.wait_until(there, timeout=120, what="the picture after a window of a pixel")
    turns(stack, page)


def test_an_invalid_preset_file_is_refused_with_a_message(stack: TestStack, visit, owner):
    page = opened(visit, stack, owner)
    scene = kept_view(page)["scene"]
    dialog = page.get_by_role("dialog")

    def open_anew() -> None:
        """Opens it again without a message about before."""
        if dialog.count():
            page.keyboard.press("Escape")
            expect(dialog).to_have_count(0)
        page.get_by_role("button", name="Saved presets").click()
        expect(dialog).to_be_visible()
        expect(dialog.get_by_role("alert")).to_have_count(0)

    bomb = b'<!DOCTYPE p [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]><preset xmlns="urn:diaphane:preset" version="1" name="&b;"/>'
    for name, body in (("a.xml", b""), ("b.xml", b"\xff\xd8\xff\xe0" + bytes(range(256))), ("c.xml", b"<html><body>Hello</body></html>"), ("d.xml", bomb),
                       ("e.xml", b'<preset xmlns="urn:diaphane:preset" version="1" name="x"><camera eye="far"/></preset>')):
        open_anew()
        dialog.get_by_label("Upload a preset file").set_input_files({"name": name, "mimeType": "application/xml", "buffer": body})
        expect(dialog.get_by_role("alert")).to_be_visible()
        assert len(dialog.get_by_role("alert").inner_text()) > 10
        page.wait_for_timeout(200)
    open_anew()
    dialog.get_by_label("Upload a preset file").set_input_files({"name": "f.xml", "mimeType": "application/xml", "buffer": b" " * 300_000})
    expect(dialog.get_by_text("This file is too large to be a preset.")).to_be_visible()
    expect(dialog.get_by_text("There are no presets yet")).to_be_visible()
    assert kept_view(page)["scene"] == scene
