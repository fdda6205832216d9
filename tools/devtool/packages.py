"""Finds and installs missing Debian packages."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Sequence

from . import commands, paths
from .progress import AptProgress
from .console import CliError, progress, say, step

#: Services that Debian would start, also at each boot, although Diaphane starts its own.
SERVICES = {"postgresql": "postgresql", "redis-server": "redis-server", "nginx-light": "nginx", "orthanc": "orthanc"}
_POLICY = Path("/usr/sbin/policy-rc.d")


def required(tests: bool = True) -> list[str]:
    """Returns the packages in packages.txt, or without `tests` only those for building and running."""
    lines = (paths.TOOLS / "packages.txt").read_text(encoding="utf-8").splitlines()
    names = [name for line in lines if (name := line.partition("#")[0].strip())]
    section = names.index("[tests]")
    return names[:section] + (names[section + 1:] if tests else [])


def missing(names: list[str], query=None) -> list[str]:
    """Returns the `names` that dpkg does not list as installed. `query` (for tests) returns dpkg-query's output."""
    done = (query or _dpkg_query)(names)
    present = {line.split()[0] for line in done.splitlines() if line.endswith(" ok installed")}
    return [name for name in names if name not in present]


def install(names: list[str], afterwards: str = "") -> None:
    """Installs packages as root or with sudo. Services among them are neither started nor enabled. `afterwards` says in the
    progress what comes next."""
    _as_root()      # exits with a message if it cannot become root
    step(f"Installing {len(names)} Debian packages: {' '.join(names)}")
    if not any(Path("/var/lib/apt/lists").glob("*_Packages*")):
        _apt("update")
    with _services_stay_off(names):
        if _apt("install", "--no-install-recommends", *names, check=False, afterwards=afterwards) != 0:
            _apt("update")      # the package lists may be older than the mirror
            _apt("install", "--no-install-recommends", *names, afterwards=afterwards)


def unpack(names: Sequence[str], into: Path) -> None:
    """Downloads packages and unpacks them into a folder. They are not installed, so that the machine gets no new services."""
    with tempfile.TemporaryDirectory(prefix="diaphane-packages-") as folder:
        # Without this option, apt-get as root would download as a user who cannot write to this
        # folder.
        command = ["apt-get", "-qq", "-o", "APT::Sandbox::User=", "download", *names]
        if commands.run(command, cwd=folder).returncode != 0:
            _apt("update")      # the package lists may be older than the mirror
            commands.output(command, f"apt-get download {' '.join(names)}", cwd=folder)
        for package in Path(folder).glob("*.deb"):
            commands.output(["dpkg-deb", "-x", package, into])


def _dpkg_query(names: list[str]) -> str:
    command = ["dpkg-query", "-W", "-f", "${Package} ${Status}\\n", *names]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout


def _as_root() -> list[str]:
    if os.geteuid() == 0:
        return []
    if not shutil.which("sudo"):
        raise CliError("Debian packages are missing, and sudo is not available to install them. Run as root:\n"
                         "apt-get update && apt-get install --no-install-recommends " + " ".join(missing(required())))
    return ["sudo"]


def _apt(*arguments: str, check: bool = True, afterwards: str = "") -> int:
    # sudo closes all files but the standard ones, and apt-get does not pass its status file on to
    # dpkg, whose scripts need standard output. Hence a shell, started by sudo, creates the status
    # file as a copy of standard output.
    command = [*_as_root(), "sh", "-c", 'exec "$@" 3>&1', "sh", "env", "DEBIAN_FRONTEND=noninteractive", "LC_ALL=C.UTF-8",
               "apt-get", "-qq", "-y", "-o", "Dpkg::Use-Pty=0", "-o", "APT::Status-Fd=3", *arguments]
    what = "Updating Debian's package lists" if arguments[0] == "update" else "Installing Debian packages"
    state = AptProgress()
    output = []
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, errors="replace") as running:
        for line in running.stdout:
            if state.read(line, time.monotonic()):
                progress(f"{what}: {state.text(time.monotonic())}{afterwards}")
            else:
                output.append(line.rstrip("\n"))
    if running.returncode != 0 and check:
        raise CliError(f"apt-get {arguments[0]} failed:\n" + "\n".join(output[-20:]))
    return running.returncode


@contextlib.contextmanager
def _services_stay_off(names: list[str]):
    new = [SERVICES[name] for name in names if name in SERVICES]
    ours = bool(new) and not _POLICY.exists()
    if ours:
        script = "printf '#!/bin/sh\\nexit 101\\n' > {0} && chmod 755 {0}".format(_POLICY)
        subprocess.run([*_as_root(), "sh", "-c", script], check=True)
    try:
        yield
    finally:
        if ours:
            subprocess.run([*_as_root(), "rm", "-f", str(_POLICY)], check=True)
    if new and Path("/run/systemd/system").is_dir():
        say(f"Left stopped and disabled, because Diaphane starts its own: {', '.join(new)}")
        subprocess.run([*_as_root(), "systemctl", "disable", "--quiet", *new], stderr=subprocess.DEVNULL)
