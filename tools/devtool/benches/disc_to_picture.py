"""From a disc to a picture on the screen, with a user's steps in Chromium: choosing, scanning, naming and uploading the folder,
then building, opening and rendering. It excludes the user's own time to find the folder and type a name."""

from __future__ import annotations

import subprocess
import tempfile
import time
from pathlib import Path

from .. import chromium
from ..bench import Result, result
from ..bench_client import Person
from ..bench_stack import running

ABOUT = "time from choosing the sample's folder to its first picture, in Chromium (target: two minutes)"
PAGE = True

SECONDS = 120.0
WAIT_MS = 600_000


def measure(quick: bool) -> list[Result]:
    from playwright.sync_api import sync_playwright

    steps: dict[str, list[float]] = {"scanned": [], "uploaded and built": [], "opened and rendered": [], "from disc to picture": []}
    with running() as stack, tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        disc = Path(folder) / "disc"
        subprocess.run([str(stack.layout.bin / "diaphane-sample"), "--write-dicom", str(disc)], check=True, stdout=subprocess.DEVNULL)
        person = Person(stack)
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        for n in range(1 if quick else 3):
            context = browser.new_context(viewport={"width": 1280, "height": 720})
            context.add_cookies([{"name": c.name, "value": c.value, "url": stack.settings.url} for c in person.http.cookies.jar])
            page = context.new_page()
            page.set_default_timeout(WAIT_MS)
            page.goto(stack.settings.url + "/add")
            began = time.monotonic()
            page.get_by_label("Choose a folder").set_input_files(disc)
            page.get_by_label("Your name for this scan").fill(f"Head {n}")
            looked = time.monotonic()
            page.get_by_role("button", name="Upload", exact=True).click()
            page.wait_for_selector(f"article.card-ready:has-text('Head {n}')")
            built = time.monotonic()
            page.get_by_role("link", name=f"Open Head {n}").click()
            page.wait_for_selector("canvas[data-samples]")
            shown = time.monotonic()
            for name, seconds in zip(steps, (looked - began, built - looked, shown - built, shown - began), strict=True):
                steps[name].append(seconds)
            context.close()
        browser.close()
    return [result(name, runs, "s", at_most=SECONDS if name == "from disc to picture" else None) for name, runs in steps.items()]
