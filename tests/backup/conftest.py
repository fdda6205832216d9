"""Lets the tests import the package, which only the image and the commands have on their path."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "backup"))
