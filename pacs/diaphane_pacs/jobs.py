"""Fetches in progress. They are kept in memory only: after a restart of the gateway, a user starts them again."""

from __future__ import annotations

import sys
import threading
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pydicom.dataset import Dataset

from diaphane.errors import DiaphaneError

from . import limits, uploads
from .dimse import DimseClient
from .errors import ArchiveError, Cancelled, faulty
from .metrics import METRICS
from .series_file import SeriesFile, read_image
from .settings import DimseArchive, Settings, WebArchive
from .web import WebClient


@dataclass(frozen=True)
class Order:
    archive: str
    account: str
    token: str
    study: str
    series: str
    title: str


@dataclass
class Job:
    order: Order
    id: str = field(default_factory=lambda: str(uuid.uuid4()))
    state: str = "fetching"     # then uploading, and at last done, failed or cancelled
    images: int = 0             # that have arrived
    total: int = 0
    uploaded: float = 0
    data_set: str = ""
    problem: str = ""           # a kind of error, or of a problem of the REST API
    stopped: threading.Event = field(default_factory=threading.Event)
    started: float = field(default_factory=time.monotonic)
    ended: float = 0

    def shown(self) -> dict[str, Any]:
        return {"id": self.id, "state": self.state, "images": self.images, "total": self.total, "uploaded": round(self.uploaded, 3),
                "data_set_id": self.data_set or None, "problem": self.problem or None}

    def check(self) -> None:
        if self.stopped.is_set():
            raise Cancelled
        if time.monotonic() - self.started > limits.FETCH_SECONDS:
            raise ArchiveError("slow", "the fetch took too long")


class Jobs:
    """Starts fetches and reports about them. Thread-safe."""

    def __init__(self, settings: Settings, api_url: str):
        self._settings, self._api_url = settings, api_url
        self._jobs: dict[str, Job] = {}
        self._lock = threading.Lock()

    def start(self, order: Order) -> Job:
        with self._lock:
            self._forget()
            running = [job for job in self._jobs.values() if not job.ended]
            if len(running) >= limits.MOST_FETCHES or sum(job.order.account == order.account for job in running) >= limits.MOST_ACCOUNT_FETCHES:
                raise ArchiveError("busy", "too many fetches are running")
            job = Job(order)
            self._jobs[job.id] = job
        threading.Thread(target=self._run, args=(job,), daemon=True).start()
        return job

    def find(self, archive: str, account: str, job_id: str) -> Job:
        with self._lock:
            job = self._jobs.get(job_id)
        if job is None or (job.order.account, job.order.archive) != (account, archive):
            raise ArchiveError("not-found", "there is no such fetch")
        return job

    def stop(self) -> None:
        with self._lock:
            for job in self._jobs.values():
                job.stopped.set()

    def _forget(self) -> None:
        """Forgets the oldest results."""
        ended = sorted((job for job in self._jobs.values() if job.ended), key=lambda job: job.ended)
        old = time.monotonic() - limits.FETCH_SECONDS
        for at, job in enumerate(ended):
            if job.ended < old or len(ended) - at > limits.MOST_FINISHED:
                del self._jobs[job.id]

    def _run(self, job: Job) -> None:
        with METRICS.measure(job.order.archive, "fetch") as measured:
            try:
                self._fetch_and_upload(job)
                job.state = "done"
            except Cancelled:
                job.state = "cancelled"
            except ArchiveError as error:
                measured.failed = job.problem = error.kind
                print(f"a fetch from {job.order.archive} failed: {error}", file=sys.stderr, flush=True)
            except DiaphaneError as error:
                measured.failed = job.problem = uploads.code_of(error)
            except Exception as error:
                measured.failed = job.problem = "internal"
                # Only the type, because the message of an exception may quote a file.
                print(f"a fetch failed with {type(error).__name__}", file=sys.stderr, flush=True)
            finally:
                if job.problem:
                    job.state = "failed"
                job.ended = time.monotonic()

    def _fetch_and_upload(self, job: Job) -> None:
        order = job.order
        file = SeriesFile(order.study, order.series)
        try:
            fetch_series(self._settings.archives[order.archive], job, file)
            job.state = "uploading"

            def progress(share: float) -> None:
                job.uploaded = share
                job.check()

            job.data_set = uploads.upload(self._api_url, order.token, order.title, file, progress)
        finally:
            file.close()


def client_of(archive: WebArchive | DimseArchive) -> WebClient | DimseClient:
    return WebClient(archive) if isinstance(archive, WebArchive) else DimseClient(archive)


def fetch_series(archive: WebArchive | DimseArchive, job: Job, file: SeriesFile) -> None:
    """Fetches all images. After an interruption, only the missing ones are requested again."""
    client = client_of(archive)
    try:
        wanted = client.images(job.order.study, job.order.series)
        if not wanted:
            raise ArchiveError("not-found", "the archive does not have this series")
        job.total = len(wanted)

        def take(image: Dataset) -> None:
            job.check()
            file.add(image)
            job.images = len(file.images)

        failure: ArchiveError | None = None
        for attempt in range(limits.ATTEMPTS):
            missing = [uid for uid in wanted if uid not in file.images]
            if not missing:
                return
            try:
                # An archive may have closed the connection just before the request, so that nothing has arrived.
                whole = attempt == 0 or (attempt == 1 and not file.images)
                _fetch(client, job, archive.name, missing, take, whole)
            except ArchiveError as error:
                # An archive that lies is not asked again.
                if error.kind not in ("unreachable", "slow") and not _was_cut_off(error):
                    raise
                failure = error
                job.check()
        if any(uid not in file.images for uid in wanted):
            raise failure or faulty("the archive did not send all images of the series")
    finally:
        client.close()


def _was_cut_off(error: ArchiveError) -> bool:
    return str(error) == "the content was cut off"


def _fetch(client: WebClient | DimseClient, job: Job, archive: str, missing: list[str], take: Callable[[Dataset], object], whole: bool) -> None:
    """Fetches the series, or the missing images one by one."""
    for image in [""] if whole else missing:
        job.check()
        if isinstance(client, DimseClient):
            client.fetch(job.order.study, job.order.series, take, image, job.stopped)
            job.check()
            continue
        for data in client.fetch(job.order.study, job.order.series, job.check, image):
            METRICS.count_bytes(archive, len(data))
            take(read_image(data))
