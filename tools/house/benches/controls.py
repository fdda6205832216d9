"""How soon the page answers a hand on its controls, whatever the server does: while it renders, and while it stands still."""

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
from ..says import say

ABOUT = "milliseconds from an input on a control until the page shows its new value, with the renderer at work and stopped (16 ms at most)"
PAGE = True

MOST_MS = 16.0
WINDOWS = ("Materials", "Light", "Lens and quality", "Cuts and slices")
#: Each slider of the open window moved, and moved again: from the event until its own value is another in the page. The next
#: comes a picture of the screen later, so that none waits for the one before.
MOVES = """async (rounds) => {
    const next = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
    const times = [];
    for (let round = 0; round < rounds; round++)
        for (const slider of document.querySelectorAll(".window input[type=range]:enabled")) {
            const before = slider.getAttribute("aria-valuetext");
            const answer = new Promise((resolve) => {
                const seen = new MutationObserver(() => { seen.disconnect(); resolve(performance.now()); });
                seen.observe(slider, { attributes: true, attributeFilter: ["aria-valuetext"] });
                setTimeout(() => { seen.disconnect(); resolve(null); }, 1000);
            });
            const low = Number(slider.min), range = Number(slider.max) - low;
            const share = slider.valueAsNumber > low + range / 2 ? 0.3 + round / 1000 : 0.7 - round / 1000;
            slider.valueAsNumber = low + share * range;
            const begun = performance.now();
            slider.dispatchEvent(new Event("input", { bubbles: true }));
            const shown = await answer;
            const same = slider.getAttribute("aria-valuetext") === before;
            if (shown !== null || same) times.push([slider.ariaLabel, shown === null ? 1000 : shown - begun]);
            await next();
        }
    return times;
}"""


def measure(quick: bool) -> list[Result]:
    from playwright.sync_api import sync_playwright

    rounds = 3 if quick else 10
    times: dict[str, list[float]] = {"rendering": [], "stopped": []}
    silent: Counter[str] = Counter()
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
                    page.evaluate(MOVES, 1)
                    moved = page.evaluate(MOVES, rounds)
                    times[state] += [ms for _, ms in moved]
                    silent.update(label for label, ms in moved if ms == 1000)
                finally:
                    os.kill(renderer, signal.SIGCONT)
                page.close()
        browser.close()
    if silent:
        say("Said the same value after a move: " + ", ".join(f"{label} ({count} times)" for label, count in silent.items()))
    return [one for state, found in times.items() for one in (
        result(f"a slider, the renderer {state}", found, "ms", at_most=MOST_MS),
        result(f"of those the slowest twentieth, the renderer {state}", [percentile(found, 95)], "ms", at_most=MOST_MS))]
