"""Diaphane's messages, logs and actions when a store hangs, a commit is cut off, or two requests need the same row."""

from __future__ import annotations

import concurrent.futures
import contextlib
import dataclasses
import os
import signal
import socket
import threading
import time
import uuid
from pathlib import Path

import httpx
import psycopg
import pytest
from api_client import CONTRACT, PASSWORD, Person, add_worker, link_token, person, problem, ready_without_upload


#: Seconds after which api gives up a call to Postgres (postgres::Patience::answer).
ANSWER_LIMIT = 5


@pytest.fixture(scope="module")
def stack(all_stacks):
    opened = all_stacks.open(only=("postgres", "redis", "api", "edge"))
    yield opened
    all_stacks.shut(opened)


@pytest.fixture(scope="module")
def one(stack) -> Person:
    return person(stack)


def family(pid: int) -> list[int]:
    """Returns a process and its children."""
    children = [int(child) for task in Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()]
    return [pid, *children]


@contextlib.contextmanager
def frozen(stack, program: str):
    """Suspends all processes of a program, while the kernel still accepts data for them."""
    stopped: list[int] = []
    try:
        for _ in range(2):  # the second time for processes that were started in between
            for pid in family(stack.pids[program]):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGSTOP)
                    stopped.append(pid)
        yield
    finally:
        for pid in stopped:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)


@contextlib.contextmanager
def held(stack, statement: str, *values: object):
    """Yields an open transaction that has run the statement. The caller ends it."""
    with psycopg.connect(stack.dsn) as connection:
        connection.execute(statement, values)
        yield connection


def waiting(stack) -> int:
    """Returns how many connections of api wait for another transaction."""
    return stack.psql("SELECT count(*) FROM pg_stat_activity WHERE application_name = 'diaphane-api' AND wait_event_type = 'Lock'")[0][0]


def readiness(stack, program: str = "api") -> dict[str, bool]:
    """Returns the checks of /readyz. The time limit is generous, and a hanging store must not delay it."""
    return httpx.get(f"http://127.0.0.1:{stack.ports[f'{program}-admin']}/readyz", timeout=20).json()["checks"]


# Two simultaneous requests


def test_only_one_of_three_accounts_confirming_an_address_at_once_gets_it(stack):
    address = f"wanted-{uuid.uuid4().hex[:12]}@example.org"
    people, tokens = [], []
    for _ in range(3):
        who = person(stack)
        people.append(who)
        stack.psql("DELETE FROM attempts")
        assert who.shows_password("/v1/me/email", {"email": address, "password": PASSWORD}).status_code == 202
        stack.wait_until(lambda n=len(tokens): len([m for m in stack.mails(address)]) > n, what="the mail")
        tokens.append(link_token(stack, address, "confirm-email"))
    assert len(set(tokens)) == 3

    def confirm(who: Person, token: str) -> int:
        return who.http.post("/v1/email-change/confirm", json={"token": token}).status_code

    # Another user is about to take the address, so that all three wait for the same row, and then does not.
    row = "INSERT INTO users (id, email, email_key, password_hash, verified_at) VALUES (%s, %s, %s, 'x', now())"
    with held(stack, row, uuid.uuid4(), address, address) as other, concurrent.futures.ThreadPoolExecutor(3) as threads:
        answers = [threads.submit(confirm, who, token) for who, token in zip(people, tokens, strict=True)]
        stack.wait_until(lambda: waiting(stack) == 3, what="three that wait")
        other.rollback()
        assert sorted(answer.result() for answer in answers) == [204, 410, 410]
    for program in ("api", "postgres"):
        assert "wanted-" not in stack.log(program)
    assert stack.psql("SELECT count(*) FROM users WHERE email_key = %s", address) == [(1,)]


Asked = tuple[str, str, dict | None]
SCENE = CONTRACT.spec["components"]["schemas"]["Scene"]["example"]

#: Requests of an account while it is being deleted.
OF_AN_ACCOUNT: dict[str, Asked] = {
    "data set": ("POST", "/v1/data-sets", {"title": "", "bytes": 1000}),
    "export": ("POST", "/v1/me/export", None),
    "consent": ("POST", "/v1/recording-consent", None),
    "public name": ("PATCH", "/v1/me/public-name", {"public_name": "x"}),
    "second factor": ("POST", "/v1/me/second-factor", {"password": PASSWORD}),
    "new address": ("POST", "/v1/me/email", {"email": "new@example.org", "password": PASSWORD}),
    "new password": ("POST", "/v1/me/password", {"current": PASSWORD, "password": PASSWORD + " too"}),
    "preset": ("POST", "/v1/data-sets/{id}/presets", {"name": "x", "scene": SCENE}),
    "report": ("POST", "/v1/data-sets/{id}/reports", {"reason": "other", "words": ""}),
    "list": ("GET", "/v1/data-sets", None),
}
#: Requests of a data set's owner while it is being deleted.
OF_A_DATA_SET: dict[str, Asked] = {
    "description": ("PATCH", "/v1/data-sets/{id}", {"title": "x"}),
    "person": ("POST", "/v1/data-sets/{id}/people", {"email": "friend@example.org", "may": "view"}),
    "link": ("POST", "/v1/data-sets/{id}/links", {"hours": 1}),
    "preset": ("POST", "/v1/data-sets/{id}/presets", {"name": "x", "scene": SCENE}),
    "visibility": ("POST", "/v1/data-sets/{id}/visibility", {"visibility": "public"}),
    "deletion": ("DELETE", "/v1/data-sets/{id}", None),
}


def asked_meanwhile(stack, who: Person, asked: Asked, data_set: str, statement: str, *values: object) -> httpx.Response:
    """Returns the response to a request that waits for an earlier statement, which is committed meanwhile."""
    method, path, body = asked
    headers = {"X-CSRF-Token": who.csrf, "Idempotency-Key": uuid.uuid4().hex}
    with held(stack, statement, *values) as other, concurrent.futures.ThreadPoolExecutor(1) as thread:
        answer = thread.submit(who.http.request, method, path.format(id=data_set), json=body, headers=headers)
        stack.wait_until(lambda: answer.done() or waiting(stack) > 0, what="the request that waits, or its answer")
        other.commit()
        return answer.result()


def public_data_set(stack, owner: Person) -> str:
    data_set = ready_without_upload(stack, owner)
    stack.psql("UPDATE data_sets SET anonymised_at = now(), published_at = now(), visibility = 'public' WHERE id = %s", data_set)
    return data_set


def is_clear(answer: httpx.Response) -> bool:
    """Whether it is a success or a refusal, other than a refusal of the test's own request."""
    return answer.status_code < 500 and answer.status_code not in (400, 403, 405, 415, 422)


def test_requests_of_an_account_being_deleted_cause_no_internal_error(stack, one):
    data_set = public_data_set(stack, one)
    answers = {}
    for name, asked in OF_AN_ACCOUNT.items():
        who = person(stack)
        answers[name] = asked_meanwhile(stack, who, asked, data_set, "DELETE FROM users WHERE id = %s", who.id)
    assert {name: f"{a.status_code} {a.text}" for name, a in answers.items() if not is_clear(a)} == {}


def test_requests_during_a_deletion_cause_no_internal_error(stack, one):
    answers = {}
    for name, asked in OF_A_DATA_SET.items():
        data_set = public_data_set(stack, one)
        answers[name] = asked_meanwhile(stack, one, asked, data_set, "DELETE FROM data_sets WHERE id = %s", data_set)
    assert {name: f"{a.status_code} {a.text}" for name, a in answers.items() if not is_clear(a)} == {}


def test_publishing_a_scan_that_is_being_taken_down_is_refused(stack, one):
    data_set = ready_without_upload(stack, one)
    stack.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", data_set)
    answer = asked_meanwhile(stack, one, OF_A_DATA_SET["visibility"], data_set,
                             "UPDATE data_sets SET taken_down_at = now(), taken_down_reason = 'x' WHERE id = %s", data_set)
    assert answer.status_code in (403, 404, 409), answer.text


# Hanging stores


def test_requests_do_not_hang_on_a_frozen_postgres_and_its_connections_are_dropped(stack, one):
    assert one.http.get("/v1/me").status_code == 200
    before = stack.psql("SELECT now()")[0][0]
    with frozen(stack, "postgres"):
        assert readiness(stack)["postgres"] is False
        noticed = time.monotonic()
        with concurrent.futures.ThreadPoolExecutor(30) as threads:  # more than there are connections
            asked = [threads.submit(httpx.get, stack.url + "/v1/me", cookies=one.http.cookies, timeout=20) for _ in range(30)]
            for answer in asked:
                assert int(problem(answer.result(), 503, "unavailable")["status"]) and answer.result().headers["retry-after"]
        problem(one.announce(1000), 503, "unavailable")
        assert readiness(stack)["postgres"] is False
        # A background task may have begun a call just before the silence was noticed. If Postgres answers it within the limit,
        # its connection is not in doubt and is kept.
        time.sleep(max(noticed + ANSWER_LIMIT + 0.5 - time.monotonic(), 0))
    stack.wait_until(lambda: one.http.get("/v1/me").status_code == 200, what="the recovery")
    stack.wait_until(lambda: readiness(stack)["postgres"], what="a ready api")
    left = "SELECT count(*) FROM pg_stat_activity WHERE application_name = 'diaphane-api' AND backend_start < %s"
    stack.wait_until(lambda: stack.psql(left, before) == [(0,)], what="the end of the connections in doubt")


def test_requests_do_not_hang_on_a_frozen_redis(stack, one):
    data_set = ready_without_upload(stack, one)
    add_worker(stack, "frozen-test")
    with frozen(stack, "redis"):
        answer = one.http.post("/v1/sessions", json={"data_set_id": data_set}, timeout=20)
        problem(answer, 503, "unavailable")
        assert readiness(stack)["redis"] is False
        assert one.http.get("/v1/me", timeout=20).status_code == 200
    stack.wait_until(lambda: readiness(stack)["redis"], what="the recovery")


def test_ingestd_recovers_from_a_frozen_postgres(stack_factory):
    stack = stack_factory(only=("postgres", "redis", "api", "ingestd", "edge"))
    who = person(stack)
    with frozen(stack, "postgres"):
        stack.wait_until(lambda: readiness(stack, "ingestd")["postgres"] is False, what="the notice")
    # Also of api, which the person uses next.
    stack.wait_until(lambda: readiness(stack)["postgres"] and readiness(stack, "ingestd")["postgres"], what="the recovery")
    made = who.upload(b"x" * 100)["id"]
    stack.wait_until(lambda: who.http.get(f"/v1/data-sets/{made}").json()["state"] == "refused", what="the refusal of an invalid scan")


# Commits with an unknown outcome


class CutsCommits:
    """A proxy for Postgres that, while enabled, forwards a COMMIT and then closes both sides without its response."""

    COMMIT = b"Q" + (11).to_bytes(4, "big") + b"COMMIT\0"

    def __init__(self, port: int):
        self.to = port
        self.cutting = threading.Event()
        self.cut = 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self.listener.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client = self.listener.accept()[0]
                server = socket.create_connection(("127.0.0.1", self.to))
                threading.Thread(target=self._pass, args=(client, server, True), daemon=True).start()
                threading.Thread(target=self._pass, args=(server, client, False), daemon=True).start()

    def _pass(self, source: socket.socket, sink: socket.socket, of_client: bool) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if of_client and self.COMMIT in data and self.cutting.is_set():
                    self.cut += 1
                    # Postgres commits, but the response is lost.
                    source.shutdown(socket.SHUT_RDWR)
                    sink.sendall(data)
                    sink.shutdown(socket.SHUT_WR)
                    return
                sink.sendall(data)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def cutter(stack):
    """The stack's api, which reaches Postgres through this proxy during the test."""
    way = CutsCommits(stack.ports["postgres"])
    entry = stack.stack.running_["api"]
    program = entry.program
    detour = stack.dsn.replace(f":{stack.ports['postgres']}/", f":{way.port}/")
    stack.stop("api")
    entry.program = dataclasses.replace(program, env={**program.env, "DIAPHANE_POSTGRES": detour})
    stack.start("api")
    stack.wait_ready("api")
    yield way
    way.cutting.clear()
    stack.stop("api")
    entry.program = program
    stack.start("api")
    stack.wait_ready("api")
    way.close()


def test_a_commit_with_an_unknown_outcome_causes_no_internal_error(stack, one, cutter):
    assert one.http.get("/v1/me").status_code == 200
    cutter.cutting.set()
    for path in ("/v1/me", "/v1/data-sets", "/v1/gallery"):
        answer = one.http.get(path)
        if answer.status_code != 200:  # a read has no uncertain outcome
            problem(answer, 503, "unavailable")
            assert int(answer.headers["retry-after"]) >= 1
    cutter.cut = 0
    key = {"Idempotency-Key": uuid.uuid4().hex}
    answer = one.announce(1000, "in doubt", **key)
    assert cutter.cut > 0
    assert "may or may not" in problem(answer, 503, "outcome-unknown")["detail"]
    assert int(answer.headers["retry-after"]) >= 1
    cutter.cutting.clear()
    # It was created, and the same key creates no second one.
    made = one.announce(1000, "in doubt", **key)
    assert made.status_code in (200, 201)
    listed = [d["id"] for d in one.http.get("/v1/data-sets", params={"limit": 100}).json()["items"] if d["title"] == "in doubt"]
    assert listed == [made.json()["data_set"]["id"]]
