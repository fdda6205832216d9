"""Data sets and their uploads (tus 1.0), through the edge."""

from __future__ import annotations

import base64
import os
import subprocess

import httpx
import pytest
from api_client import PART, add_worker, api, checksum, client, make_ready, one, person, problem, remove_worker  # noqa: F401

TUS = {"Tus-Resumable": "1.0.0"}


def test_an_interrupted_upload_is_resumed_and_queued(api, one):  # noqa: F811
    data = os.urandom(2 * PART + 12345)
    made = one.data_set(len(data), title="Kopf, zweiter Versuch")
    url, data_set = made["upload_url"], made["data_set"]["id"]
    assert made["data_set"]["state"] == "uploading" and made["data_set"]["upload"]["bytes"] == len(data)
    first = one.patch(url, 0, data[:PART], **{"Upload-Checksum": checksum("sha1", data[:PART])})
    assert first.status_code == 204 and first.headers["upload-offset"] == str(PART)
    assert "upload-expires" in first.headers and first.headers["tus-resumable"] == "1.0.0"

    def cut():
        yield data[PART:PART + 70000]
        raise ConnectionError("cut")

    with pytest.raises(Exception):
        one.http.patch(url, content=cut(), headers={
            **TUS, "Upload-Offset": str(PART), "Content-Type": "application/offset+octet-stream"})
    assert one.offset(url) == PART
    assert one.patch(url, PART, data[PART:2 * PART]).status_code == 204
    last = data[2 * PART:]
    assert one.patch(url, 2 * PART, last, **{"Upload-Checksum": checksum("sha256", last)}).status_code == 204

    now = one.http.get(f"/v1/data-sets/{data_set}").json()
    assert now["state"] == "queued" and now["upload"] is None
    assert api.psql("SELECT upload_id::text FROM ingest_jobs WHERE data_set_id = %s", data_set) == [(data_set,)]
    assert (api.data_dir / "uploads" / f"{data_set}.tar").read_bytes() == data
    # The client that missed the last response asks, and learns that everything has arrived.
    assert one.offset(url) == len(data)
    assert one.patch(url, len(data), b"").status_code == 204
    problem(one.patch(url, 2 * PART, last), 409, "upload-complete")
    problem(one.http.delete(url, headers=TUS), 409, "upload-complete")


def test_ingestd_is_notified_when_an_upload_is_complete(api, one):  # noqa: F811
    import psycopg

    with psycopg.connect(api.dsn, autocommit=True) as listening:
        listening.execute("LISTEN ingest_jobs")
        one.upload(b"x" * 100)
        assert next(listening.notifies(timeout=60)).channel == "ingest_jobs"


def test_a_damaged_part_is_discarded(api, one):  # noqa: F811
    made = one.data_set(2000)
    url = made["upload_url"]
    problem(one.patch(url, 0, b"a" * 1000, **{"Upload-Checksum": checksum("sha1", b"b")}), 460, "checksum-mismatch")
    assert one.offset(url) == 0
    for malformed in ("sha1", "md5 AAAA", "sha1 AAAA"):
        document = problem(one.patch(url, 0, b"a" * 10, **{"Upload-Checksum": malformed}), 422, "invalid")
        assert document["errors"][0]["field"] == "Upload-Checksum"
    assert one.patch(url, 0, b"a" * 1000, **{"Upload-Checksum": checksum("sha1", b"a" * 1000)}).status_code == 204


def test_a_part_with_the_wrong_offset_or_size_is_refused_without_loss(api, one):  # noqa: F811
    made = one.data_set(1000)
    url = made["upload_url"]
    assert one.patch(url, 0, b"a" * 400).status_code == 204
    problem(one.patch(url, 0, b"b" * 400), 409, "offset-mismatch")
    problem(one.patch(url, 500, b"b" * 400), 409, "offset-mismatch")
    problem(one.patch(url, 400, b"b" * 601), 422, "invalid")
    problem(one.http.patch(url, content=b"b", headers={**TUS, "Upload-Offset": "400"}), 415, "media-type")
    problem(one.http.patch(url, content=b"b", headers={
        **TUS, "Content-Type": "application/offset+octet-stream"}), 422, "invalid")
    problem(one.http.patch(url, content=b"b", headers={
        "Upload-Offset": "400", "Content-Type": "application/offset+octet-stream"}), 412, "tus-version")
    assert one.patch(url, 400, b"c" * (PART + 1)).status_code == 413
    assert one.offset(url) == 400
    assert (api.data_dir / "uploads" / f"{made['data_set']['id']}.tar").read_bytes() == b"a" * 400


def test_discovery_lists_the_supported_features(api):  # noqa: F811
    answer = client(api).options("/v1/uploads")
    assert answer.status_code == 204
    assert answer.headers["tus-version"] == "1.0.0"
    assert set(answer.headers["tus-extension"].split(",")) == {"creation", "checksum", "expiration", "termination"}
    assert answer.headers["tus-checksum-algorithm"] == "sha1,sha256"


def metadata(**said: str | bytes) -> str:
    pairs = {name: value if isinstance(value, bytes) else value.encode() for name, value in said.items()}
    return ",".join(f"{name} {base64.b64encode(value).decode()}" for name, value in pairs.items())


def test_an_upload_can_be_created_with_tus_only(api, one):  # noqa: F811
    said = metadata(title="Knie, links", filename="Mustermann.tar", filetype="application/x-tar")
    answer = one.http.post("/v1/uploads", headers={**TUS, "Upload-Length": "1000", "Upload-Metadata": said})
    assert answer.status_code == 201 and answer.headers["upload-offset"] == "0" and "upload-expires" in answer.headers
    url = answer.headers["location"]
    made = one.http.get(f"/v1/data-sets/{url.rsplit('/', 1)[1]}").json()
    assert made["title"] == "Knie, links" and made["upload"]["bytes"] == 1000 and made["state"] == "uploading"
    assert one.patch(url, 0, b"x" * 1000).status_code == 204
    assert one.http.get(f"/v1/data-sets/{made['id']}").json()["state"] == "queued"
    # The same key always refers to the same upload.
    key = {**TUS, "Upload-Length": "7", "Idempotency-Key": os.urandom(8).hex()}
    assert one.http.post("/v1/uploads", headers=key).headers["location"] == one.http.post("/v1/uploads", headers=key).headers["location"]


@pytest.mark.parametrize("headers, status, kind", [
    ({}, 422, "invalid"),
    ({"Upload-Length": "0"}, 422, "invalid"),
    ({"Upload-Length": "many"}, 422, "invalid"),
    ({"Upload-Defer-Length": "1"}, 422, "invalid"),
    ({"Upload-Length": "10", "Upload-Metadata": "title !"}, 422, "invalid"),
    ({"Upload-Length": "10", "Upload-Metadata": "\x7f"}, 422, "invalid"),
    ({"Upload-Length": "10", "Upload-Metadata": metadata(title="a" * 81)}, 422, "invalid"),
    ({"Upload-Length": "10", "Upload-Metadata": metadata(title="a\nb")}, 422, "invalid"),
    ({"Upload-Length": "10", "Upload-Metadata": metadata(title=b"\xff\xfe")}, 422, "invalid"),
    ({"Upload-Length": "10", "Upload-Metadata": metadata(filetype="application/zip")}, 415, "media-type"),
    ({"Upload-Length": str(9 * 2**30)}, 413, "upload-too-large"),
    ({"Upload-Length": "10", "Tus-Resumable": "0.2.2"}, 412, "tus-version"),
])
def test_an_invalid_upload_is_refused_before_the_first_byte(api, one, headers, status, kind):  # noqa: F811
    before = len(one.http.get("/v1/data-sets", params={"limit": 100}).json()["items"])
    problem(one.http.post("/v1/uploads", headers={**TUS, **headers}), status, kind)
    assert len(one.http.get("/v1/data-sets", params={"limit": 100}).json()["items"]) == before


def test_a_full_disk_is_reported_and_leaves_nothing_behind(stack_factory):
    """Uses a small file system if possible. Otherwise, a limit on the size of the server's files simulates it."""
    stack = stack_factory(only=("postgres", "redis", "api", "edge"), extra_env={"DIAPHANE_DISK_RESERVE_MB": "0"})
    folder = stack.data_dir / "uploads"
    small = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=20m,mode=0777", "tmpfs", folder], capture_output=True).returncode == 0
    try:
        anna = person(stack)
        data = os.urandom(2 * PART)
        first, second = anna.data_set(len(data)), anna.data_set(len(data))
        if small:
            problem(anna.announce(30_000_000), 507, "storage-full")    # before the first byte
        else:
            subprocess.run(["prlimit", "--pid", str(stack.pids["api"]), f"--fsize={PART + 1000}:"], check=True, **stack.stack.run_as.popen())
        assert anna.patch(first["upload_url"], 0, data[:PART]).status_code == 204
        if small:
            assert anna.patch(second["upload_url"], 0, data[:PART]).status_code == 204
        refused = anna.patch(first["upload_url"], PART, data[PART:])
        assert "kept" in problem(refused, 507, "storage-full")["detail"] and int(refused.headers["retry-after"]) > 0
        assert anna.offset(first["upload_url"]) == PART
        assert (folder / f"{first['data_set']['id']}.tar").stat().st_size == PART
        # After space is freed, it resumes. A cancelled upload leaves nothing behind.
        if small:
            assert anna.http.delete(second["upload_url"], headers=TUS).status_code == 204
            stack.wait_until(lambda: len(os.listdir(folder)) == 1, what="the disposal")
        else:
            subprocess.run(["prlimit", "--pid", str(stack.pids["api"]), "--fsize=unlimited:"], check=True, **stack.stack.run_as.popen())
        assert anna.patch(first["upload_url"], PART, data[PART:]).status_code == 204
        assert (folder / f"{first['data_set']['id']}.tar").read_bytes() == data
        assert anna.http.delete(f"/v1/data-sets/{first['data_set']['id']}").status_code == 204
        stack.wait_until(lambda: os.listdir(folder) == [] or not small, what="the disposal")
    finally:
        if small:
            subprocess.run(["umount", "--lazy", folder], check=True)


def test_a_terminated_upload_is_removed_from_disk(api, one):  # noqa: F811
    made = one.data_set(1000)
    one.patch(made["upload_url"], 0, b"a" * 400)
    file = api.data_dir / "uploads" / f"{made['data_set']['id']}.tar"
    assert file.exists()
    assert one.http.delete(made["upload_url"], headers=TUS).status_code == 204
    assert one.http.head(made["upload_url"], headers=TUS).status_code == 404
    problem(one.http.get(f"/v1/data-sets/{made['data_set']['id']}"), 404, "not-found")
    api.wait_until(lambda: not file.exists(), what="the file's disposal")


def test_an_abandoned_upload_expires(api, one):  # noqa: F811
    made = one.data_set(1000)
    data_set = made["data_set"]["id"]
    one.patch(made["upload_url"], 0, b"a" * 400)
    used = one.http.get("/v1/me").json()["quota"]["used_bytes"]
    api.psql("UPDATE uploads SET expires_at = now() - interval '1 second' WHERE id = %s", data_set)
    assert one.http.head(made["upload_url"], headers=TUS).status_code == 410
    problem(one.patch(made["upload_url"], 400, b"a"), 410, "upload-expired")
    api.wait_until(lambda: one.http.get(f"/v1/data-sets/{data_set}").json()["state"] == "expired", what="the sweep")
    file = api.data_dir / "uploads" / f"{data_set}.tar"
    api.wait_until(lambda: not file.exists(), what="the file's disposal")
    problem(one.patch(made["upload_url"], 400, b"a"), 410, "upload-expired")
    assert not file.exists()
    assert one.http.get("/v1/me").json()["quota"]["used_bytes"] == used - 1000
    assert one.http.delete(f"/v1/data-sets/{data_set}").status_code == 204


def test_an_upload_over_the_quota_is_refused_before_the_first_byte(api):  # noqa: F811
    poor = person(api)
    api.psql("UPDATE users SET quota_bytes = 5000 WHERE id = %s", poor.id)
    made = poor.data_set(3000)
    problem(poor.announce(3000), 413, "over-quota")
    assert poor.http.get("/v1/me").json()["quota"] == {"bytes": 5000, "used_bytes": 3000}
    assert poor.http.delete(f"/v1/data-sets/{made['data_set']['id']}").status_code == 204
    assert poor.announce(5000).status_code == 201
    problem(poor.announce(9 * 2**30), 413, "upload-too-large")


def test_concurrent_uploads_cannot_exceed_the_quota_together(api):  # noqa: F811
    from concurrent.futures import ThreadPoolExecutor

    import psycopg

    poor = person(api)
    api.psql("UPDATE users SET quota_bytes = 5000 WHERE id = %s", poor.id)
    with ThreadPoolExecutor(6) as pool, psycopg.connect(api.dsn) as holding:
        # All of them wait for the account here, and then run as simultaneously as possible.
        holding.execute("SELECT 1 FROM users WHERE id = %s FOR UPDATE", [poor.id])
        waiting = [pool.submit(poor.announce, 2000) for _ in range(6)]
        api.wait_until(lambda: api.psql("SELECT count(*) FROM pg_locks WHERE NOT granted")[0][0] >= 6, what="the queue")
        holding.commit()
        answers = sorted(answer.result().status_code for answer in waiting)
    assert answers == [201, 201] + [413] * 4


def test_the_same_idempotency_key_creates_one_data_set(api, one):  # noqa: F811
    key = {"Idempotency-Key": os.urandom(8).hex()}
    first, again = one.announce(1000, "once", **key), one.announce(1000, "once", **key)
    assert first.status_code == again.status_code == 201
    assert first.json()["data_set"]["id"] == again.json()["data_set"]["id"]
    problem(one.announce(1001, "once", **key), 422, "idempotency-key-reused")
    other = person(api)
    assert other.announce(1000, "once", **key).json()["data_set"]["id"] != first.json()["data_set"]["id"]


def test_paging_through_a_list_has_no_gaps_or_repeats(api):  # noqa: F811
    many = person(api)
    made = [many.data_set(10, f"number {i}")["data_set"]["id"] for i in range(7)]
    # Some with the same timestamp, which are ordered by id.
    api.psql("UPDATE data_sets SET created_at = date_trunc('hour', now()) WHERE id = ANY(%s::uuid[])", made[2:5])
    seen, cursor = [], None
    while True:
        page = many.http.get("/v1/data-sets", params={"limit": 2, **({"cursor": cursor} if cursor else {})}).json()
        assert len(page["items"]) <= 2
        seen += [item["id"] for item in page["items"] if item["owned"]]
        if (cursor := page["next_cursor"]) is None:
            break
    assert sorted(seen) == sorted(made)
    for bad in ({"limit": 0}, {"limit": 101}, {"limit": "x"}, {"cursor": "nonsense"}, {"surprise": "1"}):
        problem(many.http.get("/v1/data-sets", params=bad), 422, "invalid")


def test_objects_of_other_users_are_not_found_on_any_route(api, one):  # noqa: F811
    made = one.data_set(1000)
    url, data_set = made["upload_url"], f"/v1/data-sets/{made['data_set']['id']}"
    ready = one.upload(b"x" * 10)["id"]
    make_ready(api, ready)
    add_worker(api, "foreign-test")
    session = one.http.post("/v1/sessions", json={"data_set_id": ready}).json()["session_id"]
    other = person(api)
    answers: list[httpx.Response] = [
        other.http.get(data_set), other.http.delete(data_set), other.http.get(f"{data_set}/thumbnails/bone"),
        other.http.get(f"/v1/data-sets/{ready}/thumbnails/bone"), other.patch(url, 0, b"x"),
        other.http.delete(url, headers=TUS), other.http.post("/v1/sessions", json={"data_set_id": ready}),
        other.http.get(f"/v1/sessions/{session}"), other.http.delete(f"/v1/sessions/{session}"),
        other.http.post(f"/v1/sessions/{session}/tickets"),
    ]
    for answer in answers:
        problem(answer, 404, "not-found")
    assert other.http.head(url, headers=TUS).status_code == 404
    assert other.http.get("/v1/sessions").json()["items"] == []
    assert all(not item["owned"] for item in other.http.get("/v1/data-sets").json()["items"])
    # unchanged for its owner
    assert one.http.get(data_set).status_code == 200 and one.offset(url) == 0
    assert one.http.get(f"/v1/sessions/{session}").status_code == 200
    assert list((api.data_dir / "uploads").glob(f"{made['data_set']['id']}*")) == []
    remove_worker(api, "foreign-test")


def test_the_sample_is_uploaded_with_its_token_and_visible_to_everyone(api, one):  # noqa: F811
    token = api.sample_token_file.read_text(encoding="utf-8").strip()
    sampler = client(api)
    sampler.headers["Authorization"] = f"Bearer {token}"
    made = sampler.post("/v1/data-sets", json={"title": "Sample", "bytes": 100}).json()
    sample = made["data_set"]["id"]
    assert made["data_set"]["is_sample"] and made["data_set"]["owned"]
    problem(one.http.get(f"/v1/data-sets/{sample}"), 404, "not-found")   # not before it is ready
    answer = sampler.patch(made["upload_url"], content=b"x" * 100, headers={
        **TUS, "Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"})
    assert answer.status_code == 204
    make_ready(api, sample)
    seen = one.http.get(f"/v1/data-sets/{sample}").json()
    assert seen["is_public"] and seen["is_sample"] and not seen["owned"]
    assert sample in [item["id"] for item in one.http.get("/v1/data-sets", params={"limit": 100}).json()["items"]]
    problem(one.http.delete(f"/v1/data-sets/{sample}"), 403, "forbidden")
    assert sample in [item["id"] for item in sampler.get("/v1/data-sets").json()["items"]]
    sampler.headers["Authorization"] = "Bearer " + "0" * 64
    problem(sampler.post("/v1/data-sets", json={"bytes": 100}), 401, "unauthenticated")
    sampler.headers["Authorization"] = f"Bearer {token}"
    problem(sampler.post("/v1/sessions", json={"data_set_id": sample}), 401, "unauthenticated")
    assert sampler.delete(f"/v1/data-sets/{sample}").status_code == 204


def test_a_deleted_data_set_leaves_nothing_on_disk(api, one):  # noqa: F811
    made = one.upload(b"x" * 100)["id"]
    make_ready(api, made)
    volume, cached = api.data_dir / "volumes" / made, api.data_dir / "cache" / "thumbnails" / made
    for folder, name in ((volume, "volume.json"), (cached, "bone.jpg")):
        folder.mkdir(parents=True)
        (folder / name).write_bytes(b"x")
        for path in (folder / name, folder, folder.parent):
            api.stack.run_as.own(path)
    assert one.http.delete(f"/v1/data-sets/{made}").status_code == 204
    problem(one.http.get(f"/v1/data-sets/{made}"), 404, "not-found")
    upload = api.data_dir / "uploads" / f"{made}.tar"
    api.wait_until(lambda: not volume.exists() and not cached.exists() and not upload.exists(), what="the disposal")
    api.wait_until(lambda: api.psql("SELECT 1 FROM disposals WHERE id = %s", made) == [], what="the note's removal")
