"""C-MOVE: the archive sends the images of a fetch to the receiver, which hands them to the fetch that waits for them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from pydicom.dataset import Dataset

#: Takes an image and returns a status of C-STORE.
Keep = Callable[[Dataset], int]


class Moves:
    """The fetches that wait for images. Thread-safe."""

    def __init__(self) -> None:
        self._waiting: list[tuple[str, str, str, Keep]] = []
        self._lock = threading.Lock()

    @contextmanager
    def expected(self, archive: str, study: str, series: str, keep: Keep) -> Iterator[None]:
        """Passes the images of a series that the archive with this AE title sends to `keep`."""
        entry = (archive, study, series, keep)
        with self._lock:
            self._waiting.append(entry)
        try:
            yield
        finally:
            with self._lock:
                self._waiting.remove(entry)

    def offer(self, archive: str, image: Dataset) -> int | None:
        """Returns the status of the fetches that take the image, or None if no fetch waits for it."""
        key = (archive, str(image.get("StudyInstanceUID", "")), str(image.get("SeriesInstanceUID", "")))
        with self._lock:
            takers = [keep for *of, keep in self._waiting if tuple(of) == key]
        # Two users may fetch the same series. Each of them can only refuse for itself, so one success suffices.
        statuses = [keep(image) for keep in takers]
        return min(statuses) if statuses else None


MOVES = Moves()
