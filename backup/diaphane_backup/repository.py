"""The encrypted repository, by restic."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import BackupError

#: Exit status of `restic backup` if it could not read some files.
_INCOMPLETE = 3


@dataclass(frozen=True)
class Snapshot:
    """A backup: its short name, when it was made (UTC, ISO 8601) and its tags."""

    name: str
    time: str
    tags: tuple[str, ...]


class Repository:
    """A repository at `place` (a folder, s3:..., sftp:... or another that restic knows), encrypted with the key in a file."""

    def __init__(self, place: str, key: Path, cache: Path | None = None):
        if not key.is_file() or not key.read_text(encoding="ascii", errors="replace").strip():
            raise BackupError(f"the backup key {key} is missing or empty")
        self._env = {**os.environ, "RESTIC_REPOSITORY": place, "RESTIC_PASSWORD_FILE": str(key), "RESTIC_PROGRESS_FPS": "0"}
        self._cache = [f"--cache-dir={cache}"] if cache else ["--no-cache"]

    def ensure(self) -> None:
        """Creates the repository if there is none. A repository with another key is an error and is left alone."""
        probe = self._call("cat", "config")
        if probe.returncode == 0:
            # Locks of backups that were killed would keep keep() from removing anything.
            self._run("unlock")
            return
        text = probe.stderr
        if "wrong password" in text or "no key found" in text:
            raise BackupError("the repository was made with another key")
        if "Is there a repository" not in text and "does not exist" not in text and "unable to open config file" not in text:
            raise BackupError(f"the repository cannot be opened: {_reason(text)}")
        self._run("init")

    def save(self, folder: Path, names: list[str], tag: str, parent: str = "", leave_out: tuple[str, ...] = ()) -> str:
        """Copies entries of a folder into a new snapshot and returns its name. Only what is not in the repository is stored, and
        files that are as they were in the snapshot `parent` are not read.

        Raises BackupError. A file that cannot be read is an error unless it has been deleted meanwhile.
        """
        present = [name for name in names if (folder / name).exists()]
        options = [*([f"--parent={parent}"] if parent else ["--force"]), *(f"--exclude={folder / name}" for name in leave_out)]
        done = self._call("backup", "--json", "--host=diaphane", f"--tag={tag}", *options, *present, cwd=folder)
        messages = [json.loads(line) for line in (done.stdout + done.stderr).splitlines() if line.startswith("{")]
        unread = [Path(one.get("item", "")) for one in messages if one.get("message_type") == "error"]
        if kept := [path for path in unread if os.path.lexists(folder / path)]:
            raise BackupError(f"{len(kept)} files cannot be read")
        if done.returncode not in (0, _INCOMPLETE):
            raise BackupError(f"restic backup failed: {_reason(done.stderr)}")
        made = [str(one["snapshot_id"]) for one in messages if one.get("message_type") == "summary"]
        if not made:
            raise BackupError("restic backup made no snapshot")
        return made[0][:8]

    def snapshots(self, tag: str) -> list[Snapshot]:
        """Returns the snapshots with a tag, oldest first."""
        listed: list[dict[str, Any]] = json.loads(self._run("snapshots", "--json", f"--tag={tag}") or "[]") or []
        return [Snapshot(one["short_id"], one["time"], tuple(one.get("tags") or ())) for one in sorted(listed, key=lambda one: str(one["time"]))]

    def restore(self, snapshot: str, into: Path) -> None:
        self._run("restore", snapshot, f"--target={into}")

    def keep(self, tag: str, hourly: int, daily: int, weekly: int) -> None:
        """Forgets older snapshots and removes the data that no other snapshot has."""
        self._run("forget", f"--tag={tag}", "--group-by=host,tags", f"--keep-hourly={hourly}", f"--keep-daily={daily}",
                  f"--keep-weekly={weekly}", "--prune")

    def forget(self, tag: str) -> None:
        """Forgets all snapshots with a tag, but keeps their data until keep() is called."""
        if names := [one.name for one in self.snapshots(tag)]:
            self._run("forget", *names)

    def check(self, percent: int) -> None:
        """Verifies the structure and reads this part of the data back. Raises BackupError if anything is damaged."""
        self._run("check", *([f"--read-data-subset={percent}%"] if percent else []))

    def _call(self, *arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        try:
            return subprocess.run(["restic", *self._cache, *arguments], env=self._env, cwd=cwd,
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True)
        except FileNotFoundError as error:
            raise BackupError("restic is not installed") from error

    def _run(self, *arguments: str) -> str:
        done = self._call(*arguments)
        if done.returncode != 0:
            raise BackupError(f"restic {arguments[0]} failed: {_reason(done.stderr)}")
        return done.stdout


def _reason(text: str) -> str:
    lines = [line for line in text.strip().splitlines() if line.strip()]
    return lines[-1] if lines else "no output"
