"""Every page of the router: the findings of an accessibility checker, and no horizontal scrolling."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page

from harness import REPO, TestStack
from devtool import page_crawler
from person import PATIENCE_MS, Person

AXE = REPO / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
RULES = "['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']"


def faults(page: Page) -> list[str]:
    """Returns violations of WCAG 2.2 AA and good practice that axe can detect, and whether the page is wider than its window."""
    page.evaluate(AXE.read_text(encoding="utf-8"))
    # axe cannot determine the background of texts on glass above the picture. It reports them as undecided, not as violations.
    result = page.evaluate(f"axe.run(document, {{ runOnly: {RULES}, resultTypes: ['violations'] }})")
    found = [f"{v['id']}: {n['html'][:160]}" for v in result["violations"] for n in v["nodes"]]
    if page.evaluate("document.documentElement.scrollWidth > innerWidth"):
        found.append("wider than its window")
    if page.locator("h1").count() != 1:
        found.append(f"{page.locator('h1').count()} headings of the first rank")
    return found


@pytest.fixture(scope="module")
def shown(stack: TestStack, browser, cranium: Path):
    """Cookies of an administrator with one scan, and its id. This user can open all pages."""
    context = browser.new_context(viewport={"width": 960, "height": 640})
    context.set_default_timeout(PATIENCE_MS)
    person = Person.arrives(stack, context.new_page(), "walker.with-an-address-that-is-as-long-as-some")
    data_set = person.has_scan(cranium, "A scan whose name is as long as a name may be, so that one sees where it goes")
    person.becomes_administrator()
    yield context.cookies(), data_set
    context.close()


# Each theme and each kind of window at least once, without all combinations.
LOOKS = [pytest.param({"viewport": {"width": 1440, "height": 900}, "color_scheme": "light"}, id="desk-light"),
         pytest.param({"viewport": {"width": 390, "height": 844}, "color_scheme": "dark", "is_mobile": True, "has_touch": True}, id="phone-dark",
                      marks=pytest.mark.nightly)]


@pytest.mark.parametrize("look", LOOKS)
def test_no_page_has_a_fault_that_a_checker_finds(stack: TestStack, browser, shown, look: dict):
    cookies, data_set = shown
    found: dict[str, list[str]] = {}
    for who in (page_crawler.NOBODY, page_crawler.PERSON):
        context = browser.new_context(**look)
        if who == page_crawler.PERSON:
            context.add_cookies(cookies)
        page = context.new_page()
        for place in page_crawler.places(data_set):
            if place.who == who:
                page_crawler.go(page, stack.url, place, data_set)
                if wrong := faults(page):
                    found[place.name] = wrong
        context.close()
    assert found == {}


ADMINISTRATOR = "administrator"
# A desktop at 200%, and at 400% as WCAG 1.4.10 requires.
WINDOWS = ((720, 450), (320, 256))


def too_wide(page: Page) -> list[str]:
    """Returns what extends beyond the sides of the window and thereby widens the page."""
    return page.evaluate("""() => document.documentElement.scrollWidth <= innerWidth ? [] :
        [`${document.documentElement.scrollWidth} px`, ...[...document.body.querySelectorAll("*")]
            .filter((e) => e.getBoundingClientRect().right > innerWidth + 1).slice(0, 3).map((e) => e.outerHTML.slice(0, 80))]""")


@pytest.mark.parametrize("who", [
    pytest.param(page_crawler.NOBODY, marks=pytest.mark.nightly), page_crawler.PERSON, pytest.param(ADMINISTRATOR, marks=pytest.mark.nightly)])
def test_every_page_fits_at_200_and_400_percent_and_respects_reduced_motion(stack: TestStack, browser, shown, who: str):
    cookies, data_set = shown
    context = browser.new_context(reduced_motion="reduce")
    context.set_default_timeout(PATIENCE_MS)
    stack.psql("UPDATE users SET is_administrator = %s WHERE id = (SELECT owner_id FROM data_sets WHERE id = %s)", who == ADMINISTRATOR, data_set)
    if who != page_crawler.NOBODY:
        context.add_cookies(cookies)
    page = context.new_page()
    found = {}
    for place in page_crawler.places(data_set):
        if (place.who == page_crawler.NOBODY) != (who == page_crawler.NOBODY):
            continue
        if who == page_crawler.PERSON and place.path.startswith("/admin"):
            continue  # this user has nothing here
        page_crawler.go(page, stack.url, place, data_set)
        for width, height in WINDOWS:
            page.set_viewport_size({"width": width, "height": height})
            if wrong := too_wide(page):
                found[f"{place.name}, {width} px"] = wrong
        if moving := page.evaluate("document.getAnimations().filter((a) => a.effect.getComputedTiming().endTime > 50).length"):
            found[f"{place.name} moves"] = moving
    context.close()
    stack.psql("UPDATE users SET is_administrator = true WHERE id = (SELECT owner_id FROM data_sets WHERE id = %s)", data_set)
    assert found == {}


def test_the_walk_knows_every_word_of_the_router():
    words = page_crawler.first_words()
    assert {"", "scans", "add", "sign-in", "view", "join"} <= set(words) and len(words) == len(set(words))
