"""Prometheus metrics by archive. Their labels hold no patient data."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest


@dataclass
class Measured:
    failed: str = ""


class Metrics:
    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self._requests = Counter("diaphane_pacs_requests_total", "Requests to an archive, or received from one.",
                                 ["archive", "operation"], registry=self.registry)
        self._failures = Counter("diaphane_pacs_failures_total", "Failed requests by reason.",
                                 ["archive", "operation", "reason"], registry=self.registry)
        self._seconds = Histogram("diaphane_pacs_seconds", "Duration of a request.", ["archive", "operation"], registry=self.registry,
                                  buckets=(0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000))
        self._bytes = Counter("diaphane_pacs_bytes_total", "Bytes received from an archive.", ["archive"], registry=self.registry)
        self._running = Gauge("diaphane_pacs_running", "Requests that are running.", ["operation"], registry=self.registry)

        self._lost = Counter("diaphane_pacs_lost_series_total", "Received series that could not be uploaded in time.", ["archive"],
                             registry=self.registry)
        self._spool_bytes = Gauge("diaphane_pacs_spool_bytes", "Bytes of received series that are not uploaded yet.", registry=self.registry)
        self._spool_oldest = Gauge("diaphane_pacs_spool_oldest_seconds", "Age of the oldest received series that is not uploaded yet.",
                                   registry=self.registry)

    @contextmanager
    def measure(self, archive: str, operation: str) -> Iterator[Measured]:
        measured, began = Measured(), time.monotonic()
        self._running.labels(operation).inc()
        try:
            yield measured
        finally:
            self._running.labels(operation).dec()
            self._requests.labels(archive, operation).inc()
            self._seconds.labels(archive, operation).observe(time.monotonic() - began)
            if measured.failed:
                self._failures.labels(archive, operation, measured.failed).inc()

    def count_bytes(self, archive: str, count: int) -> None:
        self._bytes.labels(archive).inc(count)

    def count_lost(self, archive: str) -> None:
        self._lost.labels(archive).inc()

    def watch_spool(self, used: Callable[[], float], oldest: Callable[[], float]) -> None:
        self._spool_bytes.set_function(used)
        self._spool_oldest.set_function(oldest)

    def text(self) -> bytes:
        return bytes(generate_latest(self.registry))


METRICS = Metrics()
