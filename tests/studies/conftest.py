"""Lets the tests import the analysis of studies and its libraries."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from devtool import study  # noqa: E402

study.use_libraries()
