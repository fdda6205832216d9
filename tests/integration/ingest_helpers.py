"""Shared helpers of the ingest tests: queueing data sets, and checking what is left of them."""

from __future__ import annotations

import os
import subprocess
import uuid
from pathlib import Path

from canaries import Search
from seeds import bundle

CANARY = "Canary7f3a"
BIRTH_DATE = "19370413"


def tool(stack, name: str) -> str:
    return str(stack.stack.settings.layout.bin / name)


def cranium(stack, folder: Path) -> list[bytes]:
    """Returns the files of the sample's DICOM series, including its invented patient."""
    subprocess.run([tool(stack, "diaphane-sample"), "--write-dicom", str(folder)], check=True)
    return [file.read_bytes() for file in sorted(folder.iterdir())]


def upload_path(stack, data_set: str) -> Path:
    return stack.data_dir / "uploads" / f"{data_set}.tar"


def volume_path(stack, data_set: str) -> Path:
    return stack.data_dir / "volumes" / data_set


def enqueue(stack, data: bytes) -> str:
    """Creates a data set whose upload is complete, as `api` does."""
    data_set = str(uuid.uuid4())
    path = upload_path(stack, data_set)
    path.write_bytes(data)
    owner = path.parent.stat()
    os.chown(path, owner.st_uid, owner.st_gid)
    stack.psql("INSERT INTO data_sets (id, state) VALUES (%s, 'queued')", data_set)
    stack.psql("INSERT INTO uploads (id, data_set_id, length, received, expires_at) VALUES (%s, %s, %s, %s,"
               " now() + interval '1 hour')", data_set, data_set, len(data), len(data))
    stack.psql("INSERT INTO ingest_jobs (data_set_id, upload_id) VALUES (%s, %s)", data_set, data_set)
    stack.psql("NOTIFY ingest_jobs")
    return data_set


def state(stack, data_set: str) -> tuple:
    rows = stack.psql("SELECT state, refusal_code, refusal_text FROM data_sets WHERE id = %s", data_set)
    return rows[0] if rows else ("deleted", None, None)


def wait_end(stack, data_set: str, timeout: float = 90.0) -> tuple:
    """Returns state, refusal code and text once it is neither queued nor building and its original is deleted."""
    def ended():
        now = state(stack, data_set)
        return now if now[0] not in ("queued", "building") and not upload_path(stack, data_set).exists() else None
    return stack.wait_until(ended, timeout, f"the end of ingest (now {state(stack, data_set)})")


def nothing_left(stack, data_set: str) -> None:
    """Checks that no job, upload, original or temporary file of it exists. Another upload, or a build that is being given up, may
    have temporary files for a moment."""
    assert stack.psql("SELECT count(*) FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(0,)]
    assert stack.psql("SELECT count(*) FROM uploads WHERE data_set_id = %s", data_set) == [(0,)]
    assert not upload_path(stack, data_set).exists()
    stack.wait_until(lambda: not any((stack.data_dir / "scratch").iterdir()), what="an empty scratch directory")
    stack.wait_until(lambda: not any((stack.data_dir / "volumes").glob(f".tmp-{data_set}-*")), what="the end of its unfinished volumes")


def hiding_places(root: Path, text: str) -> list[str]:
    """Returns files below `root` that contain `text` in any form, or in their names."""
    return Search([text]).below(root)
