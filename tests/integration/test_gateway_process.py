"""The gateway is a separate process: faults of the REST API end no stream, and the other way round."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import pytest
from api_client import person
from stream_helpers import PROGRAMS, Viewer, open_session, store_ball, wait_ticket
from test_gateway_stream import back_again

VIEWERS = 4


@pytest.fixture(scope="module")
def stack(all_stacks):
    opened = all_stacks.open(only=PROGRAMS)
    yield opened
    all_stacks.shut(opened)


class Watcher(threading.Thread):
    """Rotates the picture continuously. A picture must answer each rotation over the original connection."""

    def __init__(self, viewer: Viewer):
        super().__init__(daemon=True)
        self.viewer = viewer
        self.turns = 0
        self.fault: Exception | None = None
        self.stopping = threading.Event()

    def run(self) -> None:
        try:
            while not self.stopping.is_set():
                seq = self.viewer.turn(2)
                self.viewer.frame(condition=lambda shown: shown.input_seq >= seq)
                self.turns += 1
        except Exception as fault:  # noqa: BLE001 - whatever ended the stream is the finding
            self.fault = fault

    def finish(self) -> None:
        self.stopping.set()
        self.join(90)
        assert self.fault is None, f"a stream was interrupted: {self.fault!r}"


@pytest.fixture
def watched(stack):
    """Streams of several users that run throughout. Afterwards, none was interrupted, also according to the gateway's metrics."""
    def closes() -> str:
        return "\n".join(line for line in stack.metrics("gateway").splitlines() if line.startswith("diaphane_stream_closes_total"))

    people = [person(stack) for _ in range(2)]
    balls = [store_ball(stack, one, 24) for one in people]
    sessions = [(people[i % 2], *open_session(people[i % 2], balls[i % 2])) for i in range(VIEWERS)]
    viewers = [Viewer(stack.url, url, side=32) for _, _, url in sessions]
    for viewer in viewers:
        viewer.frame()
    # Streams of earlier tests may still be ending, and be counted then.
    stack.wait_until(lambda: f"diaphane_stream_attached {VIEWERS}" in stack.metrics("gateway").splitlines(), what="the end of earlier streams")
    before = closes()
    watchers = [Watcher(viewer) for viewer in viewers]
    for watcher in watchers:
        watcher.start()

    def go_on() -> None:
        """Waits until each stream has shown three more rotations."""
        marks = [watcher.turns + 3 for watcher in watchers]
        stack.wait_until(lambda: all(w.fault or w.turns >= mark for w, mark in zip(watchers, marks)), 60, "pictures after the fault")
        assert [w.fault for w in watchers if w.fault] == []

    go_on()
    yield go_on
    for watcher in watchers:
        watcher.finish()
    assert closes() == before, "the gateway closed a stream"
    for viewer, (somebody, session, _) in zip(viewers, sessions):
        viewer.leave()
        somebody.http.delete(f"/v1/sessions/{session}")


def test_killing_the_rest_api_interrupts_no_stream(stack, watched):
    stack.kill("api", restart=False)
    watched()
    assert httpx.get(stack.url + "/v1/me", timeout=60).status_code == 502, "the REST API is gone meanwhile"
    stack.start("api")
    stack.wait_ready("api")
    watched()


def test_restarting_the_rest_api_under_load_interrupts_no_stream(stack, watched):
    somebody = person(stack)
    ending = threading.Event()

    def load() -> set[int]:
        statuses = set()
        with httpx.Client(base_url=stack.url, cookies=somebody.http.cookies, timeout=30) as http:
            while not ending.wait(0.02):    # four of these stay below the rate that the edge grants to one address
                statuses.add(http.get("/v1/data-sets").status_code)
        return statuses

    with ThreadPoolExecutor(4) as pool:
        loads = [pool.submit(load) for _ in range(4)]
        for _ in range(2):
            stack.stop("api")
            watched()
            stack.start("api")
            stack.wait_ready("api")
            watched()
        ending.set()
        statuses = set().union(*(one.result(60) for one in loads))
    # Requests in progress are answered. Requests while nothing listens are told to retry.
    assert 200 in statuses and statuses <= {200, 502, 503}, statuses


def test_killing_the_gateway_fails_no_rest_request_and_viewers_reconnect(stack):
    somebody = person(stack)
    session, url = open_session(somebody, store_ball(stack, somebody, 24))
    viewer = Viewer(stack.url, url)
    seq = viewer.turn(33)
    viewer.frame(condition=lambda shown: shown.input_seq >= seq)
    api = stack.pids["api"]
    stack.kill("gateway")
    statuses = []
    until = time.monotonic() + 1
    while time.monotonic() < until:
        statuses.append(somebody.http.get("/v1/me").status_code)
    assert set(statuses) == {200}
    assert viewer.close_code() not in (1000, 4404), "the session is not over"
    again = back_again(stack, somebody, session)
    assert again.config.scene == viewer.config.scene and again.config.input_seq == seq
    again.leave()
    assert stack.pids["api"] == api


def test_the_gateway_needs_neither_the_database_nor_the_api(stack):
    """It has no secrets of theirs, and tickets are redeemed while they are unavailable."""
    environment = Path(f"/proc/{stack.pids['gateway']}/environ").read_bytes()
    assert b"POSTGRES" not in environment and b"FACTOR_KEY" not in environment
    somebody = person(stack)
    session, _ = open_session(somebody, store_ball(stack, somebody, 24))
    url = wait_ticket(somebody, session)
    stack.stop("api")
    stack.stop("postgres")
    try:
        viewer = Viewer(stack.url, url)
        viewer.frame()
        viewer.leave()
    finally:
        stack.start("postgres")
        stack.wait_ready("postgres")
        stack.start("api")
        stack.wait_ready("api")
