"""ClamAV's daemon for the test of it: unpacked, not installed, so that the machine has no service more and looks for no signatures."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from . import packages, paths
from .says import HouseError, say, step

FOLDER = paths.REPO / ".tools" / "clamav"
_PACKAGES = ("clamav-daemon", "libclamav12", "libmspack0")
_LIBRARIES = FOLDER / "usr" / "lib" / "x86_64-linux-gnu"
CLAMD = FOLDER / "usr" / "sbin" / "clamd"


def environment() -> dict[str, str]:
    return {"LD_LIBRARY_PATH": str(_LIBRARIES), "LANG": "C.UTF-8"}


def ensure(may_install: bool = True) -> None:
    if CLAMD.exists():
        return
    if not may_install:
        say(f"missing: {CLAMD} (Debian packages {', '.join(_PACKAGES)}, unpacked)")
        raise HouseError("nothing was installed (--no-install)")
    step("Fetching ClamAV's daemon for its test (7 MB)")
    with tempfile.TemporaryDirectory(prefix="diaphane-clamav-") as folder:
        if os.geteuid() == 0:
            shutil.chown(folder, "_apt")
        if _download(folder) != 0:
            packages.update()      # the lists may be older than what the mirror still has
            if _download(folder) != 0:
                raise HouseError("apt-get download failed: " + " ".join(_PACKAGES))
        beside = FOLDER.with_suffix(".new")
        shutil.rmtree(beside, ignore_errors=True)
        beside.mkdir(parents=True)
        for file in sorted(Path(folder).glob("*.deb")):
            subprocess.run(["dpkg-deb", "-x", str(file), str(beside)], check=True)
        beside.rename(FOLDER)


def _download(folder: str) -> int:
    return subprocess.run(["apt-get", "-qq", "download", *_PACKAGES], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
