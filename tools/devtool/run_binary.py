"""Programs that a user runs by hand. They are built when needed and receive the command line unchanged."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from . import build, console, datadir, install, paths, supervise, unpack
from .console import CliError


def run(name: str, arguments: list[str], wait: bool = False) -> int:
    """Replaces this process by the program, or with `wait` runs it, so that the caller can clean up
    afterwards."""
    console.to_stderr()
    binary = paths.build_dir() / "bin" / name
    if not binary.exists() or os.environ.get("DIAPHANE_BUILD") is None:
        install.ensure("up")
        build.build_programs(name)
    if wait:
        return subprocess.run([binary, *arguments]).returncode
    os.execv(binary, [name, *arguments])


def scan(rest: list[str]) -> int:
    return _with_archives("diaphane-scan", rest)


def export(rest: list[str]) -> int:
    return _with_archives("diaphane-export", rest)


def align(rest: list[str]) -> int:
    return _with_archives("diaphane-align", rest)


def render(rest: list[str]) -> int:
    return _with_archives("diaphane-render", rest)


def _with_archives(name: str, arguments: list[str]) -> int:
    """Runs the program with the folders that archives among the arguments were unpacked into."""
    with unpack.unpacked(arguments) as unpacked:
        return run(name, unpacked, wait=unpacked != arguments)


#: Options with which the sample tool writes files or uploads to a given server, so that no instance
#: needs to run here.
_OWN_WAY = ("--write-dicom", "--write-bundle", "--mapped-mha", "--mapped-volume", "--upload", "--help", "-h")


def sample(data: Path, rest: list[str]) -> int:
    """Uploads the sample scan again to the Diaphane that runs on `data`, or does what the arguments in `rest` say."""
    if any(argument.partition("=")[0] in _OWN_WAY for argument in rest):
        return run("diaphane-sample", rest)
    if supervise.running_supervisor(data) is None:
        raise CliError(f"Diaphane is not running on {data}. Start it first: ./diaphane up --detach")
    url = datadir.read_record(data).get("url", "")
    binary = paths.build_dir() / "bin" / "diaphane-sample"
    build.build_programs("diaphane-sample")
    done = subprocess.run([*supervise.sample_command(binary, url, data), *rest], stdout=subprocess.PIPE, text=True)
    if done.returncode == 0:
        console.say(f"The sample scan is at {url}/view/{done.stdout.strip()}")
    return done.returncode
