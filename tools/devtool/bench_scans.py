"""The real scans that the benchmarks of ingest and of volumes use."""

from __future__ import annotations

import subprocess
from pathlib import Path

from . import paths
from .bench_volumes import CRANIUM
from .console import say

CH2 = Path("/usr/share/mricron/templates/ch2.nii.gz")     # Debian's mricron-data
SHARED_SCANS = paths.REPO.parent / "shared" / "scans"


def scans_of(folder: Path, scratch: Path) -> list[Path]:
    """Returns the NIfTI files of the folder and those that Debian packages have. Converted files go to `scratch`."""
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
    import nibabel

    image = nibabel.load(file)
    if image.ndim <= 3:
        return file
    first = scratch / file.name
    nibabel.save(image.slicer[..., 0], first)
    return first
