"""A CT of 512 x 512 x 1000 from the last byte of its upload to a stored volume, on this machine."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import shutil
import subprocess
import tarfile
import tempfile
import time
from copy import deepcopy
from pathlib import Path
from typing import Callable, Iterator

from .. import clamav, users
from ..bench import Result, result
from ..bench_client import Person
from ..bench_stack import folder as own_folder
from ..bench_stack import peak_memory_mb, running
from ..console import CliError, say
from ..stack import Stack

ABOUT = "a CT of 512 x 512 x 1000 (plain, tilted, compressed, enhanced) and one of 980 MB: time, CPU time and memory"
SIDE, SLICES = 512, 1000
LARGE = 1868                     # frames of a file of 980 MB; the limit is 1 GiB (ingest/dicom/precheck.h)
PARTS = ("postgres", "redis", "api", "ingestd", "edge")
PROGRAMS = ("diaphane-api", "diaphane-ingestd")
SECONDS, GIGABYTES = 60, 3.0     # targets for 2 cores


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--only", default="", metavar="TEXT", help="only kinds whose name contains this text")
    parser.add_argument("--antivirus", action="store_true", help="scan uploads with clamd first (with a single signature, which is faster than with all)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    results = []
    kinds: dict[str, Callable[[], Iterator[bytes]]] = {"1000 files": lambda: _files(0.0)}
    if not quick:
        kinds |= {"1000 files, tilted by 15 degrees": lambda: _files(0.268),
                  "1000 files, JPEG lossless": lambda: _files(0.0, "JPEG lossless"),
                  "1000 files, JPEG 2000": lambda: _files(0.0, "JPEG 2000"),
                  "one enhanced file": lambda: _enhanced(SLICES),
                  "one enhanced file of 980 MB": lambda: _enhanced(LARGE)}
    for name, files in kinds.items():
        if options.only not in name:
            continue
        target = name != "one enhanced file of 980 MB"
        with _antivirus(options.antivirus) as settings, running(only=PARTS, **settings) as stack, tempfile.TemporaryDirectory(dir="/var/tmp") as folder:
            bundle = Path(folder) / "bundle.tar"
            _pack(bundle, files())
            person = Person(stack)
            begin = time.monotonic()
            data_set = person.upload(bundle)
            sent = time.monotonic()
            before, load = _processor_time(stack.pids["ingestd"]), os.getloadavg()[0]
            person.wait_ready(data_set, timeout=600)
            seconds = time.monotonic() - sent
            processor = _processor_time(stack.pids["ingestd"]) - before
            child = _child_peak(stack)
            parent = peak_memory_mb(stack.pids["ingestd"]) / 1e3
            person.delete(data_set)
            say(f"{name}: {bundle.stat().st_size / 1e6:.0f} MB sent in {sent - begin:.1f} s; load {load:.1f} when it began")
        results += [result(f"{name}: last byte to ready", [seconds], "s", at_most=SECONDS if target else None),
                    result(f"{name}: CPU time", [processor], "s"),
                    result(f"{name}: peak memory of the child", [child], "GB"),
                    result(f"{name}: peak memory of child and ingestd", [child + parent], "GB",
                           at_most=GIGABYTES if target else None)]
    return results


@contextlib.contextmanager
def _antivirus(wanted: bool) -> Iterator[dict[str, str]]:
    """Yields the settings of ingestd while clamd runs."""
    if not wanted:
        yield {}
        return
    clamav.ensure()
    run_as = users.ordinary_user()
    with own_folder(run_as) as own:
        daemon = clamav.Daemon(run_as, own)
        daemon.start()
        try:
            yield {"DIAPHANE_ANTIVIRUS": str(daemon.path)}
        finally:
            daemon.kill()


def _processor_time(pid: int) -> float:
    """Returns the CPU seconds of a process and of its children that have ended."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()
    return sum(int(field) for field in fields[11:15]) / os.sysconf("SC_CLK_TCK")


def _pixels(z: int) -> bytes:
    """Returns noise around a bright tube, different in each slice, so that it compresses no better
    than a real scan."""
    import numpy as np

    y, x = np.mgrid[:SIDE, :SIDE]
    noise = np.random.default_rng(z).integers(0, 60, (SIDE, SIDE))
    tube = 1000 * (((x - 256) / 200) ** 2 + ((y - 256 - z / 20) / 150) ** 2 < 1)
    return (noise + tube).astype("<u2").tobytes()


def _files(lean: float, packing: str = "") -> Iterator[bytes]:
    """Yields 1000 slices, 0.7 mm apart, each shifted by `lean` mm per mm along its columns."""
    from ..ingest_cases.phantom import Series, Slice, dataset

    class Blank(Series):
        def stored(self, one: Slice):
            import numpy as np
            return np.zeros((SIDE, SIDE), np.uint16)

    y, z, uid = "12345678.125", "87654321.125", "2.25.11111111111"
    ds = dataset(Blank(), Slice((0.0, float(y), float(z)), pixel=(0.7, 0.7), rows=SIDE, columns=SIDE, intercept=-1024.0, uid=uid))
    if packing:
        # each is decoded again, so that these are as slow as 1000 different ones
        models = [_packed(ds, _pixels(50 * i), packing) for i in range(20)]
    else:
        models = [_saved(ds)[:-2 * SIDE * SIDE]]
    assert all(model.count(text.encode()) >= 1 for text in (y, z, uid) for model in models)
    for i in range(SLICES):
        own = {y: f"{0.7 * i * lean:012.3f}", z: f"{0.7 * i:012.3f}", uid: f"2.25.{11111111112 + i}"}
        made = models[i % len(models)]
        for text, wanted in own.items():
            made = made.replace(text.encode(), wanted.encode())
        yield made if packing else made + _pixels(i)


def _saved(ds) -> bytes:
    out = io.BytesIO()
    ds.save_as(out, enforce_file_format=True)
    return out.getvalue()


def _packed(ds, pixels: bytes, packing: str) -> bytes:
    """Returns the file with these pixels compressed, JPEG by DCMTK and JPEG 2000 by OpenJPEG."""
    ds.PixelData = pixels
    if packing == "JPEG 2000":
        from pydicom.uid import JPEG2000Lossless

        one = deepcopy(ds)
        one.compress(JPEG2000Lossless, generate_instance_uid=False)
        return _saved(one)
    if not shutil.which("dcmcjpeg"):
        raise CliError("dcmcjpeg is not installed (Debian package dcmtk)")
    with tempfile.TemporaryDirectory() as folder:
        plain, packed = Path(folder) / "plain", Path(folder) / "packed"
        plain.write_bytes(_saved(ds))
        subprocess.run(["dcmcjpeg", "+e1", "+un", str(plain), str(packed)], check=True)
        return packed.read_bytes()


def _enhanced(frames: int) -> Iterator[bytes]:
    from ..ingest_cases.phantom import ENHANCED_CT, Series, Slice, enhanced

    class Frames(Series):
        def stored(self, one: Slice):
            import numpy as np
            return np.frombuffer(_pixels(round(one.position[2] / 0.7)), "<u2")

    slices = [Slice((0.0, 0.0, 0.7 * i), pixel=(0.7, 0.7), rows=SIDE, columns=SIDE, intercept=-1024.0) for i in range(frames)]
    yield _saved(enhanced(Frames(ENHANCED_CT), slices))


def _pack(bundle: Path, files: Iterator[bytes]) -> None:
    with tarfile.open(bundle, "w", format=tarfile.USTAR_FORMAT) as tar:
        for number, data in enumerate(files, 1):
            info = tarfile.TarInfo(f"{number:05d}.dcm")
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))


def _child_peak(stack: Stack) -> float:
    from .ingest import metric

    return metric(stack.ports["ingestd-admin"], "diaphane_ingest_child_peak_bytes") / 1e9
