"""Remembers which files passed which check, by their contents, for all checkouts of the user."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Iterable

from . import build_stamp

FOLDER = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "diaphane" / "checks"
#: Maximum number of entries. They are empty files, one for each version of a source file.
_MOST = 20_000


def entry(files: Iterable[Path], *words: str) -> Path:
    """Returns the entry of files. `words` are the check, the versions of its tools and their
    settings."""
    return FOLDER / build_stamp.digest(files, *words)


def has(found: Path) -> bool:
    try:
        os.utime(found)    # entries that are used are kept
    except FileNotFoundError:
        return False
    return True


def keep(entries: Iterable[Path]) -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    for one in entries:
        one.touch()
    known = list(FOLDER.iterdir())
    if len(known) > _MOST:
        for old in sorted(known, key=lambda path: path.stat().st_mtime)[:_MOST // 2]:
            old.unlink(missing_ok=True)
