"""Multi-touch on a page with the browser's own touch events, because Playwright's touchscreen has one finger and only taps."""

from __future__ import annotations

from playwright.sync_api import Page

Place = tuple[float, float]


class Fingers:
    def __init__(self, page: Page):
        self.page, self.session = page, page.context.new_cdp_session(page)

    def say(self, kind: str, places: list[Place]) -> None:
        points = [{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(places)]
        self.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def drag(self, ways: list[tuple[Place, Place]], steps: int = 6) -> None:
        """Moves all fingers at the same time along their ways, and lifts them while they still move."""
        self.say("touchStart", [begin for begin, _ in ways])
        for step in range(1, steps + 1):
            part = step / steps
            self.say("touchMove", [(x + part * (to_x - x), y + part * (to_y - y)) for (x, y), (to_x, to_y) in ways])
        self.say("touchEnd", [])
