"""Through the viewer, step by step, as docs/guide.md leads: each step is what a hand does before a picture of the page is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Iterator, Sequence

#: So good that the grain is not what one looks at: the picture's own number of samples.
SAMPLES = 24


@dataclass(frozen=True)
class Step:
    """`deed` is done on a viewer that was just opened, with nothing kept of the step before; `shown` (a selector) is there then."""

    name: str
    deed: Callable
    shown: str = "canvas[data-samples]"


def _press(*names: str) -> Callable:
    def deed(page) -> None:
        for name in names:
            page.get_by_role("button", name=name, exact=True).first.click()
    return deed


def _look(name: str) -> Callable:
    return lambda page: page.locator(f'[data-preset="{name}"]').click()


def _bone_and(*names: str) -> Callable:
    def deed(page) -> None:
        _look("bone")(page)
        _press(*names)(page)
    return deed


def _cut_in_half(page) -> None:
    """The front half gone: what is inside is seen."""
    _look("muscle")(page)
    _press("Cuts and slices")(page)
    front = page.get_by_role("dialog", name="Cuts and slices", exact=True).get_by_label("Front, typed")
    front.fill("0")
    front.press("Enter")


def _effort(page) -> None:
    """How much work a picture is worth, of one that is finished: the end of the window of the lens."""
    _press("Lens and quality")(page)
    lens = page.get_by_role("dialog", name="Lens and quality", exact=True)
    lens.get_by_text("More", exact=True).click()
    lens.get_by_label("A picture is finished").select_option("error")
    enough = lens.get_by_label("Error that is good enough, typed")
    enough.fill("3")
    enough.press("Enter")
    lens.get_by_role("button", name="Reset lens and quality").scroll_into_view_if_needed()


def _show_quality(page) -> None:
    shown = page.get_by_role("button", name="Show the quality")
    if shown.count():
        shown.click()


def _left_out(page) -> None:
    _show_quality(page)
    _press("What was left out to be faster")(page)


def _film(page) -> None:
    page.keyboard.press("s")
    page.get_by_role("dialog").get_by_label("What", exact=True).select_option("turntable")


STEPS = (
    Step("start", lambda page: None),
    Step("muscle", _look("muscle")),
    Step("bone", _look("bone")),
    Step("airways", _look("airways")),
    Step("materials", _press("Materials")),
    Step("light", _bone_and("Light")),
    Step("lens", _press("Lens and quality")),
    Step("effort", _effort, "canvas[data-lossless]"),
    Step("left-out", _left_out, "[data-fact=left-out]"),
    Step("cut", _cut_in_half),
    Step("slices", lambda page: page.keyboard.press("v")),
    Step("take", lambda page: page.keyboard.press("s")),
    Step("film", _film),
    Step("presets", _press("Saved presets")),
    Step("share", _press("Share the picture")),
    Step("help", _press("How to move it")),
)


def walk(page, address: str, samples: int = SAMPLES, only: Sequence[str] | None = None) -> Iterator[str]:
    """The name of each step, once it can be seen."""
    for step in STEPS:
        if only is not None and step.name not in only:
            continue
        page.goto(address)
        page.evaluate("sessionStorage.clear(), localStorage.clear()")
        page.goto("about:blank")    # the page keeps what it shows when it is left
        page.goto(address)
        page.wait_for_selector("canvas[data-samples]")
        hints = page.get_by_role("button", name="Hide the hints", exact=True)
        if step is not STEPS[0] and hints.count():
            hints.click()
        step.deed(page)
        settle(page, samples, step.shown)
        yield step.name


def settle(page, samples: int, shown: str) -> None:
    """The picture is as good as is asked for, and what is beside it has come: thumbnails are rendered once for each scan. What
    does not come (a picture behind a slice) is waited for no longer than that."""
    for quarter in range(480):
        page.wait_for_timeout(250)
        good = quarter > 120 or int(page.locator("canvas[data-samples]").first.get_attribute("data-samples") or 0) >= samples
        if good and page.locator(shown).count() and page.locator(".preset-picture:not(:has(img))").count() == 0:
            break
    page.wait_for_timeout(400)    # what glides in has come to rest
