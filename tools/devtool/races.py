"""`./diaphane races`: runs the programs' own multi-threaded tests under ThreadSanitizer (CTest's label `threads`)."""

from __future__ import annotations

import re
import subprocess

from . import build, install, paths
from .console import CliError, step

#: The file that lists the programs and their settings under ThreadSanitizer.
SETTINGS = paths.REPO / "cmake" / "Diaphane.cmake"


def programs_in(variable: str) -> list[str]:
    [listed] = re.findall(rf"set\({variable} ([\w\s]+)\)", SETTINGS.read_text(encoding="utf-8"))
    return listed.split()


def run(programs: list[str], may_install: bool = True) -> int:
    known = programs_in("DIAPHANE_MULTI_THREADED")
    if unknown := [name for name in programs if name not in known]:
        raise CliError(f"unknown program '{unknown[0]}'; choose one of: {', '.join(known)}", 64)
    install.ensure("test", may_install)
    chosen = programs or known
    build.ninja(build.configure("tsan"), [f"bin/{name}" for name in chosen])
    step("Running the tests under ThreadSanitizer")
    done = subprocess.run(["ctest", "--preset", "tsan", "-L", "threads", "-R", f"^({'|'.join(chosen)})$"], cwd=paths.REPO, env=build.environment(),
                          stdin=subprocess.DEVNULL)
    return 1 if done.returncode else 0
