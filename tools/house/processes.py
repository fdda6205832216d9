"""Processes by identity: a pid alone may have been given to another program since it was written down."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Identity:
    """A process: its pid and the time it started, in clock ticks since boot (/proc/PID/stat, field 22)."""

    pid: int
    start: int

    @staticmethod
    def of(pid: int) -> "Identity | None":
        start = _stat(pid, 19)
        return None if start is None else Identity(pid, int(start))

    def alive(self) -> bool:
        """False for a zombie too: it runs nothing and holds no port."""
        return _stat(self.pid, 19) == str(self.start) and _stat(self.pid, 0) not in (None, "Z", "X")

    def send(self, number: int, group: bool = False) -> None:
        """Signals the process, or its whole group when it leads one; nothing when it is another by now."""
        if not self.alive():
            return
        try:
            if group and os.getpgid(self.pid) == self.pid:
                os.killpg(self.pid, number)
            else:
                os.kill(self.pid, number)
        except ProcessLookupError:
            pass


def _stat(pid: int, field_after_name: int) -> str | None:
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as file:
            # The name is in brackets and may hold anything, brackets included.
            return file.read().rpartition(")")[2].split()[field_after_name]
    except (FileNotFoundError, ProcessLookupError, IndexError):
        return None


def wait_gone(identities: list[Identity], seconds: float) -> list[Identity]:
    """Those still alive after at most `seconds`."""
    deadline = time.monotonic() + seconds
    left = [i for i in identities if i.alive()]
    while left and time.monotonic() < deadline:
        time.sleep(0.02)
        left = [i for i in left if i.alive()]
    return left


def end(identity: Identity, first: int = signal.SIGTERM, seconds: float = 3.0) -> None:
    """Asks with `first`, then kills what is left of its group."""
    identity.send(first)
    if wait_gone([identity], seconds):
        identity.send(signal.SIGKILL, group=True)
        wait_gone([identity], 1.0)
