"""Two browsers in one live session: one rotates the picture, and the other sees it."""

from __future__ import annotations

import itertools
import json
import math
import re
from pathlib import Path
from typing import Callable

from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from picture import Facts, difference, drag, facts, kept_view, last_input, pixels, spread, wait_for_samples
from test_pages import check_page
from touch import Fingers


def same_picture(stack: TestStack, a: Page, b: Page) -> None:
    """Both show the same samples of the same epoch, and the pictures are equal after averaging out the noise of the codec."""

    def alike() -> bool:
        one, other = facts(a), facts(b)
        a.wait_for_timeout(50)
        return one == other and one.samples > 0 and difference(pixels(a), pixels(b)) < 3

    stack.wait_until(alike, timeout=120, what="one picture in both browsers")


def came(stack: TestStack, page: Page, by: Page, after: int) -> None:
    """Waits until a page shows the last input of another (or its own), in an epoch after the given one: the steps of a drag before
    it change the picture less. Numbers of two presenters are counted separately, so that a higher one may be older."""
    def there() -> bool:
        now = facts(page)
        return (now.epoch > after and now.input_seq == last_input(by)) or page.wait_for_timeout(50)

    stack.wait_until(there, timeout=120, what="the picture of the last input")


def settled(stack: TestStack, page: Page) -> Facts:
    """After a rotation, the full picture follows the release of the pointer. Its status appears long before a picture with this
    many samples."""
    return wait_for_samples(stack, page, 4)


def follows_with_windows_and_slices(stack: TestStack, owner: Page, follower: Page, pictures: Path) -> None:
    """A follower's windows name the presenter and change nothing. Everyone can scroll through the slices."""
    seen = facts(owner).epoch
    for title in ("Materials", "Light", "Lens and quality", "Cuts and slices"):
        follower.get_by_role("button", name=title, exact=True).click()
        window = follower.get_by_role("dialog", name=title, exact=True)
        expect(window.get_by_text("Someone else is presenting.")).to_be_visible()
        assert window.locator("fieldset.window-controls").evaluate("(set) => set.matches(':disabled') && set.querySelectorAll(':enabled:is(input, select, button)').length === 0")
    last = follower.get_by_role("dialog").last
    follower.screenshot(path=pictures / "live-follower-windows.png")
    last.get_by_role("button", name="Close Cuts and slices").click()
    follower.keyboard.press("Control+z")
    assert follower.get_by_role("button", name="Undo", exact=True).get_attribute("aria-disabled") == "true"

    # No slices until the owner allows and shows them: neither the button nor the key shows any.
    def has_none() -> None:
        expect(follower.get_by_role("button", name="Show the slices (V)")).to_have_count(0)
        follower.keyboard.press("v")
        expect(follower.locator(".slice-pane")).to_have_count(0)

    has_none()
    owner.get_by_role("button", name="View together").click()
    switch = owner.get_by_role("checkbox", name="Guests see the slices that are presented")
    expect(switch).not_to_be_checked()
    switch.check()
    expect(switch).to_be_checked()
    owner.screenshot(path=pictures / "live-share-slices.png")
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()

    has_none()
    assert facts(owner).epoch == seen
    owner.keyboard.press("v")
    axial, shown = (page.locator(".slice-pane[data-plane=axial] canvas") for page in (follower, owner))
    expect(axial).to_have_attribute("data-came", "true")
    expect(shown).to_have_attribute("data-came", "true")
    begun = int(shown.get_attribute("data-index"))
    expect(axial).to_have_attribute("data-index", str(begun))
    shown.focus()
    owner.keyboard.press("ArrowDown")
    expect(axial).to_have_attribute("data-index", str(begun + 1))
    expect(axial).to_have_attribute("data-came", "true")
    value = follower.locator(".slice-pane[data-plane=axial] .slice-value")
    expect(value).to_contain_text("HU")
    follower.screenshot(path=pictures / "live-follower-slices.png")
    cube, line = (follower.locator(name).bounding_box() for name in (".cube", ".live-line"))
    assert cube["y"] + cube["height"] <= line["y"], "the cube covers the follower's line"
    owner.keyboard.press("ArrowUp")

    # What the owner cuts away also disappears from the follower's slices, here the middle of the volume with the crosshair.
    owner.get_by_role("button", name="Cuts and slices", exact=True).click()
    cuts = owner.get_by_role("dialog", name="Cuts and slices", exact=True)
    cuts.locator("details.more > summary").click()
    cuts.get_by_role("button", name="Add plane").click()
    offset = cuts.get_by_label("Distance from the centre (value)")
    offset.fill("-40")
    offset.press("Enter")
    expect(value).to_have_text("Cut away")
    follower.screenshot(path=pictures / "live-follower-clipped.png")
    cuts.get_by_role("button", name="Remove plane 1").click()
    expect(value).to_contain_text("HU")
    owner.get_by_role("button", name="Close Cuts and slices").click()

    # When closed or switched off, they disappear from the follower's page at once.
    owner.keyboard.press("v")
    has_none()
    owner.keyboard.press("v")
    expect(axial).to_have_attribute("data-came", "true")
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("checkbox", name="Guests see the slices that are presented").uncheck()
    has_none()
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()
    owner.keyboard.press("v")
    same_picture(stack, owner, follower)


#: Runs in the page: the distance of the subject from the left and the right edge, in parts of the picture's width. The subject is
#: brighter than any background.
MARGINS = """(canvas) => {
    const { width, height } = canvas;
    const rgba = canvas.getContext("2d").getImageData(0, 0, width, height).data;
    let low = width, high = -1;
    for (let i = 0; i < rgba.length; i += 4)
        if (rgba[i] > 110) { const x = (i / 4) % width; low = Math.min(low, x); high = Math.max(high, x); }
    return [low / width, 1 - (high + 1) / width];
}"""


def the_picture_fits_a_phone_that_presents(stack: TestStack, owner: Page, phone: Page, pictures: Path) -> None:
    """Whoever presents from now on sees the whole subject, however narrow the window, and gives it back as it was."""

    def distance(page: Page) -> float:
        camera = json.loads(kept_view(page)["scene"])["camera"]
        return math.dist(*([camera[end].get(axis, 0) for axis in "xyz"] for end in ("eye", "target")))

    before, epoch = distance(owner), facts(owner).epoch
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("button", name=re.compile("^Make presenter: Guest \\d$")).click()
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()
    expect(phone.get_by_text("Owner is presenting")).to_have_count(0)
    canvas = phone.locator(".stage > canvas")
    stack.wait_until(lambda: distance(phone) > 1.5 * before or phone.wait_for_timeout(50), what="the camera moving back")
    came(stack, phone, by=phone, after=epoch)
    settled(stack, phone)
    phone.screenshot(path=pictures / "live-phone-presents.png")
    left, right = canvas.evaluate(MARGINS)
    assert left > 0.02 and right > 0.02, "the subject is wider than the window"
    owner.get_by_role("button", name="Present again").click()
    expect(phone.get_by_text("Owner is presenting")).to_be_visible()
    stack.wait_until(lambda: abs(distance(owner) / before - 1) < 0.03 or owner.wait_for_timeout(50), what="the camera moving forward")


def test_a_follower_sees_the_view_of_the_presenter_and_takes_over(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna = Person.arrives(stack, visit(samples=64), "anna")    # more samples must come after a picture has settled
    anna.has_scan(cranium, "Head")
    anna.open_scan("Head")
    owner = anna.page
    wait_for_samples(stack, owner, 1)
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("button", name="Create link").click()
    link = owner.get_by_label("Link to share").input_value()
    check_page(owner)

    # The same with the keyboard: the dialog keeps the focus, and Escape closes it and returns the focus.
    owner.keyboard.press("Escape")
    expect(owner.get_by_role("button", name="View together")).to_be_focused()
    owner.keyboard.press("Enter")
    expect(owner.get_by_role("dialog")).to_be_visible()

    # Another browser without cookies or an account.
    follower = visit()
    follower.goto(link)
    follower.get_by_label("Your name (visible to others in this session)").fill("Bob")
    follower.screenshot(path=pictures / "live-join.png")
    check_page(follower)
    follower.get_by_role("button", name="Join", exact=True).click()
    expect(follower.locator("canvas[data-samples]")).to_be_visible()
    expect(follower.get_by_text("Owner is presenting")).to_be_visible()
    expect(owner.locator("[data-participant]")).to_have_count(2)
    expect(owner.get_by_text("Bob")).to_be_visible()
    owner.screenshot(path=pictures / "live-share.png")
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()
    same_picture(stack, owner, follower)
    assert spread(pixels(follower)) > 3

    # The presenter's rotation reaches the follower. The follower's rotation changes nothing.
    before = pixels(follower)
    epoch = facts(owner).epoch
    drag(owner, 200, 0)
    came(stack, owner, by=owner, after=epoch)
    same_picture(stack, owner, follower)
    assert difference(before, pixels(follower)) > 3
    before = settled(stack, owner)
    drag(follower, 100, 0)
    assert wait_for_samples(stack, owner, before.samples + 2).epoch == before.epoch
    follower.screenshot(path=pictures / "live-follower.png")
    check_page(follower)
    follows_with_windows_and_slices(stack, owner, follower, pictures)

    # A phone with another aspect ratio shows everything that the presenter sees.
    phone = visit(phone=True)
    phone.goto(link)
    phone.get_by_role("button", name="Join", exact=True).click()
    expect(phone.get_by_text("Owner is presenting")).to_be_visible()
    wait_for_samples(stack, phone, 1)
    phone.screenshot(path=pictures / "live-phone.png")
    check_page(phone)
    the_picture_fits_a_phone_that_presents(stack, owner, phone, pictures)
    phone.close()

    # The role changes hands: the former presenter follows, and no earlier picture reappears.
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("button", name="Make presenter: Bob").click()
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()
    expect(owner.get_by_text("Bob is presenting")).to_be_visible()
    expect(follower.get_by_text("Owner is presenting")).to_have_count(0)
    same_picture(stack, owner, follower)  # in the size of the new presenter
    before = pixels(owner)
    epochs = [facts(owner).epoch]
    drag(follower, 0, 120)
    for _ in range(40):
        owner.wait_for_timeout(50)
        epochs.append(facts(owner).epoch)
    came(stack, owner, by=follower, after=epochs[0])  # on a busy machine later than these two seconds
    epochs.append(facts(owner).epoch)
    same_picture(stack, owner, follower)
    assert epochs == sorted(epochs), "an older picture came after a newer one"
    assert difference(before, pixels(owner)) > 3

    # After a reload, the guest is the same and still presents. Disabling the link disconnects them.
    follower.reload()
    wait_for_samples(stack, follower, 1)
    expect(owner.get_by_text("Bob is presenting")).to_be_visible()
    # The owner may take the picture back while the guest is there, and give it again.
    owner.get_by_role("button", name="Present again").click()
    expect(follower.get_by_text("Owner is presenting")).to_be_visible()
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("button", name="Make presenter: Bob").click()
    expect(owner.get_by_text("Bob is presenting")).to_be_visible()
    owner.get_by_role("button", name="Disable link").click()
    expect(follower.get_by_role("status").filter(has_text="This link has expired or was disabled")).to_be_visible()
    expect(owner.locator("[data-participant]")).to_have_count(1)
    expect(owner.get_by_text("presenting", exact=True)).to_be_visible()
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()
    epoch = facts(owner).epoch
    drag(owner, -80, 0)
    came(stack, owner, by=owner, after=epoch)


def test_interaction_is_recorded_only_with_revocable_consent(stack: TestStack, visit, cranium: Path, pictures: Path):
    eve = Person.arrives(stack, visit(), "eve")
    eve.has_scan(cranium, "Private Title")
    eve.open_scan("Private Title")
    page = eve.page
    wait_for_samples(stack, page, 1)
    drag(page, 120, 0)
    page.get_by_role("button", name="Usage recording").click()
    switch = page.get_by_role("switch", name="Record how I use the viewer")
    expect(switch).to_be_enabled()
    expect(switch).not_to_be_checked()
    # The page records once the server has confirmed it. It asks for that after each change.
    with page.expect_response(lambda answer: answer.url.endswith("/v1/recordings") and answer.request.method == "GET"):
        switch.check()
    page.screenshot(path=pictures / "recording.png")
    check_page(page)
    page.get_by_role("dialog").get_by_role("button", name="Close").click()
    before = facts(page)
    drag(page, 150, 40)
    wait_for_samples(stack, page, 1, input_seq=before.input_seq + 1)
    page.get_by_role("link", name="My scans").click()  # leaving the page saves the recording
    stored = stack.wait_until(lambda: stack.psql("SELECT body FROM recordings") or page.wait_for_timeout(50), what="the recording")
    body = stored[0][0]
    assert '"camera"' in body
    for secret in ("Private", eve.email, "bone"):
        assert secret not in body
    eve.open_scan("Private Title")
    page.get_by_role("button", name="Usage recording").click()
    with page.expect_download() as export:
        page.get_by_role("link", name="Download").click()
    assert Path(export.value.path()).read_text() == body
    page.get_by_role("button", name="Delete").click()
    expect(page.get_by_role("button", name="Delete")).to_have_count(0)
    assert stack.psql("SELECT count(*) FROM recordings") == [(0,)]
    consent = "**/v1/recording-consent"
    page.route(consent, lambda route: route.abort())
    switch.click()
    expect(page.get_by_role("dialog").get_by_role("alert")).to_be_visible()
    expect(switch).to_be_checked()  # the recording was not announced to anyone
    page.unroute(consent)
    switch.uncheck()
    stack.wait_until(lambda: stack.psql("SELECT count(*) FROM users WHERE recording_consent_at IS NOT NULL") == [(0,)]
                     or page.wait_for_timeout(50), what="the consent taken back")


def pointer_at(page: Page, inside: str, name: str) -> list[float]:
    """Returns where a participant's pointer is from the left, or nothing while it is not shown."""
    return page.locator(inside).locator(".pointer", has_text=name).evaluate_all("(marks) => marks.map((mark) => mark.getBoundingClientRect().x)")


def points(stack: TestStack, move: Callable[[int], None], page: Page, inside: str, name: str, right_of: float = 2) -> float:
    """Points until another page shows it. A pointer that rests is hidden after 4 seconds, which two busy pages may need to show it, so
    that it keeps moving: `move` is given 0 and 1 in turn. Returns where it is. (At the left edge is one in a picture that the page
    has not measured yet.)"""
    moves = itertools.count()

    def seen() -> list[float]:
        move(next(moves) % 2)
        page.wait_for_timeout(50)
        return [x for x in pointer_at(page, inside, name) if x > right_of]

    return stack.wait_until(seen, timeout=120, what=f"the pointer of {name}")[0]


def middle_of(page: Page, element: str) -> tuple[float, float]:
    box = page.locator(element).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_everyone_sees_the_slices_of_the_presenter_and_where_the_others_point(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna = Person.arrives(stack, visit(), "anna")
    anna.has_scan(cranium, "Head")
    anna.open_scan("Head")
    owner = anna.page
    wait_for_samples(stack, owner, 1)
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("button", name="Create link").click()
    link = owner.get_by_label("Link to share").input_value()
    phone = visit(phone=True)
    phone.goto(link)
    phone.get_by_label("Your name (visible to others in this session)").fill("Bob")
    phone.get_by_role("button", name="Join", exact=True).click()
    wait_for_samples(stack, phone, 1)
    owner.get_by_role("checkbox", name="Guests see the slices that are presented").check()
    expect(owner.get_by_role("checkbox", name="Guests can point")).to_be_checked()
    owner.screenshot(path=pictures / "live-share-pointers.png")
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()

    # Both point at the picture: the presenter with the mouse, the guest with a finger that is held down.
    canvas = ".stage > canvas"
    x, y = middle_of(owner, canvas)
    points(stack, lambda step: owner.mouse.move(x + step, y), phone, ".stage > .handle-area", "Owner")
    finger = Fingers(phone)
    left, top = middle_of(phone, canvas)
    finger.say("touchStart", [(left, top)])
    first = points(stack, lambda step: finger.say("touchMove", [(left + step, top)]), owner, ".stage > .handle-area", "Bob")
    points(stack, lambda step: finger.say("touchMove", [(left + 20 + step, top)]), owner, ".stage > .handle-area", "Bob", right_of=first + 5)
    owner.mouse.move(*(n + 20 for n in middle_of(owner, canvas)))
    owner.screenshot(path=pictures / "live-pointer-desktop.png")
    phone.screenshot(path=pictures / "live-pointer-phone.png")
    finger.say("touchEnd", [])

    # The phone follows the presenter's slices with their window and measurement, one plane at a time.
    owner.keyboard.press("v")
    expect(phone.locator(".slice-pane[data-plane=axial] canvas")).to_have_attribute("data-came", "true")
    # The owner's own view understands the mouse once it knows its size, as its scale does.
    expect(owner.locator(".slice-pane[data-plane=axial] .slice-scale")).to_be_visible()
    owner.get_by_role("radio", name="Ruler").check()
    x, y = middle_of(owner, ".slice-pane[data-plane=axial] canvas")
    owner.mouse.move(x - 60, y)
    owner.mouse.down()
    owner.mouse.move(x + 40, y + 10, steps=4)
    owner.mouse.up()
    expect(phone.locator(".slice-pane[data-plane=axial] .slice-measure text")).to_have_text(owner.locator(".slice-pane[data-plane=axial] .slice-measure text").text_content())
    owner.get_by_label("Width", exact=True).fill("777")
    owner.keyboard.press("Enter")
    axial = owner.locator(".slice-pane[data-plane=axial] canvas")
    axial.focus()
    owner.keyboard.press("ArrowDown")
    owner.keyboard.press("ArrowUp")
    index = axial.get_attribute("data-index")
    expect(phone.locator(".slice-pane[data-plane=axial] canvas")).to_have_attribute("data-index", index)
    expect(phone.locator(".slice-slider")).to_be_disabled()
    points(stack, lambda step: owner.mouse.move(x + step, y + 40), phone, ".slice-pane[data-plane=axial]", "Owner")
    owner.screenshot(path=pictures / "live-slices-desktop.png")
    phone.screenshot(path=pictures / "live-slices-phone.png")
    check_page(phone)
    phone.get_by_role("radio", name="Coronal").check()
    expect(phone.locator(".slice-pane[data-plane=coronal] canvas")).to_have_attribute("data-came", "true")
    owner.keyboard.press("v")
    expect(phone.locator(".slice-pane")).to_have_count(0)

    # The presenter turns the pointers of guests off.
    owner.get_by_role("button", name="View together").click()
    owner.get_by_role("checkbox", name="Guests can point").uncheck()
    owner.get_by_role("dialog").get_by_role("button", name="Close").click()
    expect(owner.locator(".pointer")).to_have_count(0)
    phone.get_by_role("button", name="View together").click()
    expect(phone.get_by_text("Everyone sees where you point")).to_have_count(0)
    phone.close()


def test_a_link_can_let_its_guests_look_through_all_slices(stack: TestStack, visit, cranium: Path, pictures: Path):
    anna = Person.arrives(stack, visit(), "anna")
    anna.has_scan(cranium, "Head")
    anna.open_scan("Head")
    owner = anna.page
    owner.get_by_role("button", name="View together").click()
    dialog = owner.get_by_role("dialog")
    wide = dialog.get_by_role("checkbox", name="Guests with this link can look through all slices themselves")
    expect(wide).not_to_be_checked()
    wide.check()
    owner.screenshot(path=pictures / "live-share-all-slices.png")
    dialog.get_by_role("button", name="Create link").click()
    expect(dialog.get_by_text("Guests with this link can look through all slices themselves, except what you have cut away.")).to_be_visible()
    expect(dialog.get_by_role("checkbox", name="Guests see the slices that are presented")).to_have_count(0)
    guest = visit()
    guest.goto(dialog.get_by_label("Link to share").input_value())
    guest.get_by_role("button", name="Join", exact=True).click()
    guest.get_by_role("button", name="Show the slices (V)").click()
    axial = guest.locator(".slice-pane[data-plane=axial] canvas")
    expect(axial).to_have_attribute("data-came", "true")
    begun = int(axial.get_attribute("data-index"))
    axial.focus()
    guest.keyboard.press("ArrowDown")
    expect(axial).to_have_attribute("data-index", str(begun + 1))
    expect(axial).to_have_attribute("data-came", "true")
    # The owner's page still knows the link after a reload, and a new one begins with the picture alone.
    owner.reload()
    owner.get_by_role("button", name="View together").click()
    expect(dialog.get_by_text("Guests with this link can look through all slices themselves, except what you have cut away.")).to_be_visible()
    dialog.get_by_role("button", name="Disable link").click()
    expect(guest.get_by_role("heading", name="Your visit has ended")).to_be_visible()
    expect(wide).not_to_be_checked()
