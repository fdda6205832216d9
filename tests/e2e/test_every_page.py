"""Every page of the router, whoever made it: what an accessibility checker finds, and that nothing has to be scrolled sideways."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page

from harness import REPO, TestStack
from house import page_walk
from person import Person

AXE = REPO / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
RULES = "['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice']"


def faults(page: Page) -> list[str]:
    """WCAG 2.2 AA and good practice as far as axe can see it; and a page that is wider than its window."""
    page.evaluate(AXE.read_text(encoding="utf-8"))
    # Texts on glass above the picture have no ground that axe could know: those it calls undecided, and they are no violations.
    result = page.evaluate(f"axe.run(document, {{ runOnly: {RULES}, resultTypes: ['violations'] }})")
    found = [f"{v['id']}: {n['html'][:160]}" for v in result["violations"] for n in v["nodes"]]
    if page.evaluate("document.documentElement.scrollWidth > innerWidth"):
        found.append("wider than its window")
    if page.locator("h1").count() != 1:
        found.append(f"{page.locator('h1').count()} headings of the first rank")
    return found


@pytest.fixture(scope="module")
def shown(stack: TestStack, browser, cranium: Path):
    """Cookies of an administrator with one scan, and its id: all pages can be seen by that person."""
    context = browser.new_context(viewport={"width": 960, "height": 640})
    person = Person.arrives(stack, context.new_page(), "walker")
    data_set = person.has_scan(cranium, "Walked")
    person.becomes_administrator()
    yield context.cookies(), data_set
    context.close()


# Each look and each kind of window once, not all of them with all.
LOOKS = [pytest.param({"viewport": {"width": 1440, "height": 900}, "color_scheme": "light"}, id="desk-light"),
         pytest.param({"viewport": {"width": 390, "height": 844}, "color_scheme": "dark", "is_mobile": True, "has_touch": True}, id="phone-dark")]


@pytest.mark.parametrize("look", LOOKS)
def test_no_page_has_a_fault_that_a_checker_finds(stack: TestStack, browser, shown, look: dict):
    cookies, data_set = shown
    found: dict[str, list[str]] = {}
    for who in (page_walk.NOBODY, page_walk.PERSON):
        context = browser.new_context(**look)
        if who == page_walk.PERSON:
            context.add_cookies(cookies)
        page = context.new_page()
        for place in page_walk.places(data_set):
            if place.who == who:
                page_walk.go(page, stack.url, place, data_set)
                if wrong := faults(page):
                    found[place.name] = wrong
        context.close()
    assert found == {}


def test_every_page_fits_at_200_percent_and_moves_nothing_for_who_wants_it_still(stack: TestStack, browser, shown):
    cookies, data_set = shown
    context = browser.new_context(viewport={"width": 720, "height": 450}, reduced_motion="reduce")  # a desk at 200 %
    context.add_cookies(cookies)
    page = context.new_page()
    found = {}
    for place in page_walk.places(data_set):
        if place.who == page_walk.PERSON:
            page_walk.go(page, stack.url, place, data_set)
            moving = page.evaluate("document.getAnimations().filter((a) => a.effect.getComputedTiming().endTime > 50).length")
            if moving or page.evaluate("document.documentElement.scrollWidth > innerWidth"):
                found[place.name] = f"{moving} move, {page.evaluate('document.documentElement.scrollWidth')} px wide"
    context.close()
    assert found == {}


def test_the_walk_knows_every_word_of_the_router():
    words = page_walk.first_words()
    assert {"", "scans", "add", "sign-in", "view", "join"} <= set(words) and len(words) == len(set(words))
