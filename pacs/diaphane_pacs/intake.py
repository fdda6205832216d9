"""Scans that others send. Collects their images by sender and series, and uploads each complete series as its account."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from pydicom.dataset import Dataset

from diaphane._http import Api
from diaphane.errors import ApiError, DiaphaneError, NotFoundError

from . import limits, uploads
from .errors import ArchiveError
from .metrics import METRICS
from .series_file import ImageIds, ids_of
from .spool import Sender, Spool, SpooledSeries

#: A volume has at least so many slices.
LEAST_IMAGES = 3
_UPLOADS_AT_ONCE = 2


@dataclass
class _Series:
    """A series that is still arriving, or that waits for its upload."""

    sender: Sender
    file: SpooledSeries | None = None    # with the first image
    changed: float = field(default_factory=time.monotonic)
    closed: bool = False
    dropped: bool = False      # the account is full, which the sender was told
    incomplete: bool = False   # images were not stored, or perhaps not, which the sender may send again
    attempts: int = 0
    forgotten: int = 0         # uploads that expired, or that the user removed
    due: float = 0             # next attempt to upload it
    lock: threading.Lock = field(default_factory=threading.Lock)


class Intake:
    """A series is complete when its sender has no open connection and was quiet for some seconds, because senders split series into
    several associations or requests. Thread-safe.
    """

    def __init__(self, api_url: str, quiet_seconds: float, spool: Spool, callers: Mapping[str, str] | None = None):
        self._api_url, self._quiet, self.spool = api_url, quiet_seconds, spool
        self._series: dict[tuple[Sender, str], _Series] = {}
        self._connections: dict[Sender, int] = {}
        self._waiting: list[_Series] = []
        self._lock = threading.Lock()
        self._stop = threading.Event()
        for file in spool.recover(callers or {}):
            series = _Series(file.sender, file, dropped=file.bytes > file.free_bytes, incomplete=not file.is_complete)
            if file.is_complete:
                self._waiting.append(series)
            else:
                self._series[file.sender, file.series_code] = series
        METRICS.watch_spool(lambda: float(spool.used), self._oldest)
        for _ in range(_UPLOADS_AT_ONCE):
            threading.Thread(target=self._work, daemon=True).start()

    def stop(self) -> None:
        """Ends without uploading what is spooled, which the next gateway does."""
        self._stop.set()

    def connect(self, sender: Sender, change: int) -> None:
        """Counts a connection that was opened (1) or closed (-1)."""
        with self._lock:
            count = self._connections.pop(sender, 0) + change
            if count:
                self._connections[sender] = count

    @contextmanager
    def connected(self, sender: Sender) -> Iterator[None]:
        self.connect(sender, 1)
        try:
            yield
        finally:
            self.connect(sender, -1)

    def check(self, sender: Sender) -> None:
        """Raises ArchiveError unless the sender's token belongs to an account with access and has the scopes archive and write."""
        self._call(sender, "listArchives")
        # Needs the scope write. There is no such upload.
        self._call(sender, "getUploadOffset", upload_id="00000000-0000-4000-8000-000000000000", headers=uploads.TUS)

    def add(self, sender: Sender, image: Dataset) -> None:
        """Returns once the image is on the disk.

        Raises ArchiveError: unauthorised, full (the account has no storage left), no-room (the spool has none), busy, invalid or faulty.
        """
        ids = ids_of(image)
        series = self._find(sender, self.spool.code(ids.series))
        with series.lock:
            if series.closed:
                raise ArchiveError("busy", "the series is complete already")
            series.changed = time.monotonic()
            if series.file is None:
                series.file = self._begin(sender, ids)
            if series.dropped:
                raise ArchiveError("full", "the account has no storage left")
            try:
                series.file.add(image)
            except ArchiveError as error:
                series.incomplete |= error.kind == "no-room"
                raise
            if series.file.bytes > series.file.free_bytes:
                series.dropped = True
                raise ArchiveError("full", "the account has no storage left")

    def _begin(self, sender: Sender, ids: ImageIds) -> SpooledSeries:
        self.check(sender)
        receipt = self._call(sender, "recordReceipt", body={"via": sender.via, "study": ids.study}, repeatable=True)
        return self.spool.create(sender, ids.series, int(receipt["free_bytes"]))

    def _find(self, sender: Sender, series: str) -> _Series:
        with self._lock:
            found = self._series.get((sender, series))
            if found is None:
                if sum(key[0] == sender for key in self._series) >= limits.MOST_OPEN_SERIES:
                    raise ArchiveError("busy", "too many series are arriving")
                found = self._series[sender, series] = _Series(sender)
            return found

    def _call(self, sender: Sender, operation: str, **arguments: Any) -> dict[str, Any]:
        api = Api(self._api_url, sender.token, uploads.TIMEOUT)
        try:
            response = api.call(operation, wait=5, **arguments)
            return dict(response.json()) if response.content else {}
        except NotFoundError:
            return {}
        except ApiError as error:
            raise ArchiveError("unauthorised" if error.status in (401, 403) else "busy", f"the server refused it: {error.kind}") from error
        except DiaphaneError as error:
            raise ArchiveError("busy", "the server cannot be reached") from error
        finally:
            api.close()

    def _oldest(self) -> float:
        """Returns for how many seconds a series has been in the spool."""
        with self._lock:
            files = [one.file for one in (*self._series.values(), *self._waiting) if one.file]
        return max((time.time() - file.received for file in files), default=0)

    def _work(self) -> None:
        while not self._stop.wait(min(0.5, self._quiet / 4)):
            while not self._stop.is_set() and (series := self._next()) is not None:
                self._finish(series)

    def _next(self) -> _Series | None:
        """Returns a series whose upload is due, which the caller puts back if that fails."""
        now = time.monotonic()
        with self._lock:
            for key, one in list(self._series.items()):
                quiet = self._quiet * (limits.RESEND_FACTOR if one.incomplete else 1)
                if one.changed < now - quiet and not self._connections.get(key[0]):
                    self._waiting.append(self._series.pop(key))
            due = next((one for one in self._waiting if one.due <= now), None)
            if due is not None:
                self._waiting.remove(due)
        if due is not None and not due.closed:
            with due.lock:
                due.closed = True
                if due.file and not due.file.is_complete:
                    due.file.complete()
        return due

    def _finish(self, series: _Series) -> None:
        file = series.file
        if file is None:
            return
        try:
            done = self._is_no_scan(series, file) or self._deliver(series, file)
        except Exception as error:
            print(f"a received series was not uploaded: {type(error).__name__}", file=sys.stderr, flush=True)
            done = False
        if not done and time.time() - file.received > limits.SPOOL_SECONDS:
            print("a received series could not be uploaded in time and was removed", file=sys.stderr, flush=True)
            METRICS.count_lost(series.sender.name)
            done = True
        if done:
            file.remove()
            return
        series.attempts += 1
        series.due = time.monotonic() + min(limits.RETRY_SECONDS, 2.0 ** min(series.attempts - 1, 20))
        with self._lock:
            self._waiting.append(series)

    @staticmethod
    def _is_no_scan(series: _Series, file: SpooledSeries) -> bool:
        if series.dropped:
            return True
        if max(len(file.images), file.frames) >= LEAST_IMAGES:
            return False
        print(f"a received series of {len(file.images)} images is not a volume and was dropped", file=sys.stderr, flush=True)
        return True

    def _deliver(self, series: _Series, file: SpooledSeries) -> bool:
        """Returns whether the series is no longer needed."""
        # The server forgets an incomplete upload, and the key, after a day without a change.
        key = f"{file.folder.name}-{int((time.time() - file.received) / limits.UPLOAD_SECONDS)}-{series.forgotten}"
        with METRICS.measure(series.sender.name, series.sender.via) as measured:
            try:
                uploads.deliver(self._api_url, series.sender.token, file.modality, file, key)
            except DiaphaneError as error:
                if isinstance(error, ApiError) and error.status in (404, 410):
                    series.forgotten += 1
                measured.failed = uploads.code_of(error)
                print(f"a received series was not uploaded: {measured.failed}", file=sys.stderr, flush=True)
                return False
        return True
