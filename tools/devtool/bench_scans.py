"""The real scans on which benches of ingest and of volumes measure."""

from __future__ import annotations

import gzip
import struct
import subprocess
from pathlib import Path

from . import paths
from .bench_volumes import CRANIUM
from .console import say

CH2 = Path("/usr/share/mricron/templates/ch2.nii.gz")     # Debian's mricron-data
SHARED_SCANS = paths.REPO.parent / "shared" / "scans"


def scans_of(folder: Path, scratch: Path) -> list[Path]:
    """Returns the NIfTI files of the folder and those that Debian packages have. `scratch` takes what must be converted."""
    found: list[Path] = []
    if not folder.is_dir():
        say(f"skipped: the scans of {folder}, which does not exist")
    for file in sorted(folder.glob("*.nii.gz")):
        found.append(_first_moment(file, scratch))
    if CRANIUM.exists():
        target = scratch / "cranium"
        subprocess.run([str(paths.build_dir() / "bin" / "diaphane-sample"), f"--write-dicom={target}"], check=True,
                       stdout=subprocess.DEVNULL)
        found.append(target)
    else:
        say("skipped: cranium (install Debian's invesalius-examples)")
    if CH2.exists():
        found.append(CH2)
    else:
        say("skipped: ch2 (install Debian's mricron-data)")
    return found


def _first_moment(file: Path, scratch: Path) -> Path:
    """Returns the file, or the first volume of a time series as a new file."""
    data = bytearray(gzip.decompress(file.read_bytes()))
    dimensions = struct.unpack_from("<8h", data, 40)
    if dimensions[0] <= 3:
        return file
    start, bits = int(struct.unpack_from("<f", data, 108)[0]), struct.unpack_from("<h", data, 72)[0]
    size = dimensions[1] * dimensions[2] * dimensions[3] * bits // 8
    struct.pack_into("<8h", data, 40, 3, *dimensions[1:4], 1, 1, 1, 1)
    first = scratch / file.name
    first.write_bytes(gzip.compress(bytes(data[:start + size])))
    return first
