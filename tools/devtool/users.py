"""The ordinary user that runs everything if root started `./diaphane`."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from .console import CliError, say

NAME = "diaphane"


@dataclass(frozen=True)
class RunAs:
    """Arguments for subprocess.Popen. Empty for an ordinary user."""

    name: str = ""
    uid: int = -1
    gid: int = -1
    home: str = ""

    def popen(self) -> dict:
        if self.uid < 0:
            return {}
        return {"user": self.uid, "group": self.gid, "extra_groups": []}

    def own(self, path: Path) -> None:
        if self.uid >= 0:
            os.chown(path, self.uid, self.gid, follow_symlinks=False)

    def become(self) -> "RunAs":
        """Permanently gives up root in this process, so that root never follows links in a data directory, where the programs can
        create them. Returns the RunAs of the new user, which is empty."""
        if self.uid >= 0:
            os.setgroups([])
            os.setgid(self.gid)
            os.setuid(self.uid)
            os.environ.update(HOME=self.home, USER=self.name, LOGNAME=self.name)
        return RunAs()

    def can_read(self, *paths: Path) -> bool:
        """Whether this user can read all of the paths. They may be in a clone below /root or in a
        mktemp directory."""
        return self.uid < 0 or self._try('for path; do [ -r "$path" ] || exit 1; done', *paths)

    def can_write(self, folder: Path) -> bool:
        return os.access(folder, os.W_OK | os.X_OK) if self.uid < 0 else self._try('[ -w "$1" ] && [ -x "$1" ]', folder)

    def _try(self, script: str, *paths: Path) -> bool:
        done = subprocess.run(["/bin/sh", "-c", script, "sh", *map(str, paths)], cwd="/", **self.popen())
        return done.returncode == 0


def ordinary_user() -> RunAs:
    """Returns an empty RunAs unless root runs this. Otherwise, returns the system user `diaphane`, created if missing."""
    if os.geteuid() != 0:
        return RunAs()
    try:
        entry = pwd.getpwnam(NAME)
    except KeyError:
        useradd = shutil.which("useradd") or "/usr/sbin/useradd"
        if not Path(useradd).exists():
            raise CliError(f"started as root, but the user '{NAME}' does not exist and useradd is not available to create it")
        say(f"Started as root: creating the system user '{NAME}', which everything runs as.")
        subprocess.run([useradd, "--system", "--user-group", "--no-create-home", "--home-dir",
                        "/var/lib/diaphane", "--shell", "/usr/sbin/nologin", NAME], check=True)
        entry = pwd.getpwnam(NAME)
    return RunAs(NAME, entry.pw_uid, entry.pw_gid, entry.pw_dir)


def current() -> str:
    return pwd.getpwuid(os.geteuid()).pw_name


def owner_of(path: Path) -> RunAs:
    """Returns the user who owns the directory, if root runs this. Returns an empty RunAs for other
    users, and for directories of root."""
    try:
        entry = pwd.getpwuid(path.stat().st_uid)
    except (OSError, KeyError):
        return RunAs()
    if os.geteuid() != 0 or entry.pw_uid == 0:
        return RunAs()
    return RunAs(entry.pw_name, entry.pw_uid, entry.pw_gid, entry.pw_dir)


def default_data_dir() -> Path:
    """Returns ~/.local/share/diaphane, or /var/lib/diaphane for root, because other users cannot enter /root."""
    if os.geteuid() == 0:
        return Path("/var/lib/diaphane")
    base = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(base) / "diaphane"
