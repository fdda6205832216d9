"""The volumes for measurements of the renderer."""

from __future__ import annotations

import array
import hashlib
import json
import os
import subprocess
import sys
import uuid
from pathlib import Path

from . import paths

CRANIUM = Path("/usr/share/doc/invesalius-examples/examples/Cranium.inv3")


def cranium() -> str | None:
    """Returns the directory of the mapped cranium, which is created if missing. Returns None if its package is not installed."""
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
    """Returns the volume for a scene file. All of them fit the cranium, which a synthetic head of
    the same size replaces if it is not installed."""
    return cranium() or "made:256"


def grow(folder: Path) -> int:
    """Doubles the size of a stored volume in each direction and halves its voxels, which gives the same picture with eight times
    the bytes. Returns the new size in bytes."""
    import numpy

    about = json.loads((folder / "volume.json").read_text(encoding="utf-8"))
    voxels = numpy.fromfile(folder / "voxels.i16", dtype="<i2").reshape(about["size"][::-1])
    for axis in range(3):
        voxels = voxels.repeat(2, axis)
    about["size"] = [2 * one for one in about["size"]]
    about["spacing"] = [one / 2 for one in about["spacing"]]
    about["contentHash"] = "blake2b:" + hashlib.blake2b(voxels.data, digest_size=32).hexdigest()
    # Writes in place to keep the owner and mode of the files.
    (folder / "voxels.i16").write_bytes(voxels.data)
    (folder / "volume.json").write_text(json.dumps(about), encoding="utf-8")
    return voxels.nbytes


def store_ball(stack, size: int = 48) -> str:
    """Writes a ball of bone in air to the volume store of a stack, as ingest would. Returns its id. No data set refers to it."""
    name = str(uuid.uuid4())
    middle, radius = (size - 1) / 2, size * 0.35
    voxels = array.array("h", (1200 if (x - middle) ** 2 + (y - middle) ** 2 + (z - middle) ** 2 < radius**2 else -1000
                               for z in range(size) for y in range(size) for x in range(size))).tobytes()
    folder = stack.data / "volumes" / name
    folder.mkdir()
    (folder / "voxels.i16").write_bytes(voxels)
    (folder / "volume.json").write_text(json.dumps({
        "format": 1, "size": [size] * 3, "spacing": [2.0] * 3, "direction": [1, 0, 0, 0, 1, 0, 0, 0, 1], "modality": "CT",
        "minimum": -1000, "maximum": 1200, "percentiles": [-1000.0] * 5 + [1200.0] * 3,
        "contentHash": "blake2b:" + hashlib.blake2b(voxels, digest_size=32).hexdigest()}), encoding="utf-8")
    for path in (folder, *folder.iterdir()):
        stack.run_as.own(path)
    return name
