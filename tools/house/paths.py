"""Where things are in a checkout."""

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
    """Where the programs are built; DIAPHANE_BUILD points a test run at another build."""
    chosen = os.environ.get("DIAPHANE_BUILD")
    return Path(chosen).resolve() if chosen else REPO / "build" / "release"
