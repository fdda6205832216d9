"""Debian's Firefox, driven over Marionette, the protocol beneath geckodriver. Playwright drives only a Firefox of its own."""

from __future__ import annotations

import base64
import json
import os
from pathlib import Path

from marionette_driver import By
from marionette_driver.marionette import Marionette, WebElement

from person import PATIENCE_MS
from picture import SHRINK, SIDE

WIDTH, HEIGHT = 960, 720
#: Uncaught errors of a page end up in the log.
PREFS = {"browser.dom.window.dump.enabled": True, "intl.accept_languages": "en"}


class Firefox:
    """One window of a new profile."""

    def __init__(self, home: Path):
        self.log = home / "firefox.log"
        before = os.environ.get("HOME")
        os.environ["HOME"] = str(home)  # must belong to the user who starts Firefox
        try:
            self.browser = Marionette(bin=path(), port=0, headless=True, gecko_log=str(self.log), prefs=PREFS, workspace=str(home))
        finally:
            os.environ["HOME"] = before or ""
        self.browser.start_session()
        self.browser.timeout.implicit = self.browser.timeout.script = PATIENCE_MS / 1e3
        self.browser.set_window_rect(width=WIDTH, height=HEIGHT)

    def close(self) -> None:
        self.browser.quit()
        self.browser.cleanup()

    def faults(self) -> list[str]:
        """Returns the uncaught errors of all pages so far."""
        lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()
        return [line for line in lines if "JavaScript error: http" in line]

    def goto(self, url: str) -> None:
        self.browser.navigate(url)

    def heading(self, name: str) -> WebElement:
        """Waits for the heading. The methods below wait for their elements, too."""
        return self._find(f"//h1[normalize-space()='{name}']")

    def text(self, text: str) -> WebElement:
        return self._find(f"//*[contains(text(), '{text}')]")

    def button(self, name: str) -> WebElement:
        return self._find(f"//button[normalize-space()='{name}' or @aria-label='{name}']")

    def link(self, name: str) -> WebElement:
        return self._find(f"//a[normalize-space()='{name}' or @aria-label='{name}']")

    def field(self, label: str) -> WebElement:
        return self._find(f"//input[@id=//label[normalize-space()='{label}']/@for] | //label[contains(normalize-space(), '{label}')]//input")

    def first(self, selector: str) -> WebElement:
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def drag(self, element: WebElement, right: int, down: int) -> None:
        """Drags from the element's middle by CSS pixels."""
        chain = self.browser.actions.sequence("pointer", "mouse", {"pointerType": "mouse"})
        chain.pointer_move(0, 0, origin=element).pointer_down()
        chain.pointer_move(right, down, duration=200, origin="pointer").pointer_up().perform()

    def choose_files(self, field: WebElement, files: list[Path]) -> None:
        """Chooses the files of a folder one by one, because Marionette cannot choose the folder."""
        self.evaluate("arguments[0].webkitdirectory = false", field)
        field.send_keys("\n".join(map(str, files)))

    def evaluate(self, script: str, *arguments: object) -> object:
        return self.browser.execute_script(script, script_args=arguments, sandbox=None)

    def pixels(self, canvas: WebElement) -> bytes:
        """Returns the canvas scaled to SIDE x SIDE, RGB."""
        return base64.b64decode(self.evaluate(f"return ({SHRINK})(...arguments)", canvas, SIDE))

    def data(self, canvas: WebElement) -> dict[str, str]:
        return json.loads(self.evaluate("return JSON.stringify(arguments[0].dataset)", canvas))

    def screenshot(self, file: Path) -> None:
        file.write_bytes(base64.b64decode(self.browser.screenshot(full=False)))

    def _find(self, xpath: str) -> WebElement:
        return self.browser.find_element(By.XPATH, xpath)


def path() -> str:
    return os.environ.get("DIAPHANE_FIREFOX", "/usr/bin/firefox-esr")
