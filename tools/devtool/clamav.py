"""ClamAV's daemon for its test and measurement. It is unpacked rather than installed, so that the machine gets no new service and
downloads no signatures."""

from __future__ import annotations

import shutil
import socket
import subprocess
import time
from pathlib import Path

from . import packages, paths
from .console import CliError, say, step
from .users import RunAs

FOLDER = paths.REPO / ".tools" / "clamav"
_PACKAGES = ("clamav-daemon", "libclamav12", "libmspack0")
_LIBRARIES = FOLDER / "usr" / "lib" / "x86_64-linux-gnu"
CLAMD = FOLDER / "usr" / "sbin" / "clamd"
#: EICAR's test file, split in two parts, so that no virus scanner reports this file.
EICAR = rb"X5O!P%@AP[4\PZX54(P^)7CC)7}$" + b"EICAR-STANDARD-ANTIVIRUS-TEST-FILE!$H+H*"


class Daemon:
    """clamd run by an ordinary user in a separate folder, with the signature of EICAR's test file alone."""

    def __init__(self, run_as: RunAs, folder: Path):
        self.run_as, self.folder = run_as, folder
        self.path = folder / "s"
        (folder / "test.ndb").write_text(f"Eicar-Test:0:*:{EICAR.hex()}\n", encoding="ascii")
        (folder / "clamd.conf").write_text(f"LocalSocket {self.path}\nDatabaseDirectory {folder}\nTemporaryDirectory {folder}\n"
                                           "Foreground yes\nFixStaleSocket yes\n", encoding="ascii")
        for file in (folder, *folder.iterdir()):
            run_as.own(file)

    def start(self) -> None:
        self.path.unlink(missing_ok=True)
        self.process = subprocess.Popen([str(CLAMD), "-c", str(self.folder / "clamd.conf")], env=environment(), stdout=subprocess.DEVNULL,
                                        **self.run_as.popen())
        for _ in range(600):
            with socket.socket(socket.AF_UNIX) as one:
                if one.connect_ex(str(self.path)) == 0:
                    return
            time.sleep(0.1)
        raise CliError("clamd does not accept connections")

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


def environment() -> dict[str, str]:
    return {"LD_LIBRARY_PATH": str(_LIBRARIES), "LANG": "C.UTF-8"}


def ensure(may_install: bool = True) -> None:
    if CLAMD.exists():
        return
    if not may_install:
        say(f"missing: {CLAMD} (from the Debian packages {', '.join(_PACKAGES)})")
        raise CliError("dependencies are missing, and --no-install was given")
    step("Downloading clamd for its tests (7 MB)")
    beside = FOLDER.with_suffix(".new")
    shutil.rmtree(beside, ignore_errors=True)
    beside.mkdir(parents=True)
    packages.unpack(_PACKAGES, beside)
    beside.rename(FOLDER)
