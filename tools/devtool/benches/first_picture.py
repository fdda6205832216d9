"""From an input to the first picture that shows it, and to an error of 5%, end to end: edge, gateway, worker and back."""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path

from ..bench import Result, percentile, result
from ..bench_client import Person, Viewer, cranium
from ..bench_stack import running

ABOUT = "time from an input to its first picture (p50, p95) while rendering continues, and from the end of a gesture to 5%"
SIZE = 512
SETTLED = 0.05


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
        large = person.viewer(data_set, 1280, 720)
        large.frame()
        looks = large.config.presets[:1 if quick else 3]
        settled = {look.name: [_settle(large, _turned(look.scene, 20 * turn)) for turn in range(2 if quick else 3)] for look in looks}
        large.close()
    return [*(result(f"5% after a gesture, 1280 x 720, look {name} ({engine})", times, "s") for name, times in settled.items()),
            result(f"first picture after opening ({engine})", [opening], "ms"),
            result(f"first picture after input, p50 ({engine})", [percentile(b, 50) for b in blocks], "ms"),
            result(f"first picture after input, p95 ({engine})", [percentile(b, 95) for b in blocks], "ms"),
            result(f"first picture after a change at rest, p50 ({engine})", [percentile(b, 50) for b in changes], "ms", at_most=100),
            result(f"first picture after a change at rest, p95 ({engine})", [percentile(b, 95) for b in changes], "ms")]


def _turn(viewer: Viewer, number: int) -> float:
    """Turns the camera by some degrees during rendering."""
    _watch(viewer, 0.2)
    return _answer(viewer, _turned(viewer.config.scene, 3 * (number + 1)))


def _turned(scene, degrees: float):
    """Returns the scene seen by a camera that was turned around the vertical axis."""
    turned = type(scene)()
    turned.CopyFrom(scene)
    angle, eye, target = math.radians(degrees), turned.camera.eye, turned.camera.target
    x, y = eye.x - target.x, eye.y - target.y
    eye.x = target.x + x * math.cos(angle) - y * math.sin(angle)
    eye.y = target.y + x * math.sin(angle) + y * math.cos(angle)
    return turned


def _change(viewer: Viewer, number: int) -> float:
    """Chooses a look, as with one press of a button."""
    _watch(viewer, 0.5)
    looks = viewer.config.presets
    return _answer(viewer, looks[number % len(looks)].scene, rest=True)


def _settle(viewer: Viewer, scene) -> float:
    """Returns the seconds from the end of a gesture to a picture with a known error of at most 5%."""
    begin = time.monotonic()
    sequence = viewer.send_scene(scene, rest=True)
    while True:
        frame = viewer.frame(timeout=120)
        if frame.input_seq >= sequence and frame.width == 1280 and frame.error <= SETTLED:
            return time.monotonic() - begin


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
