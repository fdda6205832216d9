"""What the tests of ingest share: data sets put into the queue, and what is left of them."""

from __future__ import annotations

import io
import os
import subprocess
import tarfile
import uuid
from pathlib import Path

from canaries import Search

CANARY = "Canary7f3a"
BIRTH_DATE = "19370413"


def bundle(files: list[bytes]) -> bytes:
    """The tar that a browser makes of the files of a series (docs/contracts.md, "Upload bundle")."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for number, data in enumerate(files, 1):
            info = tarfile.TarInfo(f"{number:05d}.dcm")
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))
    return out.getvalue()


def tool(stack, name: str) -> str:
    return str(stack.stack.settings.layout.bin / name)


def cranium(stack, folder: Path) -> list[bytes]:
    """The files of the sample's DICOM series, with its made-up patient in them."""
    subprocess.run([tool(stack, "diaphane-sample"), "--write-dicom", str(folder)], check=True)
    return [file.read_bytes() for file in sorted(folder.iterdir())]


def upload_path(stack, data_set: str) -> Path:
    return stack.data_dir / "uploads" / f"{data_set}.tar"


def volume_path(stack, data_set: str) -> Path:
    return stack.data_dir / "volumes" / data_set


def enqueue(stack, data: bytes) -> str:
    """A data set whose upload has just arrived, as `api` leaves it."""
    data_set = str(uuid.uuid4())
    path = upload_path(stack, data_set)
    path.write_bytes(data)
    owner = path.parent.stat()
    os.chown(path, owner.st_uid, owner.st_gid)
    stack.psql("INSERT INTO data_sets (id, state) VALUES (%s, 'queued')", data_set)
    stack.psql("INSERT INTO uploads (id, data_set_id, length, received, expires_at) VALUES (%s, %s, %s, %s,"
               " now() + interval '1 hour')", data_set, data_set, len(data), len(data))
    stack.psql("INSERT INTO ingest_jobs (data_set_id, upload_id) VALUES (%s, %s)", data_set, data_set)
    return data_set


def state(stack, data_set: str) -> tuple:
    rows = stack.psql("SELECT state, refusal_code, refusal_text FROM data_sets WHERE id = %s", data_set)
    return rows[0] if rows else ("deleted", None, None)


def wait_end(stack, data_set: str, timeout: float = 30.0) -> tuple:
    """State, refusal code and text, once it is neither queued nor building and its original is gone."""
    def ended():
        now = state(stack, data_set)
        return now if now[0] not in ("queued", "building") and not upload_path(stack, data_set).exists() else None
    return stack.wait_until(ended, timeout, f"the end of ingest (now {state(stack, data_set)})")


def nothing_left(stack, data_set: str) -> None:
    """No job, no upload, no original, no temporary file of it."""
    assert stack.psql("SELECT count(*) FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(0,)]
    assert stack.psql("SELECT count(*) FROM uploads WHERE data_set_id = %s", data_set) == [(0,)]
    assert not upload_path(stack, data_set).exists()
    assert list((stack.data_dir / "scratch").iterdir()) == []
    assert [f.name for f in (stack.data_dir / "volumes").iterdir() if f.name.startswith(".tmp-")] == []


def hiding_places(root: Path, text: str) -> list[str]:
    """Files below `root` that hold `text` in any form, or have it in their names."""
    return Search([text]).below(root)
