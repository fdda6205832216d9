"""The edge under floods, with slow and vanishing clients and the real API. An ordinary client's responses must stay right and
fast. Malformed requests: test_attacks_by_role.py."""

from __future__ import annotations

import os
import resource
import select
import socket
import struct
import threading
import time

import httpx
import pytest
from api_client import person, problem
from edge_helpers import Undisturbed, connect, family, part_head, read_all, requests_of, signed, spooled, statuses, talk

#: Slowest acceptable response for an ordinary user during an attack (2 cores, shared with the attackers).
P99_SECONDS = 0.5


@pytest.fixture(scope="module")
def edge(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge"))
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def somebody(edge):
    return person(edge)


@pytest.fixture(scope="module")
def uploader(edge):
    """Another user with uploads, because `somebody` must have none to list."""
    return person(edge)


@pytest.fixture
def ordinary(edge, somebody, record_property):
    """Works during the test. Afterwards, the API is the same process, no larger, and every response was right."""
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
    """Raises the limit of this process on descriptors."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    yield hard
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def reset(one: socket.socket) -> None:
    """Closes with RST, like a client that vanishes."""
    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    one.close()


def sessions_listed(stack) -> float:
    """Returns how often sessions were listed, which tests of this file can only do by smuggling."""
    return requests_of(stack)["listSessions"]


def cut_at(length: int, start: bytes, byte: bytes) -> bytes:
    """Returns a request whose first `length` bytes end where another request begins."""
    head = start + b"X-A: a" + byte + b"b\r\nX-P: "
    return head + b"p" * (length - len(head)) + b"GET /v1/sessions HTTP/1.1\r\nX: b\r\nConnection: close\r\n\r\n"


@pytest.mark.parametrize("byte", [b"\t", b"\xe4"], ids=["TAB", "non-ASCII"])
def test_truncated_headers_smuggle_no_request_through_the_edge(edge, ordinary, byte):
    start = b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\n"
    before = sessions_listed(edge)
    # The vulnerability itself, behind the edge: such a byte cuts the headers at 512 bytes. Remove this line once it is fixed.
    assert statuses(talk(edge.ports["api"], cut_at(512, start, byte))) == [401, 401]
    assert sessions_listed(edge) == before + 1
    for length in range(300, 560):  # the edge's own headers shift it
        assert statuses(talk(edge.ports["edge"], cut_at(length, start, byte))) == [401]
    assert sessions_listed(edge) == before + 1


def test_edge_errors_have_security_headers_and_a_problem_document(edge):
    for request, status in ((b"GET //x HTTP/1.1", 400), (b"GET /v1/me?a[b]=1 HTTP/1.1", 400), (b"PUT /v1/me HTTP/1.1", 405), (b"GET /none.js HTTP/1.1", 404),
                            (b"POST /dicom-web/studies HTTP/1.1", 404)):    # without a gateway to archives
        answer = talk(edge.ports["edge"], request + b"\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        assert statuses(answer) == [status]
        head, _, body = answer.partition(b"\r\n\r\n")
        assert b"application/problem+json" in head and b"urn:diaphane:problem:" in body
        for header in (b"X-Request-Id: ", b"Content-Security-Policy: default-src 'none'", b"X-Content-Type-Options: nosniff"):
            assert head.count(header) == 1
        assert b"nginx/" not in answer


@pytest.mark.parametrize(("line", "allowed"), [
    (b"TRACE /v1/me", [b"GET, HEAD, POST, PUT, PATCH, DELETE, OPTIONS"]), (b"PUT /scans", [b"GET, HEAD"]), (b"POST /", [b"GET, HEAD"]), (b"PUT /stream", [b"GET"]),
    (b"POST /v1/me", [b"GET, HEAD"]), (b"GET /none.js", [])])  # the last but one is the REST side's message
def test_a_405_lists_the_allowed_methods(edge, line, allowed):
    answer = talk(edge.ports["edge"], line + b" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
    assert statuses(answer) == ([405] if allowed else [404])
    assert [one.partition(b": ")[2] for one in answer.split(b"\r\n") if one.startswith(b"Allow: ")] == allowed


def test_pipelined_requests_are_answered_in_order(edge, ordinary):
    paths = [f"/v1/data-sets/{i:08d}-0000-4000-8000-000000000000" for i in range(100)]
    requests = b"".join(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode() for path in paths)
    last = b"GET /none.js HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
    assert statuses(talk(edge.ports["edge"], requests + last)) == [401] * 100 + [404]


def test_disconnecting_at_any_stage_does_no_harm(edge, ordinary):
    body = b'{"email":"nobody@example.org","password":"wrong"}'
    request = (b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
               b"Content-Length: %d\r\n\r\n" % len(body)) + body
    for stage in range(0, len(request) + 1, 3):
        for leave in (reset, socket.socket.close):
            one = connect(edge.ports["edge"])
            one.sendall(request[:stage])
            leave(one)
    for _ in range(50):  # during a response
        one = connect(edge.ports["edge"])
        one.sendall(b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\n\r\n" * 20)
        one.recv(10)
        reset(one)


def test_requests_without_their_bodies_do_not_stop_others(edge, ordinary):
    """45 of them hung the listener permanently when they reached it (design: "The edge")."""
    head = (b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
            b"Content-Length: 100\r\n\r\n")
    waiting = [connect(edge.ports["edge"]) for _ in range(200)]
    for one in waiting:
        one.sendall(head)
    time.sleep(1.5)
    for one in waiting:
        reset(one)


def test_a_flood_from_one_address_limits_only_that_address(edge, ordinary):
    requests = b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\n\r\n" * 1000
    # The edge answers these itself, so that they exceed the limit of 300 in a second however slow the API is on a busy machine.
    flood = b"GET /none.js HTTP/1.1\r\nHost: localhost\r\n\r\n" * 4000
    last = b"GET /none.js HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
    with connect(edge.ports["edge"], "127.0.0.70") as one:
        sending = threading.Thread(target=one.sendall, args=(requests + flood + last,))
        sending.start()
        got = statuses(read_all(one))
        sending.join()
    assert len(got) == 5001 and set(got[1000:]) == {404, 429}
    assert got[:1000] == [401] * 1000, "a hospital behind one address opens its pages at the same minute"


def test_parts_of_an_upload_do_not_count_as_a_flood(edge, somebody):
    made = somebody.data_set(200 * 10_000)
    for number in range(200):
        answer = somebody.patch(made["upload_url"], number * 10_000, b"x" * 10_000)
        assert answer.status_code == 204, answer.text
    somebody.http.delete(f"/v1/data-sets/{made['data_set']['id']}")


def all_ended(group: list[socket.socket], seconds: float) -> int:
    """Waits until the edge has ended all of them. Returns their number."""
    waiting = select.poll()
    for one in group:
        waiting.register(one, select.POLLIN | select.POLLHUP)
    deadline = time.monotonic() + seconds
    while (ended := len(waiting.poll(100))) < len(group) and time.monotonic() < deadline:
        time.sleep(0.1)
    return ended


def drip(group: list[socket.socket]) -> None:
    """Sends another byte on each."""
    for one in group:
        try:
            one.send(b"x")
        except OSError:
            pass  # ended by the edge


PART = 8 * 1024 * 1024


@pytest.mark.parametrize("cookie", [(), ("Cookie: diaphane=" + "5" * 64, "X-CSRF-Token: " + "5" * 64)], ids=["no cookie", "a forged one"])
def test_unauthenticated_uploads_are_not_written_to_disk(edge, uploader, ordinary, cookie):
    """205 parts of 8 MB less 300 bytes from one address once filled 1.5 GB of a disk, because they were stored until their last
    byte arrived."""
    url = uploader.data_set(PART)["upload_url"]
    sent = bytes(256 * 1024)
    waiting, most = [], 0
    for _ in range(205):
        one = connect(edge.ports["edge"], "127.0.0.72")
        waiting.append(one)
        try:
            one.sendall(part_head(url, PART - 300, *cookie) + sent)
        except OSError:
            pass  # refused while still sending
        most = max(most, spooled(edge))
    assert max(most, spooled(edge)) == 0
    for one in waiting[:20]:
        assert statuses(one.recv(65536)) == [401]
    for one in waiting:
        one.close()
    uploader.http.delete(url.replace("uploads", "data-sets"))


def test_unauthenticated_bodies_are_limited_per_address_and_in_total(edge, uploader):
    head = b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 100\r\n\r\n"
    waiting = []

    def send(number: int, source: str) -> None:
        for _ in range(number):
            waiting.append(connect(edge.ports["edge"], source))
            waiting[-1].sendall(head)

    def refused() -> list[int]:
        poll = select.poll()
        found = {one.fileno(): one for one in waiting}
        for one in waiting:
            poll.register(one, select.POLLIN)
        return sorted(int(found[fd].recv(12, socket.MSG_PEEK)[9:]) for fd, _ in poll.poll(0))

    send(40, "127.0.4.1")
    edge.wait_until(lambda: refused() == [429] * 8, what="those beyond 32 of one address refused")
    for number in range(2, 10):
        send(32, f"127.0.4.{number}")
    edge.wait_until(lambda: refused() == [429] * 8 + [503] * 32, what="those beyond 256 in all refused")
    assert uploader.announce(1000).status_code == 201, "with a session a body is accepted"
    for one in waiting:
        one.close()
    edge.wait_until(lambda: statuses(talk(edge.ports["edge"], head + b" " * 100, source="127.0.4.1", silence_s=1)) not in ([], [429]), what="the places given back")


def test_a_part_for_the_upload_of_another_user_is_not_read(edge, uploader):
    url, other = uploader.data_set(PART)["upload_url"], person(edge)
    with connect(edge.ports["edge"], "127.0.0.73") as one:
        one.sendall(part_head(url, PART, *signed(other)) + bytes(100_000))
        assert statuses(one.recv(65536)) == [404]
    for length, offset, status in ((PART - 1, 1, 409), (PART, 0, None)):
        with connect(edge.ports["edge"], "127.0.0.73") as one:
            one.sendall(part_head(url, length, *signed(uploader), offset=offset) + bytes(100_000))
            if status is None:
                edge.wait_until(lambda: spooled(edge) > 0, what="the owner's part on its way")
            else:
                assert statuses(one.recv(65536)) == [status]
    edge.wait_until(lambda: spooled(edge) == 0, what="nothing of a part that broke off")
    uploader.http.delete(url.replace("uploads", "data-sets"))


def test_a_large_unauthenticated_body_is_refused_unread(edge):
    """On routes without authentication."""
    for length, status in ((16 * 1024 + 1, 413), (1 << 20, 413)):
        head = b"POST /v1/sign-in HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: %d\r\n\r\n" % length
        with connect(edge.ports["edge"]) as one:
            one.sendall(head)
            assert statuses(one.recv(65536)) == [status]
    assert spooled(edge) == 0


def test_a_body_without_a_length_is_refused(edge, uploader):
    head = "\r\n".join(("POST /v1/data-sets HTTP/1.1", "Host: localhost", "Content-Type: application/json", *signed(uploader),
                        "Transfer-Encoding: chunked", "Connection: close", "", "")).encode()
    assert statuses(talk(edge.ports["edge"], head + b"f\r\n" + b'{"bytes": 1000}' + b"\r\n0\r\n\r\n")) == [411]


def test_the_edges_internal_urls_are_unreachable_from_outside(edge):
    for path in (b"/_body_gate", b"/edge/body", b"/v1/../edge/body"):
        answer = talk(edge.ports["edge"], b"GET " + path + b" HTTP/1.1\r\nHost: localhost\r\nX-Original-Method: POST\r\n"
                      b"X-Original-Target: /v1/sign-in\r\nX-Original-Length: 5\r\nConnection: close\r\n\r\n")
        assert statuses(answer) != [204] and b"X-Account" not in answer


def test_an_account_uploads_at_most_four_parts_at_once(edge, uploader):
    url, other = uploader.data_set(PART)["upload_url"], person(edge)
    waiting = []
    for number in range(7):
        one = connect(edge.ports["edge"], f"127.0.3.{number + 1}")
        one.sendall(part_head(url, PART, *signed(uploader)) + bytes(100_000))
        waiting.append(one)
    refused = edge.wait_until(lambda: found if len(found := select.select(waiting, [], [], 0)[0]) == 3 else None, what="three refusals")
    assert [statuses(one.recv(65536)) for one in refused] == [[429]] * 3
    assert other.patch(other.data_set(1000)["upload_url"], 0, b"x" * 1000).status_code == 204, "another person's part goes through"
    assert uploader.announce(1000).status_code == 201, "and a body that is not a part"
    for one in waiting:
        one.close()
    edge.wait_until(lambda: uploader.patch(url, 0, bytes(100)).status_code == 204, what="the places given back")
    uploader.http.delete(url.replace("uploads", "data-sets"))


def test_a_body_without_disk_space_is_refused_temporarily(edge, uploader):
    """As with a full disk, for which nginx itself would return 500, which suggests a permanent fault."""
    made = uploader.data_set(200_000)
    folder = edge.data_dir / "run" / "edge-body"
    kept = folder.rename(folder.with_name("kept"))
    folder.write_bytes(b"")
    try:
        refused = uploader.patch(made["upload_url"], 0, bytes(200_000))
        assert problem(refused, 503, "unavailable") and int(refused.headers["retry-after"]) > 0
    finally:
        folder.unlink()
        kept.rename(folder)
    assert uploader.patch(made["upload_url"], 0, bytes(200_000)).status_code == 204
    uploader.http.delete(f"/v1/data-sets/{made['data_set']['id']}")


def test_slow_bodies_time_out_while_others_of_the_address_are_served(edge, uploader):
    """512 bodies at a byte per second, each endless, once blocked the service for all users behind the same address."""
    source, post = "127.0.0.74", b"POST %s HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n%s\r\n"
    mine = "".join(f"{line}\r\n" for line in signed(uploader)).encode()
    slow = [connect(edge.ports["edge"], source) for _ in range(512)]
    for one in slow[:500]:
        one.sendall(post % (b"/v1/sign-in", b""))
    for one in slow[500:]:
        one.sendall(post % (b"/v1/data-sets", mine))
    watched = Undisturbed(edge, person(edge), source)
    beside = person(edge)
    beside.http = httpx.Client(base_url=edge.url, timeout=30, headers=beside.http.headers, cookies=beside.http.cookies,
                               transport=httpx.HTTPTransport(local_address=source))
    uploads, begun = 0, time.monotonic()
    while all_ended(slow, 0) < len(slow) and time.monotonic() < begun + 60:
        drip(slow)
        made = beside.data_set(100_000)
        assert beside.patch(made["upload_url"], 0, bytes(100_000)).status_code == 204
        uploads += 1
        time.sleep(1)
    assert watched.faults() == []
    assert all_ended(slow, 0) == len(slow), "a body that comes too slowly is ended"
    assert uploads > 1
    for one in slow:
        one.close()


@pytest.mark.nightly
def test_slow_and_idle_connections_time_out(edge, ordinary, many_files):
    """1,000 slow headers, 1,000 slow bodies and 10,000 silent connections at the same time, from four addresses."""
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
        for one in slow_heads:
            try:
                one.send(head[sent % len(head):sent % len(head) + 1])
            except OSError:
                pass  # ended by the edge
        drip(slow_bodies)
        sent += 1
        time.sleep(max(0.0, begun + sent - time.monotonic()))
    assert len(ordinary.seconds) > answered + 20, "the ordinary client was served meanwhile"
    # Headers and bodies that take longer than 10 s, and connections that are silent for this long, are ended.
    for name, group in (("slow headers", slow_heads), ("slow bodies", slow_bodies), ("idle", idle)):
        ended = all_ended(group, 5)
        assert ended == len(group), f"{len(group) - ended} of {len(group)} {name} connections live on"
    for one in slow_heads + slow_bodies + idle:
        one.close()


def test_the_edge_survives_more_connections_than_descriptors(edge, ordinary, many_files):
    """The edge drops idle connections to serve active ones, and never fails permanently."""
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


def test_query_strings_are_not_logged(edge):
    word = b"5ecre7" * 10 + b"abcd"
    talk(edge.ports["edge"], b"GET /verify?token=" + word + b" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
         b"User-Agent: agent-" + word + b"\r\nReferer: http://x/" + word + b"\r\n\r\n")
    talk(edge.ports["edge"], b"GET /stream?ticket=" + word.replace(b"r", b"a") + b" HTTP/1.1\r\nHost: localhost\r\n"
         b"Upgrade: websocket\r\nConnection: close\r\n\r\n")
    edge.wait_until(lambda: '"path":"/verify"' in edge.log("edge"), what="the line in the log")
    assert "5ecre7" not in edge.log("edge")


@pytest.mark.parametrize("path", ["/", "/verify", "/scans", "/view/0d1f0c4e-0000-4000-8000-000000000000"])
def test_urls_of_views_serve_the_page(edge, path):
    answer = talk(edge.ports["edge"], f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
    assert statuses(answer) == [200]
    assert b"Cache-Control: no-cache" in answer and b"<" in answer


def test_the_edge_reports_an_outage_of_the_api_and_recovers(edge):
    edge.stop("api")
    answer = talk(edge.ports["edge"], b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
    assert statuses(answer) == [502]
    assert b"Retry-After: 2" in answer and b"urn:diaphane:problem:unavailable" in answer
    edge.start("api")
    edge.wait_ready("api")
    assert statuses(talk(edge.ports["edge"],
                         b"GET /v1/me HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")) == [401]
