"""What the house says to the person who started it."""

from __future__ import annotations

import sys
import time

_started = time.monotonic()
_out = sys.stdout


def to_stderr() -> None:
    """From now on: for commands whose standard output is their result."""
    global _out
    _out = sys.stderr


class HouseError(Exception):
    """Something the user can act on: printed without a traceback, ends with `code`."""

    def __init__(self, message: str, code: int = 1):
        super().__init__(message)
        self.code = code


def say(text: str) -> None:
    print(text, file=_out, flush=True)


def step(text: str) -> None:
    """A step of something long, with the seconds since the start, so that a log shows what took the time."""
    print(f"[{time.monotonic() - _started:6.1f}s] {text}", file=_out, flush=True)


def warn(text: str) -> None:
    print(f"diaphane: {text}", file=sys.stderr, flush=True)
