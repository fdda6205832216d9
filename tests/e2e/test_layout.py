"""What the viewer shows beside, above and around the picture: nothing is clipped, covered or left without words."""

from __future__ import annotations

import secrets
from pathlib import Path

import pytest
from playwright.sync_api import Page, WebSocketRoute, expect

from harness import TestStack
from person import Person
from picture import last_input, wait_for_samples
from seeds import write_person
from test_in_picture import open_scan
from test_live_session import MARGINS
from test_videos import taking
from touch import Fingers

WINDOWS = {"en": ("Views", "Materials", "Light", "Lens and quality", "Cuts and slices", "Marks"),
           "de": ("Ansichten", "Materialien", "Licht", "Objektiv und Qualität", "Schnitte und Schichten", "Markierungen")}

#: Runs in the page: the words of visible choices that are wider than their field. A field has 2 rem of padding and arrow.
CLIPPED = """() => [...document.querySelectorAll(".window select")].filter((one) => one.offsetWidth > 0).flatMap((one) => {
    const pen = document.createElement("canvas").getContext("2d");
    pen.font = getComputedStyle(one).font;
    return [...one.options].map((option) => option.text).filter((text) => pen.measureText(text).width + 32 > one.offsetWidth);
})"""

#: Runs in the page: the first row of the subject in CSS pixels. The subject is brighter than the ground in the middle of the picture.
TOP = """() => {
    const canvas = document.querySelector(".stage > canvas"), { width, height } = canvas;
    const rgba = canvas.getContext("2d").getImageData(width * 0.45, 0, width * 0.1, height).data;
    const columns = rgba.length / 4 / height, box = canvas.getBoundingClientRect();
    for (let y = 0; y < height; ++y) {
        let bright = 0;
        for (let x = 0; x < columns; ++x) bright += rgba[4 * (y * columns + x)] > 120;
        if (bright > columns / 2) return box.top + (y * box.height) / height;
    }
    return NaN;
}"""

#: Runs in the page: the first column of the subject in CSS pixels, like TOP.
LEFT = """() => {
    const canvas = document.querySelector(".stage > canvas"), { width, height } = canvas;
    const rgba = canvas.getContext("2d").getImageData(0, height * 0.25, width, height * 0.5).data;
    const rows = rgba.length / 4 / width, box = canvas.getBoundingClientRect();
    for (let x = 0; x < width; ++x) {
        let bright = 0;
        for (let y = 0; y < rows; ++y) bright += rgba[4 * (y * width + x)] > 120;
        if (bright > rows / 50) return box.left + (x * box.width) / width;
    }
    return NaN;
}"""


#: Runs in every page before it: keeps the margins (see MARGINS) of the first picture that it shows.
KEEP_FIRST = f"""new MutationObserver(() => {{
    const canvas = document.querySelector(".stage > canvas[data-samples]");
    if (canvas) window.firstMargins ??= ({MARGINS})(canvas);
}}).observe(document, {{ subtree: true, childList: true, attributes: true }})"""

#: First bytes of messages of the stream (api/proto/stream.proto).
HELLO, FRAME, ACK = 0x0A, 0x12, 0x1A


@pytest.fixture
def opened(stack: TestStack, visit, cranium: Path):
    """Opens a scan in a window of a size: opened("en-GB", 1280, 720)."""
    def open_one(locale: str, width: int, height: int, **more) -> tuple[Page, str]:
        page = visit(locale="en-GB", **more)
        scan = Person.arrives(stack, page, "layout").has_scan(cranium, "Head")
        cookies = page.context.cookies()
        page.close()
        page = visit(locale=locale, **more)
        page.context.add_cookies(cookies)
        open_scan(stack, page, scan, width, height)
        return page, scan
    return open_one


@pytest.mark.parametrize("locale", ["en-GB", "de-DE"])
def test_slices_begin_right_below_their_bar_and_no_choice_is_clipped(locale: str, opened, pictures: Path):
    page, _ = opened(locale, 1280, 720)
    page.keyboard.press("Escape")
    page.keyboard.press("v")
    expect(page.locator(".slice-pane")).to_have_count(3)
    for width, height in ((1280, 720), (1440, 900), (1024, 1366), (800, 600), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        expect(page.locator(".slice-pane")).to_have_count(1 if width < 700 else 3)
        page.screenshot(path=pictures / f"layout-slices-{locale}-{width}.png")
        bar, pane = (page.locator(name).first.bounding_box() for name in (".slice-bar", ".slice-pane"))
        assert 0 < pane["y"] - bar["y"] - bar["height"] <= 16, (width, bar, pane)
        menu = page.locator(".menu").bounding_box()
        assert menu is None or menu["y"] >= bar["y"] + bar["height"], (width, bar, menu)
        if width >= 1280:
            assert bar["height"] < 60, "the choices take more than one line"
    page.set_viewport_size({"width": 1280, "height": 720})
    page.keyboard.press("v")
    for name in WINDOWS[locale[:2]]:
        page.get_by_role("button", name=name, exact=True).click()
        frame = page.get_by_role("dialog", name=name, exact=True)
        for more in frame.locator("details.more:not([open]) > summary").all():
            more.click()
        page.screenshot(path=pictures / f"layout-{locale}-{name}.png")
        assert page.evaluate(CLIPPED) == [], name
        if name == "Light":
            expect(frame.get_by_label("Name", exact=True)).to_have_value("Main light")
        page.get_by_role("button", name=name, exact=True).click()


@pytest.mark.parametrize("width,height", [(1280, 720), (1440, 900), (1024, 1366)])
def test_notes_above_the_picture_never_cover_the_subject(stack: TestStack, opened, pictures: Path, width: int, height: int):
    page, _ = opened("en-GB", width, height)
    for note in (".hints", ".pill-note"):
        expect(page.locator(note)).to_be_visible()
        stack.wait_until(lambda: page.evaluate(TOP) > 0 or page.wait_for_timeout(50), what="the subject")
        page.screenshot(path=pictures / f"layout-note{note}-{width}.png")
        box = page.locator(note).bounding_box()
        assert page.evaluate(TOP) >= box["y"] + box["height"], note
        page.keyboard.press("Escape")
    # The progress of a video is such a note, too.
    dialog = taking(page, "turntable")
    dialog.get_by_role("button", name="Save the video").click()
    line = page.locator("[data-shot=rendering]")
    expect(line).to_be_visible()
    page.screenshot(path=pictures / f"layout-video-{width}.png")
    box = line.bounding_box()
    assert page.evaluate(TOP) >= box["y"] + box["height"]
    line.get_by_role("button", name="Cancel").click()


def test_the_subject_turns_beside_the_menu_on_a_phone(stack: TestStack, opened, pictures: Path):
    page, _ = opened("en-GB", 390, 844, phone=True)
    page.keyboard.press("Escape")
    menu = page.locator(".menu").bounding_box()
    for turn in range(4):
        Fingers(page).drag([((160, 380), (260, 380))])
        wait_for_samples(stack, page, 2, input_seq=last_input(page))
        page.screenshot(path=pictures / f"layout-phone-turned-{turn}.png")
        assert page.evaluate(LEFT) >= menu["x"] + menu["width"], turn


def test_a_preset_without_a_picture_says_so(opened, pictures: Path):
    page, scan = opened("en-GB", 1280, 720)
    page.route("**/presets/*/thumbnail", lambda route: route.fulfill(status=404))
    page.locator(".tool-presets").click()
    dialog = page.get_by_role("dialog", name="Saved presets")
    dialog.get_by_label("Name of the new preset").fill("Mine")
    dialog.get_by_role("button", name="Save the current view").click()
    expect(dialog.get_by_text("No picture yet")).to_be_visible()
    page.screenshot(path=pictures / "layout-presets.png")
    # The way out of a dialog stays in sight, however little room there is.
    page.set_viewport_size({"width": 800, "height": 400})
    close = dialog.get_by_role("button", name="Close").bounding_box()
    assert close["y"] + close["height"] <= 400


def test_the_first_picture_on_a_phone_shows_the_whole_subject(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(phone=True)
    scan = Person.arrives(stack, page, "phone").has_scan(cranium, "Head")

    def delay(socket: WebSocketRoute) -> None:
        """Delays what the page asks for until it has two pictures of the volume's own view, as a busy server does."""
        server, waiting, frames = socket.connect_to_server(), [], []

        def to_server(message: bytes) -> None:
            if len(frames) >= 2 or message[0] in (HELLO, ACK):
                server.send(message)
            else:
                waiting.append(message)

        def to_page(message: bytes) -> None:
            socket.send(message)
            if message[0] == FRAME and len(frames) < 2:
                frames.append(message)
                if len(frames) == 2:
                    for one in waiting:
                        server.send(one)

        socket.on_message(to_server)
        server.on_message(to_page)

    page.route_web_socket(lambda _: True, delay)
    page.add_init_script(KEEP_FIRST)
    page.goto(f"{stack.url}/view/{scan}")
    first = wait_for_samples(stack, page, 1)
    page.screenshot(path=pictures / "layout-phone-first.png")
    left, right = page.evaluate("window.firstMargins")
    assert 0.02 < left < 0.5 and 0.02 < right < 0.5, "the subject is wider than the window"
    wait_for_samples(stack, page, first.samples + 1, first.input_seq)


def test_a_disabled_link_leads_to_the_start_page(stack: TestStack, visit, pictures: Path):
    page = visit(phone=True)
    page.goto(f"{stack.url}/shared#{64 * '0'}")
    expect(page.get_by_role("heading", name="This link no longer works")).to_be_visible()
    page.screenshot(path=pictures / "layout-link-gone.png")
    page.get_by_role("link", name="Go to the start page").tap()
    expect(page).to_have_url(stack.url + "/")


def test_a_guest_on_a_phone_reads_what_they_can_do(stack: TestStack, visit, opened, pictures: Path):
    page, _ = opened("de-DE", 1280, 720)
    page.locator(".tool-share").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Link erstellen").click()
    link = dialog.locator("input[readonly]").input_value()
    phone = visit(phone=True, locale="de-DE")
    phone.goto(link)
    phone.get_by_role("button", name="Teilnehmen", exact=True).tap()
    words = phone.locator(".live-line p")
    # The presenter's window is wider than a phone.
    expect(words).to_have_text("Besitzer präsentiertDrehen Sie es selbst in Ihrer eigenen Ansicht.Quer gehalten ist das Bild größer.")
    phone.screenshot(path=pictures / "layout-guest.png")
    keeps_apart(phone)
    title = phone.get_by_role("heading", name="Geteiltes Bild").bounding_box()
    assert title["width"] > 60 and title["height"] > 15
    page.close()
    expect(words).to_have_text("Gerade präsentiert niemand. Sie können allein weitersehen.")
    phone.screenshot(path=pictures / "layout-guest-alone.png")
    keeps_apart(phone)


def test_a_guest_on_a_phone_sees_all_of_a_slice(visit, opened, pictures: Path):
    page, _ = opened("en-GB", 1280, 720)
    page.get_by_role("button", name="Show the slices (V)").click()  # which the guest follows
    page.locator(".tool-share").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Create link").click()
    link = dialog.locator("input[readonly]").input_value()
    dialog.get_by_role("checkbox", name="Guests see the slices that are presented").check()
    phone = visit(phone=True)
    phone.goto(link)
    phone.get_by_role("button", name="Join", exact=True).tap()
    slider = phone.locator(".slice-pane input[type=range]")
    expect(slider).to_be_visible()
    expect(phone.locator(".live-line")).to_be_visible()
    phone.screenshot(path=pictures / "layout-guest-slice.png")
    box, line = slider.bounding_box(), phone.locator(".live-line").bounding_box()
    assert box["y"] + box["height"] <= line["y"], "the status line covers the slice"


def test_the_tips_leave_the_looks_visible_at_twice_the_size(opened, pictures: Path):
    page, _ = opened("en-GB", 720, 450)  # as much as a window of 1440 × 900 shows at 200%
    expect(page.locator(".hints")).to_be_visible()
    expect(page.locator(".preset")).to_have_count(6)
    page.screenshot(path=pictures / "layout-zoomed.png")
    tips, looks = (page.locator(name).bounding_box() for name in (".hints", ".presets"))
    assert tips["y"] + tips["height"] <= looks["y"]


def test_the_progress_fits_in_one_line_in_german(opened):
    page, _ = opened("de-DE", 1280, 720)
    chip = page.locator(".quality-head .chip")
    expect(chip).to_be_visible()
    height = "(chip, text) => { const before = chip.firstChild.data; chip.firstChild.data = text;" \
             " const { height } = chip.getBoundingClientRect(); chip.firstChild.data = before; return height; }"
    assert chip.evaluate(height, "Wird schärfer … 99\u00a0%") == chip.evaluate(height, "Fertig")


def test_nothing_of_a_scan_stays_with_a_guest_after_the_end(visit, opened, pictures: Path):
    page, _ = opened("en-GB", 1280, 720)
    page.get_by_role("button", name="Show the slices (V)").click()  # which the guest follows
    page.locator(".tool-share").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Create link").click()
    link = dialog.locator("input[readonly]").input_value()
    dialog.get_by_role("checkbox", name="Guests see the slices that are presented").check()
    guest = visit()
    guest.goto(link)
    guest.get_by_role("button", name="Join", exact=True).click()
    expect(guest.locator(".slice-pane")).to_have_count(3)  # they open as the presenter's do
    dialog.get_by_role("button", name="Disable link").click()
    expect(guest.get_by_role("heading", name="Your visit has ended")).to_be_visible()
    expect(guest.locator(".slice-pane, .live-line")).to_have_count(0)
    expect(guest.locator(".stage > canvas")).to_be_hidden()
    expect(guest.locator(".viewer-tools").get_by_role("button", name="Controls")).to_be_visible()
    expect(guest.locator(".tool-screenshot, .tool-reset, .tool-share")).to_have_count(0)
    guest.keyboard.press("s")
    guest.keyboard.press("?")
    expect(guest.get_by_role("dialog")).to_have_accessible_name("Controls")
    guest.screenshot(path=pictures / "layout-guest-ended.png")


def test_german_pages_fit_small_windows(stack: TestStack, visit, pictures: Path):
    page = visit(locale="de-DE")
    page.set_viewport_size({"width": 1280, "height": 720})
    for path, heading in (("/", "Sehen Sie"), ("/sign-up", "Konto erstellen")):
        page.goto(stack.url + path)
        expect(page.get_by_role("heading", name=heading)).to_be_visible()
        page.screenshot(path=pictures / f"layout-de{path.replace('/', '-')}.png")
        foot = page.locator(".foot").bounding_box()
        assert foot["y"] + foot["height"] <= 720, path
    session = write_person(stack.psql, f"konto-{secrets.token_hex(4)}@example.org")
    stack.psql("UPDATE web_sessions SET browser = 'Chrome on Linux' WHERE user_id = %s", session.id)
    page.context.add_cookies([{"name": "diaphane", "value": session.token, "url": stack.url, "httpOnly": True, "sameSite": "Strict"}])
    page.goto(stack.url + "/account")
    expect(page.get_by_text("Chrome unter Linux")).to_be_visible()
    phone = visit(phone=True, locale="de-DE")
    phone.goto(stack.url)
    expect(phone.get_by_role("heading", name="Sehen Sie")).to_be_visible()
    phone.screenshot(path=pictures / "layout-de-phone.png")
    assert phone.locator(".bar").bounding_box()["height"] < 70, "the links take more than one line"


def test_the_audit_log_fits_the_window(stack: TestStack, visit, pictures: Path):
    page = visit(wide=True)
    boss = Person.arrives(stack, page, "somebody-with-a-rather-long-address")
    boss.becomes_administrator()
    stack.psql("INSERT INTO audit_log (happened_at, actor, actor_id, action, subject, details) SELECT now(), 'administrator', id,"
               " 'account.storage-quota-changed', 'account', '{\"from\": 21500000000, \"to\": 40000000000, \"by\": \"link\","
               " \"link\": \"3b1f8c52-0000-4000-8000-000000000000\", \"slices\": 1}' FROM users WHERE email = %s", boss.email)
    page.goto(stack.url + "/admin/audit")
    box = page.locator(".table-box")
    expect(box.get_by_text("3b1f8c52").first).to_be_visible()
    page.screenshot(path=pictures / "layout-audit.png")
    assert box.evaluate("(box) => box.scrollWidth <= box.clientWidth")


def keeps_apart(phone: Page) -> None:
    """The words have room, and the line, the cube and the quality do not cover each other."""
    expect(phone.locator(".quality-chip")).to_be_visible()
    words, line = (phone.locator(name).bounding_box() for name in (".live-line p", ".live-line"))
    assert words["width"] > 250 and words["height"] < 80
    for name in (".quality-chip", ".cube"):
        box = phone.locator(name).bounding_box()
        assert box["y"] + box["height"] <= line["y"], name
