"""Skips work while its inputs are unchanged, judged by their contents and not by their times."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Iterable

from . import paths


def digest(inputs: Iterable[Path], *words: str) -> str:
    """Hashes names and contents of files, including all files of directories. `words` are further inputs."""
    sums = hashlib.sha256("\0".join(words).encode())
    for path in inputs:
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file():
                sums.update(f"\0{file.relative_to(paths.REPO)}\0".encode())
                sums.update(file.read_bytes())
    return sums.hexdigest()


def is_current(name: str, expected: str) -> bool:
    try:
        return (paths.STAMPS / name).read_text(encoding="ascii") == expected
    except OSError:
        return False


def set_current(name: str, value: str) -> None:
    paths.STAMPS.mkdir(parents=True, exist_ok=True)
    (paths.STAMPS / name).write_text(value, encoding="ascii")
