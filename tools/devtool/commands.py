"""Runs other programs to their end, without input and with both of their outputs as one text."""

from __future__ import annotations

import subprocess
from typing import Sequence

from .console import CliError


def run(command: Sequence[object], **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(map(str, command)), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace", **options)


def output(command: Sequence[object], what: str = "", lines: int = 30, **options) -> str:
    """Returns the output. If the program fails, raises CliError, which names `what` and ends with the last `lines` of the output."""
    done = run(command, **options)
    if done.returncode != 0:
        raise failure(what or " ".join(map(str, command[:4])), done, lines)
    return done.stdout


def failure(what: str, done: subprocess.CompletedProcess[str], lines: int = 30) -> CliError:
    return CliError(f"{what} failed:\n" + "\n".join(done.stdout.splitlines()[-lines:]))
