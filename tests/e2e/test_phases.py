"""A scan with phases: choosing and playing them with the renderer of the stack."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
from harness import TestStack
from person import Person
from picture import wait_for_picture, wait_for_samples
from playwright.sync_api import Page, expect
from test_take_away import wait_for_sessions
from test_videos import (  # noqa: F401
    ask_for_ten_frames,
    expect_plain_video,
    frame,
    marked,
    middle,
    saved_video,
    taking,
)

PHASES = 6
#: Records the input and the phase of each picture that is shown.
RECORD = """() => {
    window.shown = [];
    const canvas = document.querySelector("canvas");
    const note = () => window.shown.push([Number(canvas.dataset.inputSeq), Number(canvas.dataset.phase)]);
    new MutationObserver(note).observe(canvas, { attributeFilter: ["data-epoch"] });
}"""


def give_phases(stack: TestStack, scan: str) -> None:
    """Makes the stored scan one of several phases of a heartbeat, whose bone becomes less dense."""
    folder = stack.data_dir / "volumes" / scan
    header = json.loads((folder / "volume.json").read_text(encoding="utf-8"))
    header["phases"] = [{"kind": "CYCLE", "value": 100 * phase / PHASES} for phase in range(PHASES)]
    first = np.frombuffer((folder / "voxels.i16").read_bytes(), "<i2")
    with (folder / "voxels.i16").open("r+b") as file:
        for phase in range(PHASES):
            file.write(np.where(first > 200, first - 20 * phase, first).astype("<i2").tobytes())
    with (folder / "volume.json").open("r+", encoding="utf-8") as file:
        file.write(json.dumps(header))
        file.truncate()


def give_mirrored_phases(stack: TestStack, scan: str, columns: int) -> None:
    """Gives the stored scan two phases. The second one has left and right exchanged."""
    folder = stack.data_dir / "volumes" / scan
    header = json.loads((folder / "volume.json").read_text(encoding="utf-8"))
    header["phases"] = [{"kind": "TIME", "value": value} for value in (0, 500)]
    first = np.frombuffer((folder / "voxels.i16").read_bytes(), "<i2").reshape(-1, columns)
    with (folder / "voxels.i16").open("r+b") as file:
        file.write(first.tobytes() + first[:, ::-1].tobytes())
    with (folder / "volume.json").open("r+", encoding="utf-8") as file:
        file.write(json.dumps(header))
        file.truncate()


def shown_phase(page: Page) -> int:
    return int(page.locator("canvas[data-phase]").first.get_attribute("data-phase"))


def test_phases_are_chosen_and_played_and_refine_when_paused(stack: TestStack, visit, cranium: Path, pictures: Path):
    page = visit(small=True)
    person = Person.arrives(stack, page, "phases")
    scan = person.has_scan(cranium, "Heart")
    give_phases(stack, scan)
    page.goto(f"{stack.url}/view/{scan}")
    wait_for_samples(stack, page, 1)
    page.get_by_role("button", name="Hide the tips").click()
    line = page.get_by_role("region", name="Phases of the scan")
    expect(line).to_contain_text("0 %")
    expect(line.get_by_role("status")).to_have_count(0)    # all phases are loaded
    page.wait_for_timeout(500)
    assert shown_phase(page) == 0, "playing never starts by itself"

    line.get_by_label("Phase", exact=True).fill("3")
    stack.wait_until(lambda: shown_phase(page) == 3, what="the chosen phase")
    expect(line).to_contain_text("50 %")
    page.keyboard.press(".")
    stack.wait_until(lambda: shown_phase(page) == 4, what="the next phase")

    page.evaluate(RECORD)
    page.keyboard.press("k")
    expect(line.get_by_role("button", name="Pause")).to_be_visible()
    seen = stack.wait_until(lambda: len({phase for _, phase in page.evaluate("window.shown")}) >= 4 and page.evaluate("window.shown"),
                            timeout=120, what="four different phases")
    page.screenshot(path=pictures / "phases-playing.png")
    line.get_by_role("button", name="Pause").click()
    inputs = [number for number, _ in seen]
    assert inputs == sorted(inputs), "a phase came after a later one"
    changes = [phase for i, (_, phase) in enumerate(seen) if i == 0 or phase != seen[i - 1][1]]
    assert len(changes) >= 4

    chosen = int(line.get_by_label("Phase", exact=True).input_value())
    stack.wait_until(lambda: shown_phase(page) == chosen, what="the phase at which it was paused")
    wait_for_samples(stack, page, 8)
    assert shown_phase(page) == chosen, "it stays paused"
    expect(page.get_by_role("button", name="Undo", exact=True)).to_have_attribute("aria-disabled", "true")    # neither choosing nor playing is an edit
    page.screenshot(path=pictures / "phases-paused.png")


def test_a_video_plays_the_phases(stack: TestStack, visit, marked: Path, pictures: Path, tmp_path: Path):  # noqa: F811
    page = visit(small=True)
    person = Person.arrives(stack, page, "phasefilm")
    scan = person.has_scan(marked, "Ball")
    header = json.loads((stack.data_dir / "volumes" / scan / "volume.json").read_text(encoding="utf-8"))
    give_mirrored_phases(stack, scan, header["size"][0])
    page.goto(f"{stack.url}/view/{scan}")
    page.get_by_role("button", name="Bone", exact=True).click()
    wait_for_picture(stack, page, input_seq=1)

    dialog = taking(page, "phases")
    dialog.get_by_label("How often the phases are played").fill("2")
    ask_for_ten_frames(dialog)
    page.screenshot(path=pictures / "phases-video-dialog.png")
    video = saved_video(stack, page, dialog, tmp_path)
    width, height = expect_plain_video(video, frames=10, rate=10, seconds=1)
    seen = [middle(frame(video, number, width, height)) for number in range(10)]
    # Two cycles of two phases: the ball changes sides three times, and the camera stands still.
    sides = [place > 0 for place in seen]
    assert sum(a != b for a, b in itertools.pairwise(sides)) == 3 and all(abs(place) > 0.05 for place in seen), seen
    wait_for_sessions(stack, page, 1)
