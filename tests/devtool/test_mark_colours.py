"""The colours of marks are the same on the page and in the files that a worker makes."""

from __future__ import annotations

import re
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]


def test_the_page_and_the_worker_draw_marks_in_the_same_colours():
    style = (REPO / "frontend/src/style/picture.css").read_text(encoding="utf-8")
    page = re.findall(r"^\[data-colour(?:=\"\d\")?\] \{ --person: #([0-9a-f]{6}); \}$", style, re.MULTILINE)
    source = (REPO / "renderd/encode/file_marks.cpp").read_text(encoding="utf-8")
    table = source[source.index("kColours{"):source.index("kDark")]
    worker = ["".join(one) for one in re.findall(r"\{+0x(\w\w), 0x(\w\w), 0x(\w\w)\}", table)]
    assert len(page) == 8
    assert worker == page
