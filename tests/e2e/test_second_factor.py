"""The second factor on the pages: set up with the QR code or the key, requested, and lost. With the keyboard where a user would.
"""

from __future__ import annotations

import base64
from pathlib import Path

import numpy
import pyotp
import pytest
import zxingcpp
from playwright.sync_api import Page, expect

from harness import TestStack
from person import PASSWORD, Person
from test_every_page import faults


def read_qr(page: Page, blank: Page) -> str:
    """Reads the QR code like a camera. `blank` is a page without the content security policy, which converts the picture to grey
    values."""
    code = page.get_by_role("img", name="QR code")
    expect(code.locator("path")).to_have_count(1)
    shown = base64.b64encode(code.screenshot()).decode()
    width, grey = blank.evaluate("""async (png) => {
        const image = new Image();
        image.src = "data:image/png;base64," + png;
        await image.decode();
        const canvas = new OffscreenCanvas(image.width, image.height).getContext("2d");
        canvas.drawImage(image, 0, 0);
        const rgba = canvas.getImageData(0, 0, image.width, image.height).data;
        return [image.width, Array.from({ length: rgba.length / 4 }, (_, i) => rgba[4 * i])];
    }""", shown)
    [found] = zxingcpp.read_barcodes(numpy.array(grey, dtype=numpy.uint8).reshape(-1, width))
    return found.text


def panel(page: Page):
    return page.get_by_role("region", name="Two-factor authentication")


def sets_up(person: Person, blank: Page) -> tuple[pyotp.TOTP, list[str]]:
    """Sets it up on the account's page. Returns the device and the recovery codes."""
    page, box = person.page, panel(person.page)
    box.get_by_label("Current password").fill(PASSWORD)
    box.get_by_role("button", name="Set up").click()
    key = box.locator("code.secret").inner_text().replace(" ", "")
    device = pyotp.parse_uri(read_qr(page, blank))
    assert device.secret == key and device.issuer == "Diaphane" and device.name == person.email
    code = box.get_by_label("Authentication code")
    assert code.get_attribute("autocomplete") == "one-time-code" and code.get_attribute("inputmode") == "numeric"
    code.fill(device.now())
    code.press("Enter")
    expect(box.get_by_role("heading", name="Your recovery codes")).to_be_focused()  # and so in the window
    return device, box.get_by_role("listitem").all_inner_texts()


def gives_password(person: Person) -> None:
    """The first step of signing in, with the keyboard alone."""
    person.stack.psql("DELETE FROM attempts")
    page = person.page
    page.goto(person.stack.url + "/sign-in")
    page.get_by_label("Email address").fill(person.email)
    page.get_by_label("Password", exact=True).fill(PASSWORD)
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Enter your code")).to_be_visible()


def next_code(stack: TestStack, person: Person, device: pyotp.TOTP) -> str:
    """Returns an unused code without waiting for the clock, by forgetting which ones were used."""
    stack.psql("UPDATE second_factors SET last_step = 0 WHERE user_id = (SELECT id FROM users WHERE email = %s)", person.email)
    return device.now()


@pytest.mark.parametrize("look", [
    pytest.param({}, id="desk"), pytest.param({"phone": True, "dark": True}, id="phone-dark", marks=pytest.mark.nightly)])
def test_signing_in_needs_the_second_factor_or_a_recovery_code(stack: TestStack, visit, pictures: Path, look: dict):
    page, blank = visit(**look), visit()
    anna = Person.arrives(stack, page, "anna")
    page.goto(stack.url + "/account")
    expect(panel(page).get_by_role("button", name="Set up")).to_be_visible()
    assert faults(page) == []
    device, codes = sets_up(anna, blank)
    assert len(codes) == 10 and faults(page) == []
    page.screenshot(path=pictures / f"recovery-codes{'-phone' if look else ''}.png", full_page=True)
    panel(page).get_by_role("button", name="I’ve saved them").click()
    expect(panel(page).get_by_role("heading", name="Two-factor authentication")).to_be_focused()  # and so in the window
    expect(panel(page).get_by_text("You have 10 recovery codes left.")).to_be_visible()
    page.get_by_role("button", name="Sign out", exact=True).click()
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()

    gives_password(anna)
    code = page.get_by_label("Authentication code")
    expect(code).to_be_focused()
    assert faults(page) == []
    page.screenshot(path=pictures / f"sign-in-code{'-phone' if look else ''}.png")
    page.keyboard.type("000000")
    page.keyboard.press("Enter")
    expect(page.get_by_text("This code is incorrect or was already used.")).to_be_visible()
    expect(code).to_be_focused()
    code.fill(next_code(stack, anna, device))
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="My scans")).to_be_visible()

    # The phone is lost.
    page.get_by_role("button", name="Sign out", exact=True).click()
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    gives_password(anna)
    page.get_by_role("button", name="Use a recovery code").click()
    expect(page.get_by_label("Recovery code")).to_be_focused()
    page.keyboard.type(codes[0])
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="My scans")).to_be_visible()
    page.goto(stack.url + "/account")
    expect(panel(page).get_by_text("You have 9 recovery codes left.")).to_be_visible()
    # Deleting the account needs a code, too.
    dialog = page.get_by_role("dialog")
    page.get_by_role("button", name="Delete my account…").click()
    dialog.get_by_label("Current password").fill(PASSWORD)
    dialog.get_by_role("button", name="Delete account").click()
    expect(dialog.get_by_text("This field is required.")).to_be_visible()
    dialog.get_by_label("Authentication code").fill("000000")
    dialog.get_by_role("button", name="Delete account").click()
    expect(dialog.get_by_text("This code is incorrect or was already used.")).to_be_visible()
    assert faults(page) == []
    dialog.get_by_role("button", name="Cancel").click()
    panel(page).get_by_role("button", name="Turn off…").click()
    dialog.get_by_label("Current password").fill(PASSWORD)
    dialog.get_by_label("Authentication code").fill(codes[1])
    assert faults(page) == []
    dialog.get_by_role("button", name="Turn off").click()
    expect(panel(page).get_by_role("button", name="Set up")).to_be_visible()


def test_an_administrator_must_set_up_the_second_factor_first(stack: TestStack, visit, pictures: Path):
    page, blank = visit(), visit()
    boss = Person.arrives(stack, page, "boss")
    stack.psql("UPDATE users SET is_administrator = true WHERE email = %s", boss.email)
    page.goto(stack.url + "/admin")
    expect(page.get_by_text("Set up two-factor authentication to use administrator features")).to_be_visible()
    assert faults(page) == []
    page.screenshot(path=pictures / "administrator-without.png")
    page.get_by_role("link", name="Set it up in your account").click()
    expect(page.get_by_role("heading", name="Two-factor authentication")).to_be_focused()
    expect(panel(page).get_by_role("button", name="Set up")).to_be_in_viewport()
    sets_up(boss, blank)
    page.get_by_role("link", name="Administration").click()
    expect(page.get_by_role("link", name="Audit log")).to_be_visible()
    expect(page.get_by_role("button", name="Search")).to_be_visible()


def test_the_password_field_shows_what_is_missing(stack: TestStack, visit):
    page = visit()
    person = Person(stack, page, "somebody@example.org")
    person.sign_up()
    page.goto(person.mailed_link())
    password = page.get_by_label("Password", exact=True)
    said = page.locator(".strength")
    for typed, words in (("kq7 zr4 vm2", "1 more character needed."), ("kq7 zr4 vm2x", "Long enough, but longer is better."),
                         ("aaaaaaaaaaaaaaaa", "Too repetitive."), ("three blind mice run far", "Very good.")):
        password.fill(typed)
        expect(said).to_have_text(words)
    assert faults(page) == []
    password.fill("kq7 zr4 vm2")
    page.get_by_role("button", name="Set password and sign in").click()
    expect(page.get_by_text("Use at least 12 characters.")).to_be_visible()
    password.fill("password1234")
    page.get_by_role("button", name="Set password and sign in").click()
    expect(password).to_have_attribute("aria-invalid", "true")
