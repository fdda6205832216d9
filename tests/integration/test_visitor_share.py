"""Slots belong to users with accounts: visitors and guests can hold a share, which yields to them (common/visitor_share.h)."""

from __future__ import annotations

import secrets
from typing import Callable

import pytest
from api_client import client, forget_attempts, person, problem
from stream_helpers import PROGRAMS, ClientMessage, Viewer, open_session, store_ball
from test_live_sessions import Guest, link_of

SLOTS = 8
SHARE = 2  # a quarter


@pytest.fixture(scope="module")
def stack(all_stacks):
    stack = all_stacks.open(only=PROGRAMS, extra_env={"DIAPHANE_SLOTS": str(SLOTS), "DIAPHANE_THREADS": "1"})
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def owner(stack):
    return person(stack)


@pytest.fixture(scope="module")
def ball(stack, owner) -> str:
    return store_ball(stack, owner, 24)


@pytest.fixture
def sample(stack, owner, ball) -> str:
    stack.psql("UPDATE data_sets SET is_sample = true, visibility = 'public', anonymised_at = now(), published_at = now() WHERE id = %s", ball)
    yield ball
    stack.psql("UPDATE data_sets SET is_sample = false, visibility = 'private', published_at = NULL WHERE id = %s", ball)
    stack.psql("DELETE FROM visits")
    forget_attempts(stack)


def visit(stack, data_set: str):
    return client(stack).post("/v1/visits", json={"key": secrets.token_hex(32), "data_set_id": data_set})


def worker_counts(stack, **expected: int) -> bool:
    told = stack.redis.hmget("diaphane:worker:local", *expected)
    return [int(one or -1) for one in told] == list(expected.values())


def fill(stack, count: int) -> tuple[list[Viewer], Callable[[], None]]:
    """Opens this many sessions of another user with an account, each with a viewer. Also returns a function that ends them,
    because a worker keeps an abandoned session for half a minute."""
    somebody = person(stack)
    seen = store_ball(stack, somebody, 24)
    viewers, sessions = [], []
    for _ in range(count):
        session, url = open_session(somebody, seen)
        sessions.append(session)
        viewers.append(Viewer(stack.url, url, side=32))
        viewers[-1].frame()

    def end() -> None:
        for session in sessions:
            assert somebody.http.delete(f"/v1/sessions/{session}").status_code == 204

    return viewers, end


def test_guests_with_free_cameras_leave_slots_for_account_holders(stack, owner, ball):
    session, url = open_session(owner, ball)
    presenter = Viewer(stack.url, url, side=32)
    token = link_of(owner, session)
    guests, own, refused = [], 0, 0
    wish = ClientMessage()
    wish.free_camera.on = True
    for _ in range(SLOTS):
        guest = Guest(stack, token).join()
        guests.append(guest)
        guest.send(wish)
        while True:
            message = guest.receive()
            kind = message.WhichOneof("body")
            if kind == "config" and not message.config.follower:
                own += 1
                break
            if kind == "problem":
                assert message.problem.code == "too_many" and not message.problem.fatal
                refused += 1
                break
    assert (own, refused) == (SHARE, SLOTS - SHARE)
    stack.wait_until(lambda: worker_counts(stack, used=1 + SHARE, visitors=SHARE), what="what the worker tells")
    # Every user with an account finds a slot, finally those of the guests' cameras.
    others, end_others = fill(stack, SLOTS - 1)
    told = guests[0].until("problem", condition=lambda said: said.field == "own_camera_taken")
    assert not told.fatal
    guests[0].frame()  # the presenter's picture
    stack.wait_until(lambda: worker_counts(stack, used=SLOTS, visitors=0), what="slots of account holders alone")
    presenter.turn(3)
    for viewer in (*others, presenter, *guests):
        viewer.leave()
    owner.http.delete(f"/v1/sessions/{session}")
    end_others()
    stack.wait_until(lambda: worker_counts(stack, used=0), timeout=90, what="an empty worker")
    # The worker learns from the answer to its report that the sessions have ended.
    stack.wait_until(lambda: "\ndiaphane_renderd_sessions 0\n" in stack.metrics("renderd"), what="a worker that knows it")


def test_visitors_from_one_address_leave_slots_for_account_holders(stack, owner, sample):
    came = [visit(stack, sample) for _ in range(SLOTS)]
    assert [answer.status_code for answer in came] == [201] * SHARE + [503] * (SLOTS - SHARE)
    problem(came[-1], 503, "busy")
    visitors = [Viewer(stack.url, answer.json()["stream_url"], side=32) for answer in came[:SHARE]]
    for viewer in visitors:
        viewer.frame()
    stack.wait_until(lambda: worker_counts(stack, visitors=SHARE), what="what the worker tells")
    holders, _ = fill(stack, SLOTS)
    assert [viewer.close_code() for viewer in visitors] == [4411] * SHARE
    problem(visit(stack, sample), 503, "no-worker")
    for viewer in holders:
        seq = viewer.turn(3)
        viewer.frame(condition=lambda frame: frame.input_seq >= seq)
        viewer.leave()
