"""The REST side of sessions and thumbnails, through the edge."""

from __future__ import annotations

import re
import socket
import uuid
from concurrent.futures import ThreadPoolExecutor

import pytest
from api_client import add_worker, api, make_ready, one, person, problem, remove_worker  # noqa: F401


@pytest.fixture(scope="module")
def ready(api, one) -> str:  # noqa: F811
    made = one.upload(b"x" * 100)["id"]
    make_ready(api, made)
    return made


@pytest.fixture
def worker(api):  # noqa: F811
    add_worker(api, "session-test")
    yield "session-test"
    remove_worker(api, "session-test")


def test_a_session_is_created_listed_and_ended(api, one, ready, worker):  # noqa: F811
    made = one.http.post("/v1/sessions", json={"data_set_id": ready})
    assert made.status_code == 201
    session = made.json()["session_id"]
    assert made.headers["location"] == f"/v1/sessions/{session}"
    assert re.fullmatch(r"/stream\?ticket=[0-9a-f]{64}", made.json()["stream_url"])
    again = one.http.post(f"/v1/sessions/{session}/tickets")
    assert again.status_code == 201 and again.json()["session_id"] == session
    assert again.json()["stream_url"] != made.json()["stream_url"]
    assert one.http.get("/v1/sessions").json()["items"] == [{"session_id": session, "data_set_id": ready, "over": None}]
    assert one.http.delete(f"/v1/sessions/{session}").status_code == 204
    problem(one.http.get(f"/v1/sessions/{session}"), 404, "not-found")
    problem(one.http.post(f"/v1/sessions/{session}/tickets"), 404, "not-found")


def test_the_same_idempotency_key_opens_one_session(api, one, ready, worker):  # noqa: F811
    key = {"Idempotency-Key": uuid.uuid4().hex}
    first = one.http.post("/v1/sessions", json={"data_set_id": ready}, headers=key).json()
    again = one.http.post("/v1/sessions", json={"data_set_id": ready}, headers=key).json()
    assert first["session_id"] == again["session_id"]
    second = one.upload(b"y" * 100)["id"]
    make_ready(api, second)
    problem(one.http.post("/v1/sessions", json={"data_set_id": second}, headers=key), 422, "idempotency-key-reused")
    one.http.delete(f"/v1/sessions/{first['session_id']}")


def test_without_a_worker_the_response_asks_to_retry(api, one, ready):  # noqa: F811
    for left_over in api.redis.smembers("diaphane:workers"):
        remove_worker(api, left_over)
    problem(one.http.post("/v1/sessions", json={"data_set_id": ready}), 503, "no-worker")
    problem(one.http.get(f"/v1/data-sets/{ready}/thumbnails/skin"), 503, "no-worker")


def test_a_slow_thumbnail_blocks_only_a_few_api_threads(api, one, ready, worker):  # noqa: F811
    """The worker never responds. 40 requests for one new picture once blocked all threads for as long as rendering took."""
    with socket.create_server(("127.0.0.1", 0)) as silent, ThreadPoolExecutor(40) as pool:
        api.redis.hset(f"diaphane:worker:{worker}", "address", f"127.0.0.1:{silent.getsockname()[1]}")
        asked = [pool.submit(one.http.get, f"/v1/data-sets/{ready}/thumbnails/skin") for _ in range(40)]
        # The call to a worker ends after 20 s.
        told = api.wait_until(lambda: done if len(done := [each for each in asked if each.done()]) == 37 else None, timeout=12,
                              what="all but three told to come again")
        assert one.http.get("/v1/me").status_code == 200
        for answer in [each.result() for each in told]:
            problem(answer, 503, "busy")
            assert answer.headers["retry-after"] == "1"
        silent.close()
    assert {each.result().status_code for each in asked} == {503}


def test_a_scan_that_is_not_ready_cannot_be_viewed(api, one, worker):  # noqa: F811
    made = one.data_set(100)["data_set"]["id"]
    problem(one.http.post("/v1/sessions", json={"data_set_id": made}), 409, "not-ready")
    problem(one.http.get(f"/v1/data-sets/{made}/thumbnails/skin"), 409, "not-ready")
    problem(one.http.post("/v1/sessions", json={"data_set_id": str(uuid.uuid4())}), 404, "not-found")
    problem(one.http.post("/v1/sessions", json={"data_set_id": "x"}), 404, "not-found")


def test_a_cached_thumbnail_comes_from_the_edge(api, one, ready):  # noqa: F811
    folder = api.data_dir / "cache" / "thumbnails" / ready
    folder.mkdir(parents=True)
    picture = b"\xff\xd8\xff" + bytes(2000)
    (folder / "bone.7.jpg").write_bytes(picture)
    for path in (folder / "bone.7.jpg", folder, folder.parent):
        api.stack.run_as.own(path)
    answer = one.http.get(f"/v1/data-sets/{ready}/thumbnails/bone")
    assert answer.status_code == 200 and answer.content == picture
    assert answer.headers["content-type"] == "image/jpeg"
    assert "private" in answer.headers["cache-control"]
    assert "x-accel-redirect" not in answer.headers
    problem(one.http.get(f"/v1/data-sets/{ready}/thumbnails/nothing"), 404, "not-found")


def test_deleting_a_data_set_ends_its_sessions(api, one, worker):  # noqa: F811
    made = one.upload(b"x" * 100)["id"]
    make_ready(api, made)
    session = one.http.post("/v1/sessions", json={"data_set_id": made}).json()["session_id"]
    assert one.http.delete(f"/v1/data-sets/{made}").status_code == 204
    problem(one.http.get(f"/v1/sessions/{session}"), 404, "not-found")
