"""The browser for tests and measurements."""

from __future__ import annotations

import os

# The last three options keep Chromium from contacting its vendor at every start.
ARGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync"]


WHOLE = "/usr/bin/chromium"
#: The same engine without Chromium's own windows, which cost 1.7 s of a core per page that a test opens.
SHELL = "/usr/bin/chromium-headless-shell"


def path() -> str:
    """Returns the browser that people have."""
    return os.environ.get("DIAPHANE_CHROMIUM", WHOLE)


def for_tests() -> str:
    return os.environ.get("DIAPHANE_CHROMIUM", SHELL)
