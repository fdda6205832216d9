"""`./diaphane backup` and `./diaphane restore`: encrypted backups of a data directory with restic (backup/diaphane_backup)."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from . import datadir, layout, packages, ports, supervise, users
from .console import CliError, say
from .plan import POSTGRES_BIN, Settings
from .stack import Stack
from .users import RunAs

KEY = "backup-key"


def save(data: Path, place: str, key: Path | None, list_only: bool, check_percent: int | None) -> int:
    """Backs up the instance that runs on `data` to the repository at `place`, or lists or verifies its backups."""
    _need_restic()
    run_as = users.owner_of(data) if data.exists() else users.ordinary_user()
    run_as = run_as if run_as.uid >= 0 else RunAs()
    if key is None:
        if not (data / "secrets").is_dir():
            raise CliError(f"{data} is not a data directory")
        made = not (data / "secrets" / KEY).exists()
        datadir.secret(data, KEY, run_as)
        key = data / "secrets" / KEY
        if made:
            say(f"Created the key of the backups, {key}. Keep a copy of it elsewhere: without it, nobody can restore them.")
    place = _folder(place, run_as)
    package = layout.reachable(run_as, layout.copy_folder()).backup
    if list_only or check_percent is not None:
        return run_package(["list"] if list_only else ["check", "--percent", str(check_percent)], package, data, place, key, "", run_as)
    if supervise.running_supervisor(data) is None:
        raise CliError(f"Diaphane is not running on {data}. Start it first: ./diaphane up --detach")
    settings = Settings(data=data, ports=datadir.read_record(data)["ports"], layout=layout.of_checkout(),
                        postgres_password=datadir.secret(data, "postgres", run_as))
    return run_package(["save"], package, data, place, key, settings.dsn, run_as)


def restore(data: Path, place: str, key: Path, snapshot: str) -> int:
    """Restores a backup into the new data directory `data`, which may not run meanwhile."""
    _need_restic()
    datadir.check(data)
    if (data / "postgres").exists():
        raise CliError(f"{data} already has an instance. Choose a new directory (--data)")
    if not key.is_file():
        raise CliError(f"{key} does not exist. A backup can be restored only with the key that it was made with", 66)
    secret = key.read_text(encoding="ascii", errors="replace")
    run_as = users.ordinary_user()
    datadir.claim(data, run_as)
    programs = layout.reachable(run_as, layout.copy_folder())
    place = _folder(place, run_as)
    os.chdir("/")           # the ordinary user may have no access to the current directory
    run_as = run_as.become()
    with Stack(data=data, ports=ports.random_free(), layout=programs, run_as=run_as, only=("postgres",)) as stack:
        # The instance needs the key for its next backups.
        copied = data / "secrets" / KEY
        copied.touch(mode=0o600)
        copied.write_text(secret, encoding="ascii")
        code = run_package(["restore", snapshot], programs.backup, data, place, copied, stack.settings.dsn, run_as)
    if code == 0:
        say(f"Start the instance: ./diaphane up --data {data}")
    return code


def run_package(arguments: list[str], package: Path, data: Path, place: str, key: Path, dsn: str, run_as: RunAs) -> int:
    env = {**os.environ, "PYTHONPATH": str(package), "PYTHONDONTWRITEBYTECODE": "1", "HOME": str(data), "DIAPHANE_BACKUP_DATA": str(data),
           "DIAPHANE_BACKUP_REPOSITORY": place, "DIAPHANE_BACKUP_KEY": str(key), "DIAPHANE_POSTGRES": dsn, "DIAPHANE_POSTGRES_BIN": str(POSTGRES_BIN)}
    return subprocess.run(["/usr/bin/python3", "-m", "diaphane_backup", *arguments], cwd="/", env=env, **run_as.popen()).returncode


def _need_restic() -> None:
    if missing := packages.missing(["restic"]):
        packages.install(missing)


def _folder(place: str, run_as: RunAs) -> str:
    """Returns the place as restic needs it. A folder is made absolute, and belongs to the user that Diaphane runs as."""
    if ":" in place:
        return place
    folder = Path(place).expanduser().resolve()
    if not folder.exists():
        folder.mkdir(mode=0o700, parents=True)
        run_as.own(folder)
    if not run_as.can_write(folder):
        raise CliError(f"Diaphane runs as the user '{run_as.name or users.current()}', who cannot write to {folder}")
    return str(folder)
