"""The tests that the pages on security and privacy name as proof are there, by that name."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

REPO = Path(__file__).resolve().parents[2]
PAGES = ("bounds.md", "security.md", "threat-model.md", "privacy.md", "edge.md", "testing.md")
SOURCES = ("common", "directory", "volume", "ingest", "scene", "api", "renderd", "operator")


def _python() -> set[str]:
    """Returns functions and files of tests."""
    files = sorted((REPO / "tests").rglob("test_*.py"))
    return {file.name for file in files} | {name for file in files for name in re.findall(r"^def (test_\w+)\(", file.read_text(encoding="utf-8"), re.M)}


def _cpp() -> set[str]:
    """Returns Suite.Name of GoogleTest tests in C++ and CUDA."""
    files = [file for folder in SOURCES for end in ("cpp", "cu") for file in (REPO / folder).rglob(f"*test*.{end}")]
    return {f"{suite}.{name}" for file in files
            for suite, name in re.findall(r"^\s*(?:TYPED_)?TEST(?:_[FP])?\((\w+),\s*(\w+)\)", file.read_text(encoding="utf-8"), re.M)}


def _is_there(name: str, known: set[str]) -> bool:
    """A final `…` or `*` matches any rest. A parametrised test may be named with or without its parameters."""
    name = name.split("[")[0]
    if name[-1] in "…*":
        return any(one.startswith(name[:-1]) for one in known)
    return name in known


@pytest.mark.parametrize("page", PAGES)
def test_every_documented_test_exists(page):
    text = (REPO / "docs" / page).read_text(encoding="utf-8")
    words = {code.rpartition("/")[2] for code in re.findall(r"`([^`\s]+)`", text)}
    python, cpp = _python(), _cpp()
    suites = {one.split(".")[0] for one in cpp}
    missing = [word for word in sorted(words) if re.fullmatch(r"test_\w+(\.py)?(\[.*\])?…?", word) and not _is_there(word, python)]
    missing += [word for word in sorted(words) if re.fullmatch(r"[A-Z]\w+\.(\w+…?|\*)", word)
                and (word.split(".")[0] in suites or re.search(r"\.[A-Z]\w{12,}", word)) and not _is_there(word, cpp)]
    assert not missing, f"docs/{page} names what no test is called: {missing}"


def test_an_unknown_test_name_is_detected():
    assert not _is_there("test_that_nobody_wrote", _python()) and not _is_there("Sandbox.WillNeverBeCalledSo…", _cpp())
    assert _is_there("test_access_matrix", _python()) and _is_there("Sandbox.*", _cpp())
