"""How many of 60 pictures per second the page shows. Real H.264 is recorded from a real worker and then played at that rate."""

from __future__ import annotations

import tempfile
from pathlib import Path

from .. import chromium, paths
from ..bench import Result, percentile, result
from ..bench_client import Person, cranium
from ..bench_stack import running
from ..console import CliError, say
from ..stack import Stack
from .support.frame_replay import Played, player, record

ABOUT = "pictures that the page shows per second in Chromium when 60 arrive, by window size"
PAGE = True

RATE = 60
SIZES = ((1280, 720), (960, 540), (640, 360))
STEPS = 40     # of the recorded rotation
WARM_UP_S = 2  # until the page has compiled its code and found a decoder


def measure(quick: bool) -> list[Result]:
    from playwright.sync_api import sync_playwright

    seconds = 6 if quick else 15
    results: list[Result] = []
    with running("cpu", DIAPHANE_MAX_ERROR="0.9") as stack, tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        person = Person(stack)
        data_set = person.upload(cranium(stack, Path(folder)))
        person.wait_ready(data_set)
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        # The previews of a scan's looks are rendered once, on the same processor.
        _see(browser, stack, person, data_set, SIZES[-1], None)
        for size in SIZES:
            recorded = record(person, data_set, *size, STEPS // 2 if quick else STEPS)
            say(f"{size[0]} x {size[1]}: {len(recorded.frames)} frames recorded, {sum(len(f.data) for f in recorded.frames) / len(recorded.frames) / 1e3:.1f} kB each")
            with player(recorded, RATE, WARM_UP_S + seconds) as (port, played):
                probe = _see(browser, stack, person, data_set, size, (port, played))
            results += _results(f"{size[0]} x {size[1]}", probe, played)
        browser.close()
    return results


def _see(browser, stack: Stack, person: Person, data_set: str, size: tuple[int, int], playing: tuple[int, Played] | None) -> dict:
    """Opens a page while pictures are played to it, and returns its notes. Without a player, waits until everything is loaded."""
    from playwright.sync_api import expect

    # The page may only connect to its own server, and the player is another one.
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, bypass_csp=playing is not None)
    try:
        url = stack.settings.url
        context.add_cookies([{"name": c.name, "value": c.value, "url": url} for c in person.http.cookies.jar])
        context.add_init_script("localStorage.setItem('diaphane.codecs', 'H264')")
        if playing:
            context.add_init_script(f"window.diaphanePlayer = {{ port: {playing[0]} }}")
            context.add_init_script(path=paths.TOOLS / "devtool" / "shown_probe.js")
        page = context.new_page()
        page.goto(f"{url}/view/{data_set}")
        page.wait_for_selector("canvas[data-samples]", timeout=120_000)
        if not playing:
            expect(page.locator(".preset-picture img")).to_have_count(5, timeout=180_000)
            return {}
        while not playing[1].over.is_set():
            page.wait_for_timeout(100)
        page.wait_for_timeout(500)
        return page.evaluate("diaphaneShown")
    finally:
        context.close()


def _results(size: str, probe: dict, played: Played) -> list[Result]:
    first = next(number for number, at in enumerate(played.sent, 1) if at > WARM_UP_S)
    shown = [one for one in probe["shown"] if one["seq"] >= first]
    if len(shown) < 2:
        raise CliError(f"{size}: the page showed {len(shown)} frames")
    begun, ended = shown[0]["now"], shown[-1]["now"]
    span = (ended - begun) / 1e3
    sent = range(first, len(played.sent) + 1)
    came = (len(sent) - 1) / (played.sent[-1] - played.sent[first - 1])
    drawn = sum(1 for seq in sent if seq in played.presented)
    gaps = [b["now"] - a["now"] for a, b in zip(shown, shown[1:], strict=False)]
    return [result(f"{size}: frames received per second, of {RATE} offered", [came], "1/s"),
            result(f"{size}: frames shown per second", [(len(shown) - 1) / span], "1/s", at_least=0.98 * RATE),
            result(f"{size}: screen refreshes per second", [sum(1 for now in probe["screen"] if begun < now <= ended) / span], "1/s"),
            result(f"{size}: received but never drawn", [100 * (1 - drawn / len(sent))], "%"),
            result(f"{size}: drawn but replaced before a screen refresh", [100 * (drawn - len(shown)) / len(sent)], "%"),
            result(f"{size}: interval between shown frames, p95", [percentile(gaps, 95)], "ms"),
            result(f"{size}: interval between shown frames, maximum", [max(gaps)], "ms")]
