"""A stack of its own for a measurement: free ports, a data directory that is removed afterwards."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from pathlib import Path
from typing import Iterable, Iterator

from . import layout, ports, users
from .stack import Stack


@contextlib.contextmanager
def folder(run_as: users.RunAs) -> Iterator[Path]:
    """In /var/tmp, which is a disk where /tmp may be memory."""
    made = Path(tempfile.mkdtemp(prefix="diaphane-bench-", dir="/var/tmp"))
    made.chmod(0o755)
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)


def prepared(base: Path, engine: str = "auto", only: Iterable[str] | None = None, **extra_env: str) -> Stack:
    """Not started yet; the same `base` gives a stack on the same data. `only`: those programs alone."""
    run_as = users.ordinary_user()
    return Stack(data=base / "data", ports=ports.random_free(), run_as=run_as, engine=engine, only=only, extra_env=extra_env,
                 layout=layout.reachable(run_as, base / "app"))


@contextlib.contextmanager
def running(engine: str = "auto", only: Iterable[str] | None = None, **extra_env: str) -> Iterator[Stack]:
    with folder(users.ordinary_user()) as base, prepared(base, engine, only, **extra_env) as stack:
        yield stack
    ports.give_back(stack.ports.values())


def peak_memory_mb(pid: int) -> float:
    """VmHWM of a process, in MB; 0 when it is gone."""
    try:
        for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024 / 1e6
    except OSError:
        pass
    return 0.0


def descendants(pid: int) -> list[int]:
    """Pids of all processes below one."""
    children: dict[int, list[int]] = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            with contextlib.suppress(OSError, IndexError, ValueError):
                stat = Path(f"/proc/{entry}/stat").read_text(encoding="ascii", errors="replace")
                children.setdefault(int(stat.rpartition(")")[2].split()[1]), []).append(int(entry))
    found, left = [], [pid]
    while left:
        below = children.get(left.pop(), [])
        found += below
        left += below
    return found
