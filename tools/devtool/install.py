"""Finds and installs the dependencies that this machine lacks for a purpose."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from . import gpu, packages, paths, venv
from .console import CliError, say

PARTS = {
    "up": [venv.BUILD],
    "image": [venv.BUILD, venv.CUDA, venv.STUDIES, venv.PACS],
    "test": [venv.BUILD, venv.CUDA, venv.TESTS, venv.CHECK, venv.STUDIES, venv.PACS],
    "check": [venv.BUILD, venv.CUDA, venv.TESTS, venv.CHECK, venv.PACS],
    "bench": [venv.BUILD, venv.TESTS, venv.STUDIES, venv.PACS],
    "replay": [venv.TESTS],
}
#: Purposes that need no browser, linters or fuzzers.
_WITHOUT_TESTS = ("up", "image", "replay")
#: Purposes that compile the CUDA engine only on machines that can run it.
_CUDA_WITH_GPU = ("up", "bench")


def parts(purpose: str, gpu_absence: str) -> list[venv.Part]:
    """Returns the parts of .tools/venv that a purpose needs. `gpu_absence`: why there is no GPU, or an empty text."""
    return PARTS[purpose] + ([venv.CUDA] if purpose in _CUDA_WITH_GPU and not gpu_absence else [])


def missing(purpose: str) -> tuple[list[str], list[venv.Part]]:
    """Returns Debian packages and parts of .tools/venv that are missing."""
    absent = [part for part in parts(purpose, gpu.absence()) if not part.current()]
    if (paths.FRONTEND / "package.json").exists() and venv.node_bin() is None:
        absent.append(venv.NODE)
    return packages.missing(packages.required(tests=purpose not in _WITHOUT_TESTS)), absent


def ensure(purpose: str, may_install: bool = True) -> None:
    """Installs the missing dependencies and reports them."""
    debian, absent = missing_or_exit(purpose, may_install)
    if debian:
        packages.install(debian)
    for part in absent:
        venv.ensure(part)


def ensure_parts(wanted: list[venv.Part], may_install: bool) -> None:
    """Installs missing parts of .tools, or raises CliError if that is not allowed."""
    for part in wanted:
        if not part.current() and not may_install:
            raise CliError(f"missing: {part.what}")
        venv.ensure(part)


def enter_venv(purpose: str) -> None:
    """Installs the missing dependencies and runs the same command again with the libraries of
    .tools/venv, unless it already uses them."""
    if Path(sys.prefix).resolve() != paths.VENV.resolve():
        ensure(purpose)
        os.execv(paths.VENV_PYTHON, [str(paths.VENV_PYTHON), str(paths.TOOLS / "devtool"), *sys.argv[1:]])


def missing_or_exit(purpose: str, may_install: bool) -> tuple[list[str], list[venv.Part]]:
    """Returns the result of missing(). If `may_install` is false, reports it and exits if anything is missing."""
    debian, absent = missing(purpose)
    if may_install or not (debian or absent):
        return debian, absent
    for name in debian:
        say(f"missing: Debian package {name}")
    for part in absent:
        say(f"missing: {part.what}")
    raise CliError("dependencies are missing, and --no-install was given")
