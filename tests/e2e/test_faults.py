"""kill -9 of programs that the picture's renderer does not need, while a picture is shown (for the renderer's own:
test_upload_to_view.py)."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from playwright.sync_api import expect

from harness import StackFactory, TestStack
from person import Person
from picture import difference, drag, last_input, listen, pixels, wait_for_picture, wait_for_samples, wait_said

SAID = "We can’t reach Diaphane. Trying again…"
#: Without the gateway, the page gets tickets but no connection.
CUT = "Connection lost. Reconnecting…"


@pytest.fixture(scope="module")
def shaken(all_stacks: StackFactory):
    stack = all_stacks.open()
    yield stack
    all_stacks.shut(stack)


@pytest.mark.parametrize("program", ["api", pytest.param("gateway", marks=pytest.mark.nightly), pytest.param("redis", marks=pytest.mark.nightly), "postgres"])
def test_a_killed_program_is_reported_and_the_page_recovers(shaken: TestStack, visit, cranium: Path, program: str, request):
    stack = shaken
    person = Person.arrives(stack, visit(small=True), "anna")
    page = person.page
    scan = person.has_scan(cranium, "Head")
    person.open_scan("Head")
    wait_for_samples(stack, page, 2)

    said = CUT if program == "gateway" else SAID
    request.addfinalizer(lambda: stack.start(program))
    stack.kill(program, restart=False)
    if program == "gateway":
        expect(page.get_by_role("status").get_by_text(said)).to_be_visible()
    drag(page, -180, 40)  # without api, Redis or Postgres, the picture follows at once; without the gateway, after it is back
    last = last_input(page)
    if program != "gateway":
        wait_for_picture(stack, page, input_seq=last)
        expect(page.locator(".viewer-status")).to_have_attribute("data-phase", "live")
    late = page.context.new_page()
    late.goto(f"{stack.url}/view/{scan}")
    expect(late.get_by_text(said)).to_be_visible()

    stack.start(program)
    expect(late.locator(".viewer-status")).to_have_attribute("data-phase", "live")
    late.close()
    expect(page.locator(".viewer-status")).to_have_attribute("data-phase", "live")
    if program == "gateway":
        # What was dragged meanwhile is sent and numbered once the page has reconnected.
        last = stack.wait_until(lambda: last_input(page), what="the drag to be sent")
    turned = wait_for_picture(stack, page, input_seq=last)
    seen = pixels(page)
    page.reload()
    wait_for_picture(stack, page, input_seq=turned.input_seq)
    assert difference(seen, pixels(page)) < 3
    page.get_by_role("link", name="My scans").click()
    expect(person.card("Head")).to_have_attribute("data-state", "ready")


def test_a_renderer_that_hangs_is_reported_and_the_page_recovers(shaken: TestStack, visit, cranium: Path, pictures: Path):
    person = Person.arrives(shaken, visit(small=True), "hanna")
    page = person.page
    person.has_scan(cranium, "Head")
    person.open_scan("Head")
    wait_for_samples(shaken, page, 2)
    expect(page.get_by_text("isn’t answering")).to_have_count(0)
    listen(page, ".viewer-status")
    os.kill(shaken.pids["renderd"], signal.SIGSTOP)
    try:
        drag(page, -180, 0)
        shaken.wait_until(lambda: any("rendering server" in text for text in page.evaluate("window.said")) or page.wait_for_timeout(50), what="the reason")
        page.screenshot(path=pictures / "renderer-hangs.png")
    finally:
        os.kill(shaken.pids["renderd"], signal.SIGCONT)
    wait_for_picture(shaken, page, input_seq=last_input(page))
    expect(page.locator(".viewer-status")).to_have_attribute("data-phase", "live")
    expect(page.get_by_text("isn’t answering")).to_have_count(0)


def test_a_network_outage_is_reported_and_the_stream_recovers(stack: TestStack, visit, cranium: Path):
    person = Person.arrives(stack, visit(small=True), "anna")
    page = person.page
    person.has_scan(cranium, "Head")
    person.open_scan("Head")
    before = wait_for_samples(stack, page, 2)
    page.context.set_offline(True)
    expect(page.get_by_role("status").get_by_text("Until then, the picture stays as it is.")).to_be_visible()
    drag(page, -180, 0)
    page.context.set_offline(False)
    expect(page.locator(".viewer-status")).to_have_attribute("data-phase", "live")
    wait_for_samples(stack, page, 1, input_seq=before.input_seq + 1)
    expect(page.get_by_text("Connection lost")).to_have_count(0)


def test_the_list_of_scans_says_that_the_server_is_unavailable_and_recovers(shaken: TestStack, visit, cranium: Path, pictures: Path, request):
    person = Person.arrives(shaken, visit(small=True), "anna")
    page = person.page
    person.has_scan(cranium, "Head")
    said = page.get_by_text("The Diaphane server can’t be reached at the moment. Your scans are safe")
    expect(said).to_have_count(0)
    request.addfinalizer(lambda: shaken.start("api"))
    shaken.kill("api", restart=False)
    expect(said).to_be_visible()
    expect(person.card("Head")).to_be_visible()
    page.screenshot(path=pictures / "scans-server-away.png")
    shaken.start("api")
    expect(said).to_have_count(0)
    expect(person.card("Head")).to_have_attribute("data-state", "ready")
