"""A user permanently cuts the face away in the picture, and only then publishes the scan."""

from __future__ import annotations

import json
from pathlib import Path

from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from picture import placed, wait_for_picture, wait_for_samples


def value(page: Page, handle: str) -> float:
    return float(page.locator(f'[data-handle="{handle}"]').get_attribute("aria-valuenow"))


def open_cut(person: Person, title: str) -> str:
    """Opens the scan, tries to publish it, and follows the way to the cut. Returns the scan's id."""
    page = person.page
    person.open_scan(title)
    page.get_by_role("button", name="Share this scan").click()
    page.get_by_role("link", name="Cut and anonymise").click()
    expect(page.get_by_role("heading", name="Anonymise this scan")).to_be_visible()
    return page.url.rsplit("/", 1)[1]


def test_a_face_is_removed_permanently(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit()
    person = Person.arrives(stack, page, "cutter")
    person.has_scan(cranium, "A head")
    data_set = open_cut(person, "A head")

    # The page states its finding and proposes a cut that removes something.
    expect(page.get_by_text("This scan shows a head")).to_be_visible()
    plane = page.get_by_role("button", name="Use the suggested cut")
    expect(plane).to_be_visible()
    wait_for_samples(stack, page, 4)
    page.screenshot(path=pictures / "cut-proposed.png")
    expect(page.locator(".cut-goes")).to_contain_text("% of the scan will be deleted")

    # With the mouse, the handle and the number follow the hand. With the keyboard, each key press moves a millimetre.
    handle = page.locator('[data-handle="z-high"]')
    before = value(page, "z-high")
    box = placed(handle)
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 20, steps=4)
    page.mouse.up()
    dragged = value(page, "z-high")
    assert dragged < before - 2
    after = handle.bounding_box()
    assert abs(after["y"] + after["height"] / 2 - (y + 20)) < 4
    handle.press("ArrowUp")
    expect(handle).to_have_attribute("aria-valuenow", str(round(dragged) + 1))
    slider = page.get_by_role("slider", name="Back").last
    back = value(page, "y-high")
    slider.focus()
    slider.press("ArrowLeft")
    assert value(page, "y-high") < back
    page.screenshot(path=pictures / "cut-dragged.png")
    page.get_by_role("button", name="Use the suggested cut").click()

    # To prevent mistakes, the button is disabled until the user confirms.
    page.get_by_role("button", name="Cut permanently…").click()
    confirm = page.get_by_role("button", name="Cut permanently", exact=True)
    expect(page.get_by_role("heading", name="This can’t be undone")).to_be_visible()
    expect(confirm).to_be_disabled()
    page.get_by_label("I have looked at it from all sides").check()
    page.screenshot(path=pictures / "cut-confirm.png")
    confirm.click()
    expect(page.get_by_role("heading", name="The cut is finished")).to_be_visible()
    page.screenshot(path=pictures / "cut-done.png")

    header = json.loads((stack.data_dir / "volumes" / data_set / "volume.json").read_text())
    assert header["size"][1] <= 256 and header["size"][2] <= 108
    assert stack.psql("SELECT anonymised_at IS NOT NULL, is_nullified FROM (SELECT anonymised_at, cut_problem IS NULL AS is_nullified"
                      " FROM data_sets WHERE id = %s) d", data_set) == [(True, True)]
    page.get_by_role("link", name="View and share the scan").click()
    expect(page.locator("canvas[data-samples]")).to_be_visible()
    wait_for_picture(stack, page)
    page.screenshot(path=pictures / "cut-after.png")
    page.get_by_role("button", name="Share this scan").click()
    expect(page.get_by_role("button", name="Add to the gallery")).to_be_visible()


def test_the_cut_handles_work_by_touch(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(phone=True)
    person = Person.arrives(stack, page, "finger")
    data_set = person.has_scan(cranium, "A head")
    # While the server does not answer, the page says so. The panel comes as soon as it does.
    page.route("**/anonymise", lambda route: route.abort())
    page.goto(f"{stack.url}/cut/{data_set}")
    expect(page.locator(".cut-panel").get_by_text("We can’t reach Diaphane")).to_be_visible()
    page.unroute("**/anonymise")
    expect(page.get_by_text("This scan shows a head")).to_be_visible()
    wait_for_samples(stack, page, 2)
    page.screenshot(path=pictures / "cut-phone.png")
    handle = page.locator('[data-handle="z-high"]')
    box = placed(handle)
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = value(page, "z-high")
    touch = page.context.new_cdp_session(page)
    for kind, down in (("touchStart", 0), ("touchMove", 10), ("touchMove", 25), ("touchEnd", None)):
        points = [] if down is None else [{"x": x, "y": y + down}]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    stack.wait_until(lambda: value(page, "z-high") < before - 2 or page.wait_for_timeout(50), what="the handle's move")
    page.get_by_role("link", name="Cancel").click()
    expect(page.locator("canvas[data-samples]")).to_be_visible()
    assert stack.psql("SELECT anonymised_at FROM data_sets WHERE id = %s", data_set) == [(None,)]
