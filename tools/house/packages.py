"""Debian packages: which are missing, and their installation."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
from pathlib import Path

from . import paths
from .says import HouseError, say, step

#: Services that Debian would start, and again at each boot, though Diaphane runs its own.
SERVICES = {"postgresql": "postgresql", "redis-server": "redis-server", "nginx-light": "nginx"}
_POLICY = Path("/usr/sbin/policy-rc.d")


def wanted() -> list[str]:
    lines = (paths.TOOLS / "packages.txt").read_text(encoding="utf-8").splitlines()
    return [name for line in lines if (name := line.partition("#")[0].strip())]


def missing(names: list[str], query=None) -> list[str]:
    """Those of `names` that dpkg does not have installed. `query` (tests) gives dpkg-query's answer."""
    done = (query or _dpkg_query)(names)
    present = {line.split()[0] for line in done.splitlines() if line.endswith(" ok installed")}
    return [name for name in names if name not in present]


def install(names: list[str]) -> None:
    """Installs them, by root or sudo. The services among them are neither started nor enabled."""
    _as_root()      # where it cannot, it says so first
    step(f"Installing {len(names)} Debian packages (minutes): {' '.join(names)}")
    if not any(Path("/var/lib/apt/lists").glob("*_Packages*")):
        _apt("update")
    with _services_stay_off(names):
        if _apt("install", "--no-install-recommends", *names, check=False) != 0:
            _apt("update")      # the lists may be older than what the mirror still has
            _apt("install", "--no-install-recommends", *names)


def update() -> None:
    _apt("update")


def _dpkg_query(names: list[str]) -> str:
    command = ["dpkg-query", "-W", "-f", "${Package} ${Status}\\n", *names]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout


def _as_root() -> list[str]:
    if os.geteuid() == 0:
        return []
    if not shutil.which("sudo"):
        raise HouseError("Debian packages are missing, and there is no sudo to install them with. As root:\n"
                         "apt-get update && apt-get install --no-install-recommends " + " ".join(missing(wanted())))
    return ["sudo"]


def _apt(*words: str, check: bool = True) -> int:
    command = [*_as_root(), "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", "-y",
               "-o", "Dpkg::Use-Pty=0", *words]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)
    if done.returncode != 0 and check:
        raise HouseError(f"apt-get {words[0]} failed:\n" + "\n".join(done.stdout.splitlines()[-20:]))
    return done.returncode


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
        say(f"Not started and not enabled, because Diaphane runs its own: {', '.join(new)}")
        subprocess.run([*_as_root(), "systemctl", "disable", "--quiet", *new], stderr=subprocess.DEVNULL)
