"""The browser that tests and measurements drive."""

from __future__ import annotations

import os

# Without the last ones Chromium tries to reach its maker at every start.
ARGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync"]


def path() -> str:
    return os.environ.get("DIAPHANE_CHROMIUM", "/usr/bin/chromium")
