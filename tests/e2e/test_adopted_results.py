"""The results of studies in the page: the analysis, and what an administrator or a researcher adopts from it."""

from __future__ import annotations

import csv
import io
import math
import re
import secrets
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from person import POST, Person
from picture import wait_for_samples
from test_every_page import faults, zoomed_faults
from test_in_picture import open_scan
from test_studies import EXPORT, composed, live
from test_tour import RECORD, Camera, sent_cameras

#: The colours of the published study, and what participants changed on average, of 255. No two of them changed the same.
BEFORE = {"bone": "#e8ba94", "muscle": "#fb0404"}
CHANGES = {"bone": (-24, 25, 37), "muscle": (-36, 40, 49)}
PARTICIPANTS = 16


def answers_come(stack: TestStack, link: str, definition: dict, value_of: Callable[[dict, int], dict[str, Any]], participants: int = PARTICIPANTS) -> None:
    """Lets participants take part without a page. `value_of` returns the answer to a step."""
    with httpx.Client(base_url=stack.url, timeout=30) as http:
        for number in range(participants):
            def send(what: str, key: str = secrets.token_hex(32), **body) -> None:  # noqa: B008
                answer = http.post(f"/v1/study/{what}", json={"key": key, **body})
                assert answer.status_code < 300, answer.text
            send("participants", token=link.split("#")[1], language=("en", "de")[number % 2], record=False)
            for sequence, step in enumerate(definition["steps"], 1):
                if step["kind"] != "consent":
                    value = {"words": ""} if step["kind"] == "words" else value_of(step, number)
                    send("answers", step=step["id"], value=value, duration_ms=1500, sequence=sequence)
            send("finish")


def comfort_value(step: dict, number: int) -> dict[str, Any]:
    if step["kind"] == "rating":
        return {"rating": number % 9}
    return {"colours": [changed(one["channel"], number) for one in step["materials"]]} if step["kind"] == "colours" else {}


def changed(channel: str, number: int) -> dict:
    """Returns the colours of a material before and after its change by a participant."""
    before = bytes.fromhex(BEFORE[channel][1:])
    own = (7 * number % 11 - 5, 5 * number % 13 - 6, 3 * number % 7 - 3)
    after = bytes(sum(one) for one in zip(before, CHANGES[channel], own, strict=True))
    return {"channel": channel, "from": BEFORE[channel], "to": f"#{after.hex()}"}


def test_a_study_is_analysed_adopted_and_exported(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True, reduced_motion="reduce")
    person = Person.arrives(stack, page, "researcher")
    person.has_scan(cranium, "Head")
    stack.psql("UPDATE users SET is_researcher = true WHERE email = %s", person.email)
    study = composed(page, stack.url, pictures, "muscle", "muscle").rsplit("/", 1)[1]
    link = opens(page)
    answers_come(stack, link, page.evaluate(EXPORT, f"/v1/studies/{study}/export?format=json")["study"]["definition"], comfort_value)

    page.reload()
    analyse(page)
    expect(page.get_by_role("table", name=re.compile("^Table 1"))).to_contain_text("Bone")
    figures = page.locator("figure img")
    stack.wait_until(lambda: figures.evaluate_all("(all) => all.length > 0 && all.every((one) => one.complete && one.naturalWidth > 0)"),
                     what="the figures")
    page.screenshot(path=pictures / "study-analysis.png", full_page=True)
    assert faults(page) + zoomed_faults(page) == []
    adopt = page.get_by_role("button", name="Use these colours for “Softer colours”")
    expect(adopt).to_have_count(0)    # only for administrators
    with page.expect_download() as download:
        page.get_by_role("link", name="Export as CSV").click()
    with zipfile.ZipFile(download.value.path()) as files:
        rows = list(csv.DictReader(io.StringIO(files.read("answers.csv").decode("utf-8-sig"))))
    assert {int(row["participant"]) for row in rows} == set(range(1, PARTICIPANTS + 1)), rows[0]

    person.becomes_administrator()
    page.reload()
    analyse(page)
    before = page.evaluate(EXPORT, "/v1/perception")
    adopt.click()
    expect(page.get_by_text("“Softer colours” now uses the colours of this study.")).to_be_visible()
    adopted = page.evaluate(EXPORT, "/v1/perception")
    assert adopted != before
    page.get_by_role("button", name="Use the published colours again").click()
    stack.wait_until(lambda: page.evaluate(EXPORT, "/v1/perception") == before, what="the published colours")


def opens(page: Page) -> str:
    """Opens the study on the page and returns the link for participants."""
    page.get_by_role("button", name="Open study").click()
    expect(page.get_by_text("The study is open.")).to_be_visible()
    page.get_by_role("button", name="Create link").click()
    return page.get_by_label("Link for participants").input_value()


def analyse(page: Page, heading: str = "Comfort") -> None:
    page.get_by_role("button", name="Analyse").click()
    expect(page.get_by_role("heading", name=heading, exact=True)).to_be_visible(timeout=120_000)


#: Three directions from which participants look, in the axes left, back and up, and how many of them look from each.
DIRECTIONS = ((0.0, -1.0, 0.1), (0.98, 0.0, 0.2), (-0.6, 0.7, 0.4))
EACH = 8


def view_value(step: dict, number: int) -> dict[str, Any]:
    """Returns a view near one of the directions, looking at what the study's own view looks at."""
    if step["kind"] != "viewpoint":
        return {}
    camera = step["view"]["scene"]["camera"]
    eye, target = ([camera[part].get(axis, 0.0) for axis in "xyz"] for part in ("eye", "target"))
    direction = [value + 0.05 * math.sin(5 * number + axis) for axis, value in enumerate(DIRECTIONS[number % len(DIRECTIONS)])]
    distance = math.dist(eye, target) / math.hypot(*direction)
    chosen = {"eye": [a + distance * b for a, b in zip(target, direction, strict=True)], "target": target, "up": [0, 0, 1]}
    return {"camera": chosen, "start": {"eye": eye, "target": target, "up": [0, 0, 1]}}


def stills_of_tour(page: Page) -> list[Camera]:
    """Plays the tour for a user who prefers reduced motion, and returns the cameras that the page sends."""
    page.emulate_media(reduced_motion="reduce")
    page.evaluate(RECORD)
    page.locator("canvas").focus()
    page.keyboard.press("t")
    line = page.locator(".tour-line")
    expect(line).to_have_attribute("data-tour", "moving")
    expect(line).to_have_count(0)  # shows each view for four seconds, and ends by itself
    return list(sent_cameras(page).values())


def azimuths(cameras: list[Camera]) -> list[float]:
    return [math.degrees(math.atan2(*(a - b for a, b in list(zip(one.eye, one.target, strict=True))[1::-1]))) for one in cameras]


def test_the_tour_of_a_study_is_adopted_shown_to_everyone_and_removed(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True, reduced_motion="reduce")
    person = Person.arrives(stack, page, "guide")
    scan = person.has_scan(cranium, "Head")
    stack.psql("UPDATE users SET is_researcher = true WHERE email = %s", person.email)
    page.goto(stack.url + "/studies/viewpoints")
    page.get_by_role("button", name="Choose picture").click()
    live(page)
    page.get_by_role("button", name="Use this picture").click()
    page.get_by_role("button", name="Save study").click()
    expect(page.get_by_text("The study is saved.")).to_be_visible()
    link, study = opens(page), page.url.rsplit("/", 1)[1]
    definition = page.evaluate(EXPORT, f"/v1/studies/{study}/export?format=json")["study"]["definition"]
    answers_come(stack, link, definition, view_value, EACH * len(DIRECTIONS))
    page.reload()
    analyse(page, "Views: the whole scan")
    adopt = page.get_by_role("button", name="Use these views of “the whole scan” for “Show me around”")
    page.screenshot(path=pictures / "study-tour.png", full_page=True)
    assert faults(page) + zoomed_faults(page) == []
    adopt.click()
    expect(page.get_by_text("“Show me around” now uses the views of this study.")).to_be_visible()

    views = page.evaluate(EXPORT, f"/v1/data-sets/{scan}/tour")["tour"]["views"]
    assert len(views) == len(DIRECTIONS)
    expected = [math.degrees(math.atan2(view["eye"][1] - view["target"][1], view["eye"][0] - view["target"][0])) for view in views]
    planted = sorted(math.degrees(math.atan2(y, x)) for x, y, _ in DIRECTIONS)
    # Each coordinate of a unit direction is off by at most 0.05, so the centre of a cluster by less than 0.05 / 0.6 radians.
    assert sorted(expected) == pytest.approx(planted, abs=5)

    visitor = visit(small=True)
    link = page.evaluate(POST, [f"/v1/data-sets/{scan}/links", {"hours": 1}])
    visitor.goto(f"{stack.url}/shared#{link['token']}")
    visitor.get_by_role("button", name="View the scan").click()
    wait_for_samples(stack, visitor, 1)
    visitor.get_by_role("button", name="Hide the tips").click()
    check_tour(azimuths(stills_of_tour(visitor)), expected)
    visitor.screenshot(path=pictures / "tour-of-study-visitor.png")

    hands = open_scan(stack, page, scan, 900, 640)
    page.get_by_role("button", name="Hide the tips").click()
    window = hands.window("Views")
    expect(window).to_contain_text(f"{EACH * len(DIRECTIONS)} participants of the study")
    page.screenshot(path=pictures / "tour-of-study.png")
    window.get_by_role("button", name="Use computed views again").click()
    expect(window).to_contain_text("The tour uses computed views again.")
    expect(window).to_contain_text("the views that show most of your scan")
    assert page.evaluate(EXPORT, f"/v1/data-sets/{scan}/tour") == {"tour": None}


def check_tour(shown: list[float], expected: list[float]) -> None:
    """The tour begins at one of the views, passes the others in their order and returns to the first."""
    first = min(range(len(expected)), key=lambda one: abs(math.remainder(expected[one] - shown[0], 360)))
    order = [expected[(first + i) % len(expected)] for i in range(len(expected) + 1)]
    assert [math.remainder(a - b, 360) for a, b in zip(shown, order, strict=True)] == pytest.approx([0.0] * len(order), abs=0.01)
