"""The cranium from its last byte to a stored volume, as anybody's scan."""

from __future__ import annotations

import re
import tempfile
import time
from pathlib import Path
from urllib.request import urlopen

from ..bench import Result, result
from ..bench_client import Person, cranium
from ..bench_stack import running

ABOUT = "the cranium: seconds to upload and to ingest, peak memory of the child that builds it"


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
    return [result("upload on the loopback", uploading, "s"),
            result("ingest, last byte to ready", ingesting, "s"),
            result("peak memory of the building child", memory, "MB")]


def metric(port: int, name: str) -> float:
    with urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5) as answer:
        text = answer.read().decode()
    found = re.search(rf"^{name}(?:{{[^}}]*}})? (\S+)$", text, re.MULTILINE)
    return float(found[1]) if found else float("nan")
