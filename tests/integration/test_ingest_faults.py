"""Faults while ingestd works: of itself, its child, and Postgres. Nothing is lost and nothing is left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Callable

import pytest
from hostile import codestreams as code
from hostile.dicom_bytes import RLE, encapsulated, series
from hostile.dicom_bytes import bundle as dicom_bundle
from ingest_helpers import bundle, cranium, enqueue, nothing_left, state, upload_path, volume_path, wait_end

PROGRAMS = ("postgres", "redis", "api", "ingestd")


@pytest.fixture(scope="module")
def ingest(all_stacks):
    # A short lease keeps the tests short.
    running = all_stacks.open(only=PROGRAMS, extra_env={"DIAPHANE_LEASE_MS": "3000"})
    yield running
    all_stacks.shut(running)


@pytest.fixture(scope="module")
def head(ingest, tmp_path_factory) -> bytes:
    return bundle(cranium(ingest, tmp_path_factory.mktemp("cranium")))


def children(pid: int) -> list[int]:
    """Returns children that read an upload. Excludes those before exec, which still have ingestd's state."""
    try:
        found = []
        for task in Path(f"/proc/{pid}/task").iterdir():
            found += [int(child) for child in (task / "children").read_text().split()]
        return [child for child in found if b"build-series" in Path(f"/proc/{child}/cmdline").read_bytes()]
    except (FileNotFoundError, ProcessLookupError):
        return []    # a thread or a child ended meanwhile; the next look tells


def next_child(ingestd: int, timeout: float = 60, missed: Callable[[], bool] = lambda: False) -> int:
    """Returns the next child that reads an upload, or 0 if it was `missed`. Looks often, because a child may live for only some
    milliseconds."""
    deadline, looks = time.monotonic() + timeout, 0
    while not (pids := children(ingestd)):
        assert time.monotonic() < deadline, f"no child was started within {timeout} s"
        looks += 1
        if looks % 100 == 0 and missed():
            return 0
        time.sleep(0.0005)
    return pids[0]


def state_of(pid: int) -> str:
    """Returns the letter of a process's state, or "X" if there is no such process."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return "X"


def is_gone(pid: int) -> bool:
    return state_of(pid) in "ZX"


def freeze(child: int, reading: bool = False) -> bool:
    """Stops a child. Returns false if it ended before."""
    try:
        while reading and "pos:\t0\n" in Path(f"/proc/{child}/fdinfo/3").read_text():
            pass
        os.kill(child, signal.SIGSTOP)
    except (FileNotFoundError, ProcessLookupError):
        return False
    while (now := state_of(child)) not in "TtZX":
        time.sleep(0.0005)
    return now in "Tt"


def frozen_child(stack, data: bytes, reading: bool = False) -> tuple[str, int]:
    """Returns a data set that is being built, and its child, stopped during its work. With `reading`, not before it reads the
    upload. On a busy machine, a child may end before it can be stopped. Then it is the child of another upload."""
    for _ in range(20):
        data_set = enqueue(stack, data)
        child = next_child(stack.pids["ingestd"], missed=lambda made=data_set: state(stack, made)[0] not in ("queued", "building"))
        if child and freeze(child, reading):
            assert state(stack, data_set)[0] == "building"
            return data_set, child
        wait_end(stack, data_set)
    raise AssertionError("no child could be stopped in time")


def test_the_child_of_a_killed_ingestd_ends_and_the_job_is_retried(ingest, head):
    data_set, child = frozen_child(ingest, head)
    ingest.kill("ingestd")
    ingest.wait_until(lambda: is_gone(child), what="the child's end")
    assert upload_path(ingest, data_set).exists(), "it is needed again"
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)
    assert (volume_path(ingest, data_set) / "voxels.i16").stat().st_size == 256 * 256 * 108 * 2


def test_leftovers_of_a_killed_ingestd_are_removed(ingest, head):
    ingest.stop("ingestd")
    volumes = ingest.data_dir / "volumes"
    data_set = enqueue(ingest, head)
    half, whole = volumes / f".tmp-{data_set}-0123456789abcdef", volumes / data_set
    for left in (half, whole):  # stored, but killed before it could report it
        left.mkdir()
        (left / "voxels.i16").write_bytes(b"half")
        os.chown(left, volumes.stat().st_uid, volumes.stat().st_gid)
        os.chown(left / "voxels.i16", volumes.stat().st_uid, volumes.stat().st_gid)
    ingest.start("ingestd")
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)
    assert (whole / "voxels.i16").stat().st_size == 256 * 256 * 108 * 2


def test_a_job_that_crashes_ingestd_is_retried_with_growing_delays(ingest, head):
    data_set, _ = frozen_child(ingest, head)
    for interruptions in range(1, 4):
        ingest.kill("ingestd")
        ingest.wait_ready("ingestd")
        if interruptions < 3:    # at once, because the child ends soon
            assert freeze(next_child(ingest.pids["ingestd"])), "it was stopped too late"
        ingest.wait_until(lambda n=interruptions: ingest.psql("SELECT interruptions, attempts FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(n, 0)],
                          what="the interruption is counted")
    # It would otherwise be over before everything has been looked at.
    ingest.psql("UPDATE ingest_jobs SET not_before = not_before + interval '1 hour' WHERE data_set_id = %s", data_set)
    assert ingest.psql("SELECT waiting_for FROM ingest_jobs WHERE data_set_id = %s", data_set) == [("interruption",)]
    assert state(ingest, data_set)[0] == "queued" and upload_path(ingest, data_set).read_bytes() == head
    assert f'"event":"job_interrupted","data_set":"{data_set}"' in ingest.log("ingestd")
    ingest.wait_until(lambda: "diaphane_ingest_interrupted 1\n" in ingest.metrics("ingestd"), what="the metric")
    ingest.psql("UPDATE ingest_jobs SET not_before = now() WHERE data_set_id = %s", data_set)
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)


def interrupted(stack, data_set: str, times: int) -> None:
    stack.psql("UPDATE ingest_jobs SET interruptions = %s WHERE data_set_id = %s", times, data_set)


def begun(stack, since: int) -> list[str]:
    return [line.split('"data_set":"')[1][:36] for line in stack.log("ingestd")[since:].splitlines() if '"ingest_started"' in line]


def test_a_job_that_was_interrupted_twice_runs_after_others_and_alone(ingest, head):
    ingest.stop("ingestd")
    since = len(ingest.log("ingestd"))
    suspect, other = enqueue(ingest, head), enqueue(ingest, head)
    interrupted(ingest, suspect, 2)
    ingest.start("ingestd")
    ingest.wait_until(lambda: len(begun(ingest, since)) == 2, what="both have begun")
    assert begun(ingest, since) == [other, suspect] and state(ingest, other)[0] == "ready"
    later = enqueue(ingest, head)
    ingest.wait_until(lambda: state(ingest, suspect)[0] in ("building", "ready"), what="the suspect")
    assert wait_end(ingest, suspect)[0] == wait_end(ingest, later)[0] == "ready"

    caught, child = frozen_child(ingest, head)
    interrupted(ingest, caught, 2)
    later = enqueue(ingest, head)
    time.sleep(2)
    assert state(ingest, later)[0] == "queued", "what takes ingestd along would take this along, too"
    os.kill(child, signal.SIGCONT)
    assert wait_end(ingest, caught)[0] == wait_end(ingest, later)[0] == "ready"


def test_an_interrupted_job_is_retried_even_if_many_others_wait(ingest, head):
    ingest.stop("ingestd")
    since = len(ingest.log("ingestd"))
    others = [enqueue(ingest, b"x") for _ in range(10)]
    suspect = enqueue(ingest, head)
    interrupted(ingest, suspect, 2)
    ingest.psql("UPDATE ingest_jobs SET not_before = now() - interval '11 minutes' WHERE data_set_id = %s", suspect)
    ingest.start("ingestd")
    assert wait_end(ingest, suspect)[0] == "ready" and begun(ingest, since)[0] == suspect
    assert {wait_end(ingest, other)[0] for other in others} == {"refused"}


@pytest.mark.parametrize("by", [signal.SIGSEGV, *(pytest.param(by, marks=pytest.mark.nightly) for by in (signal.SIGABRT, signal.SIGSYS))])
def test_a_crash_of_the_child_refuses_only_its_upload(ingest, head, by):
    other = enqueue(ingest, head)
    assert wait_end(ingest, other)[0] == "ready"
    before = (volume_path(ingest, other) / "volume.json").read_bytes()
    data_set, child = frozen_child(ingest, head, reading=True)
    later = enqueue(ingest, head)
    os.kill(child, by)
    os.kill(child, signal.SIGCONT)
    assert wait_end(ingest, data_set) == ("refused", "unreadable", "This upload could not be read safely.")
    nothing_left(ingest, data_set)
    assert not volume_path(ingest, data_set).exists()
    assert wait_end(ingest, later)[0] == "ready"
    assert (volume_path(ingest, other) / "volume.json").read_bytes() == before


def test_a_job_whose_child_was_killed_is_retried(ingest, head):
    """As the kernel does when memory is short."""
    data_set, child = frozen_child(ingest, head)
    os.kill(child, signal.SIGKILL)
    ingest.wait_until(lambda: ingest.psql("SELECT attempts, waiting_for FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(1, "memory")],
                      what="it waits")
    assert upload_path(ingest, data_set).exists()
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)


@pytest.mark.nightly
def test_low_memory_refuses_no_upload(stack_factory):
    """A limit on ingestd's writable memory simulates a machine with too little: the child is below its own limit."""
    ingest = stack_factory(only=PROGRAMS)
    plane = code.rle_zeros(512 * 512)
    data = dicom_bundle(series(200, syntax=RLE, rows=512, columns=512, pixels=encapsulated(code.rle(plane, plane))))
    pid = ingest.pids["ingestd"]
    status = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines())
    held = int(status["VmData"].split()[0]) * 1024
    subprocess.run(["prlimit", "--pid", str(pid), f"--data={held + (16 << 20)}:"], check=True, **ingest.stack.run_as.popen())
    data_set = enqueue(ingest, data)
    try:
        ingest.wait_until(lambda: ingest.psql("SELECT attempts, waiting_for FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(1, "memory")],
                          what="it waits")
        assert upload_path(ingest, data_set).exists() and "ran out of memory before the child process reached its limit" in ingest.log("ingestd")
    finally:
        subprocess.run(["prlimit", "--pid", str(pid), "--data=unlimited:"], check=True, **ingest.stack.run_as.popen())
    ingest.psql("UPDATE ingest_jobs SET not_before = now()")
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)


def test_uploads_wait_while_their_disk_is_not_mounted(ingest, head):
    assert wait_end(ingest, enqueue(ingest, head))[0] == "ready"
    ingest.stop("ingestd")
    data_set = enqueue(ingest, head)
    uploads = ingest.data_dir / "uploads"
    for new_start in (True, False):
        if not new_start:
            data_set, child = frozen_child(ingest, head)
        uploads.rename(uploads.with_name("unmounted"))
        uploads.mkdir()
        os.chown(uploads, (was := uploads.with_name("unmounted").stat()).st_uid, was.st_gid)
        uploads.chmod(was.st_mode & 0o777)
        if new_start:
            ingest.start("ingestd")
        else:
            os.kill(child, signal.SIGKILL)
            ingest.psql("UPDATE ingest_jobs SET waits = 100")
        try:
            ingest.wait_until(lambda: "the upload disk is not mounted" in ingest.log("ingestd"), what="it is logged")
            ingest.wait_until(lambda one=data_set: ingest.psql("SELECT waiting_for, attempts <= 1 FROM ingest_jobs WHERE data_set_id = %s", one)
                              == [("service", True)], what="it waits")
            # Between its pauses it is tried again, and not refused.
            ingest.wait_until(lambda one=data_set: state(ingest, one) == ("queued", None, None), what="it is queued")
        finally:
            uploads.rmdir()
            uploads.with_name("unmounted").rename(uploads)
        ingest.psql("UPDATE ingest_jobs SET not_before = now()")
        assert wait_end(ingest, data_set)[0] == "ready"
        nothing_left(ingest, data_set)


@pytest.mark.nightly
def test_a_child_without_cpu_time_is_ended_and_its_job_retried(stack_factory, head):
    # Only here, because on a busy machine other children would get too little in so short a time.
    ingest = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_TIME_LIMIT_S": "8"})
    data_set, child = frozen_child(ingest, head)
    assert wait_end(ingest, data_set)[0] == "ready"
    assert is_gone(child)
    nothing_left(ingest, data_set)


def test_stopping_ingestd_returns_the_job_without_counting_an_attempt(ingest, head):
    data_set, child = frozen_child(ingest, head)
    before = len(ingest.events)
    ingest.stop("ingestd")
    assert not any("did not stop in time" in event for event in ingest.events[before:])
    assert is_gone(child)
    assert state(ingest, data_set)[0] == "queued"
    assert ingest.psql("SELECT attempts, leased_by FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(0, None)]
    assert upload_path(ingest, data_set).exists()
    ingest.start("ingestd")
    assert wait_end(ingest, data_set)[0] == "ready"


def test_an_outage_of_postgres_during_a_build_loses_nothing(ingest, head):
    data_set, child = frozen_child(ingest, head)
    ingest.kill("postgres", restart=False)
    os.kill(child, signal.SIGCONT)
    time.sleep(2)
    ingest.start("postgres")
    ingest.wait_ready("postgres")
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)


def test_a_deleted_data_set_stops_its_build(ingest, head):
    data_set, child = frozen_child(ingest, head)
    ingest.psql("DELETE FROM data_sets WHERE id = %s", data_set)
    ingest.wait_until(lambda: is_gone(child), what="the child's end")
    ingest.wait_until(lambda: not upload_path(ingest, data_set).exists(), what="the original's end")
    nothing_left(ingest, data_set)
    assert not volume_path(ingest, data_set).exists()


def test_an_upload_that_needs_too_much_memory_is_refused(stack_factory, head):
    small = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_MEMORY_LIMIT_MB": "700"})
    roomy = enqueue(small, head)
    ended = wait_end(small, roomy)
    assert ended[0] == "ready" or ended[1] in ("too_large", "unreadable")
    nothing_left(small, roomy)
