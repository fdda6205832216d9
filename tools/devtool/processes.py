"""Processes by identity, because a recorded pid may belong to another program by now."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Identity:
    """A process: its pid and its start time in clock ticks since boot (/proc/PID/stat, field 22)."""

    pid: int
    start: int

    @staticmethod
    def of(pid: int) -> "Identity | None":
        start = _stat(pid, 19)
        return None if start is None else Identity(pid, int(start))

    def alive(self) -> bool:
        """Whether the process runs. A zombie, which runs nothing and holds no port, does not."""
        return _stat(self.pid, 19) == str(self.start) and _stat(self.pid, 0) not in (None, "Z", "X")

    def send(self, number: int) -> None:
        """Signals the process unless its pid belongs to another one by now."""
        if not self.alive():
            return
        try:
            os.kill(self.pid, number)
        except ProcessLookupError:
            pass

    def group(self) -> list["Identity"]:
        """Returns live processes of the session and group that this process leads, even after its death. Linux does not reuse its
        pid while the group has members, so a leader with another start time means that the group belongs to another program."""
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
            # The name is in brackets and may contain anything, including brackets.
            return file.read().rpartition(")")[2].split()[field_after_name]
    except (FileNotFoundError, ProcessLookupError, IndexError):
        return None


def wait_gone(identities: list[Identity], seconds: float) -> list[Identity]:
    """Returns the processes that are still alive after at most `seconds`."""
    deadline = time.monotonic() + seconds
    left = [i for i in identities if i.alive()]
    while left and time.monotonic() < deadline:
        time.sleep(0.02)
        left = [i for i in left if i.alive()]
    return left


def kill_group(leader: Identity, seconds: float = 1.0) -> list[Identity]:
    """Kills the rest of a program's group, such as nginx's workers, which outlive a killed master and keep its port. Returns
    those that are still alive after `seconds`."""
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
    """Signals the process with `first`, then kills the rest of its group."""
    identity.send(first)
    wait_gone([identity], seconds)
    kill_group(identity)


def boot() -> str:
    """Identifies the current boot of the machine, to which start times of processes refer."""
    with open("/proc/sys/kernel/random/boot_id", encoding="ascii") as file:
        return file.read().strip()
