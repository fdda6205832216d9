"""Walks through the viewer as docs/guide.md describes it. Each step contains the user's actions before a screenshot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Iterator, Sequence

#: Samples per pixel, enough that noise does not distract.
SAMPLES = 24


@dataclass(frozen=True)
class Step:
    """A step of the tour. `deed` runs on a newly opened viewer without state from the previous
    step. Afterwards, `shown` (a selector) is visible."""

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
    """Cuts the front half away, so that the inside is visible."""
    _look("muscle")(page)
    _press("Cuts and slices")(page)
    front = page.get_by_role("dialog", name="Cuts and slices", exact=True).get_by_label("Front (value)")
    front.fill("0")
    front.press("Enter")


def _show_details(page) -> None:
    """Opens the figures of the quality panel."""
    shown = page.get_by_role("button", name="Show the quality")
    if shown.count():
        shown.click()
    page.get_by_text("Details", exact=True).click()


def _effort(page) -> None:
    """Shows the limits on the work for a finished picture, at the end of the lens panel."""
    _show_details(page)
    _press("Lens and quality")(page)
    lens = page.get_by_role("dialog", name="Lens and quality", exact=True)
    lens.get_by_text("More", exact=True).click()
    lens.get_by_label("Stop refining").select_option("error")
    enough = lens.get_by_label("Target noise level (value)")
    enough.fill("3")
    enough.press("Enter")
    lens.get_by_role("button", name="Reset lens and quality").scroll_into_view_if_needed()


def _left_out(page) -> None:
    _show_details(page)
    _press("Optimisations")(page)


def _video(page) -> None:
    page.keyboard.press("s")
    page.get_by_role("dialog").get_by_label("File type", exact=True).select_option("turntable")


def _labels(page) -> None:
    _bone_and("Labels")(page)
    page.get_by_label("Show the structures in colour").check()


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
    Step("video", _video),
    Step("presets", _press("Saved presets")),
    Step("share", _press("View together")),
    Step("help", _press("Controls")),
)
#: The steps with a scan that has labels.
LABELLED_STEPS = (Step("labels", _labels),)


def walk(page, address: str, samples: int = SAMPLES, only: Sequence[str] | None = None, steps: Sequence[Step] = STEPS) -> Iterator[str]:
    """Yields the name of each step once it is visible."""
    for step in steps:
        if only is not None and step.name not in only:
            continue
        page.goto(address)
        page.evaluate("sessionStorage.clear(), localStorage.clear()")
        page.goto("about:blank")    # leaving the page saves its state
        page.goto(address)
        page.wait_for_selector("canvas[data-samples]")
        hints = page.get_by_role("button", name="Hide the tips", exact=True)
        if step is not STEPS[0] and hints.count():
            hints.click()
        step.deed(page)
        settle(page, samples, step.shown)
        yield step.name


def settle(page, samples: int, shown: str) -> None:
    """Waits until the picture has the requested quality and the thumbnails, which are rendered once per scan, have loaded.
    Limited in time, because a picture behind a slice never appears."""
    for quarter in range(480):
        page.wait_for_timeout(250)
        good = quarter > 120 or int(page.locator("canvas[data-samples]").first.get_attribute("data-samples") or 0) >= samples
        if good and page.locator(shown).count() and page.locator(".preset-picture:not(:has(img))").count() == 0:
            break
    page.wait_for_timeout(400)    # wait for transitions to finish
