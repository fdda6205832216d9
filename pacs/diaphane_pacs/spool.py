"""Received series on disk, from the success that a sender is told until the upload is complete. The images are cleaned before they are
written, so no patient data is here. A series outlives the end of the gateway at any moment.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import hmac
import json
import mmap
import os
import shutil
import sys
import threading
import time
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

from diaphane._upload import END, member

from . import limits
from .errors import ArchiveError, faulty
from .series_file import SeriesFile


@dataclass(frozen=True)
class Sender:
    """Who sends: the way, a name for the metrics, and the token of the account."""

    via: str
    name: str
    token: str


class SpoolError(Exception):
    """The spool cannot be used."""


class SpooledSeries(SeriesFile):
    """A series in a folder of its own: `series.tar`, and `series.jsonl` with a line about the series and one per image. What the last
    complete line does not cover was never confirmed to the sender.
    """

    def __init__(self, spool: Spool, folder: Path, sender: Sender, series: str, received: float, free_bytes: int):
        super().__init__(file=_opened(folder / "series.tar"))
        self.spool, self.folder, self.sender = spool, folder, sender
        self.series_code, self.received, self.free_bytes = series, received, free_bytes
        self._lines = _opened(folder / "series.jsonl")
        self.is_complete = False
        self._end = 0
        self._lines_end = 0

    def code(self, uid: str) -> str:
        return self.spool.code(uid)

    def begin(self) -> None:
        # A device's token stays in the settings. That of a STOW request is kept, because nothing else can upload for its account.
        token = self.sender.token if self.sender.via == "stow" else ""
        self._line({"via": self.sender.via, "name": self.sender.name, "token": token, "series": self.series_code,
                    "received": self.received, "free_bytes": self.free_bytes})
        for folder in (self.folder, self.folder.parent):
            _sync_folder(folder)

    def recover(self, lines: list[bytes]) -> None:
        """Takes over the images that were confirmed. The first line is about the series."""
        self._lines_end = len(lines[0])
        for line in lines[1:]:
            try:
                image = json.loads(line)
                if "complete" in image:
                    self.is_complete = True
                    continue
                if image["end"] > os.fstat(self._file.fileno()).st_size:
                    break
                self.images.add(image["image"])
                self.frames += image["frames"]
                self.modality, self.bytes, self._end = image["modality"], image["bytes"], image["end"]
            except (ValueError, KeyError, TypeError):
                break
            self._lines_end += len(line)
        self.spool.take(self._end, always=True)

    def complete(self) -> None:
        """Notes that the sender has sent everything."""
        self.is_complete = True
        with contextlib.suppress(OSError):
            self._line({"complete": True})

    def _write(self, data: bytes, image: str, frames: int) -> None:
        """Returns only once the image is on the disk."""
        if self.bytes + len(data) > limits.MOST_SERIES_BYTES:
            raise faulty("the series is larger than a series may be")
        packed = b"".join(member(len(self.images) + 1, data))
        self.spool.take(len(packed))
        try:
            _write_at(self._file.fileno(), packed, self._end)
            self._line({"image": image, "frames": frames, "modality": self.modality, "bytes": self.bytes + len(data), "end": self._end + len(packed)})
        except OSError as error:
            self.spool.take(-len(packed))
            raise ArchiveError("no-room", "the disk of the spool is full or fails") from error
        self.bytes += len(data)
        self._end += len(packed)

    def _line(self, line: dict[str, Any]) -> None:
        data = json.dumps(line).encode() + b"\n"
        _write_at(self._lines.fileno(), data, self._lines_end)
        self._lines_end += len(data)

    def finish(self) -> mmap.mmap:
        _write_at(self._file.fileno(), END, self._end)
        return mmap.mmap(self._file.fileno(), self._end + len(END), access=mmap.ACCESS_READ)

    def close(self) -> None:
        super().close()
        self._lines.close()

    def remove(self) -> None:
        self.close()
        # Without its lines, what a kill leaves here is removed at the next start.
        (self.folder / "series.jsonl").unlink(missing_ok=True)
        shutil.rmtree(self.folder, ignore_errors=True)
        self.spool.take(-self._end)


class Spool:
    """A folder with mode 0700 that one gateway uses at a time. Thread-safe."""

    def __init__(self, folder: Path, most_bytes: int, key: str):
        self.folder, self.most_bytes, self._key = folder, most_bytes, key.encode()
        self._used = 0
        self._used_lock = threading.Lock()
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            os.chmod(folder, 0o700)
            self._lock = (folder / "lock").open("wb")
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise SpoolError(f"another gateway uses the spool {folder}") from error
        except OSError as error:
            raise SpoolError(f"cannot use the spool {folder}: {error.strerror}") from error

    def close(self) -> None:
        self._lock.close()

    @property
    def used(self) -> int:
        return self._used

    @property
    def free(self) -> int:
        """Returns the bytes that still fit."""
        disk = shutil.disk_usage(self.folder)
        return min(self.most_bytes - self._used, disk.free - min(limits.DISK_RESERVE_BYTES, disk.total // 20))

    def code(self, uid: str) -> str:
        """Returns a keyed hash of a UID, which finds the same image or series again."""
        return hmac.new(self._key, uid.encode(), hashlib.sha256).hexdigest()[:32]

    def take(self, count: int, always: bool = False) -> None:
        with self._used_lock:
            if count > 0 and not always and count > self.free:
                raise ArchiveError("no-room", "the spool is full")
            self._used += count

    def create(self, sender: Sender, series: str, free_bytes: int) -> SpooledSeries:
        folder = self.folder / uuid.uuid4().hex
        try:
            folder.mkdir(mode=0o700)
            made = SpooledSeries(self, folder, sender, self.code(series), time.time(), free_bytes)
            made.begin()
            return made
        except OSError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise ArchiveError("no-room", "the disk of the spool is full or fails") from error

    def recover(self, callers: Mapping[str, str]) -> Iterator[SpooledSeries]:
        """Yields the series of an earlier gateway. Folders without a confirmed image are removed."""
        for folder in sorted(one for one in self.folder.iterdir() if one.is_dir()):
            series = self._recovered(folder, callers)
            if series is not None and series.images:
                yield series
            elif series is not None:
                series.remove()
            else:
                shutil.rmtree(folder, ignore_errors=True)

    def _recovered(self, folder: Path, callers: Mapping[str, str]) -> SpooledSeries | None:
        try:
            data = (folder / "series.jsonl").read_bytes()
            # A line without an end was cut off.
            lines = data[:data.rfind(b"\n") + 1].splitlines(keepends=True)
            if not lines:
                return None
            head = json.loads(lines[0])
            sender = Sender(head["via"], head["name"], head["token"] or callers.get(head["name"], ""))
            series = SpooledSeries(self, folder, sender, head["series"], head["received"], head["free_bytes"])
        except FileNotFoundError:
            return None
        except (ValueError, KeyError, TypeError):
            print("a received series is damaged and was removed", file=sys.stderr, flush=True)
            return None
        series.recover(lines)
        return series


def _opened(path: Path) -> BinaryIO:
    return cast(BinaryIO, os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600), "r+b", buffering=0))


def _write_at(file: int, data: bytes, at: int) -> None:
    """Replaces everything from `at`, of which a full disk may have cut off a part, and waits for the disk."""
    os.ftruncate(file, at)
    rest = memoryview(data)
    while rest:
        count = os.pwrite(file, rest, at)
        rest, at = rest[count:], at + count
    os.fdatasync(file)


def _sync_folder(folder: Path) -> None:
    file = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(file)
    finally:
        os.close(file)
