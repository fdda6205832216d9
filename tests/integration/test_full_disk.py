"""A complete upload is never lost to a full disk: whichever write fails, the work waits, the user is notified, and processing
resumes when space is free again. Each write in turn is the one that fails."""

from __future__ import annotations

import io
import os
import subprocess
import zipfile
from pathlib import Path
from typing import Callable

import pytest
from api_client import person, problem
from cut_helpers import KEEP, expected_left, hash_of, holders_of_mark, marked_scan
from harness import REPO
from hostile.dicom_bytes import bundle, series
from ingest_helpers import upload_path, volume_path

MOST_STEPS = 80
CONFIRMATION = "this cannot be undone"


class Disk:
    """The disk of a stack, which full_disk.c fills."""

    def __init__(self, control: Path):
        self.full_, self.after_ = control / "full", control / "after"
        self.was_full = False

    def fill_after(self, steps: int) -> None:
        self.make_room()
        self.was_full = False
        self.after_.write_text(f"{steps}\n")
        self.after_.chmod(0o666)

    @property
    def full(self) -> bool:
        self.was_full |= self.full_.exists()
        return self.full_.exists()

    def make_room(self) -> None:
        """Frees the disk permanently."""
        self.after_.unlink(missing_ok=True)
        self.full_.unlink(missing_ok=True)


@pytest.fixture(scope="module")
def running(all_stacks):
    control = all_stacks.folder()
    library = control / "full_disk.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, REPO / "tests" / "integration" / "full_disk.c", "-ldl"], check=True)
    control.chmod(0o777)
    data = all_stacks.folder()
    roots = ":".join(str(data / name) for name in ("uploads", "volumes", "scratch", "cache"))
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge", "ingestd"), data_dir=data, extra_env={
        "LD_PRELOAD": str(library), "FULL_DISK_ROOTS": roots, "FULL_DISK_CONTROL": str(control), "DIAPHANE_LIGHT_MB": "0"})
    yield stack, Disk(control)
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def owner(running):
    return person(running[0])


def at_every_step(disk: Disk, act: Callable[[], None]) -> int:
    """Runs `act` with the disk full at the first step, the second, and so on, until there is no further step. Returns the number
    of steps. `act` frees the disk once it has seen that it is full, and returns when everything is done."""
    for step in range(MOST_STEPS):
        disk.fill_after(step)
        act()
        disk.make_room()
        if not disk.was_full:
            return step
    raise AssertionError("there is no end of steps")


def wait_through(stack, disk: Disk, done: Callable[[], object], told: Callable[[], object], whole: Callable[[], None]) -> None:
    """Waits until `done`. If the disk fills up before, `told` must become true and `whole` must pass before it is freed."""
    stack.wait_until(lambda: disk.full or done(), what="the end, or a full disk")
    if disk.full:
        stack.wait_until(lambda: told() or done(), what="the person is told")
        if not done():
            whole()
        disk.make_room()
        stack.psql("UPDATE ingest_jobs SET not_before = now()")  # as if the pause of a waiting job were over
    stack.wait_until(done, what="the end")
    disk.make_room()  # later steps are not tested


def test_an_upload_survives_a_full_disk_at_every_write(running, owner):
    stack, disk = running
    data = bundle(series())

    def act() -> None:
        made = owner.data_set(len(data))
        url, one = made["upload_url"], made["data_set"]["id"]
        answer = owner.patch(url, 0, data)
        if answer.status_code != 204:
            assert disk.full
            assert "kept" in problem(answer, 507, "storage-full")["detail"] and owner.offset(url) == 0
            disk.make_room()
            assert owner.patch(url, 0, data).status_code == 204

        def seen() -> dict:
            return owner.http.get(f"/v1/data-sets/{one}").json()

        def whole() -> None:
            now = seen()
            assert now["refusal"] is None and (now["state"] == "ready" or upload_path(stack, one).read_bytes() == data)

        wait_through(stack, disk, lambda: seen()["state"] == "ready" and not upload_path(stack, one).exists(),
                     lambda: seen()["waiting_for"] == "room" or seen()["state"] == "ready", whole)
        assert seen()["waiting_for"] is None and (volume_path(stack, one) / "voxels.i16").stat().st_size == 2 * 20 * 16 * 16
        stack.wait_until(lambda: not [f for f in os.listdir(stack.data_dir / "volumes") if f.startswith(".tmp-")], what="no remains")
        assert os.listdir(stack.data_dir / "scratch") == []
        assert owner.http.delete(f"/v1/data-sets/{one}").status_code == 204

    assert at_every_step(disk, act) >= 12
    assert 'diaphane_ingest_waits_total{for="room"} 0' not in stack.metrics("ingestd")
    assert '"event":"job_waits"' in stack.log("ingestd") and stack.psql("SELECT count(*) FROM ingest_jobs") == [(0,)]


@pytest.mark.nightly
def test_a_cut_survives_a_full_disk_at_every_write(running, owner):
    stack, disk = running

    def act() -> None:
        one, content = marked_scan(stack, owner)
        ordered = owner.http.post(f"/v1/data-sets/{one}/anonymise",
                                  json={"keep": KEEP, "volume_hash": content, "confirm": CONFIRMATION})
        assert ordered.status_code == 202, ordered.text

        def seen() -> dict:
            return owner.http.get(f"/v1/data-sets/{one}").json()

        def whole() -> None:
            voxels = (volume_path(stack, one) / "voxels.i16").read_bytes()
            assert hash_of(voxels) == content or voxels == expected_left()

        wait_through(stack, disk, lambda: seen()["state"] == "ready", lambda: seen()["waiting_for"] == "room", whole)
        assert seen()["anonymised_at"] and owner.http.get(f"/v1/data-sets/{one}/anonymise").json()["problem"] is None
        assert (volume_path(stack, one) / "voxels.i16").read_bytes() == expected_left()
        stack.wait_until(lambda: holders_of_mark(stack.data_dir / "volumes", stack.data_dir / "scratch") == [], what="the old voxels are gone")

    assert at_every_step(disk, act) >= 9


@pytest.mark.nightly
def test_an_export_waits_for_room_at_every_write(running):
    stack, disk = running
    somebody = person(stack)
    one, _ = marked_scan(stack, somebody)
    exports = stack.data_dir / "cache" / "exports"

    def act() -> None:
        assert somebody.http.post("/v1/me/export").status_code == 202

        def seen() -> dict:
            return somebody.http.get("/v1/me/export").json()

        def whole() -> None:
            assert seen()["state"] == "queued" and list(exports.glob("*.zip")) == []

        wait_through(stack, disk, lambda: seen()["state"] == "ready", lambda: seen()["waiting"], whole)
        file = zipfile.ZipFile(io.BytesIO(somebody.http.get("/v1/me/export/file").content))
        assert file.testzip() is None and f"scans/{one}/voxels.i16" in file.namelist() and not seen()["waiting"]
        assert somebody.http.delete("/v1/me/export").status_code == 204
        stack.wait_until(lambda: not exports.exists() or os.listdir(exports) == [], what="the disposal")

    assert at_every_step(disk, act) >= 3


@pytest.mark.nightly
def test_a_deletion_succeeds_on_a_full_disk_at_every_write(running, owner):
    stack, disk = running

    def act() -> None:
        one, _ = marked_scan(stack, owner)
        assert owner.http.delete(f"/v1/data-sets/{one}").status_code == 204

        def gone() -> bool:
            return not volume_path(stack, one).exists() and stack.psql("SELECT count(*) FROM disposals WHERE id = %s", one) == [(0,)]

        noted = f'"event":"failed to delete files","id":"{one}"'
        wait_through(stack, disk, gone, lambda: noted in stack.log("api"), lambda: None)
        assert holders_of_mark(*(path for path in (stack.data_dir / "volumes").iterdir() if one in path.name)) == []

    assert at_every_step(disk, act) >= 3
