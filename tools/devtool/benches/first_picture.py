"""From an input to the first picture that shows it, end to end: edge, gateway, worker and back."""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path

from ..bench import Result, percentile, result
from ..bench_client import Person, Viewer, cranium
from ..bench_stack import running

ABOUT = "time from an input to its first picture (p50, p95) while rendering continues"
SIZE = 512


def measure(quick: bool) -> list[Result]:
    with running() as stack, tempfile.TemporaryDirectory() as folder:
        person = Person(stack)
        data_set = person.upload(cranium(stack, Path(folder)))
        person.wait_ready(data_set)
        begin = time.monotonic()
        viewer = person.viewer(data_set, SIZE, SIZE)
        viewer.frame()
        opening = 1e3 * (time.monotonic() - begin)
        inputs = 10 if quick else 40
        blocks = [[_turn(viewer, block * inputs + number) for number in range(inputs)] for block in range(3)]
        changes = [[_change(viewer, block * inputs + number) for number in range(inputs)] for block in range(3)]
        engine = viewer.config.engine
        viewer.close()
    return [result(f"first picture after opening ({engine})", [opening], "ms"),
            result(f"first picture after input, p50 ({engine})", [percentile(b, 50) for b in blocks], "ms"),
            result(f"first picture after input, p95 ({engine})", [percentile(b, 95) for b in blocks], "ms"),
            result(f"first picture after a change at rest, p50 ({engine})", [percentile(b, 50) for b in changes], "ms", at_most=100),
            result(f"first picture after a change at rest, p95 ({engine})", [percentile(b, 95) for b in changes], "ms")]


def _turn(viewer: Viewer, number: int) -> float:
    """Turns the camera by some degrees during rendering."""
    _watch(viewer, 0.2)
    scene = type(viewer.config.scene)()
    scene.CopyFrom(viewer.config.scene)
    angle = math.radians(3 * (number + 1))
    x, y = scene.camera.eye.x - scene.camera.target.x, scene.camera.eye.y - scene.camera.target.y
    scene.camera.eye.x = scene.camera.target.x + x * math.cos(angle) - y * math.sin(angle)
    scene.camera.eye.y = scene.camera.target.y + x * math.sin(angle) + y * math.cos(angle)
    return _answer(viewer, scene)


def _change(viewer: Viewer, number: int) -> float:
    """Chooses a look, as with one press of a button."""
    _watch(viewer, 0.5)
    looks = viewer.config.presets
    return _answer(viewer, looks[number % len(looks)].scene, rest=True)


def _watch(viewer: Viewer, seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        viewer.frame()


def _answer(viewer: Viewer, scene, rest: bool = False) -> float:
    """Returns the milliseconds until a picture shows the scene."""
    begin = time.monotonic()
    sequence = viewer.send_scene(scene, rest)
    while viewer.frame().input_seq < sequence:
        pass
    return 1e3 * (time.monotonic() - begin)
