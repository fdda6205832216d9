"""How quickly the page's controls respond, independent of the server, while it renders and while it is idle."""

from __future__ import annotations

import os
import signal
import tempfile
from collections import Counter
from pathlib import Path

from .. import chromium
from ..bench import Result, percentile, result
from ..bench_client import Person, cranium
from ..bench_stack import running
from ..console import say

ABOUT = "time from an input on a slider until the page shows its new value, with the renderer running and stopped (target: 16 ms)"
PAGE = True

MOST_MS = 16.0
WINDOWS = ("Materials", "Light", "Lens and quality", "Cuts and slices")
NO_ANSWER_MS = 1000
#: Moves each slider of the open panel by an event and waits until its value in the page has changed. Each move is undone
#: afterwards, so that no slider reaches a position that blocks it or another one: faces of the clip box and points of a curve
#: stop at each other.
MOVES = """async ([rounds, noAnswer]) => {
    const next = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
    const said = (slider) => slider.getAttribute("aria-valuetext");
    const undo = document.querySelector("button[aria-keyshortcuts='Control+Z']");
    const times = [];
    for (let round = 0; round < rounds; round++)
        for (const slider of document.querySelectorAll(".window input[type=range]:enabled")) {
            const before = said(slider);
            const answer = new Promise((resolve) => {
                const seen = new MutationObserver(() => { seen.disconnect(); resolve(performance.now()); });
                seen.observe(slider, { attributes: true, attributeFilter: ["aria-valuetext"] });
                setTimeout(() => { seen.disconnect(); resolve(null); }, noAnswer);
            });
            const low = Number(slider.min), range = Number(slider.max) - low;
            slider.valueAsNumber = low + range * (slider.valueAsNumber > low + range / 2 ? 0.3 + round / 1000 : 0.7 - round / 1000);
            const begun = performance.now();
            slider.dispatchEvent(new Event("input", { bubbles: true }));
            const shown = await answer;
            times.push([slider.ariaLabel, shown === null ? noAnswer : shown - begun]);
            slider.dispatchEvent(new Event("change", { bubbles: true }));
            await next();
            undo.click();
            for (let waited = 0; said(slider) !== before && waited < 60; waited++) await next();
            if (said(slider) !== before) throw new Error(`${slider.ariaLabel} was not undone`);
            await next();
        }
    return times;
}"""


def measure(quick: bool) -> list[Result]:
    from playwright.sync_api import sync_playwright

    rounds = 3 if quick else 10
    times: dict[str, list[tuple[str, float]]] = {"rendering": [], "stopped": []}
    with running() as stack, tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        person = Person(stack)
        data_set = person.upload(cranium(stack, Path(folder)))
        person.wait_ready(data_set)
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        context = browser.new_context(viewport={"width": 960, "height": 640})
        url = stack.settings.url
        context.add_cookies([{"name": c.name, "value": c.value, "url": url} for c in person.http.cookies.jar])
        for state in times:
            for window in WINDOWS:
                page = context.new_page()
                page.goto(f"{url}/view/{data_set}")
                page.wait_for_selector("canvas[data-samples]", timeout=120_000)
                page.get_by_role("button", name=window, exact=True).click()
                while page.locator(".window details:not([open]) > summary").count():
                    page.locator(".window details:not([open]) > summary").first.click()
                renderer = stack.pids["renderd"]
                if state == "stopped":
                    os.kill(renderer, signal.SIGSTOP)
                try:
                    page.evaluate(MOVES, [1, NO_ANSWER_MS])
                    times[state] += page.evaluate(MOVES, [rounds, NO_ANSWER_MS])
                finally:
                    os.kill(renderer, signal.SIGCONT)
                page.close()
        browser.close()
    return [one for state, found in times.items() for one in _results(state, found)]


def _results(state: str, found: list[tuple[str, float]]) -> list[Result]:
    """Returns the results. An input without a response counts as NO_ANSWER_MS."""
    took = [ms for _, ms in found]
    worst = sorted(found, key=lambda one: one[1], reverse=True)[:5]
    say(f"{len(found)} moves, renderer {state}; slowest: " + ", ".join(f"{label} {ms:.1f} ms" for label, ms in worst))
    silent = Counter(label for label, ms in found if ms == NO_ANSWER_MS)
    if silent:
        say("Said the same value after a move: " + ", ".join(f"{label} ({count} times)" for label, count in silent.items()))
    return [result(f"median, renderer {state}", took, "ms", at_most=MOST_MS),
            result(f"p95, renderer {state}", [percentile(took, 95)], "ms", at_most=MOST_MS),
            result(f"maximum, renderer {state}", [max(took)], "ms", at_most=MOST_MS)]
