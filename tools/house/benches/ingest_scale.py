"""A CT of 512 x 512 x 1000 from its last byte to a stored volume, as anybody's upload, on this machine."""

from __future__ import annotations

import io
import tarfile
import tempfile
import time
from pathlib import Path
from typing import Callable, Iterator

from ..bench import Result, result
from ..bench_client import Person
from ..bench_stack import peak_memory_mb, running
from ..stack import Stack

ABOUT = "512 x 512 x 1000 CT, as 1000 files, tilted, and as one enhanced file: seconds to ingest, peak memory"
SIDE, SLICES = 512, 1000
PARTS = ("postgres", "redis", "api", "ingestd", "edge")
PROGRAMS = ("diaphane-api", "diaphane-ingestd")
SECONDS, GIGABYTES = 60, 3.0     # on 2 cores


def measure(quick: bool) -> list[Result]:
    results = []
    kinds: dict[str, Callable[[], Iterator[bytes]]] = {"1000 files": lambda: _files(0.0)}
    if not quick:
        kinds |= {"1000 files, tilted by 15 degrees": lambda: _files(0.268), "one enhanced file": _enhanced}
    for name, files in kinds.items():
        with running(only=PARTS) as stack, tempfile.TemporaryDirectory() as folder:
            bundle = Path(folder) / "bundle.tar"
            _pack(bundle, files())
            person = Person(stack)
            data_set = person.upload(bundle)
            sent = time.monotonic()
            person.wait_ready(data_set, timeout=600)
            seconds = time.monotonic() - sent
            child = _child_peak(stack)
            parent = peak_memory_mb(stack.pids["ingestd"]) / 1e3
            person.delete(data_set)
        results += [result(f"{name}: last byte to ready", [seconds], "s", at_most=SECONDS),
                    result(f"{name}: peak of the child and of ingestd together", [child + parent], "GB", at_most=GIGABYTES)]
    return results


def _pixels(z: int) -> bytes:
    """Noise around a bright tube, other in each slice: nothing that is quicker than a real scan."""
    import numpy as np

    y, x = np.mgrid[:SIDE, :SIDE]
    noise = np.random.default_rng(z).integers(0, 60, (SIDE, SIDE))
    tube = 1000 * (((x - 256) / 200) ** 2 + ((y - 256 - z / 20) / 150) ** 2 < 1)
    return (noise + tube).astype("<u2").tobytes()


def _files(lean: float) -> Iterator[bytes]:
    """1000 slices, 0.7 mm apart, each `lean` mm a mm further down its columns."""
    from ..ingest_cases.phantom import Series, Slice, dataset

    class Blank(Series):
        def stored(self, one: Slice):
            import numpy as np
            return np.zeros((SIDE, SIDE), np.uint16)

    y, z, uid = "12345678.125", "87654321.125", "2.25.11111111111"
    ds = dataset(Blank(), Slice((0.0, float(y), float(z)), pixel=(0.7, 0.7), rows=SIDE, columns=SIDE, intercept=-1024.0, uid=uid))
    out = io.BytesIO()
    ds.save_as(out, enforce_file_format=True)
    head = out.getvalue()[:-2 * SIDE * SIDE]
    assert all(head.count(text.encode()) >= 1 for text in (y, z, uid))
    for i in range(SLICES):
        own = {y: f"{0.7 * i * lean:012.3f}", z: f"{0.7 * i:012.3f}", uid: f"2.25.{11111111112 + i}"}
        made = head
        for text, wanted in own.items():
            made = made.replace(text.encode(), wanted.encode())
        yield made + _pixels(i)


def _enhanced() -> Iterator[bytes]:
    from ..ingest_cases.phantom import ENHANCED_CT, Series, Slice, enhanced

    class Frames(Series):
        def stored(self, one: Slice):
            import numpy as np
            return np.frombuffer(_pixels(round(one.position[2] / 0.7)), "<u2")

    slices = [Slice((0.0, 0.0, 0.7 * i), pixel=(0.7, 0.7), rows=SIDE, columns=SIDE, intercept=-1024.0) for i in range(SLICES)]
    out = io.BytesIO()
    enhanced(Frames(ENHANCED_CT), slices).save_as(out, enforce_file_format=True)
    yield out.getvalue()


def _pack(bundle: Path, files: Iterator[bytes]) -> None:
    with tarfile.open(bundle, "w", format=tarfile.USTAR_FORMAT) as tar:
        for number, data in enumerate(files, 1):
            info = tarfile.TarInfo(f"{number:05d}.dcm")
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))


def _child_peak(stack: Stack) -> float:
    from .ingest import metric

    return metric(stack.ports["ingestd-admin"], "diaphane_ingest_child_peak_bytes") / 1e9
