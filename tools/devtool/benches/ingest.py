"""The cranium from the last byte of its upload to a stored volume."""

from __future__ import annotations

import re
import tempfile
import time
from pathlib import Path
from urllib.request import urlopen

from ..bench import Result, result
from ..bench_client import Person, cranium
from ..bench_stack import running

ABOUT = "the cranium: time to upload and ingest, peak memory of the child process"


def measure(quick: bool) -> list[Result]:
    uploading, ingesting, memory = [], [], []
    with running(engine="cpu") as stack, tempfile.TemporaryDirectory() as folder:
        person, bundle = Person(stack), cranium(stack, Path(folder))
        for _ in range(3 if quick else 10):
            begin = time.monotonic()
            data_set = person.upload(bundle)
            sent = time.monotonic()
            person.wait_ready(data_set)
            ingesting.append(time.monotonic() - sent)
            uploading.append(sent - begin)
            memory.append(metric(stack.ports["ingestd-admin"], "diaphane_ingest_child_peak_bytes") / 1e6)
            person.delete(data_set)
    return [result("upload over loopback", uploading, "s"),
            result("last byte to ready", ingesting, "s"),
            result("peak memory of the child", memory, "MB")]


def metric(port: int, name: str) -> float:
    with urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5) as answer:
        text = answer.read().decode()
    found = re.search(rf"^{name}(?:{{[^}}]*}})? (\S+)$", text, re.MULTILINE)
    return float(found[1]) if found else float("nan")
