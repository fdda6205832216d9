"""The volumes that the renderer is measured on."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from . import paths

CRANIUM = Path("/usr/share/doc/invesalius-examples/examples/Cranium.inv3")


def cranium() -> str | None:
    """The directory of the mapped cranium, made when it is not there; nothing where its package is not installed."""
    given = os.environ.get("DIAPHANE_CRANIUM")
    if given:
        return given
    if not CRANIUM.exists():
        return None
    folder = paths.REPO / "build" / "volumes" / "cranium"
    if not (folder / "volume.json").exists():
        subprocess.run([sys.executable, str(paths.TOOLS / "gpu" / "cranium_volume.py"), str(folder)], check=True)
    return str(folder)


def volume_for(_scene: Path) -> str:
    """All scene files fit the cranium; where it is not, a made head of its size stands in."""
    return cranium() or "made:256"
