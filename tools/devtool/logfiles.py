"""Logs of the programs. Each program writes to its own file, so that nothing is lost when the supervisor dies."""

from __future__ import annotations

import shutil
from pathlib import Path

LIMIT_BYTES = 8 << 20
KEPT = 2


def bound(path: Path, limit: int = LIMIT_BYTES) -> None:
    """Moves the text of a log over the limit to `.1` and `.2`, and empties the file in place. The program has it open for
    appending, so its next line is at the start. A line written in between may be lost."""
    try:
        if path.stat().st_size <= limit:
            return
    except FileNotFoundError:
        return
    for number in range(KEPT, 1, -1):
        older = path.with_name(f"{path.name}.{number - 1}")
        if older.exists():
            older.replace(path.with_name(f"{path.name}.{number}"))
    shutil.copyfile(path, path.with_name(f"{path.name}.1"))
    with open(path, "r+b") as file:
        file.truncate(0)


def tail(path: Path, lines: int = 15) -> str:
    try:
        with open(path, "rb") as file:
            file.seek(0, 2)
            file.seek(max(0, file.tell() - 32768))
            return "\n".join(file.read().decode(errors="replace").splitlines()[-lines:])
    except OSError:
        return ""
