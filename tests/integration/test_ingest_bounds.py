"""Limits of one account in ingest: storage, turns, memory, the queue, and the disk of exports."""

from __future__ import annotations

import os
import signal

import pytest
from api_client import person, problem
from hostile import codestreams as code
from hostile.dicom_bytes import RLE, bundle, encapsulated, series
from ingest_helpers import upload_path, volume_path
from test_ingest_faults import freeze, next_child

SIDE, SLICES = 256, 20
VOLUME = 2 * SIDE * SIDE * SLICES


def small_upload_of_a_large_volume() -> bytes:
    plane = code.rle_zeros(SIDE * SIDE)
    data = bundle(series(SLICES, syntax=RLE, rows=SIDE, columns=SIDE, pixels=encapsulated(code.rle(plane, plane))))
    assert len(data) < VOLUME / 20
    return data


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge", "ingestd"), extra_env={
        "DIAPHANE_MOST_UNPROCESSED": "30", "DIAPHANE_LIGHT_MB": "1"})
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def strict(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge"), extra_env={
        "DIAPHANE_MOST_UNPROCESSED": "3", "DIAPHANE_MOST_DATA_SETS": "5", "DIAPHANE_EXPORTS_MB": "1"})
    yield stack
    all_stacks.shut(stack)


def state(somebody, data_set: str) -> dict:
    return somebody.http.get(f"/v1/data-sets/{data_set}").json()


def wait_ends(stack, somebody, ids: list[str]) -> list[dict]:
    return [stack.wait_until(lambda i=i: (now := state(somebody, i))["state"] in ("ready", "refused") and now, what="the end") for i in ids]


def test_volumes_count_against_the_quota_by_their_own_size(running):
    somebody = person(running)
    data = small_upload_of_a_large_volume()
    quota = 2 * VOLUME + 6 * len(data)
    running.psql("UPDATE users SET quota_bytes = %s WHERE email = %s", quota, somebody.email)
    ids = [somebody.data_set(len(data)) for _ in range(6)]
    for made in ids:
        assert somebody.patch(made["upload_url"], 0, data).status_code == 204
    ends = wait_ends(running, somebody, [made["data_set"]["id"] for made in ids])
    assert sorted(end["state"] for end in ends) == ["ready"] * 2 + ["refused"] * 4
    for end in ends:
        if end["state"] == "refused":
            assert end["refusal"]["code"] == "over_quota" and "3 MB" in end["refusal"]["text"], end["refusal"]
            # api may delete the original before ingestd discards the volume.
            running.wait_until(lambda i=end["id"]: not upload_path(running, i).exists() and not volume_path(running, i).exists(),
                               what="the end of the original and of the volume")
    used = somebody.http.get("/v1/me").json()["quota"]
    assert used["used_bytes"] == 2 * VOLUME <= used["bytes"] == quota


def test_a_quota_reduced_during_a_build_is_enforced(running):
    """The final check: the quota was sufficient when the job was claimed, but no longer is."""
    somebody = person(running)
    data = small_upload_of_a_large_volume()
    made = somebody.data_set(len(data))
    assert somebody.patch(made["upload_url"], 0, data[:100]).status_code == 204
    running.stop("ingestd")
    assert somebody.patch(made["upload_url"], 100, data[100:]).status_code == 204
    # A trigger on the claim simulates another volume of the owner, so that the quota has changed when the row is written.
    running.psql("""CREATE FUNCTION shrink() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
                      UPDATE users SET quota_bytes = 1000000 WHERE id = NEW.owner_id; RETURN NEW; END $$""")
    running.psql(f"""CREATE TRIGGER shrink AFTER UPDATE ON data_sets FOR EACH ROW
                     WHEN (NEW.state = 'building' AND NEW.id = '{made["data_set"]["id"]}') EXECUTE FUNCTION shrink()""")
    try:
        running.start("ingestd")
        [end] = wait_ends(running, somebody, [made["data_set"]["id"]])
    finally:
        running.psql("DROP TRIGGER shrink ON data_sets")
        running.psql("DROP FUNCTION shrink")
    assert end["refusal"]["code"] == "over_quota"
    running.wait_until(lambda: not volume_path(running, end["id"]).exists(), what="the volume's end")


def test_jobs_of_different_accounts_take_turns(running):
    """One account has 20 uploads, and another one has a later one. That is among the first to be processed."""
    running.stop("ingestd")
    many, single = person(running), person(running)
    first = [many.upload(b"x")["id"] for _ in range(20)]
    last = single.upload(bundle(series()))["id"]
    before = len(running.log("ingestd"))
    running.start("ingestd")
    wait_ends(running, single, [last])
    wait_ends(running, many, first)
    begun = [line.split('"data_set":"')[1][:36] for line in running.log("ingestd")[before:].splitlines() if '"ingest_started"' in line]
    assert sorted(begun) == sorted([*first, last]) and begun.index(last) <= 2, begun.index(last)


def test_a_slow_job_of_one_account_does_not_hold_up_another(running):
    slow, quick = person(running), person(running)
    data = bundle(series())
    running.stop("ingestd")    # so that its child cannot end before this test looks for it
    stuck = slow.upload(small_upload_of_a_large_volume())["id"]
    running.start("ingestd")
    while not freeze(child := next_child(running.pids["ingestd"])):
        pass    # that of the light worker, which leaves the volume to the other one
    try:
        behind = slow.upload(data)["id"]
        assert wait_ends(running, quick, [quick.upload(data)["id"]])[0]["state"] == "ready"
        assert state(slow, stuck)["state"] == "building"
        assert state(slow, behind)["state"] == "queued", "an account has one job under way, so the other worker stays free"
    finally:
        os.kill(child, signal.SIGCONT)
    assert [end["state"] for end in wait_ends(running, slow, [stuck, behind])] == ["ready", "ready"]


def test_pending_and_total_scans_per_account_are_limited(strict):
    stack = strict
    somebody, other = person(stack), person(stack)
    for _ in range(3):
        somebody.data_set(10)
    refused = somebody.announce(10)
    assert "3 of your scans" in problem(refused, 429, "too-many")["detail"] and int(refused.headers["retry-after"]) > 0
    other.data_set(10)
    stack.psql("UPDATE data_sets SET state = 'refused' WHERE owner_id = %s", somebody.id)
    somebody.data_set(10)
    somebody.data_set(10)
    stack.psql("UPDATE data_sets SET state = 'refused' WHERE owner_id = %s", somebody.id)
    assert "5 scans" in problem(somebody.announce(10), 409, "too-many-data-sets")["detail"]


def test_a_volume_too_large_for_the_light_worker_is_built_by_the_heavy_one(running):
    """While another user's job occupies the other worker, only the light one can claim it, and then hands it over."""
    somebody, large = person(running), person(running)
    data = small_upload_of_a_large_volume()
    running.stop("ingestd")
    first, second = somebody.upload(data)["id"], large.upload(data)["id"]
    running.start("ingestd")
    assert wait_ends(running, somebody, [first])[0]["state"] == wait_ends(running, large, [second])[0]["state"] == "ready"


def test_an_export_waits_for_disk_space_of_other_exports(strict):
    stack = strict
    other, somebody = person(stack), person(stack)
    made = somebody.data_set(10)["data_set"]["id"]
    stack.psql("UPDATE data_sets SET state = 'ready', volume_bytes = 600000 WHERE id = %s", made)
    stack.psql("""INSERT INTO exports (id, user_id, state, bytes, created_at, expires_at)
                  VALUES (gen_random_uuid(), %s, 'ready', 600000, now(), now() + interval '1 day')""", other.id)
    assert somebody.http.post("/v1/me/export").status_code == 202
    stack.wait_until(lambda: somebody.http.get("/v1/me/export").json()["waiting"], what="the person is told")
    assert other.http.delete("/v1/me/export").status_code == 204
    stack.wait_until(lambda: somebody.http.get("/v1/me/export").json()["state"] == "ready", what="the export")


def test_uploads_and_exports_wait_while_the_disk_is_below_its_reserve(stack_factory):
    stack = stack_factory(only=("postgres", "redis", "api", "edge", "ingestd"))
    somebody = person(stack)

    def with_reserve(mb: int) -> None:
        for program in ("api", "ingestd"):
            stack.stop(program)
            stack.stack.running_[program].program.env["DIAPHANE_DISK_RESERVE_MB"] = str(mb)
            stack.start(program)
        stack.wait_ready("api", "ingestd")

    stack.stop("ingestd")
    one = somebody.upload(bundle(series()))["id"]
    with_reserve(1_000_000)
    stack.wait_until(lambda: state(somebody, one)["waiting_for"] == "room", what="the person is told")
    assert somebody.http.post("/v1/me/export").status_code == 202
    stack.wait_until(lambda: somebody.http.get("/v1/me/export").json()["waiting"], what="the person is told")
    assert upload_path(stack, one).exists() and os.listdir(stack.data_dir / "volumes") == []
    problem(somebody.announce(1000), 507, "storage-full")
    with_reserve(0)
    assert wait_ends(stack, somebody, [one])[0]["state"] == "ready"
    stack.wait_until(lambda: somebody.http.get("/v1/me/export").json()["state"] == "ready", what="the export")
