"""The ordinary user that everything runs as when `./diaphane` was started by root."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from .says import HouseError, say

NAME = "diaphane"


@dataclass(frozen=True)
class RunAs:
    """Arguments for subprocess.Popen. Empty when we are an ordinary user already."""

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
        """Gives up root for good in this process, so that nothing in a data directory, where the programs may write
        and place links, is ever followed by root. Who we are afterwards: nobody in particular."""
        if self.uid >= 0:
            os.setgroups([])
            os.setgid(self.gid)
            os.setuid(self.uid)
            os.environ.update(HOME=self.home, USER=self.name, LOGNAME=self.name)
        return RunAs()

    def can_read(self, *paths: Path) -> bool:
        """Whether this user gets at all of them (a clone below /root or in a mktemp directory: no)."""
        return self.uid < 0 or self._try('for path; do [ -r "$path" ] || exit 1; done', *paths)

    def can_write(self, folder: Path) -> bool:
        return os.access(folder, os.W_OK | os.X_OK) if self.uid < 0 else self._try('[ -w "$1" ] && [ -x "$1" ]', folder)

    def _try(self, script: str, *paths: Path) -> bool:
        done = subprocess.run(["/bin/sh", "-c", script, "sh", *map(str, paths)], cwd="/", **self.popen())
        return done.returncode == 0


def ordinary_user() -> RunAs:
    """Nobody in particular when we are not root; else the system user `diaphane`, made when it is missing."""
    if os.geteuid() != 0:
        return RunAs()
    try:
        entry = pwd.getpwnam(NAME)
    except KeyError:
        useradd = shutil.which("useradd") or "/usr/sbin/useradd"
        if not Path(useradd).exists():
            raise HouseError(f"started by root, and there is neither a user '{NAME}' nor useradd to make it")
        say(f"Started by root: making the system user '{NAME}' that everything will run as.")
        subprocess.run([useradd, "--system", "--user-group", "--no-create-home", "--home-dir",
                        "/var/lib/diaphane", "--shell", "/usr/sbin/nologin", NAME], check=True)
        entry = pwd.getpwnam(NAME)
    return RunAs(NAME, entry.pw_uid, entry.pw_gid, entry.pw_dir)


def current() -> str:
    return pwd.getpwuid(os.geteuid()).pw_name


def owner_of(path: Path) -> RunAs:
    """For root: the user whose directory it is. Nobody in particular for others, and where root itself owns it."""
    try:
        entry = pwd.getpwuid(path.stat().st_uid)
    except (OSError, KeyError):
        return RunAs()
    if os.geteuid() != 0 or entry.pw_uid == 0:
        return RunAs()
    return RunAs(entry.pw_name, entry.pw_uid, entry.pw_gid, entry.pw_dir)


def default_data_dir() -> Path:
    """~/.local/share/diaphane; for root /var/lib/diaphane, because nobody else can enter /root."""
    if os.geteuid() == 0:
        return Path("/var/lib/diaphane")
    base = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(base) / "diaphane"
