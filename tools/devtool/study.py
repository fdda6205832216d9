"""`./diaphane study`: the analysis of studies (studies/), with its libraries in .tools/studies."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Sequence

from . import layout, paths, venv

PACKAGE = paths.REPO / "studies"
PYTHON = "/usr/bin/python3"
#: Not for users: `up` runs it (start_installer).
INSTALL = "install-when-told"


def run(rest: Sequence[str]) -> int:
    if rest and rest[0] == INSTALL:
        return install(Path(rest[1]))
    venv.ensure(venv.STUDIES)
    os.execve(PYTHON, [PYTHON, "-m", "diaphane_studies", *rest], {**os.environ, **environment(libraries(), PACKAGE)})


def start_installer(into: Path) -> subprocess.Popen | None:
    """Starts a process that waits for a line and then installs the libraries. `up` gives up root before the first picture, and
    downloads nothing until then. Returns None if they are installed."""
    if venv.STUDIES.current():
        layout.copy_study_libraries(into)
        return None
    command = ["/usr/bin/nice", "-n", "19", PYTHON, str(paths.TOOLS / "devtool"), "study", INSTALL, str(into)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)


def install(into: Path) -> int:
    if sys.stdin.readline():
        venv.ensure(venv.STUDIES)
        layout.copy_study_libraries(into)
    return 0


def libraries() -> Path:
    assert venv.STUDIES.folder is not None
    return venv.STUDIES.folder


def environment(*folders: Path) -> dict[str, str]:
    return {"PYTHONPATH": os.pathsep.join(map(str, folders)), "PYTHONDONTWRITEBYTECODE": "1", "MPLBACKEND": "agg"}


def use_libraries() -> None:
    """Lets this process import the analysis and its libraries."""
    for folder in (libraries(), PACKAGE):
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
