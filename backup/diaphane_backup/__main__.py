"""Commands: save, restore, list, check. Settings come from the environment, as in the chart."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from .database import Database
from .errors import BackupError
from .installation import COMPLETE, Installation, Kept
from .repository import Repository


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="diaphane_backup", description="Saves and restores an installation of Diaphane, encrypted.")
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("save", help="make a backup and remove those that are no longer kept")
    restore = commands.add_parser("restore", help="restore a backup into an empty installation")
    restore.add_argument("snapshot", nargs="?", default=os.environ.get("DIAPHANE_BACKUP_SNAPSHOT") or "latest",
                         help="name of the backup (default: the newest)")
    commands.add_parser("list", help="list the backups")
    check = commands.add_parser("check", help="verify the repository")
    check.add_argument("--percent", type=int, choices=range(101), metavar="0-100", default=0, help="part of the data to read back (default: 0)")
    given = parser.parse_args(arguments)
    try:
        return _run(given)
    except BackupError as error:
        print(f"diaphane_backup: {error}", file=sys.stderr, flush=True)
        return 1


def _run(given: argparse.Namespace) -> int:
    started = time.monotonic()
    repository = Repository(_needed("DIAPHANE_BACKUP_REPOSITORY"), Path(_needed("DIAPHANE_BACKUP_KEY")), _folder("DIAPHANE_BACKUP_CACHE"))
    if given.command == "list":
        for one in repository.snapshots(COMPLETE):
            print(one.name, one.time)
        return 0
    if given.command == "check":
        repository.check(given.percent)
        print("the repository is intact")
        return 0
    installation = Installation(Path(_needed("DIAPHANE_BACKUP_DATA")), Database(_needed("DIAPHANE_POSTGRES"), _folder("DIAPHANE_POSTGRES_BIN")))
    if given.command == "save":
        name = installation.save(repository, Kept(_number("HOURLY", 24), _number("DAILY", 7), _number("WEEKLY", 4)))
        print(f"saved backup {name} in {time.monotonic() - started:.0f} s", flush=True)
    else:
        name = installation.restore(repository, given.snapshot)
        print(f"restored backup {name} in {time.monotonic() - started:.0f} s", flush=True)
    return 0


def _needed(name: str) -> str:
    value = os.environ.get(name, "")
    if not value:
        raise BackupError(f"{name} is not set")
    return value


def _folder(name: str) -> Path | None:
    value = os.environ.get(name, "")
    return Path(value) if value else None


def _number(which: str, default: int) -> int:
    text = os.environ.get(f"DIAPHANE_BACKUP_{which}", "") or str(default)
    if not text.isascii() or not text.isdigit() or not 0 <= int(text) <= 1000:
        raise BackupError(f"DIAPHANE_BACKUP_{which} must be a number of backups, at most 1000")
    return int(text)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
