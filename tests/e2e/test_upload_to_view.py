"""From a folder of DICOM files to a moving picture, as a user does it."""

from __future__ import annotations

import subprocess
from pathlib import Path

from playwright.sync_api import expect

from canaries import canaries_below, canaries_in
from harness import TestStack, contents_below
from person import Person
from picture import FINE_ERROR, difference, drag, facts, kept_view, last_input, listen, pixels, spread, wait_for_picture, wait_for_samples, wait_said


def test_a_user_uploads_views_and_reopens_a_scan(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit()
    person = Person.signs_up_and_in(stack, page, "anna")
    expect(page.get_by_text("No scans yet")).to_be_visible()

    person.choose_folder(cranium)
    expect(page.get_by_text("1 image series can be shown")).to_be_visible()
    expect(page.get_by_text("Mustermann Canary7f3a")).to_be_visible()  # visible to the user on this page
    expect(page.get_by_text("108 slices")).to_be_visible()
    page.screenshot(path=pictures / "series.png")

    person.uploads_scan(cranium, "My head")
    person.open_scan("My head")

    # The picture appears, is not empty, and its error falls.
    early = wait_for_samples(stack, page, 2)
    rested = wait_for_picture(stack, page, error=FINE_ERROR)
    first = pixels(page)
    assert spread(first) > 5
    later = wait_for_picture(stack, page, error=0.9 * rested.error)
    # On a slow machine, the first picture is small. Growing to the canvas starts an epoch once.
    assert early.epoch <= rested.epoch <= early.epoch + 1
    assert later.epoch == rested.epoch
    assert later.error < rested.error
    assert rested.error < early.error or early.error == float("inf") or early.epoch < rested.epoch
    page.screenshot(path=pictures / "viewer.png")

    # Noise: the same scene from the start (changing the size back and forth starts a new epoch).
    noise = difference(first, pixels(page))

    # A drag changes it by more than its noise.
    before = facts(page)
    drag(page, 220, 60)
    turned = wait_for_picture(stack, page, input_seq=last_input(page))
    second = pixels(page)
    assert turned.epoch > before.epoch
    assert difference(first, second) > 5 * max(noise, 0.2)
    page.screenshot(path=pictures / "turned.png")

    # A reload restores the view: the same session continues.
    session = kept_view(page)["session_id"]
    last = last_input(page)
    page.reload()
    again = wait_for_picture(stack, page, input_seq=last)
    assert again.input_seq >= last, "on a busy machine, the end of the drag is sent after `last` was read"
    assert difference(second, pixels(page)) < 0.4 * difference(first, second)
    assert session == kept_view(page)["session_id"]


def test_another_user_cannot_see_the_scan(stack: TestStack, visit, cranium: Path):
    anna = Person.arrives(stack, visit(), "anna")
    scan = anna.has_scan(cranium, "Private head")
    anna.open_scan("Private head")
    session = anna.page.evaluate("fetch('/v1/sessions').then((r) => r.json()).then((s) => s.items[0].session_id)")

    bert = Person.arrives(stack, visit(), "bert")
    expect(bert.page.get_by_text("No scans yet")).to_be_visible()
    expect(bert.card("Private head")).to_have_count(0)
    bert.page.goto(f"{stack.url}/view/{scan}")
    expect(bert.page.get_by_role("status").get_by_text("This scan doesn’t exist, or you don’t have access to it.")).to_be_visible()
    expect(bert.page.locator("canvas[data-samples]")).to_have_count(0)
    for method, path, body in [
        ("GET", f"/v1/data-sets/{scan}", None),
        ("DELETE", f"/v1/data-sets/{scan}", None),
        ("GET", f"/v1/data-sets/{scan}/thumbnails/skin", None),
        ("POST", "/v1/sessions", {"data_set_id": scan}),
        ("GET", f"/v1/sessions/{session}", None),
        ("DELETE", f"/v1/sessions/{session}", None),
        ("POST", f"/v1/sessions/{session}/tickets", None),
    ]:
        assert bert.api(method, path, body) == 404, (method, path)
    assert anna.api("GET", f"/v1/data-sets/{scan}") == 200

    nobody = visit()
    nobody.goto(f"{stack.url}/view/{scan}")
    expect(nobody.get_by_role("heading", name="Sign in")).to_be_visible()


def test_patient_names_are_never_sent_or_stored(stack_factory, visit, cranium: Path):
    stack = stack_factory()
    person = Person.signs_up_and_in(stack, visit(), "anna")

    # The search works: the folder itself is full of canaries.
    assert len(canaries_in((sorted(cranium.iterdir())[0]).read_bytes())) > 0

    stack.stop("ingestd")  # so that the upload can be inspected before it is built and deleted
    person.upload(cranium, "Nameless head")
    expect(person.card("Nameless head")).to_have_attribute("data-state", "queued")
    uploaded = [path for path in (stack.data_dir / "uploads").iterdir() if path.stat().st_size > 10_000_000]
    assert len(uploaded) == 1
    assert canaries_in(uploaded[0].read_bytes()) == []

    stack.start("ingestd")
    expect(person.card("Nameless head")).to_have_attribute("data-state", "ready")
    person.open_scan("Nameless head")
    wait_for_samples(stack, person.page, 4)

    stack.redis.save()
    assert canaries_below(stack.data_dir) == []
    dump = subprocess.run(["pg_dump", "--inserts", stack.dsn], capture_output=True, check=True).stdout
    assert b"Nameless head" in dump  # the dump is real, because it contains what the user typed
    assert canaries_in(dump) == []
    uploads = stack.data_dir / "uploads"
    stack.wait_until(lambda: all(len(content) <= 1000 for _, content in contents_below(uploads)), what="the removal of the original")


def test_a_lost_renderer_is_reported_and_the_picture_returns(stack_factory, visit, cranium: Path):
    stack = stack_factory()
    person = Person.arrives(stack, visit(), "anna")
    person.has_scan(cranium, "Head")
    person.open_scan("Head")
    page = person.page
    wait_for_picture(stack, page)
    first = pixels(page)
    drag(page, -260, 40)
    turned = wait_for_picture(stack, page, input_seq=last_input(page))
    before = pixels(page)

    # It may be said for 120 ms only: while no worker is there, the next request for a ticket gives another reason.
    listen(page, ".viewer-status")
    stack.kill("renderd")
    wait_said(stack, page, "Reconnecting")
    expect(page.locator(".viewer-status")).to_have_attribute("data-phase", "live")
    again = wait_for_picture(stack, page, input_seq=turned.input_seq)
    assert again.input_seq >= turned.input_seq
    # The same view, apart from noise, and not the one that the session began with.
    stack.wait_until(lambda: difference(before, pixels(page)) < 0.2 * difference(first, before), what="the view before")
    expect(page.get_by_role("status").get_by_text("Reconnecting")).to_have_count(0)
