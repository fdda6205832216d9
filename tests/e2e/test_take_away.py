"""What a user exports: a picture as a file, and a link to the view."""

from __future__ import annotations

import base64
import re
import struct
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from picture import FINE_ERROR, SHRINK, SIDE, difference, drag, facts, last_input, listen, pixels, spread, wait_for_picture, wait_for_samples, wait_said

PNG = b"\x89PNG\r\n\x1a\n"
#: Mean difference per channel, of 255, between two renderings of one view with 2% and 5% of noise, averaged over SIDE x SIDE
#: boxes.
ALIKE = 2.0


def chunks(png: bytes) -> list[str]:
    """Returns the names of the chunks in order."""
    assert png.startswith(PNG)
    names, at = [], len(PNG)
    while at < len(png):
        length, name = struct.unpack_from(">I4s", png, at)
        names.append(name.decode())
        at += 12 + length
    return names


def shrunk(page: Page, png: bytes) -> tuple[int, int, bytes]:
    """Returns width, height, and the picture as the browser decodes it and `pixels` scales it."""
    width, height, text = page.evaluate(
        f"""async ([data, side]) => {{
            const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
            const picture = await createImageBitmap(new Blob([bytes], {{ type: "image/png" }}));
            return [picture.width, picture.height, ({SHRINK})(picture, side)];
        }}""", [base64.b64encode(png).decode(), SIDE])
    return width, height, base64.b64decode(text)


def sessions(page: Page) -> int:
    return page.evaluate("fetch('/v1/sessions').then((r) => r.json()).then((s) => s.items.length)")


def wait_for_sessions(stack: TestStack, page: Page, count: int) -> None:
    stack.wait_until(lambda: page.wait_for_timeout(50) or sessions(page) == count, what=f"{count} sessions, no more and no less")


def live_answers(stack: TestStack, page: Page) -> None:
    """A key rotates the displayed picture while something else is rendered."""
    before = facts(page)
    page.keyboard.press("ArrowRight")
    stack.wait_until(lambda: page.wait_for_timeout(50) or facts(page).input_seq > before.input_seq, timeout=120, what="the live picture")


def hide_message(page: Page) -> None:
    """Hides the message about a file, which hides itself 8 seconds after the file is saved."""
    hide = page.get_by_role("button", name="Hide this message")
    hide.evaluate_all("(buttons) => buttons.forEach((button) => button.click())")
    expect(hide).to_have_count(0)


def test_a_picture_is_rendered_for_saving_during_a_live_session(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    person = Person.arrives(stack, page, "tanja")
    scan = person.has_scan(cranium, "Erika Mustermann")
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_picture(stack, page, error=FINE_ERROR)
    drag(page, 60, 0)
    wait_for_samples(stack, page, 1, input_seq=last_input(page))

    assert sessions(page) == 1
    page.keyboard.press("s")
    dialog = page.get_by_role("dialog", name="Save or share")
    expect(dialog).to_be_visible()
    page.screenshot(path=pictures / "take-dialog.png")

    # Invalid sizes are refused with a message, and nothing starts.
    dialog.get_by_label("Size").select_option("other")
    dialog.get_by_label("Width").fill("16385")
    dialog.get_by_label("Height").fill("4320")
    dialog.get_by_role("button", name="Save the picture").click()
    expect(dialog.get_by_role("alert")).to_have_text("Each side must be between 16 and 16,384 pixels. Enter whole numbers.")

    # The aspect ratio of the screen in another size.
    dialog.get_by_label("Width").fill("360")
    dialog.get_by_label("Height").fill("240")
    dialog.get_by_label("Quality", exact=True).select_option("quick")
    listen(page, ".shot-line")
    with page.expect_download() as download:
        dialog.get_by_role("button", name="Save the picture").click()
        wait_said(stack, page, "Rendering the picture")
        page.screenshot(path=pictures / "take-rendering.png")
        live_answers(stack, page)  # meanwhile
        page.keyboard.press("Control+z")
    assert re.fullmatch(r"diaphane-[\d-]+\.png", download.value.suggested_filename)
    png = Path(download.value.path()).read_bytes()
    (pictures / "taken.png").write_bytes(png)
    assert set(chunks(png)) <= {"IHDR", "sRGB", "gAMA", "IDAT", "IEND"}, chunks(png)
    assert b"Mustermann" not in png and scan.encode() not in png
    wait_said(stack, page, "The picture has been saved.")
    hide_message(page)
    wait_for_picture(stack, page, input_seq=last_input(page), error=FINE_ERROR)
    width, height, taken = shrunk(page, png)
    live = pixels(page)
    assert (width, height) == (360, 240)
    assert spread(taken) > 5 and difference(taken, live) < ALIKE, (spread(taken), difference(taken, live))
    wait_for_sessions(stack, page, 1)

    # After cancelling, nothing is saved, and the session is released.
    page.get_by_role("button", name="Save or share").click()
    dialog.get_by_label("Size").select_option("largest")
    dialog.get_by_label("Quality", exact=True).select_option("best")
    dialog.get_by_role("button", name="Save the picture").click()
    line = page.locator("[data-shot=rendering]")
    expect(line).to_be_visible()
    wait_for_sessions(stack, page, 2)
    line.get_by_role("button", name="Cancel").click()
    expect(page.get_by_role("status").get_by_text("No picture was saved.")).to_be_visible()
    wait_for_sessions(stack, page, 1)


def test_a_link_shows_the_same_view_only_to_users_with_access(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    person = Person.arrives(stack, page, "linus")
    scan = person.has_scan(cranium, "Erika Mustermann")
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_picture(stack, page, error=FINE_ERROR)
    usual = pixels(page)
    page.get_by_role("button", name="Bone", exact=True).click()
    drag(page, 90, 20)
    wait_for_picture(stack, page, input_seq=last_input(page), error=FINE_ERROR)
    page.keyboard.press("s")
    field = page.get_by_role("textbox", name="Link", exact=True)
    expect(field).to_have_value(re.compile(r"#view="))
    link = field.input_value()
    assert link.startswith(f"{stack.url}/view/{scan}#view=1.") and len(link) < 2048
    page.keyboard.press("Escape")
    wait_for_picture(stack, page, input_seq=last_input(page), error=FINE_ERROR)
    shown = pixels(page)
    assert difference(usual, shown) > 2 * ALIKE

    def opened(address: str) -> Page:
        other = page.context.new_page()
        other.set_viewport_size({"width": 480, "height": 320})
        other.goto(address)
        return other

    again = opened(link)
    stack.wait_until(lambda: again.wait_for_timeout(50) or again.evaluate("location.hash") == "", what="the link taken")
    wait_for_picture(stack, again, input_seq=1, error=FINE_ERROR)
    assert difference(pixels(again), shown) < ALIKE
    again.screenshot(path=pictures / "linked.png")
    again.close()

    # Damaged links, and links of a later version, show a message and the scan as usual.
    for address, words in ((link[:-40], "damaged or incomplete"), (link.replace("#view=1.", "#view=2."), "newer version of Diaphane")):
        odd = opened(address)
        expect(odd.get_by_text(words)).to_be_visible()
        wait_for_picture(stack, odd, error=FINE_ERROR)
        assert difference(pixels(odd), usual) < ALIKE
        odd.screenshot(path=pictures / "link-refused.png")
        odd.close()

    # The link grants another user no access.
    stranger = visit(small=True)
    Person.arrives(stack, stranger, "fremd")
    stranger.goto(link)
    expect(stranger.get_by_role("status").get_by_text("This scan doesn’t exist, or you don’t have access to it.")).to_be_visible()
