"""The installation's own pages (privacy notice, terms, contact), and the consent to the privacy notice."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from test_every_page import faults


@pytest.fixture
def own_texts(stack: TestStack):
    """The folder of the operator's texts, empty again afterwards."""
    folder = stack.data_dir / "legal"
    yield folder
    for file in folder.glob("*.txt"):
        file.unlink()


def shows_links(page: Page, url: str) -> None:
    page.goto(url)
    links = page.get_by_role("navigation", name="Legal information").get_by_role("link")
    expect(links).to_have_count(3)  # the page appears after its scripts have loaded
    assert [link.get_attribute("href") for link in links.all()] == ["/privacy", "/terms", "/contact"]


def test_legal_templates_list_what_the_operator_must_fill_in(stack: TestStack, visit, pictures: Path):
    for number, look in enumerate(({"wide": True}, {"phone": True, "dark": True})):
        page = visit(**look)
        for path, heading in (("privacy", "Privacy notice"), ("terms", "Terms of use"), ("contact", "Contact")):
            page.goto(f"{stack.url}/{path}")
            expect(page.get_by_role("heading", name=heading, level=1)).to_be_visible()
            expect(page.get_by_role("alert").get_by_text("hasn’t completed this page yet")).to_be_visible()
            expect(page.locator("mark").first).to_be_visible()
            assert faults(page) == [], path
            page.screenshot(path=pictures / f"legal-{path}-{number}.png", full_page=True)
    page = visit(locale="de-AT")
    page.goto(stack.url + "/privacy")
    expect(page.get_by_role("heading", name="Datenschutzerklärung")).to_be_visible()
    page.screenshot(path=pictures / "legal-privacy-german.png", full_page=True)


def test_the_operators_texts_replace_the_templates(stack: TestStack, visit, own_texts: Path):
    (own_texts / "contact.de.txt").write_text("# Impressum\n\nBeispiel GmbH\nHauptstraße 1\n\n<b>hilfe@example.org</b>\n", encoding="utf-8")
    page = visit()
    page.goto(stack.url + "/contact")
    # Nothing is filled in in English, so the German text is better than a template.
    expect(page.get_by_role("heading", name="Impressum")).to_be_visible()
    assert page.locator("article").get_attribute("lang") == "de"
    assert page.get_by_text("hasn’t completed").count() == 0
    assert page.get_by_role("link", name="hilfe@example.org").get_attribute("href") == "mailto:hilfe@example.org"
    expect(page.get_by_text("<b>")).to_be_visible()   # HTML is text
    (own_texts / "contact.en.txt").write_text("# Who we are\n\nExample Ltd\n", encoding="utf-8")
    page.reload()
    expect(page.get_by_role("heading", name="Who we are")).to_be_visible()
    assert page.request.get(stack.url + "/legal/contact.en.txt.txt").status == 404
    assert page.request.post(stack.url + "/legal/contact.en.txt").status == 405


def test_account_pages_link_the_legal_texts_and_remind_administrators(stack: TestStack, visit):
    page = visit()
    for path in ("/", "/sign-up", "/sign-in"):
        shows_links(page, stack.url + path)
    page.get_by_role("link", name="Privacy notice").click()
    expect(page.get_by_role("heading", name="Privacy notice", level=1)).to_be_visible()
    person = Person.arrives(stack, visit(), "legal")
    shows_links(person.page, stack.url + "/account")
    person.becomes_administrator()
    person.page.goto(stack.url + "/admin/fleet")
    expect(person.page.get_by_text("you must fill in: Privacy notice, Terms of use, Contact")).to_be_visible()


def test_sign_up_requires_agreeing_to_the_privacy_notice(stack: TestStack, visit, pictures: Path):
    page = visit(phone=True)
    page.goto(stack.url + "/sign-up")
    box = page.get_by_label("I agree that this service processes my scans")
    expect(box).not_to_be_checked()
    page.get_by_label("Email address").fill("careful@example.org")
    page.get_by_role("button", name="Create account").click()
    expect(page.get_by_text("Tick this box to continue.")).to_be_visible()
    expect(box).to_be_focused()
    assert faults(page) == []
    page.screenshot(path=pictures / "consent-sign-up.png", full_page=True)
    with page.expect_popup() as notice:
        page.get_by_role("link", name="Read the privacy notice").click()
    expect(notice.value.get_by_role("heading", name="Privacy notice", level=1)).to_be_visible()
    assert page.get_by_label("Email address").input_value() == "careful@example.org"


def test_users_without_consent_are_asked_before_they_see_their_scans(stack: TestStack, visit, pictures: Path):
    person = Person.arrives(stack, visit(wide=True), "earlier")
    page = person.page
    stack.psql("UPDATE users SET consent_version = NULL, consent_at = NULL WHERE email = %s", person.email)
    page.goto(stack.url + "/scans")
    expect(page.get_by_role("heading", name="We need your consent")).to_be_visible()
    assert faults(page) == []
    page.screenshot(path=pictures / "consent-asked.png")
    # Their data are theirs even without it.
    page.get_by_role("main").get_by_role("link", name="Your account").click()
    expect(page.get_by_role("heading", name="Your data")).to_be_visible()
    page.goto(stack.url + "/add")
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_text("Tick this box to continue.")).to_be_visible()
    page.get_by_label("I agree").check()
    page.get_by_role("button", name="Continue").click()
    expect(page.get_by_role("heading", name="Add a scan")).to_be_visible()
    page.reload()
    expect(page.get_by_role("heading", name="Add a scan")).to_be_visible()

    stack.psql("UPDATE users SET consent_version = 'older' WHERE email = %s", person.email)
    page.goto(stack.url + "/scans")
    page.get_by_role("main").get_by_role("button", name="Sign out").click()
    expect(page.get_by_role("link", name="Sign in")).to_be_visible()
