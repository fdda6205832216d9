"""CPU priorities and cores of programs that belong to sessions of their own.

Where Linux groups the processes of a session (`kernel.sched_autogroup_enabled`), nice values only compare processes of one
session, and every session gets an equal share. Each program here leads a session, and so does each backend of Postgres. Such a
group has a nice value of its own, in /proc/PID/autogroup."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from .processes import Identity


def first_cores(count: int, usable: Iterable[int] | None = None) -> list[int]:
    """Returns the numbers of the first `count` cores of this process, or of all with 0."""
    cores = sorted(os.sched_getaffinity(0) if usable is None else usable)
    return cores[:count] if count else cores


PROC = Path("/proc")


def family(pid: int, proc: Path = PROC) -> Iterator[int]:
    """Yields the process and its descendants. A descendant whose parent has ended is not found."""
    yield pid
    try:
        children = (proc / str(pid) / "task" / str(pid) / "children").read_text(encoding="ascii").split()
    except OSError:    # it has ended, or this kernel does not list children
        return
    for child in children:
        yield from family(int(child), proc)


class GroupPriorities:
    """Sets the nice values of sessions, each once."""

    def __init__(self, proc: Path = PROC) -> None:
        self.proc_ = proc
        self.done_: set[tuple[Identity, int]] = set()

    def apply(self, programs: Iterable[tuple[int, int]]) -> None:
        """Gives the session of each process, and of its descendants, its nice value. `programs`
        contains pairs of pid and nice value. Linux accepts only one change per 0.1 s from
        ordinary users, so a refused one is left to the next call."""
        found = set()
        for leader, nice in programs:
            for pid in family(leader, self.proc_):
                identity = Identity.of(pid)
                if identity is None:
                    continue
                one = (identity, nice)
                if one in self.done_ or self._set(pid, nice):
                    found.add(one)
        self.done_ = found

    def _set(self, pid: int, nice: int) -> bool:
        """Sets the nice value of a process's session. Returns False if the change has to be
        repeated."""
        try:
            (self.proc_ / str(pid) / "autogroup").write_text(str(nice), encoding="ascii")
        except BlockingIOError:
            return False
        except OSError:    # it has ended, there are no such groups, or the process is another user's
            pass
        return True
