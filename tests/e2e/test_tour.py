"""Standard views and "Show me around": which cameras the page sends, and which of them are shown, by mouse, keys and touch."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from picture import ALIKE, difference
from test_controls import Eye
from test_in_picture import open_viewer
from test_settings import Hands

#: Records the messages to the server, and the inputs of the pictures that are shown.
RECORD = """() => {
    window.sentMessages = [], window.shownInputs = [];
    const send = WebSocket.prototype.send;
    WebSocket.prototype.send = function (data) {
        window.sentMessages.push(Array.from(new Uint8Array(data.buffer ?? data)));
        return send.call(this, data);
    };
    const canvas = document.querySelector("canvas");
    new MutationObserver(() => window.shownInputs.push(Number(canvas.dataset.inputSeq)))
        .observe(canvas, { attributeFilter: ["data-input-seq"] });
}"""
#: The largest turn between two pictures that are shown, in degrees.
MOST_TURN = 3
#: The camera crosses the wire as doubles, but the page computes the angle from rotation matrices, where acos loses half the digits.
ROUNDING = 1e-5


def fields(data: bytes) -> Iterator[tuple[int, bytes | int]]:
    """Reads the fields of a protobuf message: numbers and bytes."""
    at = 0

    def varint() -> int:
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(data):
        key = varint()
        if key & 7 == 0:
            yield key >> 3, varint()
            continue
        length = {1: 8, 5: 4}.get(key & 7) or varint()
        yield key >> 3, data[at:at + length]
        at += length


def message(data: bytes) -> dict[int, bytes | int]:
    return dict(fields(data))


@dataclass(frozen=True)
class Camera:
    eye: tuple[float, ...]
    target: tuple[float, ...]
    up: tuple[float, ...]

    def turned(self, other: Camera) -> float:
        """Returns the angle of the rotation between two cameras in degrees."""
        trace = sum(dot(a, b) for a, b in zip(self.axes(), other.axes(), strict=True))
        return math.degrees(math.acos(max(-1, min(1, (trace - 1) / 2))))

    def axes(self) -> tuple[tuple[float, ...], ...]:
        back = unit(tuple(a - b for a, b in zip(self.eye, self.target, strict=True)))
        right = unit(cross(self.up, back))
        return right, cross(back, right), back


def dot(a, b) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def unit(a):
    return tuple(x / math.hypot(*a) for x in a)


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def sent_cameras(page: Page) -> dict[int, Camera]:
    """Returns the cameras that the page has sent, by the number of their input."""
    cameras = {}
    for data in page.evaluate("window.sentMessages"):
        update = message(bytes(data)).get(2)
        scene = message(update).get(2) if update else None
        if not scene:
            continue
        parts = message(message(scene)[3])
        vectors = [message(parts[n]) for n in (1, 2, 3)]
        cameras[message(update)[1]] = Camera(*(tuple(struct.unpack("<d", v[n])[0] if n in v else 0.0 for n in (1, 2, 3)) for v in vectors))
    return cameras


def shown_cameras(page: Page) -> list[Camera]:
    """Returns the cameras of the pictures that were shown, in order."""
    cameras = sent_cameras(page)
    return [cameras[number] for number in page.evaluate("window.shownInputs") if number in cameras]


def check_smooth(cameras: list[Camera]) -> None:
    turns = [b.turned(a) for a, b in zip(cameras, cameras[1:])]
    assert max(turns) <= MOST_TURN + ROUNDING, max(turns)


def check_outside(cameras: list[Camera]) -> None:
    """The eye never enters the sphere around the made-up head, which is within 130 mm of the middle (ingest/sample)."""
    distances = [math.hypot(*camera.eye) for camera in cameras]
    assert min(distances) > 200, min(distances)


@pytest.mark.nightly
def test_tour_of_the_sample_on_a_phone_is_smooth_and_stays_outside(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(phone=True)
    hands = open_viewer(stack, page, cranium, "tourist", 390, 844)
    page.get_by_role("button", name="Hide the tips").tap()
    page.evaluate(RECORD)
    page.get_by_role("button", name="Views", exact=True).tap()
    page.screenshot(path=pictures / "views-phone.png")
    page.get_by_role("button", name="Show me around").tap()
    line = page.locator(".tour-line")
    expect(line).to_have_attribute("data-tour", "moving")
    expect(page.get_by_role("dialog", name="Views", exact=True)).to_have_count(0)  # leaves the picture its room
    stack.wait_until(lambda: len(sent_cameras(page)) > 60 or page.wait_for_timeout(200), what="a part of the tour")
    page.screenshot(path=pictures / "tour-phone.png")
    line.get_by_role("button", name="Pause").tap()
    expect(line).to_contain_text("The tour is paused")
    hands.settle()
    paused = Eye(hands)
    page.wait_for_timeout(500)
    assert Eye(hands).turned(paused) < 1e-6
    line.get_by_role("button", name="Continue").tap()
    expect(line).to_have_count(0)  # once around, and it ends by itself
    sent, shown = list(sent_cameras(page).values()), shown_cameras(page)
    check_smooth(sent)
    check_smooth(shown)
    check_outside(sent)
    # The sheet has closed, so the tour ends at the distance at which the whole picture shows the head.
    last, ending = sent[-1], Eye(hands)
    assert math.isclose(math.dist(last.eye, last.target), ending.distance, rel_tol=1e-6)
    azimuths = {round(math.degrees(math.atan2(c.eye[1] - c.target[1], c.eye[0] - c.target[0])) / 30) % 12 for c in sent}
    assert len(azimuths) == 12, azimuths  # all around
    page.screenshot(path=pictures / "tour-end-phone.png")


SIDES = {"A": (0, -1, 0), "P": (0, 1, 0), "L": (1, 0, 0), "R": (-1, 0, 0), "S": (0, 0, 1), "I": (0, 0, -1)}
NAMES = {"A": "Front", "P": "Back", "L": "Patient’s left", "R": "Patient’s right", "S": "Above", "I": "Below"}


def check_side(hands: Hands, letter: str, distance: float) -> None:
    hands.settle()
    eye = Eye(hands)
    towards = sum(a * b for a, b in zip(eye.away, SIDES[letter], strict=True)) / eye.distance
    assert towards > 0.9999 and math.isclose(eye.distance, distance, rel_tol=1e-6), (letter, towards, eye.distance)


@pytest.mark.nightly
def test_standard_views_by_button_key_and_cube_frame_the_subject(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit()
    hands = open_viewer(stack, page, cranium, "sides", 960, 640)
    page.get_by_role("button", name="Hide the tips").click()
    page.locator("canvas").focus()
    home = Eye(hands).distance
    page.evaluate(RECORD)
    for letter in ("A", "R", "I"):
        hands.act(lambda letter=letter: page.keyboard.press(f"Shift+{letter}"))
        check_side(hands, letter, home)
    # Keys move the camera until the cube shows the front. The cube keeps the zoom, and the key frames the subject again.
    hands.act(lambda: [page.keyboard.press(key) for key in ["+"] + ["ArrowDown"] * 8])
    hands.settle()
    zoomed = Eye(hands).distance
    assert zoomed < 0.95 * home, (zoomed, home)
    hands.act(page.get_by_role("button", name="View from the front").click)
    check_side(hands, "A", zoomed)
    page.locator("canvas").focus()
    hands.act(lambda: page.keyboard.press("Shift+A"))
    check_side(hands, "A", home)
    page.emulate_media(reduced_motion="reduce")
    views = hands.window("Views")
    hands.settle()  # the camera has made room for the window
    home = Eye(hands).distance
    for letter in ("P", "L", "S"):
        page.evaluate("window.sentMessages.length = 0")
        hands.act(views.get_by_role("button", name=NAMES[letter], exact=True).click)
        check_side(hands, letter, home)
        assert len(sent_cameras(page)) == 1, "the camera moves although the user prefers reduced motion"
    page.screenshot(path=pictures / "views.png")
    # Tour by keys.
    page.emulate_media(reduced_motion="no-preference")
    page.locator("canvas").focus()
    line = page.locator(".tour-line")
    for end in ("t", "Escape"):
        page.keyboard.press("t")
        expect(line).to_have_attribute("data-tour", "moving")
        page.keyboard.press("p")
        expect(line).to_have_attribute("data-tour", "paused")
        page.screenshot(path=pictures / "tour.png")
        page.keyboard.press(end)
        expect(line).to_have_count(0)
    # A drag stops it, and a video takes its views.
    page.keyboard.press("t")
    expect(line).to_have_attribute("data-tour", "moving")
    page.mouse.move(700, 250)
    page.mouse.down()
    page.mouse.move(720, 260)
    page.mouse.up()
    expect(line).to_have_count(0)
    hands.settle()
    page.keyboard.press("t")
    line.get_by_role("button", name="Save as a video").click()
    expect(page.get_by_label("File type")).to_have_value("around")
    expect(page.get_by_label("Length in seconds")).to_have_value("20")
    page.screenshot(path=pictures / "tour-video.png")


def test_comfort_changes_the_colours_and_stays_with_another_look(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    hands = open_viewer(stack, page, cranium, "gentle", 720, 440)
    page.get_by_role("button", name="Hide the tips").click()
    page.get_by_role("button", name="Muscle").click()
    look = hands.window("Materials")
    hands.type(look, "Softer colours", "2")
    hands.settle()
    softer = hands.picture()
    page.screenshot(path=pictures / "comfort-softer.png")
    expect(page.get_by_role("button", name="Muscle").first).to_have_attribute("aria-pressed", "true")
    hands.type(look, "Softer colours", "-2")
    hands.settle()
    stronger = hands.picture()
    page.screenshot(path=pictures / "comfort-stronger.png")
    # At 4, the colours of blood differ by 84 of 255 in green: far more than two renderings of one view.
    assert difference(softer, stronger) > 2 * ALIKE, difference(softer, stronger)
    look.get_by_role("button", name="Close").click()  # the window has a button of this name, too
    hands.act(page.get_by_role("button", name="Bone", exact=True).click)
    look = hands.window("Materials")
    expect(look.get_by_label("Softer colours (value)")).to_have_value("-2")
    hands.act(look.get_by_role("button", name="Reset the materials").click)
    expect(look.get_by_label("Softer colours (value)")).to_have_value("0")
    look.get_by_role("button", name="Close").click()
    hands.act(page.get_by_role("button", name="Airways").click)
    look = hands.window("Materials")
    expect(look.get_by_label("Softer colours (value)")).to_have_count(0)
