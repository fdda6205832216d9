"""The public pages with the keyboard, on a phone, and in both themes, and the findings of an accessibility checker."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import REPO, TestStack
from person import PASSWORD, Person
from picture import difference, last_input, pixels, wait_for_picture, wait_for_samples

AXE = REPO / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
#: Completely inside the window and their row.
ALL_IN_SIGHT = """(all) => all.every((one) => {
    const box = one.getBoundingClientRect(), row = one.parentElement.getBoundingClientRect();
    return box.left >= Math.max(0, row.left) && box.right <= Math.min(innerWidth, row.right);
})"""
LOOKS = [pytest.param({"wide": True}, id="light"), pytest.param({"wide": True, "dark": True}, id="dark", marks=pytest.mark.nightly), pytest.param({"phone": True}, id="phone")]


def check_page(page: Page) -> None:
    """Checks WCAG 2.2 AA as far as axe can, and that there is no horizontal scrolling."""
    page.evaluate(AXE.read_text(encoding="utf-8"))
    # axe cannot determine the background of texts on glass above the picture.
    result = page.evaluate("axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'] })")
    assert [(v["id"], [n["html"] for n in v["nodes"]]) for v in result["violations"]] == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("look", LOOKS)
def test_every_page_is_accessible_and_fits_the_window(stack: TestStack, visit, cranium: Path, pictures: Path, look: dict, request):
    page = visit(**look)
    name = request.node.callspec.id

    def seen(what: str) -> None:
        page.screenshot(path=pictures / f"{name}-{what}.png")
        check_page(page)

    page.goto(stack.url + "/sign-up")
    expect(page.get_by_role("heading", name="Create your account")).to_be_visible()
    seen("sign-up")
    person = Person.arrives(stack, page, "lookaround")
    seen("no-scans")
    person.choose_folder(cranium)
    expect(page.get_by_text("1 image series can be shown")).to_be_visible()
    seen("series")
    person.has_scan(cranium, "A head")
    expect(page.get_by_role("img", name="Picture of A head")).to_be_visible()
    seen("scans")
    person.open_scan("A head")
    wait_for_samples(stack, page, 2)
    looks = page.locator(".preset")
    expect(looks).to_have_count(6)
    stack.wait_until(lambda: looks.evaluate_all(ALL_IN_SIGHT) or page.wait_for_timeout(50), what="all looks in sight")
    seen("viewer")
    page.get_by_role("button", name="Controls").click()
    seen("help")


def test_the_sample_is_shown_to_everyone_and_labelled(stack: TestStack, visit, pictures: Path):
    sample = REPO / "build" / "release" / "bin" / "diaphane-sample"
    tool = Path(os.environ["DIAPHANE_BUILD"]) / "bin" / "diaphane-sample" if "DIAPHANE_BUILD" in os.environ else sample
    done = subprocess.run([tool, "--upload", stack.url, "--token-file", stack.sample_token_file], capture_output=True, text=True, check=True)
    page = visit()
    person = Person.arrives(stack, page, "guest")
    card = page.locator(f"article[data-id='{done.stdout.strip()}']")
    expect(card).to_have_attribute("data-state", "ready")
    expect(card.get_by_text("Sample", exact=True)).to_be_visible()
    # A sample can be compared with another scan, but not renamed or deleted.
    expect(card.get_by_role("button").and_(page.locator(":not([aria-label^='Compare'])"))).to_have_count(0)
    check_page(page)
    card.get_by_role("link").click()
    wait_for_samples(stack, page, 2)
    assert page.evaluate("fetch('/v1/sessions').then((r) => r.json()).then((s) => s.items.length)") == 1

    # Leaving for another page releases the renderer's slot.
    page.get_by_role("link", name="My scans").click()
    expect(page.get_by_role("heading", name="My scans")).to_be_visible()
    stack.wait_until(lambda: person.api("GET", "/v1/sessions") == 200
                     and page.evaluate("fetch('/v1/sessions').then((r) => r.json()).then((s) => s.items.length)") == 0,
                     what="the end of the session")


def test_everything_works_by_keyboard(stack: TestStack, visit, cranium: Path):
    page = visit()
    person = Person(stack, page, "keys@example.org")
    page.goto(stack.url + "/sign-up")
    page.get_by_label("Email address").focus()
    page.keyboard.type(person.email)
    for key in ("Tab", "Space", "Tab", "Tab", "Enter"):   # the consent, its link, the button
        page.keyboard.press(key)
    expect(page.get_by_role("heading", name="Check your email")).to_be_focused()
    page.goto(person.mailed_link())
    # The heading takes the focus when the page is ready, as for a user who reads it first.
    expect(page.get_by_role("heading", name="Choose your password")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.type(PASSWORD)
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Welcome")).to_be_focused()
    expect(page.get_by_text(f"You’re signed in as {person.email}.")).to_be_visible()
    page.get_by_role("main").get_by_role("link", name="Add a scan").press("Enter")
    expect(page.get_by_role("heading", name="Add a scan")).to_be_focused()
    person.has_scan(cranium, "Head")
    page.set_viewport_size({"width": 480, "height": 320})
    page.get_by_role("link", name="Open Head").press("Enter")
    wait_for_samples(stack, page, 4)

    start = pixels(page)
    for _ in range(8):
        page.keyboard.press("ArrowRight")
    turned = wait_for_picture(stack, page, input_seq=last_input(page))  # one step alone changes little
    assert difference(start, pixels(page)) > 3

    page.keyboard.press("3")
    bone = wait_for_picture(stack, page, input_seq=turned.input_seq + 1)
    expect(page.locator(".preset[aria-pressed=true]")).to_have_attribute("data-preset", "bone")

    page.keyboard.press("r")
    wait_for_picture(stack, page, input_seq=bone.input_seq + 1)
    page.keyboard.press("s")
    page.get_by_label("Size").select_option("other")
    page.get_by_label("Width").fill("120")
    page.get_by_label("Height").fill("80")
    page.get_by_role("dialog").get_by_label("Quality", exact=True).select_option("quick")
    with page.expect_download() as download:
        page.get_by_label("Height").press("Enter")
    assert re.fullmatch(r"diaphane-[\d-]+\.png", download.value.suggested_filename)
    assert Path(download.value.path()).read_bytes().startswith(b"\x89PNG")
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Controls")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)


def test_an_unconfirmed_address_cannot_sign_in(stack: TestStack, visit):
    page = visit()
    person = Person(stack, page, "slow@example.org")
    person.sign_up()
    page.goto(stack.url + "/sign-in")
    page.get_by_label("Email address").fill(person.email)
    page.get_by_label("Password", exact=True).fill(PASSWORD)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("alert")).to_contain_text("password is wrong")


def test_an_emailed_link_works_once(stack: TestStack, visit):
    page = visit()
    person = Person(stack, page, "twice@example.org")
    person.sign_up()
    link = person.mailed_link()
    page.goto(link)
    person.choose_password()
    assert "token" not in page.url
    page.reload()
    expect(page.get_by_role("heading", name="Add a scan")).to_be_visible()
    page = visit()
    page.goto(link)
    page.get_by_label("Password", exact=True).fill(PASSWORD)
    page.get_by_role("button", name="Set password and sign in").click()
    expect(page.get_by_role("alert")).to_contain_text("already been used")
    assert page.evaluate("fetch('/v1/me').then((r) => r.status)") == 401


def test_the_chosen_colour_scheme_is_kept(stack: TestStack, visit):
    page = visit()
    page.goto(stack.url)
    page.get_by_role("button", name="Switch to dark mode").click()
    page.reload()
    expect(page.locator("html")).to_have_attribute("data-theme", "dark")
    expect(page.get_by_role("button", name="Switch to light mode")).to_be_visible()


def test_signing_out_ends_the_web_session(stack: TestStack, visit):
    page = visit()
    person = Person.arrives(stack, page, "leaver")
    page.get_by_role("button", name="Sign out").click()
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    page.goto(stack.url + "/scans")
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    assert page.evaluate("fetch('/v1/data-sets').then((r) => r.status)") == 401
    assert page.evaluate("sessionStorage.length") == 0
    person.sign_in()


def test_a_forgotten_password_is_replaced_after_a_wrong_address(stack: TestStack, visit):
    page = visit()
    anna = Person.arrives(stack, page, "anna")
    page.context.clear_cookies()
    stack.psql("DELETE FROM attempts")
    page.goto(stack.url + "/forgot")
    email, send = page.get_by_label("Email address"), page.get_by_role("button", name="Send link")
    email.fill("anan@example.org")
    send.click()
    page.get_by_role("button", name="Correct the address or send it again").click()
    expect(email).to_have_value("anan@example.org")
    email.fill(anna.email)
    send.click()
    expect(page.get_by_role("heading", name="Check your email")).to_be_visible()
    mail = stack.wait_until(lambda: stack.mails(anna.email), what="the mail")[-1]
    page.goto(re.search(r"http\S+/reset#token=[0-9a-f]{64}", mail.get_content()).group(0))
    page.get_by_label("New password").fill("four blind mice run")
    page.get_by_role("button", name="Set new password").click()
    expect(page.get_by_role("heading", name="Password changed")).to_be_visible()
    page.get_by_role("link", name="Go to sign-in").click()
    anna.sign_in("four blind mice run")
