"""The input methods for controls: mouse, keyboard and touch. Each performs the same actions."""

from __future__ import annotations

from playwright.sync_api import Locator, Page

from touch import Fingers

SLIDER_STEPS = 1000


class Mouse:
    name = "mouse"

    def __init__(self, page: Page):
        self.page = page

    def press(self, button: Locator) -> None:
        button.click()

    def switch(self, box: Locator) -> None:
        box.click()

    def slide(self, slider: Locator) -> None:
        """Moves the slider to another position, a third or two thirds of its range."""
        slider.scroll_into_view_if_needed()
        slider.click(position=beside(slider))

    def choose(self, choice: Locator, value: str) -> None:
        choice.select_option(value)  # the system draws its list, which a headless browser does not show

    def drag(self, begin: tuple[float, float], right: float, down: float) -> None:
        x, y = begin
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move(x + right, y + down, steps=6)
        self.page.mouse.up()


class Finger(Mouse):
    name = "touch"

    def press(self, button: Locator) -> None:
        button.tap()

    switch = press

    def slide(self, slider: Locator) -> None:
        slider.scroll_into_view_if_needed()
        slider.tap(position=beside(slider))

    def drag(self, begin: tuple[float, float], right: float, down: float) -> None:
        """Lifting the finger while it moves is a flick, after which the next tap must still work."""
        x, y = begin
        Fingers(self.page).drag([(begin, (x + right, y + down))])


class Keys(Mouse):
    name = "keys"

    def press(self, button: Locator) -> None:
        button.focus()
        self.page.keyboard.press("Enter")

    def switch(self, box: Locator) -> None:
        box.focus()
        self.page.keyboard.press("Space")

    def slide(self, slider: Locator) -> None:
        slider.focus()
        self.page.keyboard.press("PageDown" if slider.evaluate("(e) => e.valueAsNumber") > SLIDER_STEPS / 2 else "PageUp")

    def choose(self, choice: Locator, value: str) -> None:
        places = choice.locator("option").evaluate_all("(options) => options.map((o) => o.value)")
        now = places.index(choice.input_value())
        choice.focus()
        for _ in range(abs(places.index(value) - now)):
            self.page.keyboard.press("ArrowDown" if places.index(value) > now else "ArrowUp")


def beside(slider: Locator) -> dict[str, float]:
    box = slider.bounding_box()
    part = 0.3 if slider.evaluate("(e) => e.valueAsNumber") > SLIDER_STEPS / 2 else 0.7
    return {"x": part * box["width"], "y": box["height"] / 2}


WAYS = {way.name: way for way in (Mouse, Keys, Finger)}
