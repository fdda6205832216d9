"""The stores and the API fail and recover, on a separate stack."""

from __future__ import annotations

import contextlib
import http.client
import os
import select
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import httpx
import psycopg
import pytest
from api_client import Person, add_worker, client, make_ready, person, problem


@pytest.fixture(scope="module")
def stack(all_stacks):
    opened = all_stacks.open(only=("postgres", "redis", "api", "edge"))
    yield opened
    all_stacks.shut(opened)


@pytest.fixture
def one(stack) -> Person:
    return person(stack)


def until_well(stack, ask) -> httpx.Response:
    """Returns the first response other than 502 or 503."""
    return stack.wait_until(lambda: a if (a := ask()).status_code < 500 else None, what="the recovery")


def test_an_outage_of_postgres_is_reported_and_recovered_from(stack, one):
    data = os.urandom(3000)
    made = one.data_set(len(data))
    assert one.patch(made["upload_url"], 0, data[:1000]).status_code == 204
    stack.stop("postgres")
    for answer in (one.http.get("/v1/me"), one.announce(1000), one.patch(made["upload_url"], 1000, data[1000:2000])):
        problem(answer, 503, "unavailable")
        assert int(answer.headers["retry-after"]) >= 1
    admin = httpx.get(f"http://127.0.0.1:{stack.ports['api-admin']}/readyz", timeout=60)
    assert admin.status_code == 503 and not admin.json()["checks"]["postgres"]
    stack.start("postgres")
    stack.wait_ready("postgres")
    # The next request succeeds, because dead connections are detected and replaced.
    assert one.http.get("/v1/me").status_code == 200
    assert one.offset(made["upload_url"]) == 1000
    assert one.patch(made["upload_url"], 1000, data[1000:]).status_code == 204
    assert (stack.data_dir / "uploads" / f"{made['data_set']['id']}.tar").read_bytes() == data


def test_a_killed_postgres_loses_nothing_acknowledged(stack, one):
    made = [one.data_set(100)["data_set"]["id"] for _ in range(5)]
    stack.kill("postgres")
    # The next Postgres starts when all processes of the last one have ended. Until then, these may still answer.
    stack.wait_ready("postgres")
    until_well(stack, lambda: one.http.get("/v1/me"))
    listed = [item["id"] for item in one.http.get("/v1/data-sets", params={"limit": 100}).json()["items"]]
    assert set(made) <= set(listed)


def test_without_redis_only_sessions_are_unavailable(stack, one):
    made = one.upload(b"x" * 100)["id"]
    make_ready(stack, made)
    stack.stop("redis")
    problem(one.http.post("/v1/sessions", json={"data_set_id": made}), 503, "unavailable")
    problem(one.http.get("/v1/sessions"), 503, "unavailable")
    assert one.http.get("/v1/me").status_code == 200
    assert one.data_set(100)
    # It is gone for its owner, although the sessions could not be ended.
    assert one.http.delete(f"/v1/data-sets/{made}").status_code == 204
    stack.start("redis")
    stack.wait_ready("redis")
    assert one.http.get("/v1/sessions").json() == {"items": []}


def test_a_restarted_api_has_everything_it_acknowledged(stack, one):
    data = os.urandom(3000)
    made = one.data_set(len(data))
    assert one.patch(made["upload_url"], 0, data[:1000]).status_code == 204
    stack.kill("api")
    until_well(stack, lambda: one.http.get("/v1/me"))
    assert one.offset(made["upload_url"]) == 1000
    assert one.patch(made["upload_url"], 1000, data[1000:]).status_code == 204
    assert one.http.get(f"/v1/data-sets/{made['data_set']['id']}").json()["state"] == "queued"


def test_a_mail_that_fails_is_sent_later(stack):
    one = Person(stack)
    folder = stack.data_dir / "mail"
    folder.chmod(0o500)
    stack.stack.run_as.own(folder)
    stack.psql("DELETE FROM attempts")
    try:
        assert one.http.post("/v1/accounts", json={"email": one.email, "consent": True}).status_code == 202
        stack.wait_until(lambda: stack.psql("SELECT 1 FROM mail_queue WHERE attempts > 0"), what="a failed attempt")
    finally:
        folder.chmod(0o700)
    stack.psql("UPDATE mail_queue SET not_before = now()")
    stack.wait_until(lambda: stack.mails(one.email), what="the mail")


@pytest.fixture
def api_back(stack):
    """Starts the API again, whatever the test asserted."""
    yield
    stack.start("api")
    stack.wait_ready("api")


def lock_waits(stack) -> int:
    return stack.psql("SELECT count(*) FROM pg_stat_activity WHERE wait_event_type = 'Lock'")[0][0]


def test_api_finishes_requests_in_flight_before_it_stops(stack, one, api_back):
    """SIGTERM while two requests wait for Postgres: both are answered, and later ones are refused."""
    with ThreadPoolExecutor(3) as pool, psycopg.connect(stack.dsn) as holder:
        # Only requests use this table. The API's background tasks would wait for that of the data sets, too, and be counted.
        holder.execute("LOCK TABLE environments")
        answers = [pool.submit(one.http.get, "/v1/environments") for _ in range(2)]
        stack.wait_until(lambda: lock_waits(stack) == 2, what="two requests that wait for the lock")
        stopping = pool.submit(stack.stop, "api")
        stack.wait_until(lambda: '"event":"draining"' in stack.log("api"), what="the start of draining")
        assert not stopping.done()
        holder.commit()
        assert [answer.result().status_code for answer in answers] == [200, 200]
        stopping.result()
    assert '"event":"stopped"' in stack.log("api")
    answer = client(stack).get("/v1/me")
    assert answer.status_code in (502, 503)
    problem(answer, answer.status_code, "unavailable")


def test_a_stopping_api_never_says_that_nothing_is_there(stack, api_back):
    """Connections that stay busy while SIGTERM takes effect: the library would answer 404 while it closes its listener."""
    statuses: set[int] = set()
    ending = threading.Event()

    def ask() -> None:
        while not ending.is_set():
            connection = http.client.HTTPConnection("127.0.0.1", stack.ports["api"], timeout=60)
            with contextlib.suppress(OSError, http.client.HTTPException), contextlib.closing(connection):
                while not ending.is_set():
                    connection.request("GET", "/v1/me")
                    answer = connection.getresponse()
                    answer.read()
                    statuses.add(answer.status)

    with ThreadPoolExecutor(12) as pool:
        asking = [pool.submit(ask) for _ in range(12)]
        for _ in range(3):
            stack.stop("api")
            stack.start("api")
            stack.wait_ready("api")
        ending.set()
        for one in asking:
            one.result()
    # 503 only if a request arrived between the signal and the end, which is soon when none is in progress.
    assert 401 in statuses and statuses <= {401, 503}, statuses


def test_one_address_gets_at_most_half_of_the_api_connections(stack, one):
    """While the API's answers wait for Postgres, requests from one address pile up."""
    request = (f"GET /v1/data-sets HTTP/1.1\r\nHost: localhost:{stack.ports['edge']}\r\n"
               f"Cookie: {'; '.join(f'{name}={value}' for name, value in one.http.cookies.items())}\r\n\r\n").encode()

    def connected() -> socket.socket:
        return socket.create_connection(("127.0.0.1", stack.ports["edge"]), timeout=30, source_address=("127.0.0.71", 0))

    with contextlib.ExitStack() as ended, psycopg.connect(stack.dsn) as holder:
        holder.execute("LOCK TABLE data_sets")
        # All requests together, because the API answers 503 to the first of them when they have waited for two seconds.
        connections = [ended.enter_context(connected()) for _ in range(128 + 10)]
        for connection in connections:
            connection.sendall(request)

        def answers() -> list[bytes]:
            answered = select.select(connections, [], [], 0)[0]
            return [connection.recv(12, socket.MSG_PEEK).split(b" ")[1] for connection in answered]

        stack.wait_until(lambda: answers().count(b"429") >= 10, what="ten refusals")
        counted = answers()
        assert counted.count(b"429") == 10 and set(counted) <= {b"429", b"503"}


def test_requests_beyond_capacity_are_refused_with_a_message(stack, one):
    """A flood of sign-ins is limited in memory and time, while an ordinary user is served."""
    def guess(i: int) -> int:
        return httpx.post(stack.url + "/v1/sign-in", timeout=30,
                          json={"email": f"flood{i}@example.org", "password": "some wrong password"}).status_code

    stack.psql("DELETE FROM attempts")
    with ThreadPoolExecutor(40) as pool:
        flood = [pool.submit(guess, i) for i in range(120)]
        slowest = 0.0
        for _ in range(10):
            began = time.monotonic()
            assert one.http.get("/v1/me").status_code in (200, 503)
            slowest = max(slowest, time.monotonic() - began)
        statuses = {f.result() for f in flood}
    assert statuses <= {401, 429, 503}
    assert slowest < 10
    stack.psql("DELETE FROM attempts")
    add_worker(stack, "after-flood")
    assert one.http.get("/v1/me").status_code == 200
