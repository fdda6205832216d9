"""./diaphane replay: how recordings are read, and invalid ones refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from devtool import replay
from devtool.console import CliError


def recording(*events: dict, **more) -> dict:
    return {"format": "diaphane-interaction", "version": 1, "viewport": {"width": 64, "height": 64}, "events": list(events), **more}


def written(folder: Path, document: object) -> Path:
    file = folder / "interaction.json"
    file.write_text(json.dumps(document))
    return file


def test_a_camera_event_changes_only_the_camera_of_the_last_scene(tmp_path):
    document = replay.read(written(tmp_path, recording(
        {"at_ms": 0, "scene": {"camera": {"eye": {"x": 1}}, "phase": {}}},
        {"at_ms": 16, "camera": {"eye": {"x": 2}}},
        {"at_ms": 32, "scene": {"camera": {"eye": {"x": 3}}}})))
    assert replay.scenes(document) == [
        (0, {"camera": {"eye": {"x": 1}}, "phase": {}}),
        (16, {"camera": {"eye": {"x": 2}}, "phase": {}}),
        (32, {"camera": {"eye": {"x": 3}}})]


def test_a_frame_shows_the_newest_scene_received():
    played = [(0, {"n": 0}), (40, {"n": 1}), (60, {"n": 2}), (250, {"n": 3})]
    assert [scene["n"] for scene in replay.shown_at(played, 10)] == [0, 2, 2, 3], "the end is shown"
    assert [scene["n"] for scene in replay.shown_at(played, 20)] == [0, 1, 2, 2, 2, 3]


@pytest.mark.parametrize("wrong", [
    [], {"format": "else"}, recording(), recording({"at_ms": 0, "camera": {}}), recording(version=2),
    recording({"at_ms": 0, "scene": {}}, {"at_ms": -1, "camera": {}}),
    recording({"at_ms": 0, "scene": {}}, {"at_ms": 10_001, "camera": {}}),
    recording({"at_ms": 0, "scene": {}}, {"at_ms": 5, "camera": {}, "scene": {}}),
    recording({"at_ms": 0, "scene": {}}, {"at_ms": "5", "camera": {}}),
])
def test_an_invalid_recording_is_refused(tmp_path, wrong):
    with pytest.raises(CliError):
        replay.read(written(tmp_path, wrong))


@pytest.mark.parametrize("link", ["", "http://host/view/x", "file:///join#" + "0" * 64, "http://host/join#123"])
def test_an_invalid_link_is_not_requested(link):
    with pytest.raises(CliError):
        replay.join(link, "Replay")
