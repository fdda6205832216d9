"""API tokens on the account page: created, shown once, used by a program, and revoked."""

from __future__ import annotations

import re
import secrets
from pathlib import Path

import pytest
from diaphane import AuthenticationError, Diaphane, ForbiddenError
from playwright.sync_api import Page, expect

from harness import TestStack
from person import PASSWORD, Person
from seeds import write_person
from test_every_page import faults


def panel(page: Page, name: str = "API tokens"):
    return page.get_by_role("region", name=name)


@pytest.mark.parametrize("look", [
    pytest.param({}, id="desk"), pytest.param({"phone": True, "dark": True}, id="phone-dark", marks=pytest.mark.nightly)])
def test_a_token_is_made_used_and_revoked(stack: TestStack, visit, pictures: Path, look: dict):
    page = visit(**look)
    Person.arrives(stack, page, "anna")
    page.goto(stack.url + "/account")
    box = panel(page)
    expect(box.get_by_text("You have no API tokens.")).to_be_visible()
    box.get_by_role("button", name="Create a token…").click()
    box.get_by_role("button", name="Cancel").click()
    expect(box.get_by_role("button", name="Create token")).to_have_count(0)
    box.get_by_role("button", name="Create a token…").click()
    box.get_by_role("checkbox", name="List, view and render scans").uncheck()
    box.get_by_role("button", name="Create token").click()
    expect(box.get_by_text("Choose at least one permission.")).to_be_visible()
    assert faults(page) == []
    box.get_by_role("checkbox", name="List, view and render scans").check()
    box.get_by_label("Name").fill("Laptop in the lab")
    box.get_by_label("Valid for").select_option("7 days")
    box.get_by_label("Current password").fill("wrong")
    box.get_by_role("button", name="Create token").click()
    expect(box.get_by_text("The password is incorrect.")).to_be_visible()
    page.screenshot(full_page=True, path=pictures / f"token-form{'-phone' if look else ''}.png")
    box.get_by_label("Current password").fill(PASSWORD)
    box.get_by_role("button", name="Create token").click()

    token = box.get_by_label("New token").input_value()
    assert token.startswith("diaphane_") and faults(page) == []
    expect(box.get_by_text("never used")).to_be_visible()
    page.screenshot(full_page=True, path=pictures / f"token-new{'-phone' if look else ''}.png")
    box.get_by_role("button", name="I’ve saved it").click()
    expect(box.get_by_label("New token")).to_have_count(0)
    with Diaphane(stack.url, token) as program:
        assert [scan for scan in program.scans() if not scan.data["is_sample"]] == []
        with pytest.raises(ForbiddenError):
            program.api.call("createDataSet", body={"bytes": 10})
        page.reload()
        expect(box.get_by_text("last used")).to_be_visible()
        assert token not in page.content(), "it is shown once"
        page.screenshot(full_page=True, path=pictures / f"token-list{'-phone' if look else ''}.png")
        box.get_by_role("button", name="Revoke Laptop in the lab").click()
        expect(box.get_by_text("You have no API tokens.")).to_be_visible()
        with pytest.raises(AuthenticationError):
            next(program.scans())


def test_the_panel_is_in_german_on_a_german_page(stack: TestStack, visit, pictures: Path):
    page = visit(locale="de-DE")
    anna = Person(stack, page, f"anna-{secrets.token_hex(4)}@example.org")
    cookie = write_person(stack.psql, anna.email, password=PASSWORD).token
    page.context.add_cookies([{"name": "diaphane", "value": cookie, "url": stack.url, "httpOnly": True, "sameSite": "Strict"}])
    page.goto(stack.url + "/account")
    box = panel(page, "API-Tokens")
    box.get_by_role("button", name="Token erstellen …").click()
    box.get_by_role("checkbox", name="Aufnahmen hochladen, bearbeiten und löschen").check()
    box.get_by_label("Name").fill("Laptop im Labor")
    box.get_by_label("Aktuelles Passwort").fill(PASSWORD)
    box.get_by_role("button", name="Token erstellen", exact=True).click()
    expect(box.get_by_label("Neues Token")).to_have_value(re.compile("^diaphane_[0-9a-f]{64}$"))
    expect(box.get_by_text("Aufnahmen auflisten, ansehen und rendern; Aufnahmen hochladen, bearbeiten und löschen")).to_be_visible()
    box.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "token-german.png", full_page=True)
