"""Every page of the router: the findings of an accessibility checker, no horizontal scrolling at any zoom, and reduced motion."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page

from harness import REPO, TestStack
from devtool import page_crawler
from devtool.page_crawler import NOBODY, PERSON, Place
from person import PATIENCE_MS, Person

AXE = REPO / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
RULES = "['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']"
ADMINISTRATOR = "administrator"
#: Each page once: as a visitor where visitors have something to see, and otherwise as an administrator, who sees the most.
ONCE = "once"
#: Pages for visitors. Users who are signed in see the same.
PUBLIC = ("", "sign-in", "sign-up", "verify", "forgot", "reset", "confirm-email", "join", "shared", "study", "privacy", "terms", "contact")
# A desktop at 200%, and at 400% as WCAG 1.4.10 requires.
WINDOWS = ((720, 450), (320, 256))


def faults(page: Page) -> list[str]:
    """Returns violations of WCAG 2.2 AA and good practice that axe can detect, and whether the page is wider than its window."""
    page.evaluate(AXE.read_text(encoding="utf-8"))
    # axe cannot determine the background of texts on glass above the picture. It reports them as undecided, not as violations.
    result = page.evaluate(f"axe.run(document, {{ runOnly: {RULES}, resultTypes: ['violations'] }})")
    found = [f"{v['id']}: {n['html'][:160]}" for v in result["violations"] for n in v["nodes"]]
    if page.locator("h1").count() != 1:
        found.append(f"{page.locator('h1').count()} headings of the first rank")
    return found + too_wide(page)


def too_wide(page: Page) -> list[str]:
    """Returns what extends beyond the sides of the window and thereby widens the page."""
    return page.evaluate("""() => document.documentElement.scrollWidth <= innerWidth ? [] :
        [`${document.documentElement.scrollWidth} px in ${innerWidth} px`, ...[...document.body.querySelectorAll("*")]
            .filter((e) => e.getBoundingClientRect().right > innerWidth + 1).slice(0, 3).map((e) => e.outerHTML.slice(0, 80))]""")


def zoomed_faults(page: Page) -> list[str]:
    before, found = page.viewport_size, []
    for width, height in WINDOWS:
        page.set_viewport_size({"width": width, "height": height})
        found += too_wide(page)
    if moving := page.evaluate("document.getAnimations().filter((a) => a.effect.getComputedTiming().endTime > 50).length"):
        found.append(f"{moving} parts move")
    page.set_viewport_size(before)
    return found


def viewed_by(place: Place, who: str) -> bool:
    if who == ONCE:
        return place.who == (NOBODY if place.path[1:] in PUBLIC or place.path == "/nothing-here" else PERSON)
    if who == PERSON and place.path.startswith("/admin"):
        return False  # this user has nothing here
    return (place.who == NOBODY) == (who == NOBODY)


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
DESKTOP = {"viewport": {"width": 1440, "height": 900}, "color_scheme": "light"}
PHONE = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark", "is_mobile": True, "has_touch": True}


@pytest.mark.parametrize(("look", "who"), [
    pytest.param(DESKTOP, ONCE, id="desktop-once"),
    *(pytest.param(DESKTOP, who, id=f"desktop-{who}", marks=pytest.mark.nightly) for who in (NOBODY, PERSON, ADMINISTRATOR)),
    *(pytest.param(PHONE, who, id=f"phone-{who}", marks=pytest.mark.nightly) for who in (NOBODY, ADMINISTRATOR))])
def test_every_page_passes_the_accessibility_check(stack: TestStack, browser, shown, look: dict, who: str):
    cookies, data_set = shown
    stack.psql("UPDATE users SET is_administrator = %s WHERE id = (SELECT owner_id FROM data_sets WHERE id = %s)", who != PERSON, data_set)
    found: dict[str, list[str]] = {}
    for viewer in (NOBODY, PERSON):
        context = browser.new_context(reduced_motion="reduce", **look)
        context.set_default_timeout(PATIENCE_MS)
        if viewer == PERSON:
            context.add_cookies(cookies)
        page = context.new_page()
        for place in page_crawler.places(data_set):
            if place.who == viewer and viewed_by(place, who):
                page_crawler.go(page, stack.url, place, data_set)
                if wrong := faults(page) + (zoomed_faults(page) if look is DESKTOP else []):
                    found[place.name] = wrong
        context.close()
    stack.psql("UPDATE users SET is_administrator = true WHERE id = (SELECT owner_id FROM data_sets WHERE id = %s)", data_set)
    assert found == {}


def test_the_page_crawler_covers_every_route():
    words = page_crawler.first_words()
    assert {"", "scans", "add", "sign-in", "view", "join"} <= set(words) and len(words) == len(set(words))
    assert set(PUBLIC) < set(words)
