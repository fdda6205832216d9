"""The programs that a person runs by hand: built when needed, then handed the command line as it is."""

from __future__ import annotations

import os
from pathlib import Path

from . import build, datadir, install, paths, says, supervise
from .says import HouseError


def run(name: str, arguments: list[str]) -> int:
    says.to_stderr()
    binary = paths.build_dir() / "bin" / name
    if not binary.exists() or os.environ.get("DIAPHANE_BUILD") is None:
        install.ensure("up")
        build.build_programs(name)
    os.execv(binary, [name, *arguments])


def sample(data: Path, arguments: list[str]) -> int:
    """Sends the sample scan to the Diaphane that runs on `data`."""
    if supervise.running_supervisor(data) is None and not {"--help", "-h"} & set(arguments):
        raise HouseError(f"nothing runs on {data}; start it first: ./diaphane up --detach")
    url = datadir.read_record(data).get("url", "")
    binary = paths.build_dir() / "bin" / "diaphane-sample"
    build.build_programs("diaphane-sample")
    os.execv(binary, [*supervise.sample_command(binary, url, data), *arguments])
