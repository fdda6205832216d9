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

    def send(self, number: int) -> None:
        """Signals the process; nothing when it is another by now."""
        if not self.alive():
            return
        try:
            os.kill(self.pid, number)
        except ProcessLookupError:
            pass

    def group(self) -> list["Identity"]:
        """Live processes of the session and group that this process was started as leader of, also after its own death.

        Linux gives its pid to nobody else while the group has members, so a leader with another start time means that the
        group is somebody else's by now."""
        if _stat(self.pid, 19) not in (None, str(self.start)):
            return []
        own = str(self.pid)
        found = []
        for entry in os.listdir("/proc"):
            if entry.isdigit() and _stat(int(entry), 2) == own and _stat(int(entry), 3) == own:
                one = Identity.of(int(entry))
                if one and one.start >= self.start and one.alive():
                    found.append(one)
        return found


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


def kill_group(leader: Identity, seconds: float = 1.0) -> list[Identity]:
    """Kills what there is of a program's group: nginx's workers, for instance, outlive a master that was killed, and keep its
    port. Those that are still alive after `seconds`."""
    deadline = time.monotonic() + seconds
    while members := leader.group():
        try:
            os.killpg(leader.pid, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):
            pass
        wait_gone(members, max(0.0, deadline - time.monotonic()))
        if time.monotonic() >= deadline:
            return leader.group()
    return []


def end(identity: Identity, first: int = signal.SIGTERM, seconds: float = 3.0) -> None:
    """Asks with `first`, then kills what is left of its group."""
    identity.send(first)
    wait_gone([identity], seconds)
    kill_group(identity)


def boot() -> str:
    """What tells one start of the machine from another: start times of processes count from it."""
    with open("/proc/sys/kernel/random/boot_id", encoding="ascii") as file:
        return file.read().strip()
