"""Two scans side by side with linked cameras, and one over the other."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from person import PATIENCE_MS, Person
from picture import ALIKE, SIDE, difference, listen, pixels, wait_for_picture
from playwright.sync_api import Page, expect


def camera(page: Page, side: int) -> list[float]:
    return [float(number) for number in (page.locator(f"[data-side='{side}'] canvas").get_attribute("data-camera") or "").split()]


def direction(numbers: list[float]) -> tuple[float, ...]:
    away = [numbers[i] - numbers[i + 3] for i in range(3)]
    return tuple(one / math.hypot(*away) for one in away)


def both_show(page: Page) -> None:
    expect(page.locator("canvas[data-samples]")).to_have_count(2)


def newest_shown(page: Page) -> None:
    """Waits until both pictures show the newest input."""
    page.wait_for_function("""() => [...document.querySelectorAll("canvas")].every((one) => Number(one.dataset.inputSeq) > 0)""")


def drag(page: Page, side: int, right: float, down: float) -> None:
    box = page.locator(f"[data-side='{side}'] canvas").bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=4)
    page.mouse.up()


def scans_of(fake, page: Page) -> dict[str, str]:
    page.request.post(f"{fake.url}/v1/sign-in")
    return {scan["title"]: scan["id"] for scan in page.request.get(f"{fake.url}/v1/data-sets").json()["items"] if scan["state"] == "ready"}


def test_a_second_scan_is_chosen_on_the_card(fake, visit, pictures: Path):
    page = visit(wide=True)
    ids = scans_of(fake, page)
    page.goto(f"{fake.url}/scans")
    page.get_by_role("button", name="Compare Head, spring with another scan").click()
    dialog = page.get_by_role("dialog", name="Choose the second scan")
    expect(dialog.get_by_role("button", name="Head, spring")).to_have_count(0)
    page.screenshot(path=pictures / "compare_choose.png")
    dialog.get_by_role("button", name="Knee after the fall").click()
    expect(page).to_have_url(f"{fake.url}/compare/{ids['Head, spring']}/{ids['Knee after the fall']}")
    both_show(page)
    expect(page.get_by_role("heading", level=1)).to_have_text("Head, spring and Knee after the fall")
    page.screenshot(path=pictures / "compare_side_by_side.png")
    page.get_by_role("link", name="Open Knee after the fall alone").click()
    expect(page).to_have_url(f"{fake.url}/view/{ids['Knee after the fall']}")
    page.get_by_role("button", name="Compare with another scan").click()
    expect(page.get_by_role("dialog", name="Choose the second scan")).to_be_visible()


def test_turning_one_picture_turns_the_other(fake, visit):
    page = visit(wide=True)
    ids = scans_of(fake, page)
    page.goto(f"{fake.url}/compare/{ids['Head, spring']}/{ids['Knee after the fall']}")
    both_show(page)
    before = camera(page, 0)
    drag(page, 1, 80, 20)
    assert direction(camera(page, 1)) != pytest.approx(direction(before), abs=0.01)
    assert direction(camera(page, 0)) == pytest.approx(direction(camera(page, 1)), abs=1e-4)
    # The looks that both have change together.
    page.locator("[data-side='0'] [data-preset='bone']").click()
    expect(page.locator("[data-side='1'] [data-preset='bone']")).to_have_attribute("aria-pressed", "true")
    # Keys turn both, too.
    turned = camera(page, 0)
    page.keyboard.press("ArrowRight")
    assert direction(camera(page, 0)) != pytest.approx(direction(turned), abs=0.01)
    assert direction(camera(page, 1)) == pytest.approx(direction(camera(page, 0)), abs=1e-4)
    # A reload keeps the view of both.
    kept = camera(page, 0)
    page.reload()
    both_show(page)
    assert camera(page, 0) == pytest.approx(kept, abs=0.01) and camera(page, 1) == pytest.approx(kept, abs=0.01)
    page.get_by_label("Linked cameras").select_option("Turn separately")
    drag(page, 0, 80, 0)
    assert camera(page, 1) == pytest.approx(kept, abs=0.01)
    assert direction(camera(page, 0)) != pytest.approx(direction(kept), abs=0.01)


def test_aligned_scans_are_linked_by_place(fake, visit, pictures: Path):
    """The fake server shifts the second scan by (4, -6, 10) mm."""
    page = visit(wide=True)
    ids = scans_of(fake, page)
    page.goto(f"{fake.url}/compare/{ids['Head, spring']}/{ids['Beating heart']}")
    both_show(page)
    expect(page.get_by_label("Linked cameras")).to_have_value("places")
    page.wait_for_function("""() => document.querySelector("[data-side='1'] canvas").dataset.camera.endsWith("-4.000 6.000 -10.000")""")
    first, second = camera(page, 0), camera(page, 1)
    assert [a - b for a, b in zip(first, second)] == pytest.approx([4, -6, 10] * 2, abs=0.01)
    page.get_by_role("button", name="Align", exact=True).click()
    expect(page.get_by_role("dialog")).to_contain_text("share a frame of reference")
    page.screenshot(path=pictures / "compare_aligned.png")


def test_scans_are_aligned_and_shown_one_over_the_other(fake, visit, pictures: Path):
    page = visit(wide=True)
    ids = scans_of(fake, page)
    page.goto(f"{fake.url}/compare/{ids['Knee after the fall']}/{ids['Beating heart']}")
    page.get_by_role("link", name="One over the other").click()
    expect(page.get_by_text("These scans don’t share a frame of reference")).to_be_visible()
    page.screenshot(path=pictures / "compare_align.png")
    # The fake server needs 2.5 s, so a busy machine may look too late.
    listen(page, "body")
    page.get_by_role("button", name="Align them").click()
    panel = page.get_by_role("complementary", name="Second scan")
    expect(panel).to_be_visible()
    assert any("Aligning the scans…" in text for text in page.evaluate("window.said"))
    panel.get_by_text("Alignment", exact=True).click()
    expect(panel).to_contain_text("aligned to about 1.3 mm")
    expect(panel).to_contain_text("Not for diagnosis")
    share = panel.get_by_role("slider", name="Mixture")
    expect(share).to_have_value("0.5")
    share.fill("0.8")
    page.get_by_role("button", name="Undo").click()
    expect(share).to_have_value("0.5")
    panel.get_by_label("Look", exact=True).select_option("Bone")
    page.screenshot(path=pictures / "compare_over.png")
    panel.get_by_label("Show").select_option("Before and after")
    divider = page.get_by_role("slider", name="Divider between the first and the second scan")
    expect(divider).to_have_attribute("aria-valuenow", "50")
    divider.press("ArrowRight")
    expect(divider).to_have_attribute("aria-valuenow", "52")
    box, stage = divider.bounding_box(), page.locator(".stage").bounding_box()
    assert box and stage
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 300)
    page.mouse.down()
    page.mouse.move(stage["x"] + stage["width"] / 4, box["y"] + 300, steps=3)
    page.mouse.up()
    expect(divider).to_have_attribute("aria-valuenow", "25")
    page.screenshot(path=pictures / "compare_split.png")
    page.reload()
    expect(divider).to_have_attribute("aria-valuenow", "25")


@pytest.mark.parametrize("size", [{"width": 390, "height": 844}, {"width": 800, "height": 600}, {"width": 1440, "height": 900}],
                         ids=lambda size: str(size["width"]))
def test_pictures_are_beside_each_other_or_one_above_the_other(fake, visit, pictures: Path, size: dict):
    page = visit()
    page.set_viewport_size(size)
    ids = scans_of(fake, page)
    page.goto(f"{fake.url}/compare/{ids['Head, spring']}/{ids['Knee after the fall']}")
    both_show(page)
    first, second = (page.locator(f"[data-side='{side}'] canvas").bounding_box() for side in (0, 1))
    assert first and second
    if size["width"] < size["height"]:
        assert second["y"] >= first["y"] + first["height"] and second["x"] == first["x"]
    else:
        assert second["x"] >= first["x"] + first["width"] and second["y"] == first["y"]
    assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
    page.screenshot(path=pictures / f"compare_{size['width']}.png")


def converge(page: Page) -> None:
    """Waits until both pictures show the newest input well enough to be compared."""
    page.wait_for_function("() => [...document.querySelectorAll('canvas')].every((one) => Number(one.dataset.error) < 0.2)")


def test_two_scans_of_the_renderer_turn_together(stack, visit, cranium: Path, pictures: Path):
    person = Person.arrives(stack, visit(), "compare")
    first, second = (person.has_scan(cranium, title) for title in ("Before", "After"))
    page = person.page
    page.goto(f"{stack.url}/compare/{first}/{second}")
    both_show(page)
    # The page stores the view a quarter of a second after it has the scene.
    stack.wait_until(lambda: page.evaluate("(id) => sessionStorage.getItem(`diaphane.view.compare.1.${id}`)", second), what="the stored views")
    before = kept_cameras(page, first, second)
    drag(page, 0, 120, 30)
    page.wait_for_timeout(500)    # the page stores views a quarter of a second after the last input
    after = kept_cameras(page, first, second)
    assert before[0] != after[0] and before[1] != after[1], "both scenes were sent"
    assert after[0]["eye"] == pytest.approx(after[1]["eye"], abs=1e-6)
    converge(page)
    page.screenshot(path=pictures / "compare_real.png")
    sessions = [one["data_set_id"] for one in page.request.get(f"{stack.url}/v1/sessions").json()["items"]]
    assert sorted(sessions) == sorted([first, second])
    page.get_by_role("link", name="My scans").click()
    stack.wait_until(lambda: page.request.get(f"{stack.url}/v1/sessions").json()["items"] == [], what="the end of both sessions")


def kept_cameras(page: Page, *scans: str) -> list[dict]:
    keys = [f"diaphane.view.compare.{side}.{scan}" for side, scan in enumerate(scans)]
    return [json.loads(json.loads(page.evaluate("(key) => sessionStorage.getItem(key)", key))["scene"])["camera"] for key in keys]


def fused_panel(page: Page):
    """Returns the panel of the second scan, once both scans are in the picture."""
    panel = page.get_by_role("complementary", name="Second scan")
    expect(panel.get_by_role("slider", name="Mixture")).to_be_visible()
    return panel


def shown_at(stack, page: Page, share: float) -> bytes:
    page.get_by_role("slider", name="Mixture").fill(str(share))
    page.wait_for_timeout(500)    # the page stores the newest input a quarter of a second later
    wait_for_picture(stack, page, fused_input(page))
    return pixels(page)


def fused_input(page: Page) -> int:
    """Returns the newest input that the page has stored."""
    return page.evaluate("""() => JSON.parse(Object.entries(sessionStorage)
        .find(([name]) => name.startsWith("diaphane.view.over."))?.[1] ?? "{}").input_seq ?? 0""")


def halves(picture: bytes) -> tuple[bytes, bytes]:
    """Returns the left and the right half of a picture, without the columns beside the divider."""
    rows = [picture[3 * SIDE * y:3 * SIDE * (y + 1)] for y in range(SIDE)]
    return b"".join(row[:3 * (SIDE // 2 - 4)] for row in rows), b"".join(row[3 * (SIDE // 2 + 4):] for row in rows)


def test_scans_of_one_examination_lie_over_each_other(stack, visit, cranium: Path, pictures: Path):
    person = Person.arrives(stack, visit(), "fused")
    first, second = (person.uploads_scan(cranium, title) for title in ("Before", "After"))
    page = person.page
    page.goto(f"{stack.url}/compare/{first}/{second}/over")
    panel = fused_panel(page)
    [session] = page.request.get(f"{stack.url}/v1/sessions").json()["items"]
    assert (session["data_set_id"], session["over"]) == (first, second)
    only_first, only_second = shown_at(stack, page, 0), shown_at(stack, page, 1)
    page.screenshot(path=pictures / "fused_second.png")
    # The second scan has other colours than the first, of which half of the picture is background.
    assert difference(only_first, only_second) > ALIKE
    shown_at(stack, page, 0.5)
    page.screenshot(path=pictures / "fused_both.png")
    panel.locator("summary").first.click()
    panel.get_by_label("Show").select_option("Before and after")
    panel.locator("summary").first.click()
    page.wait_for_timeout(500)
    wait_for_picture(stack, page, fused_input(page))
    page.screenshot(path=pictures / "fused_split.png")
    split = halves(pixels(page))
    assert difference(split[0], halves(only_first)[0]) < ALIKE
    assert difference(split[1], halves(only_second)[1]) < ALIKE
    # Slices show both scans, here the same values twice.
    page.keyboard.press("v")
    value = page.locator(".slice-value").first
    expect(value).to_have_text(re.compile(r"^(\S+ HU), second scan: \1$"))
    page.screenshot(path=pictures / "fused_slices.png")


def test_scans_of_two_examinations_are_aligned(stack, visit, cranium: Path, pictures: Path):
    """Both are the same scan, but their frame of reference is unknown."""
    person = Person.arrives(stack, visit(), "aligned")
    first, second = (person.has_scan(cranium, title) for title in ("Before", "After"))
    page = person.page
    page.goto(f"{stack.url}/compare/{first}/{second}/over")
    page.get_by_role("button", name="Align them").click()
    expect(page.get_by_text("Aligning the scans…")).to_be_visible()
    page.screenshot(path=pictures / "aligning.png")
    panel = page.get_by_role("complementary", name="Second scan")
    expect(panel).to_be_visible(timeout=5 * PATIENCE_MS)
    fused_panel(page)
    found = page.request.get(f"{stack.url}/v1/data-sets/{first}/alignments/{second}").json()
    # The same scan lies at the same place, to half of the shortest side of a voxel and half a degree.
    identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    for place, (number, wanted) in enumerate(zip(found["matrix"], identity, strict=True)):
        assert number == pytest.approx(wanted, abs=0.5 if place % 4 == 3 else math.radians(0.5))
    panel.locator("summary").first.click()
    panel.get_by_text("Alignment", exact=True).click()
    expect(panel).to_contain_text("The scans are aligned to")
    page.screenshot(path=pictures / "aligned.png")
    page.get_by_role("link", name="Side by side").click()
    both_show(page)
    expect(page.get_by_label("Linked cameras")).to_have_value("places")
