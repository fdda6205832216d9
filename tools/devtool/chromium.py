"""The browser for tests and measurements."""

from __future__ import annotations

import os

# The last three options keep Chromium from contacting its vendor at every start.
ARGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync"]


def path() -> str:
    return os.environ.get("DIAPHANE_CHROMIUM", "/usr/bin/chromium")
