"""The edge under floods, slow and vanishing clients, with the real API behind it; meanwhile an ordinary client's answers stay right and
quick. Malformed requests: test_attacks_by_role.py."""

from __future__ import annotations

import os
import resource
import select
import socket
import struct
import time

import pytest
from api_client import person
from edge_help import Undisturbed, connect, family, requests_of, statuses, talk

#: How slow an ordinary answer may be at worst while the machine is under attack (2 cores, shared with the attackers).
P99_SECONDS = 0.5


@pytest.fixture(scope="module")
def edge(stack_house):
    stack = stack_house.open(only=("postgres", "redis", "api", "edge"))
    yield stack
    stack_house.shut(stack)


@pytest.fixture(scope="module")
def somebody(edge):
    return person(edge)


@pytest.fixture
def ordinary(edge, somebody, record_property):
    """Runs beside the test; afterwards the API is the same process, no larger, and every answer was right."""
    watched = Undisturbed(edge, somebody)
    one = watched.ordinary
    yield one
    assert watched.faults() == []
    print(f"ordinary client: {3 * len(one.seconds)} answers, p99 {one.p99() * 1000:.1f} ms; "
          f"api {watched.grown_mb:+.1f} MB, edge {watched.edge_mb:.1f} MB")
    record_property("ordinary_p99_ms", round(one.p99() * 1000, 1))
    assert one.p99() < P99_SECONDS


@pytest.fixture(scope="module", autouse=True)
def many_files():
    """As many descriptors as this process may have."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    yield hard
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def reset(one: socket.socket) -> None:
    """Closes with RST, as a client that vanishes."""
    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    one.close()


def sessions_listed(stack) -> float:
    """How often the API was asked for a list of sessions, which no test of this file does but by smuggling."""
    return requests_of(stack)["listSessions"]


def cut_at(length: int, start: bytes, byte: bytes) -> bytes:
    """A request whose first `length` bytes end where another one begins."""
    head = start + b"X-A: a" + byte + b"b\r\nX-P: "
    return head + b"p" * (length - len(head)) + b"GET /v1/sessions HTTP/1.1\r\nX: b\r\nConnection: close\r\n\r\n"


@pytest.mark.parametrize("byte", [b"\t", b"\xe4"], ids=["TAB", "non-ASCII"])
def test_headers_that_the_listener_cuts_smuggle_nothing_through_the_edge(edge, ordinary, byte):
    start = b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\n"
    before = sessions_listed(edge)
    # The weakness itself, behind the edge: such a byte cuts the headers at 512 bytes. One day it may be mended; then
    # this line goes.
    assert statuses(talk(edge.ports["api"], cut_at(512, start, byte))) == [401, 401]
    assert sessions_listed(edge) == before + 1
    for length in range(300, 560):  # the edge's own headers shift it
        assert statuses(talk(edge.ports["edge"], cut_at(length, start, byte))) == [401]
    assert sessions_listed(edge) == before + 1


def test_each_answer_of_the_edge_has_its_security_headers_and_says_what_is_wrong(edge):
    for request, status in ((b"GET //x HTTP/1.1", 400), (b"GET /v1/me?a[b]=1 HTTP/1.1", 400), (b"PUT /v1/me HTTP/1.1", 405), (b"GET /none.js HTTP/1.1", 404)):
        answer = talk(edge.ports["edge"], request + b"\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        assert statuses(answer) == [status]
        head, _, body = answer.partition(b"\r\n\r\n")
        assert b"application/problem+json" in head and b"urn:diaphane:problem:" in body
        for header in (b"X-Request-Id: ", b"Content-Security-Policy: default-src 'none'", b"X-Content-Type-Options: nosniff"):
            assert head.count(header) == 1
        assert b"nginx/" not in answer


@pytest.mark.parametrize(("line", "allowed"), [
    (b"TRACE /v1/me", [b"GET, HEAD, POST, PATCH, DELETE, OPTIONS"]), (b"PUT /scans", [b"GET, HEAD"]), (b"POST /", [b"GET, HEAD"]), (b"PUT /stream", [b"GET"]),
    (b"POST /v1/me", [b"GET, HEAD"]), (b"GET /none.js", [])])  # the last but one in the REST side's own words
def test_a_method_that_is_not_allowed_is_told_which_are(edge, line, allowed):
    answer = talk(edge.ports["edge"], line + b" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
    assert statuses(answer) == ([405] if allowed else [404])
    assert [one.partition(b": ")[2] for one in answer.split(b"\r\n") if one.startswith(b"Allow: ")] == allowed


def test_pipelined_requests_are_answered_in_order(edge, ordinary):
    paths = [f"/v1/data-sets/{i:08d}-0000-4000-8000-000000000000" for i in range(100)]
    requests = b"".join(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode() for path in paths)
    last = b"GET /none.js HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
    assert statuses(talk(edge.ports["edge"], requests + last)) == [401] * 100 + [404]


def test_clients_that_leave_at_every_stage_do_no_harm(edge, ordinary):
    body = b'{"email":"nobody@example.org","password":"wrong"}'
    request = (b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
               b"Content-Length: %d\r\n\r\n" % len(body)) + body
    for stage in range(0, len(request) + 1, 3):
        for leave in (reset, socket.socket.close):
            one = connect(edge.ports["edge"])
            one.sendall(request[:stage])
            leave(one)
    for _ in range(50):  # in the middle of an answer
        one = connect(edge.ports["edge"])
        one.sendall(b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\n\r\n" * 20)
        one.recv(10)
        reset(one)


def test_posts_of_headers_alone_do_not_stop_the_others(edge, ordinary):
    """45 of them hung the listener for good when they reached it (design: "The edge")."""
    head = (b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
            b"Content-Length: 100\r\n\r\n")
    waiting = [connect(edge.ports["edge"]) for _ in range(200)]
    for one in waiting:
        one.sendall(head)
    time.sleep(1.5)
    for one in waiting:
        reset(one)


def test_a_flood_from_one_address_is_limited_and_nobody_else_is(edge, ordinary):
    requests = b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\n\r\n" * 4000
    last = b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
    got = statuses(talk(edge.ports["edge"], requests + last, source="127.0.0.70", timeout=20))
    assert set(got) == {401, 429} and len(got) == 4001
    assert got[:1000] == [401] * 1000, "a hospital behind one address opens its pages at the same minute"


def test_parts_of_an_upload_are_not_mistaken_for_a_flood(edge, somebody):
    made = somebody.data_set(200 * 10_000)
    for number in range(200):
        answer = somebody.patch(made["upload_url"], number * 10_000, b"x" * 10_000)
        assert answer.status_code == 204, answer.text
    somebody.http.delete(f"/v1/data-sets/{made['data_set']['id']}")


def test_slow_and_idle_connections_are_borne_and_ended(edge, ordinary, many_files):
    """1,000 slow headers, 1,000 slow bodies and 10,000 that say nothing, all at once, from four addresses."""
    port = edge.ports["edge"]
    idle_count = min(10_000, many_files - 2_600)
    head = b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\n"
    post = (b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
            b"Content-Length: 1000\r\n\r\n")
    slow_heads = [connect(port, "127.0.0.67") for _ in range(1000)]
    slow_bodies = [connect(port, f"127.0.1.{number // 200}") for number in range(1000)]
    idle = [connect(port, "127.0.0.69") for _ in range(idle_count)]
    for one in slow_bodies:
        one.sendall(post)
    begun = time.monotonic()
    answered = len(ordinary.seconds)
    sent = 0
    while time.monotonic() - begun < 13:
        for group, text in ((slow_heads, head), (slow_bodies, b"x" * 1000)):
            for one in group:
                try:
                    one.send(text[sent % len(text):sent % len(text) + 1])
                except OSError:
                    pass  # ended by the edge
        sent += 1
        time.sleep(max(0.0, begun + sent - time.monotonic()))
    assert len(ordinary.seconds) > answered + 20, "the ordinary client was served meanwhile"
    # Headers that take longer than 10 s, and connections that say nothing for as long, are ended.
    for name, group in (("slow headers", slow_heads), ("idle", idle)):
        waiting = select.poll()
        for one in group:
            waiting.register(one, select.POLLIN | select.POLLHUP)
        deadline = time.monotonic() + 5
        while (ended := len(waiting.poll(100))) < len(group) and time.monotonic() < deadline:
            time.sleep(0.1)
        assert ended == len(group), f"{len(group) - ended} of {len(group)} {name} connections live on"
    # Slow bodies: those beyond the limit of one address were refused, the others cost the API nothing.
    for one in slow_heads + slow_bodies + idle:
        one.close()


def test_more_connections_than_there_are_descriptors(edge, ordinary, many_files):
    """The edge drops idle ones to serve those who speak; it never fails for good."""
    port = edge.ports["edge"]
    limit = min(int(open(f"/proc/{pid}/limits").read().split("Max open files")[1].split()[0])
                for pid in family(edge.pids["edge"])[1:])
    count = min(many_files - 600, limit, 19_000)
    idle = []
    for number in range(count):
        try:
            idle.append(connect(port, f"127.0.2.{number // 5000}", timeout=2))
        except OSError:
            break
    time.sleep(0.5)
    assert statuses(talk(port, b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")) == [401]
    for one in idle:
        one.close()
    assert os.path.exists(f"/proc/{edge.pids['edge']}")


def test_the_log_has_no_query(edge):
    word = b"5ecre7" * 10 + b"abcd"
    talk(edge.ports["edge"], b"GET /verify?token=" + word + b" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
         b"User-Agent: agent-" + word + b"\r\nReferer: http://x/" + word + b"\r\n\r\n")
    talk(edge.ports["edge"], b"GET /stream?ticket=" + word.replace(b"r", b"a") + b" HTTP/1.1\r\nHost: localhost\r\n"
         b"Upgrade: websocket\r\nConnection: close\r\n\r\n")
    edge.wait_until(lambda: '"path":"/verify"' in edge.log("edge"), what="the line in the log")
    assert "5ecre7" not in edge.log("edge")


@pytest.mark.parametrize("path", ["/", "/verify", "/scans", "/view/0d1f0c4e-0000-4000-8000-000000000000"])
def test_the_pages_own_addresses_are_the_page(edge, path):
    answer = talk(edge.ports["edge"], f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
    assert statuses(answer) == [200]
    assert b"Cache-Control: no-cache" in answer and b"<" in answer


def test_a_vanished_api_is_said_and_comes_back(edge):
    edge.stop("api")
    answer = talk(edge.ports["edge"], b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
    assert statuses(answer) == [502]
    assert b"Retry-After: 2" in answer and b"urn:diaphane:problem:unavailable" in answer
    edge.start("api")
    edge.wait_ready("api")
    assert statuses(talk(edge.ports["edge"],
                         b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")) == [401]
