"""What breaks while ingestd works: itself, its child, Postgres. Nothing is lost and nothing is left behind."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest
from ingest_help import bundle, cranium, enqueue, nothing_left, state, upload_path, volume_path, wait_end

PROGRAMS = ("postgres", "redis", "api", "ingestd")


@pytest.fixture(scope="module")
def ingest(stack_house):
    # A short lease and time limit, so that what waits for them does not take long.
    running = stack_house.open(only=PROGRAMS, extra_env={"DIAPHANE_LEASE_MS": "1500", "DIAPHANE_TIME_LIMIT_S": "8"})
    yield running
    stack_house.shut(running)


@pytest.fixture(scope="module")
def head(ingest, tmp_path_factory) -> bytes:
    return bundle(cranium(ingest, tmp_path_factory.mktemp("cranium")))


def children(pid: int) -> list[int]:
    """Children that read an upload. One that is not yet that program is none: what it holds is ingestd's."""
    found = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        found += [int(child) for child in (task / "children").read_text().split()]
    return [child for child in found if b"build-series" in Path(f"/proc/{child}/cmdline").read_bytes()]


def frozen_child(stack, data: bytes) -> tuple[str, int]:
    """A data set that is being built, and the child that builds it, stopped in the middle of its work."""
    ingestd = stack.pids["ingestd"]
    data_set = enqueue(stack, data)
    deadline = time.monotonic() + 10
    while not (pids := children(ingestd)):
        assert time.monotonic() < deadline, "no child was started"
        time.sleep(0.0005)
    os.kill(pids[0], signal.SIGSTOP)
    assert state(stack, data_set)[0] == "building"
    return data_set, pids[0]


def is_gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except FileNotFoundError:
        return True


def test_a_killed_ingestd_takes_its_child_along_and_the_job_is_taken_up_again(ingest, head):
    data_set, child = frozen_child(ingest, head)
    ingest.kill("ingestd")
    ingest.wait_until(lambda: is_gone(child), 3, "the child's end")
    assert upload_path(ingest, data_set).exists(), "it is needed again"
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)
    assert (volume_path(ingest, data_set) / "voxels.i16").stat().st_size == 256 * 256 * 108 * 2


def test_what_a_killed_ingestd_left_in_the_store_is_swept_and_overwritten(ingest, head):
    ingest.stop("ingestd")
    volumes = ingest.data_dir / "volumes"
    data_set = enqueue(ingest, head)
    half, whole = volumes / f".tmp-{data_set}-0123456789abcdef", volumes / data_set
    for left in (half, whole):  # stored, but killed before it could say so
        left.mkdir()
        (left / "voxels.i16").write_bytes(b"half")
        os.chown(left, volumes.stat().st_uid, volumes.stat().st_gid)
        os.chown(left / "voxels.i16", volumes.stat().st_uid, volumes.stat().st_gid)
    ingest.start("ingestd")
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)
    assert (whole / "voxels.i16").stat().st_size == 256 * 256 * 108 * 2


def test_a_job_that_ends_ingestd_every_time_is_given_up(ingest, head):
    data_set, _ = frozen_child(ingest, head)
    for _ in range(2):
        ingest.kill("ingestd")
        ingest.wait_ready("ingestd")
        caught = ingest.wait_until(lambda: children(ingest.pids["ingestd"]), what="the next attempt")
        os.kill(caught[0], signal.SIGSTOP)
    ingest.kill("ingestd")
    ended, code, text = wait_end(ingest, data_set)
    assert (ended, code) == ("refused", "internal") and "again" in text
    nothing_left(ingest, data_set)


@pytest.mark.parametrize("by", [signal.SIGSEGV, signal.SIGABRT, signal.SIGSYS])
def test_a_crash_of_the_child_is_a_refusal_and_touches_no_other_upload(ingest, head, by):
    other = enqueue(ingest, head)
    assert wait_end(ingest, other)[0] == "ready"
    before = (volume_path(ingest, other) / "volume.json").read_bytes()
    data_set, child = frozen_child(ingest, head)
    later = enqueue(ingest, head)
    os.kill(child, by)
    os.kill(child, signal.SIGCONT)
    assert wait_end(ingest, data_set) == ("refused", "unreadable", "This upload could not be read safely.")
    nothing_left(ingest, data_set)
    assert not volume_path(ingest, data_set).exists()
    assert wait_end(ingest, later)[0] == "ready"
    assert (volume_path(ingest, other) / "volume.json").read_bytes() == before


def test_a_killed_child_is_tried_again(ingest, head):
    """As the kernel kills it when memory is short."""
    data_set, child = frozen_child(ingest, head)
    os.kill(child, signal.SIGKILL)
    ingest.wait_until(lambda: ingest.psql("SELECT attempts, waiting_for FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(1, "memory")],
                      what="it waits")
    assert upload_path(ingest, data_set).exists()
    assert wait_end(ingest, data_set)[0] == "ready"
    nothing_left(ingest, data_set)


def test_a_child_that_does_not_end_is_ended(ingest, head):
    data_set, child = frozen_child(ingest, head)
    assert wait_end(ingest, data_set, 20)[1] == "too_slow"
    assert is_gone(child)
    nothing_left(ingest, data_set)


def test_a_stop_gives_the_job_back_in_time_and_counts_no_attempt(ingest, head):
    data_set, child = frozen_child(ingest, head)
    before = time.monotonic()
    ingest.stop("ingestd")
    assert time.monotonic() - before < 4.5
    assert is_gone(child)
    assert state(ingest, data_set)[0] == "queued"
    assert ingest.psql("SELECT attempts, leased_by FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(0, None)]
    assert upload_path(ingest, data_set).exists()
    ingest.start("ingestd")
    assert wait_end(ingest, data_set)[0] == "ready"


def test_a_lost_postgres_in_mid_build_loses_nothing(ingest, head):
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
    ingest.wait_until(lambda: is_gone(child), 3, "the child's end")
    ingest.wait_until(lambda: not upload_path(ingest, data_set).exists(), 3, "the original's end")
    nothing_left(ingest, data_set)
    assert not volume_path(ingest, data_set).exists()


def test_a_child_without_enough_memory_is_a_refusal(stack_factory, head):
    small = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_MEMORY_LIMIT_MB": "700"})
    roomy = enqueue(small, head)
    ended = wait_end(small, roomy)
    assert ended[0] == "ready" or ended[1] in ("too_large", "unreadable")
    nothing_left(small, roomy)
