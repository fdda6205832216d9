"""A data directory: its folders, its secrets, its record of what runs (stack.json)."""

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
from .says import HouseError
from .users import RunAs


def check(data: Path) -> None:
    """HouseError when it cannot be one. Makes nothing: it is asked before anything that takes long."""
    if not re.fullmatch(r"[\w./@+~-]+", str(data)):
        raise HouseError(f"{data}: a data directory's path may hold only letters, digits and ./@+~-_ (nginx reads it)")
    try:
        if data.exists() and not data.is_dir():
            raise HouseError(f"{data} is not a directory")
        if data.exists() and any(data.iterdir()) and not (data / "secrets").is_dir():
            raise HouseError(f"{data} holds something else than Diaphane's data; choose an empty directory (--data)")
        above = next(folder for folder in data.parents if folder.exists())
        if not data.exists() and not (above.is_dir() and os.access(above, os.W_OK | os.X_OK)):
            raise HouseError(f"{data} cannot be made in {above}; choose another place (--data)")
    except OSError as error:
        raise HouseError(f"{data} cannot be looked into: {error.strerror}; choose another place (--data)") from error


def claim(data: Path, run_as: RunAs) -> None:
    """Makes the directory itself, owned by the ordinary user: all that root does there. One that holds something
    else is refused, not taken over."""
    check(data)
    try:
        data.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise HouseError(f"{data} cannot be made: {error.strerror}; choose another place (--data)") from error
    if not any(data.iterdir()):
        run_as.own(data)
    if not run_as.can_write(data):
        raise HouseError(f"the user '{run_as.name or users.current()}', which everything runs as, cannot write in {data}; "
                         f"choose another place (--data), such as {users.default_data_dir()}")


def prepare(data: Path, run_as: RunAs) -> None:
    """claim(), and what is missing of its folders."""
    claim(data, run_as)
    for name in ("secrets", *FOLDERS):
        folder = data / name
        if not folder.exists():
            folder.mkdir(mode=0o700)
            run_as.own(folder)


def secret(data: Path, name: str, run_as: RunAs) -> str:
    """The secret of that name, made at random the first time; 256 bits in hex, in a file of mode 0600."""
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
    """What was written last; empty when there is none or it is unreadable."""
    try:
        record = json.loads((data / "stack.json").read_text(encoding="utf-8"))
        return record if isinstance(record, dict) else {}
    except (OSError, ValueError):
        return {}


def recorded(entry: dict) -> Identity | None:
    """The process of an entry of stack.json, when it is still the one that was written down, and alive."""
    try:
        identity = Identity(int(entry["pid"]), int(entry["start"]))
    except (KeyError, TypeError, ValueError):
        return None
    return identity if identity.alive() else None


#: The longest path of a Unix socket (sockaddr_un), and the longest name of those in a data directory.
MOST_SOCKET_PATH, LONGEST_SOCKET = 107, "renderd.sock"


def socket_folder(data: Path, run_as: RunAs) -> Path:
    """Where Unix sockets lie: run/ of the data directory, or, where their paths would be too long for a socket, a private folder
    below /run/user or /tmp. Nobody else can enter it."""
    uid = run_as.uid if run_as.uid >= 0 else os.geteuid()
    own = data / "run"
    if len(str(own / LONGEST_SOCKET)) <= MOST_SOCKET_PATH:
        if not is_private(own, uid):
            raise HouseError(f"{own} must be open to its owner alone: chmod 700 {own}")
        return own
    earlier = read_record(data).get("sockets")
    if isinstance(earlier, str) and is_private(Path(earlier), uid):
        return Path(earlier)
    runtime = Path(f"/run/user/{uid}")
    made = Path(tempfile.mkdtemp(prefix="diaphane-", dir=runtime if is_private(runtime, uid) else "/tmp"))
    run_as.own(made)
    return made


def is_private(folder: Path, uid: int) -> bool:
    """A directory, no link to one, of that user, that nobody else can enter."""
    try:
        about = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(about.st_mode) and about.st_uid == uid and about.st_mode & 0o077 == 0


def left_running(record: dict) -> list[tuple[str, Identity]]:
    """Name and leader of each program of stack.json of which something still runs, if only processes that it started."""
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
    """Held while a supervisor runs on a data directory; the kernel drops it when the supervisor dies."""

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
