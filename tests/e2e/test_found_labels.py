"""The bone that the server finds in a CT: it is listed, named when it is pressed, and shown alone, in two languages."""

from __future__ import annotations

import re
import secrets
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from person import PASSWORD, Person
from picture import last_input, wait_for_samples
from seeds import give_scan, write_person

BONE = 0xFFFFFF05       # kFoundParts in volume/labels.h


def opened(stack: TestStack, page: Page, cranium: Path, menu: str, window: str) -> Page:
    """Returns the page of a CT, with this window of its menu."""
    person = Person(stack, page, f"skully-{secrets.token_hex(4)}@example.org")
    token = write_person(stack.psql, person.email, password=PASSWORD).token
    page.context.add_cookies([{"name": "diaphane", "value": token, "url": stack.url, "httpOnly": True, "sameSite": "Strict"}])
    scan = give_scan(stack, person.email, cranium, "A skull")
    page.goto(f"{stack.url}/view/{scan}")
    expect(page.locator("canvas[data-samples]")).to_be_visible()
    page.get_by_role("navigation", name=menu).get_by_role("button", name=window).click()
    return page


def test_the_bone_of_a_ct_is_listed_named_and_shown_alone(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = opened(stack, visit(), cranium, "Picture settings", "Labels")
    row = page.locator(".label-list li")
    expect(row).to_have_count(1)
    expect(row).to_have_attribute("data-label", str(BONE))
    expect(row).to_contain_text(re.compile(r"Bone.*\d{3} ml"))
    expect(page.get_by_test_id("labels-found")).to_have_text("The server found these structures automatically. They can be wrong.")
    page.get_by_role("button", name="Show only Bone").click()
    expect(page.get_by_role("button", name="Show only Bone")).to_have_attribute("aria-pressed", "true")
    expect(page.locator("[data-preset=bone]"), "the look that shows bone best").to_have_attribute("aria-pressed", "true")
    page.get_by_label("Show the structures in colour").check()
    page.get_by_role("button", name="What is this?").click()
    box = page.locator(".picker").bounding_box()
    # The skull is beside the window, once the picture has moved there.
    wait_for_samples(stack, page, 1, input_seq=last_input(page))
    page.locator(".picker").click(position={"x": box["width"] * 0.74, "y": box["height"] * 0.35})
    expect(page.get_by_role("status").filter(has_text="Bone")).to_be_visible()
    page.screenshot(path=pictures / "found-bone-named.png")
    page.get_by_role("button", name="Done").click()
    page.get_by_role("navigation", name="Picture settings").get_by_role("button", name="Labels").click()
    page.get_by_role("button", name="Show the slices").click()
    expect(page.get_by_role("checkbox", name="Labels"), "nobody has marked anything").not_to_be_checked()


def test_the_list_of_found_structures_is_german_too(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = opened(stack, visit(locale="de-DE"), cranium, "Bildeinstellungen", "Strukturen")
    expect(page.locator(".label-list li")).to_contain_text("Knochen")
    expect(page.get_by_test_id("labels-found")).to_have_text("Der Server hat diese Strukturen automatisch erkannt. Sie können falsch sein.")
    page.screenshot(path=pictures / "found-bone-de.png")
