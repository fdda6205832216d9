"""The monthly rendering time: the page warns before it ends and when it ends, and everything continues after an increase."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from picture import wait_for_samples

MINUTE_MS = 60_000


def leave(stack: TestStack, person: Person, left_ms: int) -> None:
    """Sets the quota to the used time plus `left_ms`. Usage that is recorded meanwhile leaves less, never more."""
    stack.psql("""UPDATE users u SET render_quota_ms = COALESCE((SELECT r.device_ms FROM render_time r WHERE r.user_id = u.id
                  ORDER BY month DESC LIMIT 1), 0) + %s WHERE email = %s""", left_ms, person.email)


def turn_until(stack: TestStack, page: Page, seen) -> None:
    """Rotates the picture until then, because a finished one uses no time."""

    def turned() -> bool:
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(200)
        return seen()

    stack.wait_until(turned, timeout=180, what="the end of the time")


def test_the_end_of_the_render_time_is_announced(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit()
    person = Person.arrives(stack, page, "patient")
    scan = person.has_scan(cranium, "Head")
    person.open_scan("Head")
    wait_for_samples(stack, page, 1)
    expect(page.get_by_text("of rendering time left this month")).to_have_count(0)

    # Warned some minutes before the end and again in the last minute. The warning can be closed.
    leave(stack, person, 4 * MINUTE_MS)
    page.reload()
    line = page.get_by_role("status").get_by_text("of rendering time left this month")
    expect(line).to_contain_text("Finished pictures use no rendering time.")
    page.screenshot(path=pictures / "time-minutes.png")
    page.get_by_role("button", name="Hide this message").click()
    expect(line).to_have_count(0)
    expect(page.locator("canvas")).to_be_focused()
    leave(stack, person, MINUTE_MS * 9 // 10)
    page.reload()
    expect(page.get_by_role("status").get_by_text("You have less than a minute of rendering time left this month.")).to_be_visible()
    wait_for_samples(stack, page, 1)

    # Everything is used, and the open picture has its grace period.
    leave(stack, person, 0)
    ending = page.get_by_role("status").get_by_text("You have used up your rendering time for this month. This picture stays open until")
    turn_until(stack, page, lambda: ending.count() > 0)
    page.screenshot(path=pictures / "time-ending.png")
    wait_for_samples(stack, page, 1)
    stack.psql("UPDATE render_time SET warned_at = warned_at - interval '3 minutes' WHERE user_id = (SELECT id FROM users WHERE email = %s)", person.email)
    # Without further input, it ends as well, with a message.
    over = page.get_by_role("heading", name="No rendering time left")
    expect(over).to_be_visible()
    expect(page.get_by_role("status").get_by_text("It resets on")).to_be_visible()
    expect(over).to_be_focused()
    page.screenshot(path=pictures / "time-over.png")

    # Opened again, it shows the same message, also on a phone. The scans are still there.
    phone = visit(phone=True)
    phone.context.add_cookies(page.context.cookies())
    phone.goto(f"{stack.url}/view/{scan}")
    expect(phone.get_by_role("heading", name="No rendering time left")).to_be_visible()
    phone.screenshot(path=pictures / "time-over-phone.png")
    phone.get_by_role("link", name="See your usage").click()
    expect(phone.get_by_text("You have used up your rendering time for this month.")).to_be_visible()
    phone.get_by_role("link", name="My scans").first.click()
    expect(phone.locator("article.card", has_text="Head")).to_have_attribute("data-state", "ready")

    # An administrator increases the quota.
    leave(stack, person, 600 * MINUTE_MS)
    page.reload()
    wait_for_samples(stack, page, 1)
    expect(over).to_have_count(0)
