"""Messages to the user of ./diaphane."""

from __future__ import annotations

import shutil
import sys
import threading
import time

_started = time.monotonic()
_out = sys.stdout
#: Seconds between two lines of progress where a line cannot be overwritten.
_PROGRESS_INTERVAL = 15.0
_lock = threading.Lock()
_progress_shown = False
_last_line = _started


def to_stderr() -> None:
    """Redirects all further messages to standard error, for commands whose standard output is their result."""
    global _out
    _out = sys.stderr


class CliError(Exception):
    """An error that the user can act on. Printed without a traceback, with exit code `code`."""

    def __init__(self, message: str, code: int = 1):
        super().__init__(message)
        self.code = code


def say(text: str) -> None:
    _print(text)


def step(text: str) -> None:
    """Reports a step of a long operation with the seconds since the start, so that a log shows where time was spent."""
    _print(_with_time(text))


def progress(text: str) -> None:
    """Reports how far the current step is. On a terminal, it is one line that the next message overwrites. In a log, it is a line
    every 15 seconds."""
    global _progress_shown, _last_line
    if _out.isatty():
        width = shutil.get_terminal_size().columns - 1      # a second line would stay
        with _lock:
            print(f"\r\x1b[K{_with_time(text)[:width]}", end="", file=_out, flush=True)
            _progress_shown = True
    elif time.monotonic() - _last_line >= _PROGRESS_INTERVAL:
        _print(_with_time(text))


def warn(text: str) -> None:
    with _lock:
        _erase_progress()
        print(f"diaphane: {text}", file=sys.stderr, flush=True)


def _with_time(text: str) -> str:
    return f"[{time.monotonic() - _started:6.1f}s] {text}"


def _print(text: str) -> None:
    global _last_line
    with _lock:
        _erase_progress()
        print(text, file=_out, flush=True)
        _last_line = time.monotonic()


def _erase_progress() -> None:
    global _progress_shown
    if _progress_shown:
        print("\r\x1b[K", end="", file=_out, flush=True)
        _progress_shown = False
