"""Searches for the made-up patient in everything that a server keeps, in every form a program may have given it."""

from __future__ import annotations

import base64
from pathlib import Path

# What ingest/dicom/series_writer.h puts into every text of the series, and the folder's and files' names.
WORDS = ["Canary7f3a", "Mustermann", "IM000001"]


def forms(word: str) -> dict[str, bytes]:
    """Base64 three times: what lies before the word shifts its coding; the ends that depend on neighbours are cut off."""
    plain = word.encode()
    found = {"UTF-8": plain, "UTF-16LE": word.encode("utf-16-le"), "UTF-16BE": word.encode("utf-16-be"),
             "hex": plain.hex().encode(), "HEX": plain.hex().upper().encode()}
    for shift in range(3):
        coded = base64.b64encode(b"\0" * shift + plain)
        found[f"base64+{shift}"] = coded[-(-shift * 8 // 6):].rstrip(b"=")[:-1]
    return found


NEEDLES = {f"{word} in {name}": needle for word in WORDS for name, needle in forms(word).items()}


def canaries_in(data: bytes) -> list[str]:
    return [name for name, needle in NEEDLES.items() if needle in data]


def canaries_below(folder: Path) -> list[str]:
    """In the contents and names of all files; a file that goes while one looks is gone."""
    found = []
    for path in sorted(folder.rglob("*")):
        found += [f"{name}: the name of {path}" for name in canaries_in(str(path.relative_to(folder)).encode())]
        if path.is_file():
            try:
                found += [f"{name}: {path}" for name in canaries_in(path.read_bytes())]
            except FileNotFoundError:
                pass
    return found
