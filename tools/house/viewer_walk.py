"""Through the viewer, step by step, as docs/guide.md leads: each step is what a hand does before a picture of the page is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Iterator, Sequence

#: So good that the grain is not what one looks at: the picture's own number of samples.
SAMPLES = 24


@dataclass(frozen=True)
class Step:
    """`deed` is done on a viewer that was just opened, with nothing kept of the step before."""

    name: str
    deed: Callable


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


STEPS = (
    Step("start", lambda page: None),
    Step("muscle", _look("muscle")),
    Step("bone", _look("bone")),
    Step("materials", _press("Materials")),
    Step("light", _bone_and("Light")),
    Step("lens", _press("Lens and quality")),
    Step("cut", _cut_in_half),
    Step("slices", lambda page: page.keyboard.press("v")),
    Step("take", lambda page: page.keyboard.press("s")),
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
        page.evaluate("sessionStorage.clear()")
        page.goto("about:blank")    # the page keeps what it shows when it is left
        page.goto(address)
        page.wait_for_selector("canvas[data-samples]")
        hints = page.get_by_role("button", name="Hide the hints", exact=True)
        if step is not STEPS[0] and hints.count():
            hints.click()
        step.deed(page)
        settle(page, samples)
        yield step.name


def settle(page, samples: int) -> None:
    """The picture is as good as is asked for, and what is beside it has come; what does not come is waited for no longer than that."""
    page.wait_for_timeout(400)
    for _ in range(120):
        if int(page.locator("canvas[data-samples]").first.get_attribute("data-samples") or 0) >= samples:
            break
        page.wait_for_timeout(250)
