"""Every control of the picture with mouse, keyboard and touch, checked on the resulting pictures."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Callable

import pytest
from playwright.sync_api import Locator, Page, expect

from touch import Fingers
from harness import TestStack
from picture import ALIKE, FINE_ERROR, SIDE, difference, facts
from test_in_picture import middle, open_scan, open_viewer
from test_settings import Hands
from input_methods import WAYS, Mouse

WINDOWS = {"look": "Materials", "light": "Light", "lens": "Lens and quality", "cuts": "Cuts and slices"}
RESETS = {"look": "Reset the materials", "light": "Reset the light", "lens": "Reset lens and quality", "cuts": "Remove all cuts and slices"}


def seen(picture: bytes) -> tuple[float, float, float]:
    """Returns the share of the picture that is not background, and its centre in pixels of SIDE."""
    ground = picture[:3]
    places = [(n % SIDE, n // SIDE) for n in range(SIDE * SIDE) if max(abs(picture[3 * n + c] - ground[c]) for c in range(3)) > 12]
    count = max(1, len(places))
    return len(places) / SIDE / SIDE, sum(x for x, _ in places) / count, sum(y for _, y in places) / count


class Eye:
    """The camera of the scene that the page keeps."""

    def __init__(self, hands: Hands):
        camera = json.loads(hands.kept()[0])["camera"]
        self.eye, self.target, self.up = ([camera.get(name, {}).get(axis, 0.0) for axis in "xyz"] for name in ("eye", "target", "up"))

    @property
    def away(self) -> list[float]:
        return [a - b for a, b in zip(self.eye, self.target, strict=True)]

    @property
    def distance(self) -> float:
        return math.hypot(*self.away)

    def turned(self, other: Eye) -> float:
        """Returns the degrees between the two viewing directions."""
        dot = sum(a * b for a, b in zip(self.away, other.away, strict=True)) / self.distance / other.distance
        return math.degrees(math.acos(max(-1, min(1, dot))))

    def moved(self, other: Eye) -> float:
        return math.dist(self.target, other.target)

    def rolled(self, other: Eye) -> float:
        return math.dist(self.up, other.up)


def looked(hands: Hands, deed: Callable[[], None]) -> tuple[Eye, Eye, bytes, bytes]:
    """Returns eye and picture before and after."""
    before, picture = Eye(hands), hands.picture(FINE_ERROR)
    hands.act(deed)
    hands.settle()
    return before, Eye(hands), picture, hands.picture(FINE_ERROR)


def is_turn(hands: Hands, deed: Callable[[], None]) -> None:
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) > 4 and after.moved(before) < 1e-3 and abs(after.distance / before.distance - 1) < 1e-6
    assert difference(old, new) > 1, difference(old, new)


def is_pan(hands: Hands, deed: Callable[[], None]) -> None:
    """Moves to the right."""
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) < 1e-3 and after.moved(before) > 4
    assert seen(new)[1] - seen(old)[1] > 1.5, (seen(old), seen(new))


def is_zoom(hands: Hands, deed: Callable[[], None], nearer: bool) -> None:
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) < 1e-3 and abs(math.log(after.distance / before.distance)) > 0.05
    assert (after.distance < before.distance) == nearer == (seen(new)[0] > seen(old)[0]), (before.distance, after.distance, seen(old), seen(new))


def is_roll(hands: Hands, deed: Callable[[], None]) -> None:
    before, after, old, new = looked(hands, deed)
    assert after.turned(before) < 1e-3 and after.rolled(before) > 0.05
    assert difference(old, new) > 0.5, difference(old, new)


def is_home(hands: Hands, deed: Callable[[], None], home: Eye) -> None:
    _, after, _, _ = looked(hands, deed)
    assert after.moved(home) < 1e-3 and after.turned(home) < 1e-3 and after.rolled(home) < 1e-3 and abs(after.distance / home.distance - 1) < 1e-6


@pytest.mark.nightly
def test_mouse_keys_and_touch_navigate_the_picture(stack: TestStack, visit, cranium: Path):
    page = visit(small=True, touch=True)
    hands = open_viewer(stack, page, cranium, "manon", 480, 400)
    page.get_by_role("button", name="Hide the tips").click()
    home = Eye(hands)
    canvas = page.locator("canvas")
    x, y = middle(canvas.bounding_box())
    y -= 30  # above the looks

    def drag(right: float, down: float, button: str = "left", key: str = "") -> Callable[[], None]:
        def deed() -> None:
            if key:
                page.keyboard.down(key)
            page.mouse.move(x, y)
            page.mouse.down(button=button)
            page.mouse.move(x + right, y + down, steps=6)
            page.mouse.up(button=button)
            if key:
                page.keyboard.up(key)
        return deed

    def wheel() -> None:
        page.mouse.move(x, y)
        page.mouse.wheel(0, -240)

    is_turn(hands, drag(60, 0))
    is_pan(hands, drag(40, 0, key="Shift"))
    is_pan(hands, drag(40, 0, button="middle"))
    is_zoom(hands, wheel, nearer=True)
    is_zoom(hands, drag(0, 60, button="right"), nearer=False)
    is_roll(hands, drag(60, 0, key="Control"))
    is_home(hands, page.get_by_role("button", name="Reset the view").click, home)

    def keys(*names: str) -> Callable[[], None]:
        def deed() -> None:
            for name in names:
                page.keyboard.press(name)
        return deed

    canvas.focus()
    is_turn(hands, keys("ArrowRight"))
    is_pan(hands, keys(*["Shift+ArrowRight"] * 3))
    is_zoom(hands, keys("+", "+", "+"), nearer=True)
    is_zoom(hands, keys("-", "-"), nearer=False)
    is_roll(hands, keys(*["Control+ArrowRight"] * 3))
    is_home(hands, keys("r"), home)

    fingers = Fingers(page)
    is_turn(hands, lambda: fingers.drag([((x, y), (x + 60, y))]))
    is_pan(hands, lambda: fingers.drag([((x - 40, y), (x, y)), ((x + 40, y), (x + 80, y))]))
    is_zoom(hands, lambda: fingers.drag([((x - 30, y), (x - 60, y)), ((x + 30, y), (x + 60, y))]), nearer=True)
    is_home(hands, page.get_by_role("button", name="Reset the view").tap, home)

    def flick_and_tap() -> None:
        fingers.drag([((x, y), (x + 60, y))])
        page.get_by_role("button", name="Reset the view").tap()

    # The tap after a flick is not ignored.
    is_turn(hands, lambda: fingers.drag([((x, y), (x, y + 40))]))
    is_home(hands, flick_and_tap, home)

    # The looks: by mouse, by touch, by digit.
    for choose, name in ((lambda: page.locator("[data-preset=bone]").click(), "bone"), (lambda: page.locator("[data-preset=muscle]").tap(), "muscle"),
                         (lambda: page.keyboard.press("1"), "skin"), (lambda: page.keyboard.press("6"), "airways")):
        old = hands.picture()
        hands.act(choose)
        expect(page.locator(f"[data-preset={name}]")).to_have_attribute("aria-pressed", "true")
        assert difference(old, hands.picture()) > 2
    # The other tools.
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    canvas.focus()
    page.keyboard.press("f")
    page.wait_for_function("document.fullscreenElement !== null")
    page.keyboard.press("f")
    page.wait_for_function("document.fullscreenElement === null")


def epoch_of(page: Page) -> tuple[int, int]:
    now = facts(page)
    return now.epoch, now.input_seq


def answered(hands: Hands, what: str, deed: Callable[[], None]) -> None:
    """Waits for a picture of another scene, which shows that the renderer accepted it."""
    epoch, seq = epoch_of(hands.page)
    deed()

    def came() -> bool:
        hands.page.wait_for_timeout(20)
        now = facts(hands.page)
        return now.epoch > epoch and now.input_seq > seq

    hands.stack.wait_until(came, timeout=120, what=f"the picture after {what}")


#: Controls that do not change the scene: handles in the picture, scale of the histogram, size of a moving picture.
NO_PICTURE = {"Keep showing the handles when this window is closed", "Histogram scale", "Resolution while moving"}


def work_all(hands: Hands, way: Mouse, frame: Locator) -> list[str]:
    """Uses each slider, switch, choice and colour of a window. Returns their names."""
    worked: list[str] = []
    while frame.locator("details:not([open]) > summary").count():
        way.press(frame.locator("details:not([open]) > summary").first)
    for label in frame.get_by_role("slider").evaluate_all("(all) => all.map((e) => e.getAttribute('aria-label'))"):
        slider = frame.get_by_role("slider", name=label, exact=True)
        if slider.count() == 1:
            before = slider.get_attribute("aria-valuetext")
            answered(hands, label, lambda: way.slide(slider))
            assert slider.get_attribute("aria-valuetext") != before, label
            worked.append(label)
    for label in frame.locator("input[type=color]").evaluate_all("(all) => all.map((e) => e.labels[0].textContent)"):
        colour = frame.get_by_label(label, exact=True)
        answered(hands, label, lambda: colour.fill("#3aa06c"))  # the system's own dialog chooses it
        worked.append(label)
    for label in frame.locator("select.choice").evaluate_all("(all) => all.map((e) => e.labels[0].querySelector('.control-name').textContent)"):
        choice = frame.locator("label.control", has=frame.get_by_text(label, exact=True)).locator("select")
        if label in NO_PICTURE or choice.count() != 1:
            continue
        others = [one for one in choice.locator("option").evaluate_all("(options) => options.map((o) => o.value)") if one != choice.input_value()]
        answered(hands, label, lambda: way.choose(choice, others[0]))
        worked.append(label)
    for label in frame.get_by_role("checkbox").evaluate_all("(all) => all.map((e) => e.getAttribute('aria-label') ?? e.labels[0].textContent)"):
        box = frame.get_by_role("checkbox", name=label, exact=True)
        if label in NO_PICTURE or box.count() != 1:
            continue
        answered(hands, label, lambda: way.switch(box))
        answered(hands, f"{label}, back", lambda: way.switch(box))
        worked.append(label)
    return worked


def press_all(hands: Hands, way: Mouse, frame: Locator, names: list[str]) -> None:
    for name in names:
        answered(hands, name, lambda: way.press(frame.get_by_role("button", name=name, exact=True).first))


def work_graph(hands: Hands, way: Mouse, frame: Locator) -> None:
    graph = frame.get_by_role("application")
    graph.scroll_into_view_if_needed()
    if way.name == "keys":
        graph.focus()
        for key in ("Insert", "ArrowRight", "Shift+ArrowDown", "Delete"):
            answered(hands, f"{key} in the graph", lambda: hands.page.keyboard.press(key))
        return
    points = int(graph.get_attribute("data-points"))
    chosen = graph.locator(".graph-point").nth(points // 2)
    answered(hands, "a point dragged", lambda: way.drag(middle(chosen.bounding_box()), 6, 14))
    box = graph.bounding_box()
    x, y = box["x"] + 0.04 * box["width"], box["y"] + 0.3 * box["height"]
    double = hands.page.mouse.dblclick if way.name == "mouse" else lambda x, y: [hands.page.touchscreen.tap(x, y) for _ in range(2)]
    answered(hands, "a point added", lambda: double(x, y))
    expect(graph).to_have_attribute("data-points", str(points + 1))
    press_all(hands, way, frame, ["Delete point"])


def work_ball(hands: Hands, way: Mouse, frame: Locator) -> None:
    ball = frame.locator(".ball")
    ball.scroll_into_view_if_needed()
    if way.name == "keys":
        ball.focus()
        answered(hands, "the ball", lambda: hands.page.keyboard.press("Shift+ArrowLeft"))
        return
    answered(hands, "the ball", lambda: way.drag(middle(ball.locator(".ball-dot").bounding_box()), -12, 8))


def work_place(hands: Hands, way: Mouse, frame: Locator) -> None:
    """Moves the window itself, and docks it again."""
    head, before = frame.locator("h2"), frame.bounding_box()
    if way.name == "keys":
        frame.locator(".window-grip").focus()
        for _ in range(4):
            hands.page.keyboard.press("ArrowRight")
    else:
        way.drag(middle(head.bounding_box()), 120, 30)
    moved = frame.bounding_box()
    assert moved["x"] - before["x"] > 60, (before, moved)
    way.press(frame.get_by_role("button", name="at the side"))
    expect(frame.get_by_role("button", name="at the side")).to_have_count(0)
    assert abs(frame.bounding_box()["x"] - before["x"]) < 1


def type_nonsense(hands: Hands, frame: Locator) -> None:
    """Numbers out of range, text and pasted junk are refused with a message, and nothing changes."""
    scene = hands.kept()[0]
    for field in frame.locator(".typed input").all():
        shown = field.input_value()
        for junk in ("1e99", "-1e99", "NaN", "12px", "<script>" * 500):
            field.fill("")
            field.focus()
            hands.page.keyboard.insert_text(junk)
            field.press("Enter")
            expect(frame.get_by_role("alert")).to_contain_text("Enter a value between")
        field.press("Escape")
        expect(frame.get_by_role("alert")).to_have_count(0)
        assert field.input_value() == shown
    assert hands.kept()[0] == scene


def close(way: Mouse, frame: Locator, name: str) -> None:
    if way.name == "keys":
        frame.focus()
        frame.page.keyboard.press("Escape")
    else:
        way.press(frame.get_by_role("button", name=f"Close {name}"))
    expect(frame).to_have_count(0)


def test_every_control_of_the_page_changes_the_scene_and_can_be_undone(fake, visit, pictures: Path):
    """The fake server accepts every scene. The next test asks the renderer."""
    page = visit(small=True)
    page.request.post(f"{fake.url}/v1/sign-in")
    scans = page.request.get(f"{fake.url}/v1/data-sets").json()["items"]
    work_every_control(open_scan(fake, page, next(scan["id"] for scan in scans if scan["state"] == "ready"), 720, 440), "mouse", pictures)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["mouse", "keys", "touch"])
def test_every_control_changes_the_picture_and_can_be_undone(stack: TestStack, visit, cranium: Path, pictures: Path, name: str):
    page = visit(small=True, touch=name == "touch")
    work_every_control(open_viewer(stack, page, cranium, name, 720, 440), name, pictures)


def work_every_control(hands: Hands, name: str, pictures: Path) -> None:
    page, way = hands.page, WAYS[name](hands.page)
    way.press(page.get_by_role("button", name="Hide the tips"))
    begun, first = hands.kept()[0], hands.picture()
    worked: dict[str, list[str]] = {}
    for which, title in WINDOWS.items():
        way.press(page.get_by_role("button", name=title, exact=True))
        frame = page.get_by_role("dialog", name=title, exact=True)
        expect(frame).to_be_focused()
        if which == "look":
            work_graph(hands, way, frame)
            press_all(hands, way, frame, ["Add point", "Delete point", "Add material"])
        elif which == "light":
            work_ball(hands, way, frame)
        elif which == "cuts":
            way.press(frame.get_by_text("Planes", exact=True))
            press_all(hands, way, frame, ["Add plane"])
            for plane in ("axial", "coronal", "sagittal"):
                answered(hands, plane, lambda: way.switch(frame.get_by_label(f"Show the {plane} slice")))
        elif which == "lens":
            answered(hands, "the focus", lambda: way.switch(frame.get_by_label("Focus on the centre")))
        worked[which] = work_all(hands, way, frame)
        if which == "look":
            press_all(hands, way, frame, ["Remove Material 2" if frame.get_by_role("button", name="Remove Material 2").count() else
                                          frame.get_by_role("button", name="Remove ").last.text_content()])
        elif which == "light":
            press_all(hands, way, frame, ["Ring", "None"])
            answered(hands, "a light removed", lambda: way.press(frame.get_by_role("button", name="Remove ").last))
        elif which == "cuts":
            press_all(hands, way, frame, ["Remove plane 1"])
        if name == "keys":
            type_nonsense(hands, frame)
        work_place(hands, way, frame)
        page.screenshot(path=pictures / f"by-{name}-{which}.png")
        press_all(hands, way, frame, [RESETS[which]])
        close(way, frame, title)
    for which, least in {"look": 11, "light": 10, "lens": 8, "cuts": 19}.items():
        assert len(worked[which]) >= least, worked[which]
    undo = page.get_by_role("button", name="Undo", exact=True)
    redo = page.get_by_role("button", name="Redo", exact=True)
    hands.settle()
    last = hands.kept()[0]
    step = (lambda: page.keyboard.press("Control+z")) if name == "keys" else lambda: way.press(undo)
    steps = 0
    while undo.get_attribute("aria-disabled") == "false":
        step()
        steps += 1
    hands.settle()
    assert hands.kept()[0] == begun
    assert difference(first, hands.picture()) < ALIKE
    for _ in range(steps):
        page.keyboard.press("Control+Shift+z") if name == "keys" else way.press(redo)
    hands.settle()
    assert hands.kept()[0] == last
