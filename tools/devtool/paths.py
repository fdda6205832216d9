"""Locations in a checkout."""

from __future__ import annotations

import os
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
TOOLS = REPO / "tools"
VENV = REPO / ".tools" / "venv"
VENV_PYTHON = VENV / "bin" / "python"
STAMPS = REPO / ".tools" / "stamps"
FRONTEND = REPO / "frontend"


def build_dir() -> Path:
    """Returns the folder of the built programs. DIAPHANE_BUILD selects another build for a test run."""
    chosen = os.environ.get("DIAPHANE_BUILD")
    return Path(chosen).resolve() if chosen else REPO / "build" / "release"
