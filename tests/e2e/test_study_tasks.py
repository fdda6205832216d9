"""The latency task of a study with the real programs, and the recording of how a participant moves the picture."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from harness import TestStack
from person import Person
from test_every_page import faults
from test_studies import EXPORT, agree, live, sent_answers

DELAYS = [0, 150, 400]
#: A larger body needs the participant's key in a header, which the edge checks (docs/bounds.md).
LARGE = 16 * 1024
#: Changes of the view in the first trial, each of which takes more than 150 bytes of a recording.
PRESSES = 120


def composes_latency_study(stack: TestStack, page: Page, cranium: Path) -> str:
    """Composes and opens the latency study with recordings, and returns its link."""
    person = Person.arrives(stack, page, "latency")
    person.has_scan(cranium, "Head")
    stack.psql("UPDATE users SET is_researcher = true WHERE email = %s", person.email)
    page.goto(stack.url + "/studies/latency")
    page.get_by_label("Ask participants whether their movements of the picture may be recorded").check()
    page.get_by_label("Delays").fill(", ".join(map(str, DELAYS)))
    page.get_by_role("button", name="Choose picture").click()
    live(page)
    page.get_by_label("Highlight a part").check()
    page.get_by_role("button", name="Mark in the picture").click()
    page.keyboard.press("Enter")  # the middle of the picture
    expect(page.locator(".picker")).to_have_count(0)
    page.get_by_label("Name of the part (English)").fill("Forehead")
    page.get_by_role("button", name="Use this picture").click()
    page.get_by_role("button", name="Save study").click()
    expect(page.get_by_text("The study is saved.")).to_be_visible()
    page.get_by_role("button", name="Open study").click()
    expect(page.get_by_text("The study is open.")).to_be_visible()
    page.get_by_role("button", name="Create link").click()
    return page.get_by_label("Link for participants").input_value()


def does_trial(page: Page, number: int, presses: int) -> None:
    """Turns the picture by keys once its first view is shown, and rates the delay."""
    expect(page.get_by_text(f"Task {number} of {len(DELAYS)}")).to_be_visible()
    page.get_by_role("button", name="Start", exact=True).click()
    faces = page.get_by_role("button", name="It faces me")
    expect(faces).to_be_visible(timeout=120_000)  # begins with the first picture of the trial, after its delay
    live(page)
    page.locator("canvas").focus()
    for _ in range(presses):
        page.keyboard.press("ArrowLeft")
    assert faults(page) == []
    faces.click()
    page.get_by_label("Yes", exact=True).check()
    page.get_by_label("8", exact=True).check()
    page.get_by_role("button", name="Continue").click()


def test_a_participant_does_the_latency_task_and_a_large_recording_arrives_whole(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(wide=True, reduced_motion="reduce")
    link, study = composes_latency_study(stack, page, cranium), page.url.rsplit("/", 1)[1]
    participant = visit()
    answers = sent_answers(participant)
    recorded: list[dict] = []
    participant.on("response", lambda response: recorded.append(json.loads(response.request.post_data))
                   if response.url.endswith("/v1/study/recordings") and response.ok else None)
    participant.goto(link)
    participant.get_by_label("Yes, record how I move the picture").check()
    agree(participant)  # the picture is covered until a trial starts
    for number, presses in ((1, PRESSES), (2, 3), (3, 3)):
        does_trial(participant, number, presses)
    participant.screenshot(path=pictures / "study-latency.png")
    participant.get_by_label("Your answer").fill("It felt quick.")
    participant.get_by_role("button", name="Continue").click()
    expect(participant.get_by_role("heading", name="Thank you for taking part")).to_be_visible()

    trials = answers[0]["value"]["trials"]
    assert sorted(one["delay_ms"] for one in trials) == DELAYS
    assert all(one["time_ms"] > 0 and 0 <= one["error_degrees"] <= 180 and one["acceptable"] and one["rating"] == 8 for one in trials)
    stack.wait_until(lambda: recorded or participant.wait_for_timeout(50), what="the recording")
    export = page.evaluate(EXPORT, f"/v1/studies/{study}/export?format=json")
    one = export["participants"][0]
    assert one["state"] == "finished" and one["answers"][0]["value"]["trials"] == [pytest.approx(trial) for trial in trials]
    kept = one["recordings"]
    assert [recording["step"] for recording in kept] == [sent["step"] for sent in recorded]
    for recording, sent in zip(kept, recorded, strict=True):
        assert eyes(recording) == pytest.approx(eyes(sent["recording"]))
        assert [event["at_ms"] for event in recording["events"]] == [event["at_ms"] for event in sent["recording"]["events"]]
    assert max(len(json.dumps(sent)) for sent in recorded) > LARGE
    assert sum(len(recording["events"]) for recording in kept) > PRESSES


def eyes(recording: dict) -> list[float]:
    """Returns the coordinates of the cameras of a recording. The server writes its numbers in another form."""
    cameras = [event.get("camera") or event["scene"]["camera"] for event in recording["events"]]
    return [camera["eye"].get(axis, 0.0) for camera in cameras for axis in "xyz"]
