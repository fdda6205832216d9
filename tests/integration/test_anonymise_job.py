"""The cut as ingestd performs it: the kept part is unchanged and the rest is gone, at whatever step ingestd is killed."""

from __future__ import annotations

import json
import signal

import pytest
from cut_helpers import (SIDE, build_killer, expected_left, hash_of, holders_of_mark, order, ready_data_set, run_ingestd)
from ingest_helpers import volume_path
from stream_helpers import free_port


@pytest.fixture(scope="module")
def stores_and_api(all_stacks):
    running = all_stacks.open(only=("postgres", "redis", "api"))
    yield running
    all_stacks.shut(running)


@pytest.fixture(scope="module")
def killer(tmp_path_factory):
    return build_killer(tmp_path_factory.mktemp("killer"))


@pytest.fixture
def port():
    return free_port()


def is_cut(stack, data_set: str) -> bool:
    return stack.psql("SELECT state FROM data_sets WHERE id = %s", data_set) == [("ready",)]


def finish(stack, data_sets: list[str], port: int) -> None:
    """The claimers of the jobs are dead. Their leases expire, and another ingestd claims the jobs."""
    stack.psql("UPDATE ingest_jobs SET leased_until = now()")
    other = run_ingestd(stack, port)
    try:
        for data_set in data_sets:
            stack.wait_until(lambda one=data_set: is_cut(stack, one), what="the cut")
    finally:
        other.terminate()
        other.communicate(timeout=60)


def check_cut(stack, data_set: str) -> None:
    folder = volume_path(stack, data_set)
    voxels = (folder / "voxels.i16").read_bytes()
    assert voxels == expected_left()
    header = json.loads((folder / "volume.json").read_text())
    assert header["size"] == [SIDE, SIDE, SIDE // 2] and header["maximum"] == 63
    assert header["contentHash"] == hash_of(voxels)
    row = stack.psql("SELECT size_z, volume_bytes, cut_problem, anonymised_at IS NOT NULL FROM data_sets WHERE id = %s",
                     data_set)
    assert row == [(SIDE // 2, len(voxels), None, True)]
    assert stack.psql("SELECT count(*) FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(0,)]
    # If the first claimer was killed, the sweep of api may be erasing what it left when the second one reports the end.
    stack.wait_until(lambda: [f.name for f in folder.parent.iterdir() if f.name.startswith(".tmp-")] == [], what="the end of the old volume")
    assert holders_of_mark(stack.data_dir) == []


def test_a_cut_removes_the_outside_and_keeps_the_inside(stores_and_api, port):
    data_set, content = ready_data_set(stores_and_api)
    assert len(holders_of_mark(stores_and_api.data_dir)) == 1, "the search would find nothing anyway"
    stores_and_api.psql("WITH author AS (INSERT INTO users (id, email, email_key, password_hash) VALUES (gen_random_uuid(), 'a@marks', 'a@marks', 'x') RETURNING id) "
                        "INSERT INTO annotations SELECT gen_random_uuid(), %s, id, 'Mine', '{}', true, false, now(), now() FROM author", data_set)
    order(stores_and_api, data_set, content)
    finish(stores_and_api, [data_set], port)
    check_cut(stores_and_api, data_set)
    # Their texts may identify the patient.
    assert stores_and_api.psql("SELECT count(*) FROM annotations WHERE data_set_id = %s", data_set) == [(0,)]


def test_a_cut_killed_before_any_step_leaves_a_complete_volume_and_is_finished(stores_and_api, killer, port):
    told, cut_before_the_end = [], []
    for step in range(1, 100):
        data_set, content = ready_data_set(stores_and_api)
        order(stores_and_api, data_set, content)
        doomed = run_ingestd(stores_and_api, port, killer, step)
        stores_and_api.wait_until(lambda: doomed.poll() is not None or is_cut(stores_and_api, data_set), what="its end")
        if doomed.poll() is None:  # it has no more steps than that
            doomed.terminate()
            doomed.communicate(timeout=60)
            break
        said = doomed.communicate(timeout=60)[1]
        assert doomed.returncode == -signal.SIGKILL, said
        # Another thread may still log a line before the signal arrives.
        [last] = [line for line in said.splitlines() if line.startswith("killed before step")]
        told.append(last.partition(", ")[2])
        folder = volume_path(stores_and_api, data_set)
        stored = json.loads((folder / "volume.json").read_text())["contentHash"]
        assert stored == hash_of((folder / "voxels.i16").read_bytes()), "one of them, whole"
        cut = (folder / "voxels.i16").read_bytes() == expected_left()
        assert cut or stored == content
        anonymised = stores_and_api.psql("SELECT anonymised_at IS NOT NULL FROM data_sets WHERE id = %s", data_set)[0][0]
        assert cut if anonymised else not is_cut(stores_and_api, data_set), "never ready in between"
        cut_before_the_end.append(data_set)
    assert {"mkdir", "fsync", "renameat2", "ftruncate", "send"} <= set(told) and {"unlinkat", "remove"} & set(told), told
    assert told.index("send") < told.index("renameat2") < told.index("ftruncate"), "told, then exchanged, then erased"
    finish(stores_and_api, cut_before_the_end, port)
    for data_set in cut_before_the_end:
        check_cut(stores_and_api, data_set)


def test_a_cut_killed_before_erasing_leaves_no_data_even_without_ingestd(stores_and_api, port, tmp_path):
    data_set, content = ready_data_set(stores_and_api)
    order(stores_and_api, data_set, content)
    (tmp_path / "exchanged").touch()
    tmp_path.chmod(0o777)
    doomed = run_ingestd(stores_and_api, port, faults=tmp_path)
    doomed.communicate(timeout=60)
    assert doomed.returncode == -signal.SIGKILL
    assert (volume_path(stores_and_api, data_set) / "voxels.i16").read_bytes() == expected_left(), "it died behind the exchange"
    stores_and_api.wait_until(lambda: holders_of_mark(stores_and_api.data_dir) == [], 60, "api's sweep")
    finish(stores_and_api, [data_set], port)
    check_cut(stores_and_api, data_set)


def test_a_failed_cut_is_reported_and_changes_nothing(stores_and_api, port):
    for keep, of, words in (({"box": {"low": [0, 0, 90], "high": [9, 9, 99]}}, None, "Too little"),
                            (None, "blake2b:" + "0" * 64, "has changed since you reviewed it")):
        data_set, content = ready_data_set(stores_and_api)
        order(stores_and_api, data_set, of or content, **({"keep": keep} if keep else {}))
        finish(stores_and_api, [data_set], port)
        problem, at = stores_and_api.psql("SELECT cut_problem, anonymised_at FROM data_sets WHERE id = %s", data_set)[0]
        assert words in problem and at is None
        folder = volume_path(stores_and_api, data_set)
        assert hash_of((folder / "voxels.i16").read_bytes()) == content
        stores_and_api.psql("DELETE FROM data_sets WHERE id = %s", data_set)
        for file in folder.iterdir():
            file.unlink()


def test_a_data_set_deleted_while_it_waits_is_not_cut(stores_and_api, port):
    data_set, content = ready_data_set(stores_and_api)
    order(stores_and_api, data_set, content)
    stores_and_api.psql("DELETE FROM data_sets WHERE id = %s", data_set)
    assert stores_and_api.psql("SELECT count(*) FROM ingest_jobs") == [(0,)]
