"""A whole disc in the browser: 3,000 files of 0.5 MB are chosen in Chromium, until the page shows their contents.

The files are CT slices as scanners write them (several series, a header of 4 KB with a patient), and some other files: text,
truncated, random and empty ones. They were just written, so they are read from memory and not from a disc."""

from __future__ import annotations

import os
import shutil
import struct
from pathlib import Path

from .. import chromium, users
from ..bench import Result, result
from ..bench_client import Person
from ..bench_stack import folder, prepared

ABOUT = "time to scan 3,000 files of 0.5 MB in Chromium, also as a ZIP file, and the longest main-thread task meanwhile"
PAGE = True

FILES, SERIES = 3000, 6
SECONDS = 10.0
ARCHIVE_SECONDS = 15.0
LONGEST_TASK_MS = 100.0  # longer tasks are noticeable

# Records in the page, from the choice of the files: tasks over 50 ms, pauses between displayed frames, and how often the progress
# changed. Chromium spends part of the first task, before the page runs, on creating 3,000 objects. That part is reported
# separately.
PROBE = """() => {
  const probe = (window.scanProbe = { from: 0, to: 0, longest_task: 0, before: 0, longest_pause: 0, progress: 0 });
  new PerformanceObserver((list) => { for (const e of list.getEntries()) if (probe.from && !probe.to) {
    probe.before = Math.max(probe.before, probe.from - e.startTime);
    probe.longest_task = Math.max(probe.longest_task, e.startTime + e.duration - Math.max(e.startTime, probe.from));
  } })
    .observe({ type: "longtask" });
  addEventListener("change", () => (probe.from = performance.now()), { capture: true, once: true });
  let last = 0, shown = "";
  const look = (now) => {
    if (probe.from && !probe.to) {
      probe.longest_pause = Math.max(probe.longest_pause, last ? now - last : 0);
      const text = document.querySelector(".scanning .muted")?.textContent ?? "";
      if (text !== shown) probe.progress += 1;
      shown = text;
      last = now;
      if (document.querySelector(".series-card")) probe.to = performance.now();
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}"""


def element(tag: int, vr: str, value: bytes) -> bytes:
    """Returns a data element in explicit little endian."""
    value += (b"\0" if vr == "UI" else b" ") * (len(value) % 2)
    head = struct.pack("<HH", tag >> 16, tag & 0xFFFF) + vr.encode()
    return head + (struct.pack("<HI", 0, len(value)) if vr in ("OB", "OW", "UN") else struct.pack("<H", len(value))) + value


def ct_slice(series: int, number: int, pixels: bytes) -> bytes:
    """Returns a slice of 512 x 512 pixels with 16 bits, 1 mm from its neighbours."""
    uid = f"1.2.826.0.1.3680043.9.9999.{series}"
    sop_class, sop = b"1.2.840.10008.5.1.4.1.1.2", f"{uid}.{number}".encode()
    meta = element(0x00020001, "OB", b"\0\1") + element(0x00020002, "UI", sop_class) + element(0x00020003, "UI", sop) \
        + element(0x00020010, "UI", b"1.2.840.10008.1.2.1")
    texts = [(0x00080008, "CS", "ORIGINAL\\PRIMARY\\AXIAL"), (0x00080016, "UI", sop_class.decode()), (0x00080018, "UI", sop.decode()),
             (0x00080060, "CS", "CT"), (0x0008103E, "LO", f"Series {series}"), (0x00100010, "PN", "Mustermann^Max"), (0x00100020, "LO", "4711"),
             (0x00180015, "CS", "HEAD"), (0x0020000D, "UI", uid), (0x0020000E, "UI", f"{uid}.0"), (0x00200011, "IS", str(series)),
             (0x00200013, "IS", str(number)), (0x00200032, "DS", f"-120\\-120\\{number}"), (0x00200037, "DS", "1\\0\\0\\0\\1\\0")]
    data = b"".join(element(tag, vr, text.encode()) for tag, vr, text in texts)
    data += element(0x00280002, "US", struct.pack("<H", 1)) + element(0x00280004, "CS", b"MONOCHROME2")
    data += b"".join(element(tag, "US", struct.pack("<H", value)) for tag, value in ((0x00280010, 512), (0x00280011, 512)))
    data += element(0x00280030, "DS", b"0.5\\0.5")
    data += b"".join(element(0x00280100 + i, "US", struct.pack("<H", value)) for i, value in enumerate((16, 16, 15, 0)))
    data += element(0x00281052, "DS", b"-1024") + element(0x00281053, "DS", b"1")
    data += element(0x00291010, "UN", os.urandom(4096))  # private data of a vendor
    return b"\0" * 128 + b"DICM" + element(0x00020000, "UL", struct.pack("<I", len(meta))) + meta + data + element(0x7FE00010, "OW", pixels)


def write_disc(disc: Path, files: int) -> int:
    """Writes the files and returns the number of slices among them."""
    pixels = os.urandom(2 * 512 * 512)
    others = {0: b"", 1: b"not a scan\n" * 50_000, 2: os.urandom(500_000), 3: ct_slice(0, 1, pixels)[:3000]}
    slices = 0
    for n in range(files):
        place = disc / f"DIR{n // 500:03}" / f"IM{n:06}"
        place.parent.mkdir(parents=True, exist_ok=True)
        bad = n % 100 == 99
        place.write_bytes(others[n // 100 % len(others)] if bad else ct_slice(n * SERIES // files, slices, pixels))
        slices += not bad
    return slices


def scanned(page, label: str, chosen: Path) -> dict:
    """Chooses files on the page and returns what the probe saw."""
    chooser = page.get_by_label(label)
    chooser.wait_for(state="attached")
    page.evaluate(PROBE)
    chooser.set_input_files(chosen, timeout=300_000)
    page.wait_for_selector(".series-card, .hidden-series", timeout=120_000)
    page.wait_for_timeout(100)    # the next displayed frame stops the clock
    assert page.locator(".series-card").count() == SERIES, "a bad file has stopped the scan, or an archive gives other series"
    return page.evaluate("scanProbe")


def measure(quick: bool) -> list[Result]:
    from playwright.sync_api import sync_playwright

    files, seconds, of_archive, tasks, before, pauses, progress = FILES, [], [], [], [], [], []
    with folder(users.ordinary_user()) as base, prepared(base, "cpu") as stack, sync_playwright() as playwright:
        write_disc(base / "disc", files)
        archive = Path(shutil.make_archive(str(base / "disc"), "zip", base / "disc"))
        person = Person(stack)
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        for _ in range(2 if quick else 5):
            context = browser.new_context(viewport={"width": 1280, "height": 720})
            context.add_cookies([{"name": c.name, "value": c.value, "url": stack.settings.url} for c in person.http.cookies.jar])
            page = context.new_page()
            page.goto(stack.settings.url + "/add")
            probe = scanned(page, "Choose a folder", base / "disc")
            seconds.append((probe["to"] - probe["from"]) / 1000)
            tasks.append(probe["longest_task"])
            before.append(probe["before"])
            pauses.append(probe["longest_pause"])
            progress.append(probe["progress"])
            page.reload()
            probe = scanned(page, "Choose files", archive)
            of_archive.append((probe["to"] - probe["from"]) / 1000)
            context.close()
        browser.close()
    return [result(f"scanning {files} files of 0.5 MB", seconds, "s", at_most=SECONDS),
            result("the same files in a ZIP file", of_archive, "s", at_most=ARCHIVE_SECONDS),
            result("longest main-thread task", tasks, "ms", at_most=LONGEST_TASK_MS),
            result("Chromium's own work before it notifies the page", before, "ms"),
            result("longest gap between screen refreshes", pauses, "ms"),
            result("progress updates", progress, "", at_least=10)]
