"""From a movement of the mouse to the pixels of the canvas, in Chromium, end to end on one machine.

The worker draws the number of the newest input into each picture (renderd/encode/frame_mark.h). The page's canvas is read back
before each displayed frame (latency_probe.js). The time of an input is the browser's timestamp of the event."""

from __future__ import annotations

import argparse
import math
import os
import random
import re
import statistics
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from .. import chromium, paths
from ..bench import Result, percentile, result
from ..bench_client import Person, cranium
from ..bench_stack import running
from ..console import CliError, say
from ..stack import Stack

ABOUT = "time from a pointer movement to the canvas that shows it, in Chromium at 720p, per codec (p50, p95)"
PAGE = True

WIDTH, HEIGHT = 1280, 720
CODECS = {"H264": 2, "JPEG": 1, "MPEG1": 3}
P50_MS, P95_MS = 25, 60
REPEATS = 3
WARM_UP = 30  # inputs until the worker knows the cost of a picture of this scene


@dataclass(frozen=True)
class Step:
    """The stages of one input in milliseconds. `other` is the rest, which no timestamp divides: sockets, edge, gateway, and waiting in the
    worker."""

    whole: float
    to_send: float
    render: float
    encode: float
    other: float
    decode: float
    present: float

    @property
    def without_render(self) -> float:
        return self.whole - self.render


@dataclass(frozen=True)
class Block:
    """The inputs of one page, and the worker's own mean time from an input to sending its frame."""

    steps: list[Step]
    worker_ms: float

    def values(self, name: str) -> list[float]:
        return [getattr(step, name) for step in self.steps]

    def mean(self, *names: str) -> float:
        return sum(statistics.fmean(self.values(name)) for name in names)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--codec", choices=sorted(CODECS), action="append", help="only this codec (repeatable)")
    parser.add_argument("--inputs", type=int, help=f"number of inputs on each of the {REPEATS} pages per codec (default: 200, with --quick: 60)")
    parser.add_argument("--threads", type=int, default=max(1, (os.cpu_count() or 2) - 1), help="threads of the renderer "
                        "on the CPU; the browser runs on the same machine (default: all cores but one)")
    parser.add_argument("--max-error", default="0.5", help="error at which the worker stops refining; a small "
                        "value keeps its device busy between inputs (default: 0.5, reached by the first pictures)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    from playwright.sync_api import sync_playwright

    inputs = options.inputs or (60 if quick else 200)
    settings = {"DIAPHANE_MARK_FRAMES": "1", "DIAPHANE_MAX_ERROR": options.max_error, "DIAPHANE_THREADS": str(options.threads)}
    with running(**settings) as stack, \
            tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        person = Person(stack)
        data_set = person.upload(cranium(stack, Path(folder)))
        person.wait_ready(data_set)
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        results: list[Result] = []
        for codec in options.codec or CODECS:
            blocks = [_block(browser, stack, person, data_set, codec, inputs, number) for number in range(REPEATS)]
            results += _results(codec, [block for block in blocks if block is not None])
        browser.close()
    if not results:
        raise CliError("no codec could be measured")
    return results


def _block(browser, stack: Stack, person: Person, data_set: str, codec: str, inputs: int, seed: int) -> Block | None:
    """Measures a new page. Returns None if it did not get that codec."""
    from playwright.sync_api import expect

    context = browser.new_context(viewport={"width": WIDTH, "height": HEIGHT})
    try:
        url = stack.settings.url
        context.add_cookies([{"name": c.name, "value": c.value, "url": url} for c in person.http.cookies.jar])
        context.add_init_script(f"localStorage.setItem('diaphane.codecs', '{codec}')")
        for script in ("page_wire.js", "latency_probe.js"):
            context.add_init_script(path=paths.TOOLS / "devtool" / script)
        page = context.new_page()
        page.goto(f"{url}/view/{data_set}")
        page.wait_for_selector("canvas[data-samples]", timeout=120_000)
        # The previews of a scan's presets are rendered once, on the same device.
        page.wait_for_selector(".preset-picture img", timeout=180_000)
        expect(page.locator(".preset-picture:not(:has(img))")).to_have_count(0, timeout=180_000)
        if (got := page.evaluate("diaphaneProbe.codec")) != CODECS[codec]:
            say(f"{codec}: the page received codec {got}")
            return None
        chance = random.Random(seed)
        _drag(page, 0, WARM_UP, chance)
        count, total = _worker_times(stack)
        _drag(page, WARM_UP, inputs, chance)
        steps = _steps(_all_shown(page), WARM_UP)
        count, total = (now - before for now, before in zip(_worker_times(stack), (count, total), strict=True))
        return Block(steps, 1e3 * total / max(1, count))
    finally:
        context.close()


def _drag(page, first: int, inputs: int, chance: random.Random) -> None:
    """Drags in a circle around the centre at a speed that is not synchronised with the screen. The next movement comes when the
    last one is displayed. Otherwise each movement would wait for the rendering of earlier ones on a slow device."""
    def at(n: int) -> tuple[float, float]:
        return WIDTH / 2 + 120 * math.cos(n / 9), HEIGHT / 2 + 90 * math.sin(n / 9)

    page.mouse.move(*at(first))
    page.mouse.down()
    for n in range(first + 1, first + inputs + 1):
        time.sleep(chance.uniform(0.02, 0.06))
        page.mouse.move(*at(n))
        deadline = time.monotonic() + 10
        while page.evaluate("diaphaneProbe.inputs.filter((one) => one.shown > 0).length") < n and time.monotonic() < deadline:
            time.sleep(0.01)
    page.mouse.up()


def _worker_times(stack: Stack) -> tuple[float, float]:
    """Returns the number and the total seconds of the worker's times from an input to its first frame."""
    import httpx

    text = httpx.get(f"http://127.0.0.1:{stack.ports['renderd-admin']}/metrics").text
    found = dict(re.findall(r"^diaphane_renderd_input_to_frame_seconds_(count|sum)(?:\{[^}]*\})? (\S+)$", text, re.MULTILINE))
    return float(found.get("count", 0)), float(found.get("sum", 0))


def _all_shown(page) -> dict:
    """Returns the notes of the probe. (The page's policy forbids wait_for_function.)"""
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        probe = page.evaluate("diaphaneProbe")
        if probe["inputs"] and all(one["shown"] > 0 for one in probe["inputs"]):
            return probe
        time.sleep(0.1)
    raise TimeoutError("the canvas does not show the number of the last input. Does the worker run with --mark-frames?")


def _steps(probe: dict, first: int) -> list[Step]:
    steps = []
    for one in probe["inputs"][first:]:
        frame = next((f for f in probe["frames"] if f["input_seq"] >= one["input_seq"]), None)
        ack = frame and probe["acks"].get(str(frame["seq"]))
        if not ack or not ack["presented_us"]:
            continue  # replaced by a newer one before it was shown, to which `shown` belongs
        render, encode = frame["render_us"] / 1e3, frame["encode_us"] / 1e3
        received, decoded = ack["received_us"] / 1e3, ack["decoded_us"] / 1e3
        steps.append(Step(whole=one["shown"] - one["event"], to_send=one["sent"] - one["event"], render=render, encode=encode,
                          other=received - one["sent"] - render - encode, decode=decoded - received, present=one["shown"] - decoded))
    return steps


def _results(codec: str, blocks: list[Block]) -> list[Result]:
    if not blocks:
        return []
    say(f"{codec}: {sum(len(block.steps) for block in blocks)} inputs")

    def shares(name: str, percent: float) -> list[float]:
        return [percentile(block.values(name), percent) for block in blocks]

    means = [("movement to socket", [block.mean("to_send") for block in blocks]),
             ("render", [block.mean("render") for block in blocks]),
             ("encode", [block.mean("encode") for block in blocks]),
             ("waiting in the worker", [block.worker_ms - block.mean("render", "encode") for block in blocks]),
             ("sockets, edge, gateway, both ways", [block.mean("render", "encode", "other") - block.worker_ms for block in blocks]),
             ("decode", [block.mean("decode") for block in blocks]),
             ("decoded to the next screen refresh", [block.mean("present") for block in blocks])]
    return [result(f"{codec}: without rendering, p50", shares("without_render", 50), "ms", at_most=P50_MS),
            result(f"{codec}: without rendering, p95", shares("without_render", 95), "ms", at_most=P95_MS),
            result(f"{codec}: with rendering, p50", shares("whole", 50), "ms"),
            result(f"{codec}: with rendering, p95", shares("whole", 95), "ms"),
            *(result(f"{codec}:   {shown}, mean", values, "ms") for shown, values in means)]
