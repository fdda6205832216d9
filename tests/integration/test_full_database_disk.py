"""The disk of Postgres fills up: no stored data is lost, and everything resumes when space is free again."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path
from typing import Callable

import psycopg
import pytest
import requests
from api_client import person
from hostile.dicom_bytes import bundle, series
from ingest_helpers import upload_path, volume_path
from test_ingest_faults import freeze, next_child

SIZE_MB = 160
#: Size of a segment of Postgres's write-ahead log.
SEGMENT = 16 << 20


class Disk:
    """A small file system with Postgres's data."""

    def __init__(self, stack, folder: Path):
        self.stack, self.folder, self.ballast = stack, folder, folder / "ballast"

    def fill(self) -> None:
        """Fills it to the last byte, and so that Postgres needs a new log segment for the next commit."""
        with self.ballast.open("wb", buffering=0) as file:
            try:
                while True:
                    file.write(b"\0" * (1 << 20))
            except OSError:
                pass
        for _ in range(20):
            try:
                self.stack.psql("SELECT pg_logical_emit_message(false, 'full', repeat('x', %s))", SEGMENT // 4)
            except psycopg.Error:
                return
        raise AssertionError("Postgres finds room")

    def make_room(self) -> None:
        self.ballast.unlink(missing_ok=True)
        self.stack.wait_ready("postgres", timeout=60)


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge", "ingestd"), extra_env={"DIAPHANE_LIGHT_MB": "0"})
    stack.stop("postgres")
    folder = stack.data_dir / "postgres"
    owner = folder.stat()
    was = folder.rename(folder.with_name("postgres-was"))
    folder.mkdir(mode=0o700)
    options = f"size={SIZE_MB}m,mode=0700,uid={owner.st_uid},gid={owner.st_gid}"
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], capture_output=True).returncode == 0
    if not mounted:
        all_stacks.shut(stack)
        pytest.skip("no file system can be mounted here")
    try:
        subprocess.run(["cp", "-a", f"{was}/.", folder], check=True)
        stack.start("postgres")
        stack.wait_ready()
        yield stack, Disk(stack, folder)
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)
        all_stacks.shut(stack)


def until_done(stack, act: Callable[[], requests.Response], statuses: tuple[int, ...]) -> None:
    """Retries like a client until the request succeeds."""
    stack.wait_until(lambda: act().status_code in statuses, what="success")


def state(somebody, data_set: str) -> str:
    answer = somebody.http.get(f"/v1/data-sets/{data_set}")
    return answer.json()["state"] if answer.status_code == 200 else f"{answer.status_code}"


def test_an_upload_is_kept_if_the_disk_is_full_at_its_last_part(running):
    stack, disk = running
    somebody, data = person(stack), bundle(series())
    made = somebody.data_set(len(data))
    url, one = made["upload_url"], made["data_set"]["id"]
    assert somebody.patch(url, 0, data[:1000]).status_code == 204
    disk.fill()
    # 204: Postgres has come back meanwhile, and its last log segment has room for a small commit.
    refused = somebody.patch(url, 1000, data[1000:])
    assert refused.status_code in (204, 500, 503, 507), refused.text
    disk.make_room()
    # A client asks how much has arrived, and sends the rest. There is nothing to ask once the scan is built.
    stack.wait_until(lambda: somebody.http.get("/v1/me").status_code == 200, what="the API")
    if state(somebody, one) == "uploading" and (there := somebody.offset(url)) < len(data):
        assert somebody.patch(url, there, data[there:]).status_code == 204
    stack.wait_until(lambda: state(somebody, one) == "ready", what="the volume")
    stack.wait_until(lambda: not upload_path(stack, one).exists(), what="the original's end")


def frozen_build(stack, somebody) -> tuple[str, int]:
    """Returns a data set that is being built, and its child, stopped. On a busy machine, a child may end before it is stopped. Then it is
    the child of another upload."""
    ingestd = stack.pids["ingestd"]
    for _ in range(20):
        os.kill(ingestd, signal.SIGSTOP)    # so that the build does not end before its child is looked for
        one = somebody.upload(bundle(series()))["id"]
        os.kill(ingestd, signal.SIGCONT)
        child = next_child(ingestd, missed=lambda made=one: state(somebody, made) not in ("queued", "building"))
        if child and freeze(child, reading=False):
            return one, child
        stack.wait_until(lambda made=one: state(somebody, made) == "ready", what="the volume")
    raise AssertionError("no child could be stopped in time")


def test_a_job_that_ends_while_the_disk_is_full_is_completed_later(running):
    stack, disk = running
    somebody = person(stack)
    one, child = frozen_build(stack, somebody)
    unavailable = '"event":"postgres_unavailable"'
    noticed = stack.log("ingestd").count(unavailable)
    disk.fill()
    os.kill(child, signal.SIGCONT)
    # Or the job ends, because Postgres has come back and has room for a small commit.
    stack.wait_until(lambda: stack.log("ingestd").count(unavailable) > noticed or state(somebody, one) == "ready", what="ingestd notices")
    assert upload_path(stack, one).exists() or volume_path(stack, one).exists()    # in the order in which ingestd deletes and stores
    disk.make_room()
    stack.wait_until(lambda: state(somebody, one) == "ready", what="the volume")
    stack.wait_until(lambda: not upload_path(stack, one).exists(), what="the original's end")
    assert (volume_path(stack, one) / "voxels.i16").stat().st_size == 2 * 20 * 16 * 16


def test_a_deletion_during_a_full_disk_is_completed_later(running):
    stack, disk = running
    somebody = person(stack)
    one = somebody.upload(bundle(series()))["id"]
    stack.wait_until(lambda: state(somebody, one) == "ready", what="the volume")
    disk.fill()
    refused = somebody.http.delete(f"/v1/data-sets/{one}")
    # 204: as above
    assert refused.status_code == 204 or refused.status_code in (500, 503, 507) and volume_path(stack, one).exists()
    disk.make_room()
    until_done(stack, lambda: somebody.http.delete(f"/v1/data-sets/{one}"), (204, 404))
    stack.wait_until(lambda: not volume_path(stack, one).exists(), what="the volume's end")
