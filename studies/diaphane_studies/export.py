"""Reads an exported study (docs/contracts.md) and gives the answers of a step as plain values."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

FORMAT, VERSION = "diaphane-study", 1
#: Bytes of an export that the analysis reads.
MOST_BYTES = 32 << 20


class ExportError(ValueError):
    """The input is not an export that the analysis can read. The message quotes no answers."""


def parse(data: bytes) -> dict[str, Any]:
    if len(data) > MOST_BYTES:
        raise ExportError(f"the export has more than {MOST_BYTES >> 20} MiB")
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise ExportError("the export is not valid JSON") from error
    return check(document)


def read(path: Path) -> dict[str, Any]:
    try:
        return parse(path.read_bytes())
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror}") from error


def check(document: Any) -> dict[str, Any]:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise ExportError("this is not the export of a study")
    if document.get("version") != VERSION:
        raise ExportError("this version of the export is not supported")
    try:
        steps = document["study"]["definition"]["steps"]
        if not all(isinstance(step["id"], str) and isinstance(step["kind"], str) for step in steps):
            raise ExportError("a step of the export has no id or no kind")
        for one in document["participants"]:
            if not all(isinstance(answer["step"], str) for answer in one["answers"]):
                raise ExportError("an answer of the export names no step")
    except (KeyError, TypeError) as error:
        raise ExportError("the export lacks the definition, the participants or their answers") from error
    return document


def steps(document: dict[str, Any], kind: str | None = None) -> list[dict[str, Any]]:
    found = document["study"]["definition"]["steps"]
    return [step for step in found if kind is None or step["kind"] == kind]


def answers(document: dict[str, Any], step: str) -> dict[int, Any]:
    """Returns the answers to a step by the numbers of the participants."""
    return {one["number"]: answer["value"] for one in document["participants"] for answer in one["answers"] if answer["step"] == step}


def text(values: dict[str, str] | None, language: str) -> str:
    """Returns a text of the definition in a language, or in the other one if it lacks this one."""
    values = values or {}
    return values.get(language) or next(iter(values.values()), "")
