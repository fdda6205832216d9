"""The owner of a scan sees who viewed it, and guests are told before they view it."""

from __future__ import annotations

import secrets
from pathlib import Path

from playwright.sync_api import expect

from harness import TestStack
from person import Person

TOLD = "The owner can see when, how and roughly from where you view this scan."


def test_an_owner_sees_who_viewed_a_scan(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna = Person.arrives(stack, visit(), "anna")
    scan = anna.has_scan(cranium, "A head with a log")
    anna.shows_scans()
    open_log = anna.page.get_by_role("button", name="Who viewed A head with a log")
    dialog = anna.page.get_by_role("dialog", name="Who viewed this scan")
    open_log.click()
    expect(dialog.get_by_text("Nobody else has viewed this scan in the last 90 days.")).to_be_visible()
    anna.page.screenshot(path=pictures / "view-log-empty.png")
    dialog.get_by_role("button", name="Close").click()
    expect(open_log).to_be_focused()

    anna.open_scan("A head with a log")
    anna.page.get_by_role("button", name="Share this scan").click()
    share = anna.page.get_by_role("dialog", name="Share this scan")
    share.get_by_role("button", name="Create link").click()
    link = share.get_by_label("Your new link").input_value()
    guest = visit(small=True)
    guest.goto(link)
    expect(guest.get_by_text(TOLD)).to_be_visible()
    guest.screenshot(path=pictures / "view-log-told.png")
    guest.get_by_role("button", name="View the scan").click()
    expect(guest.locator("canvas[data-samples]")).to_be_visible()
    guest.goto(f"{stack.url}/join#{secrets.token_hex(32)}")
    expect(guest.get_by_text(TOLD)).to_be_visible()
    guest.screenshot(path=pictures / "view-log-join.png")

    share.get_by_role("button", name="Who viewed this scan").click()
    entries = dialog.get_by_role("listitem")
    expect(entries).to_have_count(1)
    expect(entries).to_contain_text("Someone with the link created on")
    expect(entries).to_contain_text("Chrome on Linux · same network as you now")
    dialog.get_by_role("checkbox", name="Show my own views too").check()
    expect(entries).to_have_count(2)
    expect(entries.nth(1)).to_contain_text("You")
    anna.page.screenshot(path=pictures / "view-log.png")
    dialog.get_by_role("button", name="Close").click()
    expect(share).to_be_visible()

    # As it looks with much in it, on a phone.
    stack.psql("""INSERT INTO views (id, data_set_id, route, viewer_hash, email_key, network, browser, first_at, last_at, times)
                  SELECT gen_random_uuid(), %s, route, route || n, CASE route WHEN 'person' THEN 'a.friend.with.a.long.name@mail.example.org' END,
                         '203.0.0.0/16', 'Safari on iOS', t - interval '20 minutes', t, n
                    FROM unnest(ARRAY['person', 'gallery', 'live-link', 'administrator', 'export']) AS route, generate_series(1, 13) AS n,
                         LATERAL (SELECT now() - n * interval '2 hours' AS t) AS times""", scan)
    anna.page.set_viewport_size({"width": 390, "height": 844})
    anna.shows_scans()
    open_log.click()
    expect(dialog.get_by_text("a.friend.with.a.long.name@mail.example.org").first).to_be_visible()
    expect(dialog.get_by_text("network 203.0…").first).to_be_visible()
    anna.page.screenshot(path=pictures / "view-log-phone.png")
    dialog.get_by_role("button", name="Show more").click()
    expect(entries).to_have_count(53)
