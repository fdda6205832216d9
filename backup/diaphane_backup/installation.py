"""What belongs to a backup, and the order in which it is saved and restored."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from .database import Database
from .errors import BackupError
from .repository import Repository

#: The scans with all that was made of them, and uploads, which ingest may still have to read.
SCANS = ("volumes", "uploads")
#: What else belongs to an installation outside of a cluster. In a cluster, secrets and settings are objects of their own.
SETTINGS = ("secrets", "legal", "archives.toml", "sample.loaded", "sample-ch2.loaded", "sample-inia19-t1-brain.loaded")
FILES = (*SCANS, *SETTINGS)
#: The key must not be where only the key opens it, and a new database has passwords of its own.
LEFT_OUT = ("secrets/backup-key", "secrets/postgres", "secrets/postgres-superuser")
#: Tags of complete backups, and of copies of the files that make the next one short.
COMPLETE, FILES_ONLY = "complete", "files"
_DATABASE = "database"
_ID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")


@dataclass(frozen=True)
class Kept:
    """How many backups are kept: of the newest hours, days and weeks that have one."""

    hourly: int = 24
    daily: int = 7
    weekly: int = 4


@dataclass(frozen=True)
class Installation:
    """An installation whose folders lie in `folder`. The folder itself need not be writable if it has a folder `database`."""

    folder: Path
    database: Database

    def save(self, repository: Repository, kept: Kept = Kept()) -> str:
        """Makes a backup and returns its name. Every file that its database names is in it.

        Most of the files are copied first, while users can still delete them. The second pass, in which nothing is deleted, then has
        little left to copy. Raises BackupError, and leaves no backup that looks complete.
        """
        repository.ensure()
        newest = repository.snapshots(COMPLETE)
        first = repository.save(self.folder, list(FILES), FILES_ONLY, newest[-1].name if newest else "", LEFT_OUT)
        with self.database.files_kept(), self._private() as private:
            self.database.dump(private / "dump")
            name = repository.save(self.folder, [*FILES, _DATABASE], COMPLETE, first, LEFT_OUT)
        repository.forget(FILES_ONLY)
        repository.keep(COMPLETE, kept.hourly, kept.daily, kept.weekly)
        return name

    def restore(self, repository: Repository, snapshot: str = "latest") -> str:
        """Restores a backup into an installation without users and scans. Returns the name of the backup.

        Users sign in again. Raises BackupError; if it does so after the files were restored, the next attempt needs empty folders.
        """
        saved = repository.snapshots(COMPLETE)
        chosen = saved[-1:] if snapshot == "latest" else [one for one in saved if one.name == snapshot]
        if not chosen:
            raise BackupError("the repository has no backup" + (f" {snapshot}" if snapshot != "latest" else ""))
        if self.database.has_users():
            raise BackupError("the database already has users; a backup is restored only into an empty installation")
        if filled := [name for name in SCANS if any((self.folder / name).glob("*"))]:
            raise BackupError(f"{' and '.join(filled)} already contain files; a backup is restored only into an empty installation")
        with self._private() as private:
            repository.restore(chosen[0].name, self.folder)
            if not (private / "dump").is_file():
                raise BackupError("the backup has no database")
            self.database.restore(private / "dump")
        self.database.forget_sign_ins()
        self._remove_unknown_scans()
        return chosen[0].name

    def _remove_unknown_scans(self) -> None:
        """Deletes volumes of scans that were created after the dump or deleted before it."""
        known = self.database.data_sets()
        for folder in (self.folder / "volumes").iterdir():
            if _ID.fullmatch(folder.name) and folder.name not in known:
                shutil.rmtree(folder)

    @contextmanager
    def _private(self) -> Iterator[Path]:
        """A folder for the dump that only this user can read and that is empty afterwards."""
        folder = self.folder / _DATABASE
        folder.mkdir(mode=0o700, exist_ok=True)
        try:
            (folder / "dump").unlink(missing_ok=True)    # of a backup that was killed
            yield folder
        finally:
            (folder / "dump").unlink(missing_ok=True)
            with suppress(OSError):    # in a pod, the folder is a volume
                folder.rmdir()
