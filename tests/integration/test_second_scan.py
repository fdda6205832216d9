"""Alignments of two scans, and sessions that show one over the other."""

from __future__ import annotations

import json

import pytest
from api_client import add_worker, api, one, other, problem, remove_worker  # noqa: F401
from test_api_sharing import publish, ready, runs, share, unshare

IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
QUARTER = [0, -1, 0, 5, 1, 0, 0, -7, 0, 0, 1, 11, 0, 0, 0, 1]
QUARTER_BACK = [0, 1, 0, 7, -1, 0, 0, 5, 0, 0, 1, -11, 0, 0, 0, 1]


@pytest.fixture
def worker(api):  # noqa: F811
    add_worker(api, "second-scan-test", slots=64)
    yield
    remove_worker(api, "second-scan-test")


@pytest.fixture(autouse=True)
def no_alignments(api):  # noqa: F811
    """The tests share an account, whose unfinished alignments are limited."""
    api.psql("DELETE FROM alignments")


def path_of(first: str, second: str) -> str:
    return f"/v1/data-sets/{first}/alignments/{second}"


def in_one_frame(api, *data_sets: str) -> None:  # noqa: F811
    for data_set in data_sets:
        api.psql("UPDATE data_sets SET frame_of_reference = repeat('a', 64) WHERE id = %s", data_set)


def aligned(api, first: str, second: str) -> None:  # noqa: F811
    """Does what ingestd does in the end."""
    api.psql("UPDATE alignments SET state = 'ready', matrix = %s::double precision[], residual_mm = 1.25, overlap = 0.5 "
             "WHERE fixed = %s AND moving = %s", QUARTER, first, second)


def fused(who, first: str, second: str):
    return who.http.post("/v1/sessions", json={"data_set_id": first, "over": second})


def fused_session(who, first: str, second: str) -> str:
    answer = fused(who, first, second)
    assert answer.status_code == 201, answer.text
    return answer.json()["session_id"]


def test_scans_of_one_frame_of_reference_are_aligned_at_once(api, one, worker):  # noqa: F811
    first, second = ready(api, one), ready(api, one)
    assert one.http.get(path_of(first, second)).json()["state"] == "none"
    problem(fused(one, first, second), 409, "not-aligned")
    in_one_frame(api, first, second)
    answer = one.http.put(path_of(first, second))
    assert answer.status_code == 200 and answer.json()["frame_of_reference_shared"]
    assert answer.json()["matrix"] == IDENTITY and answer.json()["residual_mm"] is None
    assert api.psql("SELECT count(*) FROM alignments WHERE fixed = %s", first) == [(0,)]
    session = one.http.get(f"/v1/sessions/{fused_session(one, first, second)}").json()
    assert (session["data_set_id"], session["over"]) == (first, second)


def test_an_alignment_is_requested_once_and_holds_in_both_directions(api, one, worker):  # noqa: F811
    first, second = ready(api, one), ready(api, one)
    assert one.http.put(path_of(first, second)).status_code == 201
    again = one.http.put(path_of(second, first))
    assert again.status_code == 200 and again.json()["state"] == "waiting"
    assert api.psql("SELECT count(*) FROM alignments WHERE %s IN (fixed, moving)", first) == [(1,)]
    aligned(api, first, second)
    found = one.http.get(path_of(first, second)).json()
    assert found["state"] == "ready" and found["matrix"] == QUARTER and found["residual_mm"] == 1.25 and found["overlap"] == 0.5
    back = one.http.get(path_of(second, first)).json()["matrix"]
    assert back == pytest.approx(QUARTER_BACK)
    session = fused_session(one, first, second)
    motion = api.redis.hget(f"diaphane:session:{session}", "to_first")
    assert [float(number) for number in motion.split()] == QUARTER
    assert one.http.delete(path_of(second, first)).status_code == 204
    assert one.http.get(path_of(first, second)).json()["state"] == "none"
    assert runs(api, session), "the session keeps its motion"
    assert one.http.post(f"/v1/sessions/{session}/tickets").status_code == 201


def test_a_failed_alignment_says_why_and_can_start_again(api, one):  # noqa: F811
    first, second = ready(api, one), ready(api, one)
    one.http.put(path_of(first, second))
    api.psql("UPDATE alignments SET state = 'failed', reason = 'little_overlap' WHERE fixed = %s", first)
    found = one.http.get(path_of(first, second)).json()
    assert found["state"] == "failed" and found["reason"] == "little_overlap" and found["matrix"] is None
    assert one.http.put(path_of(second, first)).status_code == 201
    assert api.psql("SELECT state FROM alignments WHERE %s IN (fixed, moving)", first) == [("waiting",)]


def test_an_account_has_few_unfinished_alignments(api, one):  # noqa: F811
    first = ready(api, one)
    others = [ready(api, one) for _ in range(5)]
    for second in others[:4]:
        assert one.http.put(path_of(first, second)).status_code == 201
    problem(one.http.put(path_of(first, others[4])), 429, "too-many")
    api.psql("UPDATE alignments SET state = 'failed', reason = 'not_converged' WHERE moving = %s", others[0])
    assert one.http.put(path_of(first, others[4])).status_code == 201


def test_alignments_end_with_their_scans(api, one):  # noqa: F811
    first, second, third = ready(api, one), ready(api, one), ready(api, one)
    for pair in ((first, second), (third, first)):
        assert one.http.put(path_of(*pair)).status_code == 201
    api.psql("UPDATE data_sets SET state = 'queued' WHERE id = %s", second)    # as an order to cut it does
    assert api.psql("SELECT fixed::text FROM alignments WHERE %s IN (fixed, moving)", first) == [(third,)]
    assert one.http.delete(f"/v1/data-sets/{first}").status_code == 204
    assert api.psql("SELECT count(*) FROM alignments WHERE %s IN (fixed, moving)", first) == [(0,)]


def test_losing_either_scan_ends_a_session_on_both(api, one, other, worker):  # noqa: F811
    mine, theirs, gone = ready(api, other), ready(api, one), ready(api, one)
    share(one, theirs, other.email)
    # Scans of two accounts never share a frame of reference, so they are aligned. Either owner may ask for it.
    assert other.http.put(path_of(mine, theirs)).status_code == 201
    aligned(api, mine, theirs)
    session = fused_session(other, mine, theirs)
    assert api.redis.zscore(f"diaphane:data_set:{theirs}:sessions", session), "the second scan knows its session"
    unshare(one, theirs)
    assert not runs(api, session)
    problem(fused(other, mine, theirs), 404, "not-found")
    problem(other.http.get(path_of(mine, theirs)), 404, "not-found")
    in_one_frame(api, theirs, gone)
    session = fused_session(one, theirs, gone)
    assert one.http.delete(f"/v1/data-sets/{gone}").status_code == 204
    assert not runs(api, session)


def test_guests_join_a_session_on_two_scans_only_if_both_may_be_shown(api, one, other, worker):  # noqa: F811
    mine, theirs = ready(api, other), ready(api, one)
    share(one, theirs, other.email)
    other.http.put(path_of(mine, theirs))
    aligned(api, mine, theirs)
    session = fused_session(other, mine, theirs)
    problem(other.http.post(f"/v1/sessions/{session}/links"), 403, "forbidden")
    api.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", theirs)
    assert publish(one, theirs).status_code == 200
    unshare(one, theirs)    # everybody may invite to a public scan
    session = fused_session(other, mine, theirs)
    assert other.http.post(f"/v1/sessions/{session}/links").status_code == 201


def test_a_viewer_may_do_what_both_owners_allow(api, one, other, worker):  # noqa: F811
    mine, theirs = ready(api, other), ready(api, one)
    answer = one.http.post(f"/v1/data-sets/{theirs}/people",
                           json={"email": other.email, "may": "view", "slices": True, "downloads": False})
    assert answer.status_code == 204
    other.http.put(path_of(mine, theirs))
    aligned(api, mine, theirs)
    for first, second in ((mine, theirs), (theirs, mine)):
        ticket = fused(other, first, second).json()["stream_url"].removeprefix("/stream?ticket=")
        kept = api.redis.hgetall(f"diaphane:ticket:{ticket}")
        assert (kept["viewer"], kept["slices"], kept["downloads"]) == ("shared", "1", "0")


def test_both_owners_see_who_viewed_their_scan(api, one, other, worker):  # noqa: F811
    mine, theirs = ready(api, other), ready(api, one)
    share(one, theirs, other.email)
    other.http.put(path_of(mine, theirs))
    aligned(api, mine, theirs)
    fused_session(other, mine, theirs)
    assert [view["email"] for view in one.http.get(f"/v1/data-sets/{theirs}/views").json()["items"]] == [other.email]


def test_a_session_is_not_opened_on_one_scan_twice(api, one, worker):  # noqa: F811
    first = ready(api, one)
    answer = problem(fused(one, first, first), 422, "invalid")
    assert json.dumps(answer["errors"]).count("over") == 1
    problem(one.http.get(path_of(first, first)), 409, "conflict")
