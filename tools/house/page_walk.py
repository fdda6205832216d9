"""Goes to every page of the router (frontend/src/views/routes.ts), so that pictures are made of all of them and the checker of
accessibility sees all of them: a page that is added there is walked to by itself."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Iterator

from . import paths
from .says import HouseError

ROUTES = paths.FRONTEND / "src" / "views" / "routes.ts"
SECRET = "0123456789abcdef" * 4
#: Pages below a page, where one word is not enough.
PARTS = {"admin": ("users", "audit", "fleet")}
NOBODY, PERSON = "nobody", "person"


@dataclass(frozen=True)
class Place:
    """An address, and who looks at it."""

    name: str
    path: str
    who: str


def first_words() -> list[str]:
    """Of the router's table, in its order."""
    table = re.search(r"^const pages\b.*?\{\n(.*?)^\};", ROUTES.read_text(encoding="utf-8"), re.M | re.S)
    if not table:
        raise HouseError(f"{ROUTES}: the table of pages was not found")
    return [quoted if quoted is not None else plain
            for quoted, plain in ((m[1], m[2]) for m in re.finditer(r'^  (?:"([a-z-]*)"|([a-z_]+)):', table[1], re.M))]


def places(data_set: str) -> Iterator[Place]:
    """Every page as somebody who is not signed in sees it, then as somebody who is. Which form of address a page has is
    tried out by `go`."""
    for who in (NOBODY, PERSON):
        for word in first_words():
            if word == "":
                continue        # the same page as /scans
            yield Place(f"{who}-{word}", f"/{word}", who)
            for part in PARTS.get(word, ()):
                yield Place(f"{who}-{word}-{part}", f"/{word}/{part}", who)
        yield Place(f"{who}-nothing-here", "/nothing-here", who)


def go(page, url: str, place: Place, data_set: str) -> None:
    """Waits until the page is there; HouseError where no form of its address leads to one."""
    forms = [place.path, f"{place.path}/{data_set}", f"{place.path}#{SECRET}", f"{place.path}#token={SECRET}"]
    for form in forms:
        page.goto("about:blank")    # a change behind the # alone would load nothing
        page.goto(url + form)
        settle(page)
        if place.path == "/nothing-here" or page.get_by_role("heading", name="Nothing here").count() == 0:
            return
    raise HouseError(f"no address was found for /{place.path}: say in tools/house/page_walk.py what it needs")


def settle(page, milliseconds: int = 15_000) -> None:
    """A heading is there, nothing says that it is loading, a viewer has its picture and what lies on it; what never ends (a
    viewer without a renderer) is waited for no longer."""
    page.wait_for_selector("h1", timeout=milliseconds, state="attached")
    for _ in range(20):
        if page.get_by_text("Loading…", exact=True).count() == 0:
            break
        page.wait_for_timeout(250)
    for _ in range(20):
        if page.locator(".stage canvas:not([data-samples])").count() == 0:
            break
        page.wait_for_timeout(250)
    page.wait_for_timeout(250)
