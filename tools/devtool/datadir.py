"""A data directory: its folders, its secrets, and its record of running programs (stack.json)."""

from __future__ import annotations

import fcntl
import json
import os
import re
import secrets
import stat
import tempfile
from pathlib import Path

from . import processes, users
from .plan import FOLDERS
from .processes import Identity
from .console import CliError
from .users import RunAs


def check(data: Path) -> None:
    """Raises CliError if this cannot be a data directory. Creates nothing, because it is called before any long operation."""
    if not re.fullmatch(r"[\w./@+~-]+", str(data)):
        raise CliError(f"{data}: the path of a data directory may contain only letters, digits and ./@+~-_ (a limit of nginx)")
    try:
        if data.exists() and not data.is_dir():
            raise CliError(f"{data} is not a directory")
        if data.exists() and any(data.iterdir()) and not (data / "secrets").is_dir():
            raise CliError(f"{data} contains files that are not Diaphane's. Choose an empty directory (--data)")
        above = next(folder for folder in data.parents if folder.exists())
        if not data.exists() and not (above.is_dir() and os.access(above, os.W_OK | os.X_OK)):
            raise CliError(f"cannot create {data}: no write access to {above}. Choose another directory (--data)")
    except OSError as error:
        raise CliError(f"cannot read {data}: {error.strerror}. Choose another directory (--data)") from error


def claim(data: Path, run_as: RunAs) -> None:
    """Creates the directory for the ordinary user, which is all that root does there. A directory with other contents is refused.
    """
    check(data)
    try:
        data.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise CliError(f"cannot create {data}: {error.strerror}. Choose another directory (--data)") from error
    if not any(data.iterdir()):
        run_as.own(data)
    if not run_as.can_write(data):
        raise CliError(f"Diaphane runs as the user '{run_as.name or users.current()}', who cannot write to {data}. "
                         f"Choose another directory (--data), such as {users.default_data_dir()}")


def prepare(data: Path, run_as: RunAs) -> None:
    """Calls claim() and creates missing folders."""
    claim(data, run_as)
    for name in ("secrets", *FOLDERS):
        folder = data / name
        if not folder.exists():
            folder.mkdir(mode=0o700)
            run_as.own(folder)


def secret(data: Path, name: str, run_as: RunAs) -> str:
    """Returns the secret of that name: 256 bits in hex, created at random the first time, in a file of mode 0600."""
    path = data / "secrets" / name
    if not path.exists():
        beside = path.with_name(f".{name}")
        beside.unlink(missing_ok=True)
        handle = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "w", encoding="ascii") as file:
            file.write(secrets.token_hex(32))
        run_as.own(beside)
        beside.rename(path)
    return path.read_text(encoding="ascii").strip()


def write_record(data: Path, record: dict) -> None:
    beside = data / "stack.json.new"
    beside.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    beside.replace(data / "stack.json")


def read_record(data: Path) -> dict:
    """Returns the last record, or an empty one if it is missing or unreadable."""
    try:
        record = json.loads((data / "stack.json").read_text(encoding="utf-8"))
        return record if isinstance(record, dict) else {}
    except (OSError, ValueError):
        return {}


def recorded(entry: dict) -> Identity | None:
    """Returns the process of an entry of stack.json if it is alive and still the recorded one."""
    try:
        identity = Identity(int(entry["pid"]), int(entry["start"]))
    except (KeyError, TypeError, ValueError):
        return None
    return identity if identity.alive() else None


#: The longest path of a Unix socket (sockaddr_un), and the longest name of a socket in a data directory.
MOST_SOCKET_PATH, LONGEST_SOCKET = 107, "renderd.sock"


def socket_folder(data: Path, run_as: RunAs) -> Path:
    """Returns the folder for Unix sockets: run/ of the data directory or, if the paths would be too long for a socket, a private
    folder below /run/user or /tmp that other users cannot enter."""
    uid = run_as.uid if run_as.uid >= 0 else os.geteuid()
    own = data / "run"
    if len(str(own / LONGEST_SOCKET)) <= MOST_SOCKET_PATH:
        if not is_private(own, uid):
            raise CliError(f"{own} must be accessible to its owner only. Run: chmod 700 {own}")
        return own
    earlier = read_record(data).get("sockets")
    if isinstance(earlier, str) and is_private(Path(earlier), uid):
        return Path(earlier)
    runtime = Path(f"/run/user/{uid}")
    made = Path(tempfile.mkdtemp(prefix="diaphane-", dir=runtime if is_private(runtime, uid) else "/tmp"))
    run_as.own(made)
    return made


def is_private(folder: Path, uid: int) -> bool:
    """Whether this is a directory of that user, not a link, that nobody else can enter."""
    try:
        about = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(about.st_mode) and about.st_uid == uid and about.st_mode & 0o077 == 0


def left_running(record: dict) -> list[tuple[str, Identity]]:
    """Returns the name and leader of each program of stack.json that left a running process, even if only one that it started."""
    if record.get("boot", processes.boot()) != processes.boot():
        return []
    found = []
    for entry in record.get("programs", []):
        try:
            leader = Identity(int(entry["pid"]), int(entry["start"]))
        except (KeyError, TypeError, ValueError):
            continue
        if leader.alive() or leader.group():
            found.append((str(entry.get("name", "?")), leader))
    return found


class Lock:
    """Held while a supervisor runs on a data directory. The kernel releases it when the supervisor dies."""

    def __init__(self, data: Path):
        self.file_ = open(data / "run" / "supervisor.lock", "a", encoding="ascii")

    def take(self) -> bool:
        try:
            fcntl.flock(self.file_, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            return False

    def drop(self) -> None:
        self.file_.close()
