"""`./diaphane study`: the analysis of studies (studies/), with its libraries in .tools/studies."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Sequence

from . import paths, venv

PACKAGE = paths.REPO / "studies"
PYTHON = "/usr/bin/python3"


def run(rest: Sequence[str]) -> int:
    venv.ensure(venv.STUDIES)
    os.execve(PYTHON, [PYTHON, "-m", "diaphane_studies", *rest], {**os.environ, **environment(libraries(), PACKAGE)})


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
