"""Shared fixtures of the stream's tests: a stack, a user, and a ball in the store."""

from __future__ import annotations

import pytest
from api_client import person
from stream_helpers import PROGRAMS, open_session, store_ball


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=PROGRAMS)
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def one(running):
    return person(running)


@pytest.fixture(scope="module")
def ball(running, one) -> str:
    return store_ball(running, one)


@pytest.fixture
def session(one, ball):
    """Yields a session and its first stream URL. Ended afterwards."""
    made = open_session(one, ball)
    yield made
    one.http.delete(f"/v1/sessions/{made[0]}")
