"""Visits every page of the router (frontend/src/views/routes.ts) for screenshots and accessibility checks. New pages of the
router are included automatically."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Iterator

from . import paths
from .console import CliError

ROUTES = paths.FRONTEND / "src" / "views" / "routes.ts"
SECRET = "0123456789abcdef" * 4
#: The second path segments of pages that have some.
PARTS = {"admin": ("users", "audit", "fleet")}
NOBODY, PERSON = "nobody", "person"


@dataclass(frozen=True)
class Place:
    """A page's address, and the kind of visitor."""

    name: str
    path: str
    who: str


def first_words() -> list[str]:
    """Returns the first path segments of the router's table, in order."""
    table = re.search(r"^const pages\b.*?\{\n(.*?)^\};", ROUTES.read_text(encoding="utf-8"), re.M | re.S)
    if not table:
        raise CliError(f"{ROUTES}: cannot find the table of pages")
    return [quoted if quoted is not None else plain
            for quoted, plain in ((m[1], m[2]) for m in re.finditer(r'^  (?:"([a-z-]*)"|([a-z_]+)):', table[1], re.M))]


def places(data_set: str) -> Iterator[Place]:
    """Yields every page as seen by a visitor, then as seen by a signed-in user. `go` tries which form of address a page has."""
    for who in (NOBODY, PERSON):
        for word in first_words():
            if word == "" and who == PERSON:
                continue        # the home page redirects signed-in users to /scans
            yield Place(f"{who}-{word or 'home'}", f"/{word}", who)
            for part in PARTS.get(word, ()):
                yield Place(f"{who}-{word}-{part}", f"/{word}/{part}", who)
        yield Place(f"{who}-nothing-here", "/nothing-here", who)


def go(page, url: str, place: Place, data_set: str) -> None:
    """Opens the page and waits for it. Raises CliError if none of the forms of its address leads to a page."""
    forms = [place.path, f"{place.path}/{data_set}", f"{place.path}/{data_set}/{data_set}", f"{place.path}#{SECRET}", f"{place.path}#token={SECRET}"]
    for form in forms:
        page.goto("about:blank")    # a change behind the # alone would load nothing
        page.goto(url + form)
        page.wait_for_selector("h1", state="attached")
        if place.path == "/nothing-here" or page.get_by_role("heading", name="Page not found").count() == 0:
            settle(page)
            return
    raise CliError(f"no address is known for /{place.path}: add it to tools/devtool/page_crawler.py")


def settle(page) -> None:
    """Waits until nothing is loading, and a viewer has its picture and overlays. Limited in time, because a viewer without a
    renderer never gets there."""
    for _ in range(100):
        if page.get_by_text("Loading…", exact=True).count() == 0 and page.locator(".stage canvas:not([data-samples])").count() == 0:
            break
        page.wait_for_timeout(100)
    page.wait_for_timeout(250)
