"""The picture in the viewer's canvas as numbers."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import dataclass

from playwright.sync_api import Locator, Page, expect

from harness import TestStack

SIDE = 128
#: Relative error of pictures that are compared, which two samples reach. `pixels` averages most of it out: from a picture with two
#: samples to one with sixteen, the mean difference is 0.7 for a window of 960 x 640 and 1.3 for one of 480 x 320, of 255. Four
#: samples, for 5%, cost 2.5 times as much and leave half of that.
COMPARED_ERROR = 0.25
#: For tests of noise and sharpness, and those that tell apart pictures that differ little.
FINE_ERROR = 0.05
#: Mean difference per channel, of 255, between two renderings of one view with COMPARED_ERROR: twice 1.3 * sqrt(2), rounded up.
ALIKE = 4.0


@dataclass(frozen=True)
class Facts:
    epoch: int
    input_seq: int
    samples: int
    error: float


def facts(page: Page) -> Facts:
    values = page.locator("canvas").evaluate("(c) => [c.dataset.epoch, c.dataset.inputSeq, c.dataset.samples, c.dataset.error]")
    epoch, input_seq, samples, error = (value or "0" for value in values)
    return Facts(int(epoch), int(input_seq), int(samples), float(error))


def kept_view(page: Page) -> dict:
    """Returns what this tab would restore after a reload: session_id, scene (JSON), and input_seq of the last input."""
    # Input is handled at the next frame, and saved shortly afterwards or as soon as the page may be closed.
    return json.loads(page.evaluate("""async () => {
        for (let frames = 0; frames < 2; ++frames)
            await Promise.race([new Promise(requestAnimationFrame), new Promise((over) => setTimeout(over, 500))]);
        dispatchEvent(new PageTransitionEvent("pagehide"));
        return Object.entries(sessionStorage).find(([name]) => name.startsWith("diaphane.view."))?.[1] ?? "{}";
    }"""))


def last_input(page: Page) -> int:
    return kept_view(page).get("input_seq", 0)


#: Runs in the page: scales a canvas or picture to side x side and returns RGB in base64. Scaling averages out the noise of single
#: pixels.
SHRINK = """(source, side) => {
    const small = new OffscreenCanvas(side, side).getContext("2d");
    small.imageSmoothingQuality = "high";
    small.drawImage(source, 0, 0, side, side);
    const rgba = small.getImageData(0, 0, side, side).data;
    let text = "";
    for (let i = 0; i < rgba.length; i += 4) text += String.fromCharCode(rgba[i], rgba[i + 1], rgba[i + 2]);
    return btoa(text);
}"""


def pixels(page: Page) -> bytes:
    """Returns the canvas scaled to SIDE x SIDE, RGB."""
    return base64.b64decode(page.locator("canvas").evaluate(SHRINK, SIDE))


def difference(a: bytes, b: bytes) -> float:
    """Returns the mean absolute difference per channel, 0 to 255."""
    return sum(abs(x - y) for x, y in zip(a, b, strict=True)) / len(a)


def spread(a: bytes) -> float:
    """Returns the mean absolute difference from the mean, which is 0 for an empty picture."""
    mean = sum(a) / len(a)
    return sum(abs(x - mean) for x in a) / len(a)


def wait_for_samples(stack: TestStack, page: Page, samples: int, input_seq: int = 0, timeout: float = 120) -> Facts:
    """Waits for a picture with at least this many samples that shows the given input or a newer one."""
    return _wait_for(stack, page, lambda now: now.samples >= samples, input_seq, timeout, f"a picture of {samples} samples")


def wait_for_picture(stack: TestStack, page: Page, input_seq: int = 0, timeout: float = 120, error: float = COMPARED_ERROR) -> Facts:
    """Waits for a picture whose error is at most the given one, however many samples that takes."""
    what = f"a picture with an error of {error:.0%}"
    return _wait_for(stack, page, lambda now: now.samples > 0 and now.error <= error, input_seq, timeout, what)


def _wait_for(stack: TestStack, page: Page, good: Callable[[Facts], bool], input_seq: int, timeout: float, what: str) -> Facts:
    def enough() -> Facts | None:
        now = facts(page)
        if good(now) and now.input_seq >= input_seq:
            return now
        page.wait_for_timeout(50)  # lets the page's events arrive
        return None

    return stack.wait_until(enough, timeout=timeout, what=what)


def placed(handle: Locator) -> dict:
    """Returns the box of a handle in the picture, which has its place once the page has measured the picture. Before that, the lines
    beside it are one pixel wide."""
    expect(handle.locator("xpath=../*[local-name()='svg']")).not_to_have_attribute("width", "1")
    return handle.bounding_box()


#: Runs in the page: remembers the texts of the first element that fits a selector from now on.
LISTEN = """(selector) => {
    const said = (window.said = [""]);
    const listen = () => {
        const text = document.querySelector(selector)?.textContent ?? "";
        if (text !== said.at(-1)) said.push(text);
    };
    listen();
    new MutationObserver(listen).observe(document.body, { subtree: true, childList: true, characterData: true });
}"""


def listen(page: Page, selector: str) -> None:
    """Remembers what an element of the page says from now on, because some messages are shown for a short time only."""
    page.evaluate(LISTEN, selector)


def wait_said(stack: TestStack, page: Page, text: str, timeout: float = 120) -> None:
    """Waits until the element has said this since `listen`, even if it says something else by now."""
    stack.wait_until(lambda: text in page.evaluate("window.said.join(' ')") or page.wait_for_timeout(50), timeout=timeout, what=f"“{text}”")


def drag(page: Page, right: float, down: float) -> None:
    """Drags from the middle of the picture by CSS pixels."""
    box = page.locator("canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=10)
    page.mouse.up()
