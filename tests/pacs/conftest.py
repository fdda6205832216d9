"""Lets the tests import the gateway with its libraries, which are in a folder of their own."""

from __future__ import annotations

import sys
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "pacs"))
# Last, so that the libraries of the tests come first.
sys.path.append(str(REPO / ".tools" / "pacs-libraries"))
