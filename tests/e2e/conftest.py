"""Real pages in headless Chromium against the real programs.

    visit      opens a page of its own (own cookies): visit(), visit(phone=True), visit(wide=True, dark=True), visit(small=True)
    fake       the built page on the made-up server of frontend/dev/fake, for tests of the page alone: a picture takes one frame
    cranium    a folder with the DICOM series of a made-up patient
    pictures   a folder for screenshots to look at: $DIAPHANE_PICTURES, without which the pages take none

A page that throws, or breaks its content security policy, fails its test.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import urllib.request
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from harness import REPO, StackFactory, one_at_a_time, wait_until
from devtool import chromium, ports
from person import PATIENCE_MS

expect.set_options(timeout=PATIENCE_MS)
#: Samples at which the pictures of tests have converged. Without this choice, which users have, too, a worker renders 16 to 24 of
#: them. A large window takes two seconds of a core for each, which the page and other tests would then lack.
MOST_SAMPLES = 8
#: Makes this choice once per context. Pages such as about:blank have no storage, and some tests take it away.
STOP = """try {
    if (localStorage.getItem("diaphane.effort") === null) localStorage.setItem("diaphane.effort", '{"stop_samples":SAMPLES}');
} catch {}"""
#: Where screenshots go.
PICTURES = os.environ.get("DIAPHANE_PICTURES")


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium.for_tests(), args=chromium.ARGS)
        yield browser
        browser.close()


@dataclass(frozen=True)
class FakeStack:
    """What a test of the page alone needs of a TestStack."""

    url: str
    wait_until = staticmethod(wait_until)


@pytest.fixture(scope="session")
def fake():
    given = ports.random_free()
    url, folder = f"http://127.0.0.1:{given['edge']}", REPO / "frontend"
    vite = ["node", folder / "node_modules" / "vite" / "bin" / "vite.js", "preview", "--config", "dev/fake/vite.config.ts"]
    server = subprocess.Popen([*vite, "--host", "127.0.0.1", "--port", str(given["edge"]), "--strictPort"], cwd=folder,
                              stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    wait_until(lambda: server.poll() is not None or answers(url), what="the fake server")
    yield FakeStack(url)
    server.terminate()
    server.wait()
    ports.give_back(given.values())


def answers(url: str) -> bool:
    try:
        return urllib.request.urlopen(url, timeout=10).status == 200
    except OSError:    # refused, or the connection was lost while it started
        return False


@pytest.fixture
def visit(browser: Browser):
    contexts, faults = [], []

    def open_page(phone: bool = False, dark: bool = False, wide: bool = False, small: bool = False, touch: bool = False,
                  samples: int | None = MOST_SAMPLES, **more) -> Page:
        # Not wider than a test needs: two cores render it.
        size = {"width": 1440, "height": 900} if wide else {"width": 960, "height": 640}
        if small:
            size = {"width": 480, "height": 320}
        if phone:
            size = {"width": 390, "height": 844}
        context = browser.new_context(viewport=size, color_scheme="dark" if dark else "light", is_mobile=phone,
                                      has_touch=phone or touch, device_scale_factor=2 if phone else 1, **more)
        contexts.append(context)
        context.set_default_timeout(PATIENCE_MS)    # also of pages that a test opens itself
        if samples is not None:
            context.add_init_script(STOP.replace("SAMPLES", str(samples)))
        page = context.new_page()
        if not PICTURES:
            page.screenshot = lambda **_: b""  # a normal run discards screenshots, and each takes up to a second of both cores
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda message: faults.append(message.text)
                if "Content Security Policy" in message.text else None)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert faults == []


@pytest.fixture(scope="session")
def cranium(all_stacks: StackFactory) -> Path:
    shared = all_stacks.shared()
    disc, beside = shared / "disc", shared / "disc.new"
    with one_at_a_time(shared):
        if not disc.exists():
            shutil.rmtree(beside, ignore_errors=True)
            beside.mkdir()
            build = Path(os.environ.get("DIAPHANE_BUILD", REPO / "build" / "release"))
            subprocess.run([build / "bin" / "diaphane-sample", "--write-dicom", beside / "Mustermann"], check=True, capture_output=True)
            beside.rename(disc)
    return disc / "Mustermann"


@pytest.fixture(scope="session")
def pictures() -> Path:
    folder = Path(PICTURES or tempfile.mkdtemp(prefix="diaphane-pictures-"))
    folder.mkdir(parents=True, exist_ok=True)
    return folder
