"""Uploads that mean harm, and what is to become of each (docs: ingest.md, "Hostile input").

    for case in cases(): case.write(path); ...; assert refusal_code in case.expected
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterable

from .dicom_bytes import bundle

#: Refusals without a diagnosis, which only stop the input. No case may end with one of them.
STOPPED = ("too_slow", "unreadable", "internal")


@dataclass(frozen=True)
class Case:
    """`expected`: the refusal's code, or "ready" if the trick is harmless and the scan behind it is valid. `make` yields the
    upload's bytes in order. A number stands for that many zeros, which use no space on the disk."""

    group: str
    name: str
    expected: tuple[str, ...]
    make: Callable[[], Iterable[bytes | int]]

    def write(self, path: Path) -> int:
        """Writes the upload and returns its length."""
        with path.open("wb") as file:
            for part in self.make():
                if isinstance(part, int):
                    file.seek(part, 1)
                else:
                    file.write(part)
            file.truncate(file.tell())
            return file.tell()


def of_files(group: str, name: str, expected: str, make: Callable[[], Iterable[bytes]]) -> Case:
    """Packs the files as a browser would."""
    return Case(group, name, tuple(expected.split()), lambda: [bundle(make())])


def of_tar(group: str, name: str, expected: str, make: Callable[[], Iterable[bytes | int]]) -> Case:
    return Case(group, name, tuple(expected.split()), make)


def cases() -> list[Case]:
    from . import archives, bombs, structure

    found = [*structure.cases(), *bombs.cases(), *archives.cases()]
    assert len({case.name for case in found}) == len(found), "a name stands for one case"
    return found
