"""The bytes that a visitor's browser loads, and the time that it takes: the page from the edge in Chromium without a cache."""

from __future__ import annotations

from .. import chromium
from ..bench import Result, result
from ..bench_client import Person
from ..bench_stack import running

ABOUT = "size of the page and time until it is usable, over loopback (targets: 300 kB, 1 s)"
PAGE = True

MOST_KB, MOST_MS = 300.0, 1000.0
#: Returns times in ms from the start of the navigation, and the transferred bytes.
TIMES = """() => {
    const [page] = performance.getEntriesByType("navigation");
    const shown = performance.getEntriesByName("first-contentful-paint")[0];
    const sent = performance.getEntriesByType("resource").filter((r) => !r.name.includes("/v1/") && !r.name.startsWith("blob:"));
    return { bytes: page.transferSize + sent.reduce((sum, r) => sum + r.transferSize, 0), loaded: page.loadEventEnd, shown: shown?.startTime ?? 0 };
}"""


def measure(quick: bool) -> list[Result]:
    from playwright.sync_api import sync_playwright

    kilobytes: dict[str, list[float]] = {"en": [], "de": []}
    loaded: list[float] = []
    shown: list[float] = []
    with running() as stack, sync_playwright() as playwright:
        Person(stack)  # ensures that all programs respond
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        for n in range(4 if quick else 20):
            language = ("en", "de")[n % 2]
            context = browser.new_context(viewport={"width": 1280, "height": 720}, locale=language)
            page = context.new_page()
            page.goto(stack.settings.url + "/sign-in")
            page.wait_for_selector("h1")
            page.wait_for_function("performance.getEntriesByName('first-contentful-paint').length > 0")
            seen = page.evaluate(TIMES)
            kilobytes[language].append(seen["bytes"] / 1000)
            loaded.append(seen["loaded"])
            shown.append(seen["shown"])
            context.close()
        browser.close()
    return [*(result(f"page and viewer, {language}", runs, "kB", at_most=MOST_KB) for language, runs in kilobytes.items()),
            result("time to the load event", loaded, "ms"),
            result("time to first contentful paint", shown, "ms", at_most=MOST_MS)]
