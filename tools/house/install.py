"""What is missing on this machine for a purpose, and its installation."""

from __future__ import annotations

from . import packages, paths, venv
from .says import HouseError, say

PARTS = {
    "up": [venv.BUILD],
    "test": [venv.BUILD, venv.TESTS, venv.CHECK],
    "check": [venv.BUILD, venv.TESTS, venv.CHECK],
    "bench": [venv.BUILD, venv.TESTS],
}


def missing(purpose: str) -> tuple[list[str], list[venv.Part]]:
    """Debian packages and parts of .tools/venv that are not there."""
    parts = [part for part in PARTS[purpose] if not part.current()]
    if (paths.FRONTEND / "package.json").exists() and venv.node_bin() is None:
        parts.append(venv.NODE)
    return packages.missing(packages.wanted()), parts


def ensure(purpose: str, may_install: bool = True) -> None:
    """Installs what is missing and says what; with `may_install` false only says it, and ends when there is something."""
    debian, parts = missing(purpose)
    if not debian and not parts:
        return
    if not may_install:
        for name in debian:
            say(f"missing: Debian package {name}")
        for part in parts:
            say(f"missing: {part.what}")
        raise HouseError("nothing was installed (--no-install)")
    if debian:
        packages.install(debian)
    for part in parts:
        venv.ensure(part)
