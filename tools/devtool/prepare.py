"""Installs and builds the programs of an instance on one machine. Downloads and compilation run in parallel."""

from __future__ import annotations

import concurrent.futures

from . import build, install, packages, progress, venv
from .console import step


def for_up(may_install: bool) -> None:
    """Installs Debian packages and then builds the programs. In parallel, it installs tools from PyPI and npm packages, and builds
    the web page."""
    debian, parts = install.missing_or_exit("up", may_install)
    with concurrent.futures.ThreadPoolExecutor(max_workers=1) as beside:    # carries out its work in the order given
        tools = beside.submit(_install_tools, parts)
        npm = beside.submit(_install_npm_packages, tools)
        if debian:
            packages.install(debian, afterwards=f", then {progress.programs_left(build.jobs())} of building")
        tools.result()
        page = beside.submit(_build_page, npm)    # needs protoc, which is a Debian package
        build.build_programs(*build.RUN_BY_UP, portable=False)
        page.result()


def _install_tools(parts: list[venv.Part]) -> None:
    for part in parts:
        venv.ensure(part)


def _install_npm_packages(tools: concurrent.futures.Future) -> None:
    tools.result()    # an error there also ends this thread
    if build.may_build_page():
        build.npm_install()


def _build_page(npm: concurrent.futures.Future) -> None:
    npm.result()
    if build.build_page():
        step("Built the web page")
