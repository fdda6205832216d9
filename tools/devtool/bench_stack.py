"""A separate stack for a measurement, with free ports and a temporary data directory."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from pathlib import Path
from typing import Iterable, Iterator

from . import layout, ports, users
from .stack import Stack


@contextlib.contextmanager
def folder(run_as: users.RunAs) -> Iterator[Path]:
    """Yields a folder in /var/tmp, which is on disk where /tmp may be in memory."""
    made = Path(tempfile.mkdtemp(prefix="diaphane-bench-", dir="/var/tmp"))
    made.chmod(0o755)
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)


def prepared(base: Path, engine: str = "auto", only: Iterable[str] | None = None, **extra_env: str) -> Stack:
    """Returns a stack that is not started yet. The same `base` gives a stack on the same data. With
    `only`, just these programs run."""
    run_as = users.ordinary_user()
    return Stack(data=base / "data", ports=ports.random_free(), run_as=run_as, engine=engine, only=only, extra_env=extra_env,
                 layout=layout.reachable(run_as, base / "app"))


@contextlib.contextmanager
def running(engine: str = "auto", only: Iterable[str] | None = None, **extra_env: str) -> Iterator[Stack]:
    with folder(users.ordinary_user()) as base, prepared(base, engine, only, **extra_env) as stack:
        yield stack
    ports.give_back(stack.ports.values())


def peak_memory_mb(pid: int) -> float:
    """Returns VmHWM of a process in MB, or 0 if it no longer exists."""
    try:
        for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024 / 1e6
    except OSError:
        pass
    return 0.0
