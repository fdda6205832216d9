"""`./diaphane screenshots FOLDER`: screenshots of every page and every step through the viewer, in three sizes, light and dark,
for manual review. `./diaphane guide`: those of docs/guide.md."""

from __future__ import annotations

import re
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

from . import build, chromium, install, page_crawler, paths, sample_labels, viewer_tour
from .bench_client import Person, cranium
from .bench_stack import running
from .console import CliError, say
from .stack import Stack

SIZES = {"phone": (390, 844), "tablet": (820, 1180), "desk": (1440, 900)}
LOOKS = ("light", "dark")
#: The steps that docs/guide.md shows, some of them on a phone.
GUIDE = paths.REPO / "docs" / "guide"
GUIDE_SIZES = {"desk": (1200, 750), "phone": (390, 844)}


def run(out: Path, only: str, one_size: str | None = None, one_look: str | None = None) -> int:
    made, out = 0, out.resolve()
    with _seen() as (browser, stack, person, shown):
        out.mkdir(parents=True, exist_ok=True)
        for size, (width, height) in SIZES.items():
            for look in LOOKS:
                if one_size not in (None, size) or one_look not in (None, look):
                    continue
                for name, page in _pages(browser, stack, person, shown, (width, height), look, only):
                    page.screenshot(path=out / f"{name}-{size}-{look}.png", full_page=page.locator(".viewer").count() == 0)
                    made += 1
    say(f"{made} screenshots saved to {out}")
    return 0


def guide() -> int:
    GUIDE.mkdir(parents=True, exist_ok=True)
    wanted = re.findall(r"\(guide/([\w-]+?)(-phone)?\.jpg\)", GUIDE.with_suffix(".md").read_text(encoding="utf-8"))
    known = viewer_tour.STEPS + viewer_tour.LABELLED_STEPS
    if unknown := {name for name, _ in wanted} - {step.name for step in known}:
        raise CliError(f"docs/guide.md uses pictures that no step of viewer_tour.py makes: {', '.join(sorted(unknown))}")
    with _seen() as (browser, stack, person, shown):
        for size, window in GUIDE_SIZES.items():
            steps = [step for step, phone in wanted if bool(phone) == (size == "phone")]
            context = _context(browser, stack, person, window, "light")
            page = context.new_page()
            for name in viewer_tour.walk(page, f"{stack.settings.url}/view/{shown}", only=steps):
                page.screenshot(path=GUIDE / f"{name}{'-phone' if size == 'phone' else ''}.jpg", type="jpeg", quality=82)
            context.close()
        sample_labels.add(stack, person, shown)
        page = _context(browser, stack, person, GUIDE_SIZES["desk"], "light").new_page()
        for name in viewer_tour.walk(page, f"{stack.settings.url}/view/{shown}", steps=viewer_tour.LABELLED_STEPS):
            page.screenshot(path=GUIDE / f"{name}.jpg", type="jpeg", quality=82)
    say(f"Pictures saved to {GUIDE}")
    return 0


@contextmanager
def _seen() -> Iterator[tuple]:
    """Yields a browser, a running service, a user with scans, and the scan to view."""
    install.enter_venv("bench")
    build.build_page()
    build.build_programs()
    from playwright.sync_api import sync_playwright

    with running("cpu") as stack, tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        person = Person(stack)
        shown = _scans(stack, person, Path(folder))
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        yield browser, stack, person, shown
        browser.close()


def _scans(stack: Stack, person: Person, folder: Path) -> str:
    """Creates one scan that is ready and one in each other state of a card. Returns the id of the first."""
    bundle = cranium(stack, folder)
    ready = person.upload(bundle)
    person.wait_ready(ready)
    others = {title: person.http.post("/v1/data-sets", json={"title": title, "bytes": 40_000_000}).raise_for_status().json()
              for title in ("Knee after the fall", "Shoulder, the disc that could not be read", "Chest, spring")}
    part = bundle.read_bytes()[:8 << 20]
    person.http.patch(others["Chest, spring"]["upload_url"], content=part, headers={
        "Tus-Resumable": "1.0.0", "Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"}).raise_for_status()
    import psycopg

    with psycopg.connect(stack.settings.dsn, autocommit=True) as database:
        database.execute("UPDATE data_sets SET title = 'Head, spring' WHERE id = %s", [ready])
        database.execute("UPDATE data_sets SET state = 'building' WHERE title LIKE 'Knee%'")
        database.execute("""UPDATE data_sets SET state = 'refused', refusal_code = 'missing_slices',
                            refusal_text = '3 slices are missing; copy the disc again.' WHERE title LIKE 'Shoulder%'""")
        database.execute("UPDATE users SET is_administrator = true WHERE id = %s", [person.http.get("/v1/me").json()["id"]])
    person.sets_up_second_factor()
    return ready


def _pages(browser, stack: Stack, person: Person, shown: str, size: tuple[int, int], look: str, only: str) -> Iterator[tuple[str, object]]:
    """Yields (name, page that shows it), one after the other."""
    url = stack.settings.url
    for who in (page_crawler.NOBODY, page_crawler.PERSON):
        context = _context(browser, stack, person if who == page_crawler.PERSON else None, size, look)
        page = context.new_page()
        for place in page_crawler.places(shown):
            if place.who != who or only not in place.name:
                continue
            page_crawler.go(page, url, place, shown)
            page.wait_for_timeout(400)    # wait for pictures that load late
            yield place.name, page
            if place.path == "/add" and who == page_crawler.PERSON:
                yield from _found(page, stack)
        if who == page_crawler.PERSON:
            steps = tuple(step.name for step in viewer_tour.STEPS if only in f"viewer-{step.name}")
            for step in viewer_tour.walk(page, f"{url}/view/{shown}", samples=4, only=steps):
                yield f"viewer-{step}", page
        context.close()


def _context(browser, stack: Stack, person: Person | None, size: tuple[int, int], look: str):
    phone = size[0] < 500
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=look, reduced_motion="reduce",
                                  is_mobile=phone, has_touch=phone, device_scale_factor=1)
    context.set_default_timeout(30_000)
    if person:
        context.add_cookies([{"name": c.name, "value": c.value, "url": stack.settings.url} for c in person.http.cookies.jar])
    return context


def _found(page, stack: Stack) -> Iterator[tuple[str, object]]:
    """Yields the page's results for a disc: one suitable series and some unsuitable ones."""
    with tempfile.TemporaryDirectory() as folder:
        disc = Path(folder) / "disc"
        subprocess.run([str(stack.layout.bin / "diaphane-sample"), "--write-dicom", str(disc)], check=True, stdout=subprocess.DEVNULL)
        (disc / "readme.txt").write_text("start viewer.exe", encoding="utf-8")
        chooser = page.get_by_label("Choose a folder")
        chooser.set_input_files(disc)
        page.wait_for_selector(".series-card")
        page.wait_for_timeout(400)
        yield "person-add-found", page
        few = Path(folder) / "few"
        few.mkdir()
        for file in sorted(disc.iterdir())[:3]:
            file.rename(few / file.name)
        page.get_by_role("button", name="Choose other files").click()
        page.get_by_label("Choose a folder").set_input_files(few)
        page.wait_for_selector(".hidden-series")
        yield "person-add-nothing", page

