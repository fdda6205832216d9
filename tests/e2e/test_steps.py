"""Places where people hesitated: each step shows what to do next, and nothing covers it."""

from __future__ import annotations

import re

import pytest

from pathlib import Path

from playwright.sync_api import Page, expect

#: Runs in the page: pairs of these elements that overlap, and those that leave the window.
COVERED = """(selectors) => {
    const shown = selectors.map((one) => [one, document.querySelector(one)?.getBoundingClientRect()]).filter(([, box]) => box?.width > 0);
    const wrong = shown.filter(([, box]) => box.left < 0 || box.right > innerWidth || box.bottom > innerHeight).map(([one]) => `${one} leaves the window`);
    for (const [i, [one, a]] of shown.entries()) for (const [other, b] of shown.slice(0, i))
        if (a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1) wrong.push(`${one} over ${other}`);
    return wrong;
}"""
#: Runs in the page: the names of the buttons that show only an icon.
NAMES = """() => [...document.querySelectorAll(".viewer-tools button, .menu button")]
    .filter((button) => button.getClientRects().length > 0).map((button) => button.getAttribute("aria-label"))"""


def open_viewer(fake, page: Page, tips: bool = False) -> None:
    page.request.post(f"{fake.url}/v1/sign-in")
    scans = page.request.get(f"{fake.url}/v1/data-sets").json()["items"]
    page.goto(f"{fake.url}/view/" + next(scan["id"] for scan in scans if scan["state"] == "ready"))
    expect(page.locator("canvas[data-samples]")).to_be_visible()
    if not tips:
        page.get_by_role("button", name="Hide the tips").click()


@pytest.mark.parametrize("size", [{"width": 390, "height": 844}, {"width": 1280, "height": 720}], ids=["phone", "laptop"])
def test_no_window_covers_a_note_or_the_quality(fake, visit, pictures: Path, size: dict):
    page = visit(phone=size["width"] < 500)
    page.set_viewport_size(size)
    open_viewer(fake, page)
    page.route("**/v1/sessions", lambda route: route.abort())  # so that the note about the saved picture stays
    page.get_by_role("button", name="Save or share").click()
    page.get_by_label("Size", exact=True).select_option("large")
    page.get_by_role("button", name="Save the picture").click()
    note = page.locator("[data-shot=rendering]")
    expect(note.get_by_role("button", name="Cancel")).to_be_in_viewport(ratio=1)
    page.get_by_role("button", name="Materials", exact=True).click()
    expect(page.locator(".window")).to_be_visible()
    page.screenshot(path=pictures / f"note-{size['width']}.png")
    assert page.evaluate(COVERED, ["[data-shot]", ".menu", ".window", ".viewer-tools", ".presets", ".quality, .quality-chip"]) == []
    note.get_by_role("button", name="Cancel").click()


def test_the_picture_on_the_screen_is_saved_at_once(fake, visit, pictures: Path):
    page = visit()
    open_viewer(fake, page)
    page.route("**/v1/sessions", lambda route: route.abort())  # nothing is rendered again
    page.get_by_role("button", name="Save or share").click()
    dialog = page.get_by_role("dialog", name="Save or share")
    expect(dialog.get_by_role("button", name="Create the file")).to_be_visible()  # the whole dialog has loaded
    expect(dialog.locator(".button-main")).to_have_count(1)
    with page.expect_download() as download:
        dialog.get_by_role("button", name="Save the picture").click()
    expect(dialog.get_by_text("The picture has been saved.")).to_be_visible()
    page.screenshot(path=pictures / "saved-at-once.png")
    assert download.value.suggested_filename.endswith(".png")
    dialog.get_by_label("Size", exact=True).select_option("large")
    expect(dialog.get_by_text("The picture has been saved.")).not_to_be_visible()
    expect(dialog.get_by_text("We render the picture again")).to_be_visible()


@pytest.mark.parametrize("width, height", [(1280, 720), (1440, 900)])
def test_a_tip_takes_one_line_above_the_head(fake, visit, pictures: Path, width: int, height: int):
    page = visit(locale="de-DE")
    page.set_viewport_size({"width": width, "height": height})
    open_viewer(fake, page, tips=True)
    page.screenshot(path=pictures / f"tip-{width}.png")
    box = page.locator(".hints").bounding_box()
    assert box["y"] + box["height"] < 105, box


def test_the_help_begins_at_its_top_and_names_every_icon(fake, visit, pictures: Path):
    page = visit(phone=True)
    open_viewer(fake, page)
    names = page.evaluate(NAMES)
    page.get_by_role("button", name="Controls").click()
    dialog = page.get_by_role("dialog", name="Controls")
    expect(dialog.get_by_role("heading", name="Controls")).to_be_in_viewport()
    page.screenshot(path=pictures / "help-phone.png")
    listed = dialog.locator(".help-buttons li").all_inner_texts()
    assert len(names) > 10
    assert {name.removesuffix(" (V)") for name in names} - {"Controls"} == {name.strip() for name in listed}
    # The keys of the looks are as many as the looks.
    looks = page.locator("[data-preset]").count()
    expect(dialog.get_by_role("row", name="Choose a look")).to_contain_text(f"1 to {looks}")
    expect(page.locator(".stage canvas")).to_have_attribute("aria-label", re.compile(f" 1 to {looks} choose a look"))


def test_a_card_without_a_picture_says_why(fake, visit, pictures: Path):
    page = visit()
    page.request.post(f"{fake.url}/v1/sign-in")
    answers = {"kind": "busy"}
    page.route("**/thumbnails/*", lambda route: route.fulfill(
        status=503, headers={"Retry-After": "1"}, content_type="application/problem+json",
        json={"type": f"urn:diaphane:problem:{answers['kind']}", "title": "x", "status": 503}))
    page.goto(f"{fake.url}/scans")
    card = page.locator("article.card", has_text="Knee after the fall")
    expect(card.get_by_text("The picture is being made.")).to_be_visible()
    page.screenshot(path=pictures / "card-being-made.png")
    answers["kind"] = "no-worker"
    expect(card.get_by_text("No picture yet.")).to_be_visible()
    page.screenshot(path=pictures / "card-no-picture.png")
    page.unroute("**/thumbnails/*")
    expect(card.get_by_role("img", name="Picture of Knee after the fall")).to_be_visible()


def test_a_card_says_why_its_scan_was_taken_down(fake, visit):
    page = visit()
    page.request.post(f"{fake.url}/v1/sign-in")
    listed = page.request.get(f"{fake.url}/v1/data-sets").json()
    listed["items"][0] |= {"title": "Head", "taken_down": {"reason": "A name is burnt in."}}
    page.route("**/v1/data-sets?*", lambda route: route.fulfill(json=listed))
    page.route("**/v1/data-sets", lambda route: route.fulfill(json=listed))
    page.goto(f"{fake.url}/scans")
    expect(page.locator("article.card").first).to_contain_text("An administrator has taken this scan down. Reason: A name is burnt in.")


def test_pictures_are_prepared_only_of_looks_that_a_scan_has(fake, visit):
    page = visit()
    page.request.post(f"{fake.url}/v1/sign-in")
    listed = page.request.get(f"{fake.url}/v1/data-sets").json()["items"]
    scans = {scan["id"]: scan["volume"]["modality"] for scan in listed if scan["volume"]}
    looks = {"CT": ["bone", "muscle", "skin", "through"], "MR": ["bone", "brain", "muscle", "skin"]}
    wanted = [(scan, look) for scan, kind in scans.items() for look in looks[kind]]
    asked = set()

    def note(request) -> bool:
        if "/thumbnails/" in request.url:
            asked.add(tuple(request.url.split("/")[-3::2]))
        return asked.issuperset(wanted)

    with page.expect_request(note):
        page.goto(f"{fake.url}/scans")
    page.wait_for_load_state("networkidle")
    assert sorted(asked) == sorted(wanted)


@pytest.mark.parametrize("phone, first", [(True, "Choose files"), (False, "Choose a folder")])
def test_the_usual_choice_comes_first(fake, visit, phone: bool, first: str):
    page = visit(phone=phone)
    page.request.post(f"{fake.url}/v1/sign-in")
    page.goto(f"{fake.url}/add")
    expect(page.locator(".drop-buttons button.button-main")).to_have_text(first)
    assert page.locator(".drop-buttons button").all_inner_texts()[0] == first


def test_a_mistyped_address_can_be_corrected(fake, visit):
    page = visit(phone=True)
    page.request.post(f"{fake.url}/v1/sign-out")
    page.goto(f"{fake.url}/sign-up")
    page.get_by_label("Email address").fill("ana@example.org")
    page.get_by_label("I agree").check()
    page.get_by_role("button", name="Create account").click()
    expect(page.get_by_text("We’ve sent an email to ana@example.org.")).to_be_visible()
    page.get_by_role("button", name="Correct the address or send it again").click()
    expect(page.get_by_label("Email address")).to_have_value("ana@example.org")
    page.get_by_label("Email address").fill("anna@example.org")
    page.get_by_role("button", name="Create account").click()
    expect(page.get_by_text("We’ve sent an email to anna@example.org.")).to_be_visible()
