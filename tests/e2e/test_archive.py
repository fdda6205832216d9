"""The hospital's archive on the page: a real Orthanc is searched, and a series is fetched until its card can be opened."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from archives import dimse_archive, open_stack, web_archive
from person import PATIENCE_MS, Person
from test_every_page import faults


@pytest.fixture(scope="module")
def connected(all_stacks, orthanc):
    stack = open_stack(all_stacks, [web_archive(orthanc), dimse_archive(orthanc), web_archive(orthanc, name="locked", title="Locked archive",
                                                                                             password_file="secrets/wrong-password")], only=None)
    yield stack
    all_stacks.shut(stack)


def panel(page: Page, name: str = "From the hospital’s archive"):
    return page.get_by_role("region", name=name)


def arrives_with_access(stack, page: Page) -> Person:
    person = Person.arrives(stack, page, "radiologist")
    stack.psql("UPDATE users SET archive_access = true WHERE email = %s", person.email)
    page.goto(stack.url + "/add")
    return person


def test_users_without_access_do_not_see_the_archive(connected, visit):
    page = visit()
    Person.arrives(connected, page, "anna")
    page.goto(connected.url + "/add")
    expect(page.get_by_text("Choose a folder")).to_be_visible()
    expect(panel(page)).to_have_count(0)


@pytest.mark.parametrize("look", [pytest.param({}, id="desk"), pytest.param({"phone": True, "dark": True}, id="phone-dark")])
def test_a_series_is_found_and_fetched_with_the_keyboard(connected, visit, pictures: Path, look: dict):
    page, kind = visit(**look), "-phone" if look else ""
    arrives_with_access(connected, page)
    box = panel(page)
    box.get_by_role("button", name="Search").click()
    expect(box.get_by_text("Enter a name, a patient ID, an accession number or a first day.")).to_be_visible()
    assert faults(page) == []
    name = box.get_by_label("Patient’s name")
    name.fill("Nobody")
    name.press("Enter")
    expect(box.get_by_role("heading", name="No examination found")).to_be_focused()
    name.fill("phantasia")
    name.press("Enter")
    expect(box.get_by_role("heading", name="1 examination found")).to_be_focused()
    expect(box.get_by_text("Phantasia Canary · Phantasia^Canary")).to_be_visible()
    page.screenshot(full_page=True, path=pictures / f"archive-found{kind}.png")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    fetch = box.get_by_role("button", name=re.compile("^Fetch "))
    expect(fetch).to_be_visible()
    title = box.get_by_label("Your name for this scan")
    expect(title).to_have_value("CT, Jan 1, 2020")     # without the series description, which names the patient
    page.evaluate("scrollTo(0, 0)")    # the bar covers a field, which axe would take for a small one
    assert faults(page) == []
    page.screenshot(full_page=True, path=pictures / f"archive-series{kind}.png")
    title.fill("Head")
    title.press("Enter")
    expect(box.get_by_text("The scan has been fetched.")).to_be_visible(timeout=PATIENCE_MS)
    assert faults(page) == []
    page.screenshot(full_page=True, path=pictures / f"archive-fetched{kind}.png")
    box.get_by_role("link", name="My scans").click()
    expect(page.get_by_role("link", name="Open Head")).to_be_visible(timeout=PATIENCE_MS)
    page.screenshot(full_page=True, path=pictures / f"archive-card{kind}.png")


def test_a_fetch_can_be_cancelled_and_started_again(connected, visit):
    page = visit()
    arrives_with_access(connected, page)
    box = panel(page)
    box.get_by_label("Archive", exact=True).select_option("Old archive")
    box.get_by_label("Patient’s name").fill("phantasia")
    box.get_by_role("button", name="Search").click()
    box.get_by_role("button", name="Show series").click()
    # A fetch that waits: its state is that of one whose archive has not answered yet.
    waiting = {"id": "00000000-0000-4000-8000-000000000001", "state": "fetching", "images": 3, "total": 40, "uploaded": 0,
               "data_set_id": None, "problem": None}
    cancelled = []

    def answer(route) -> None:
        if route.request.method == "DELETE":
            cancelled.append(route.request.url)
            return route.fulfill(status=204)
        return route.fulfill(status=202 if route.request.method == "POST" else 200, json={**waiting, "state": "cancelled" if cancelled else "fetching"})

    page.route("**/v1/archives/*/fetches**", answer)
    page.route("**/v1/archives/*/fetches/*", answer)
    box.get_by_role("button", name=re.compile("^Fetch ")).click()
    expect(box.get_by_text("3 of 40 images")).to_be_visible()
    box.get_by_role("button", name=re.compile("^Cancel fetching")).click()
    expect(box.get_by_role("button", name=re.compile("^Fetch "))).to_be_visible()
    assert len(cancelled) == 1


def test_an_archive_that_refuses_is_explained_in_both_languages(connected, visit, pictures: Path):
    page = visit()
    arrives_with_access(connected, page)
    box = panel(page)
    box.get_by_label("Archive", exact=True).select_option("Locked archive")
    box.get_by_label("Patient’s name").fill("phantasia")
    box.get_by_role("button", name="Search").click()
    expect(box.get_by_role("alert")).to_contain_text("The archive does not let Diaphane in.")
    page.get_by_label("Language").select_option("Deutsch")
    box = panel(page, "Aus dem Archiv des Krankenhauses")
    box.get_by_label("Archiv", exact=True).select_option("Locked archive")
    box.get_by_label("Name der untersuchten Person").fill("phantasia")
    box.get_by_role("button", name="Suchen").click()
    expect(box.get_by_role("alert")).to_contain_text("Das Archiv lässt Diaphane nicht zu.")
    assert faults(page) == []
    page.screenshot(full_page=True, path=pictures / "archive-refused-de.png")
