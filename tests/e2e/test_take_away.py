"""What a person takes away: a picture as a file, and a link to what is seen."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from picture import difference, drag, facts, pixels, wait_for_samples

#: Mean difference of a channel, of 255, between two renderings of one view: 2 % and 5 % of noise, averaged over SIDE x SIDE boxes.
ALIKE = 2.0


def test_a_link_shows_the_same_to_whoever_may_see_it_and_to_nobody_else(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    person = Person.arrives(stack, page, "linus")
    scan = person.has_scan(cranium, "Erika Mustermann")
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 8)
    usual = pixels(page)
    page.get_by_role("button", name="Bone", exact=True).click()
    drag(page, 90, 20)
    stack.wait_until(lambda: page.wait_for_timeout(50) or facts(page).input_seq > 1, what="another view")
    wait_for_samples(stack, page, 16, input_seq=facts(page).input_seq)
    page.wait_for_timeout(300)
    page.keyboard.press("s")
    field = page.get_by_label("The link")
    expect(field).to_have_value(re.compile(r"#view="))
    link = field.input_value()
    assert link.startswith(f"{stack.url}/view/{scan}#view=1.") and len(link) < 2048
    page.keyboard.press("Escape")
    wait_for_samples(stack, page, 16, input_seq=facts(page).input_seq)
    shown = pixels(page)
    assert difference(usual, shown) > 2 * ALIKE

    def opened(address: str) -> Page:
        other = page.context.new_page()
        other.set_viewport_size({"width": 480, "height": 320})
        other.goto(address)
        return other

    again = opened(link)
    stack.wait_until(lambda: again.wait_for_timeout(50) or again.evaluate("location.hash") == "", what="the link taken")
    wait_for_samples(stack, again, 16, input_seq=1)
    assert difference(pixels(again), shown) < ALIKE
    again.screenshot(path=pictures / "linked.png")
    again.close()

    # Junk, and a link of a later version: said, and the scan as usual.
    for address, words in ((link[:-40], "damaged or was cut off"), (link.replace("#view=1.", "#view=2."), "newer Diaphane")):
        odd = opened(address)
        expect(odd.get_by_text(words)).to_be_visible()
        wait_for_samples(stack, odd, 16)
        assert difference(pixels(odd), usual) < ALIKE
        odd.screenshot(path=pictures / "link-refused.png")
        odd.close()

    # To somebody else the link opens nothing.
    stranger = visit(small=True)
    Person.arrives(stack, stranger, "fremd")
    stranger.goto(link)
    expect(stranger.get_by_text("There is no such scan, or it belongs to somebody else.")).to_be_visible()
