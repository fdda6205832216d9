"""One picture in two windows of the same user."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from person import PATIENCE_MS, Person
from picture import drag, kept_view, last_input, wait_for_samples


@pytest.mark.nightly
def test_a_duplicated_tab_takes_over_the_session(stack: TestStack, visit, cranium: Path):
    person = Person.arrives(stack, visit(), "anna")
    person.has_scan(cranium, "Head")
    person.open_scan("Head")
    first = person.page
    wait_for_samples(stack, first, 1)

    # Like "Duplicate" in a browser: the new window starts with the state of the old one. (window.open would do this, too, but in
    # a headless browser its window does not always receive mouse events.)
    assert kept_view(first)["session_id"]
    remembered = first.evaluate("JSON.stringify(sessionStorage)")
    second = first.context.new_page()
    second.set_default_timeout(PATIENCE_MS)
    second.add_init_script(f"if (sessionStorage.length === 0) Object.assign(sessionStorage, {remembered})")
    second.goto(first.url)
    wait_for_samples(stack, second, 1)
    assert kept_view(first)["session_id"] == kept_view(second)["session_id"]
    expect(first.get_by_role("status")).to_contain_text("This picture is now open in another window.")
    drag(second, 200, 0)
    wait_for_samples(stack, second, 2, input_seq=last_input(second))
    # it does not reclaim the session on its own
    expect(first.locator(".viewer-status")).to_have_attribute("data-phase", "elsewhere")

    first.get_by_role("button", name="Continue here").click()
    expect(first.locator(".viewer-status")).to_have_attribute("data-phase", "live")
    expect(first.get_by_role("button", name="Continue here")).to_have_count(0)
    expect(second.get_by_role("status")).to_contain_text("This picture is now open in another window.")
    drag(first, -100, 0)
    wait_for_samples(stack, first, 2, input_seq=last_input(first))
