"""The REST listener without the edge in front of it: what it must withstand although the edge blocks most of it. On a separate
stack, because some tests leave connections behind."""

from __future__ import annotations

import contextlib
import socket
import time

import httpx
import pytest


@pytest.fixture(scope="module")
def stack(all_stacks):
    opened = all_stacks.open(only=("postgres", "redis", "api"))
    yield opened
    all_stacks.shut(opened)


def connect(stack) -> socket.socket:
    return socket.create_connection(("127.0.0.1", stack.ports["api"]), timeout=60)


def exchange(stack, raw: bytes) -> bytes:
    """Returns all responses until the listener closes or is silent for five seconds after one."""
    with connect(stack) as peer:
        peer.sendall(raw.replace(b"Host: x\r\n", b"Host: x\r\nConnection: close\r\n"))
        answer = b""
        with contextlib.suppress(TimeoutError, ConnectionResetError):
            while some := peer.recv(65536):
                answer += some
                peer.settimeout(5)
        return answer


def status(answer: bytes) -> int:
    return int(answer.split(b" ", 2)[1])


def still_serves(stack) -> None:
    # If it were blocked, this request would wait until the other peers leave.
    assert httpx.get(f"http://127.0.0.1:{stack.ports['api']}/v1/me", timeout=60).status_code == 401


def cpu_seconds(stack) -> float:
    with open(f"/proc/{stack.pids['api']}/stat", encoding="ascii") as file:
        fields = file.read().rsplit(") ", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100


def test_the_api_listens_only_on_loopback(stack):
    port = f":{stack.ports['api']:04X}"
    with open("/proc/net/tcp", encoding="ascii") as file:
        listening = [line.split()[1] for line in file.readlines()[1:] if line.split()[3] == "0A"]
    assert [a for a in listening if a.endswith(port)] == ["0100007F" + port]


def test_requests_without_their_body_do_not_block_others(stack):
    with contextlib.ExitStack() as open_ones:
        for _ in range(100):
            peer = open_ones.enter_context(connect(stack))
            peer.sendall(b"POST /v1/sign-in HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                         b"Content-Length: 1000\r\n\r\n{")
        for _ in range(5):
            still_serves(stack)
    still_serves(stack)


def send_until_answered(peer: socket.socket, head: bytes) -> bytes:
    """Continues the body, because the library only checks for a response when more of the body arrives."""
    peer.sendall(head)
    peer.setblocking(False)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        with contextlib.suppress(BlockingIOError, ConnectionError):
            peer.send(b"x" * 65536)
        with contextlib.suppress(BlockingIOError):
            return peer.recv(65536)
        time.sleep(0.001)
    raise AssertionError("no answer")


def test_a_refused_body_closes_its_connection_and_no_thread_spins(stack):
    head = b"POST /v1/sign-in HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nContent-Length: 900000000\r\n\r\n"
    for _ in range(20):
        with connect(stack) as peer:
            answer = send_until_answered(peer, head)
            assert status(answer) == 413 and b"Connection: close" in answer
    before = cpu_seconds(stack)
    time.sleep(0.5)
    assert cpu_seconds(stack) - before < 0.2
    still_serves(stack)


def test_clients_that_disconnect_during_a_request_leave_no_work(stack):
    whole = b"POST /v1/sign-in HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n" + b"x" * 50
    for cut in range(1, len(whole), 3):
        with connect(stack) as peer:
            peer.sendall(whole[:cut])
    still_serves(stack)
    before = cpu_seconds(stack)
    time.sleep(0.5)
    assert cpu_seconds(stack) - before < 0.2


@pytest.mark.parametrize("target", [b"//x/v1/me", b"/v1//me", b"/v1/%6de", b"/v1/../v1/me", b"/v1/./me", b"/v1/me/", b"/"])
def test_other_spellings_of_a_route_are_not_found(stack, target):
    answer = exchange(stack, b"GET " + target + b" HTTP/1.1\r\nHost: x\r\n\r\n")
    assert status(answer) in (400, 404)


@pytest.mark.parametrize(("path", "status_line"), [(b"/v1/me", b"HTTP/1.1 401 Unauthorized"), (b"/v1/nowhere", b"HTTP/1.1 404 Not Found")])
def test_a_response_has_the_standard_reason_phrase(stack, path, status_line):
    assert exchange(stack, b"GET " + path + b" HTTP/1.1\r\nHost: x\r\n\r\n").splitlines()[0] == status_line


def test_trace_is_not_echoed(stack):
    answer = exchange(stack, b"TRACE /v1/me HTTP/1.1\r\nHost: x\r\nCookie: diaphane=" + b"a" * 64 + b"\r\n\r\n")
    assert status(answer) == 405 and b"a" * 64 not in answer


def test_an_unknown_method_is_refused(stack):
    for method in (b"BREW", b"PUT", b"CONNECT", b"get"):
        assert status(exchange(stack, method + b" /v1/me HTTP/1.1\r\nHost: x\r\n\r\n")) in (400, 401, 405)


def test_the_total_size_of_bodies_in_memory_is_bounded(stack):
    """Announced parts of 8 MiB that never arrive. Beyond the budget, clients are told to retry."""
    head = (b"PATCH /v1/uploads/00000000-0000-4000-8000-000000000000 HTTP/1.1\r\nHost: x\r\nTus-Resumable: 1.0.0\r\n"
            b"Content-Type: application/offset+octet-stream\r\nContent-Length: 8388608\r\n\r\n")

    def answer_to(head: bytes) -> bytes:
        with connect(stack) as peer, contextlib.suppress(ConnectionError):
            return send_until_answered(peer, head)
        return b""

    with contextlib.ExitStack() as open_ones:
        for _ in range(16):
            open_ones.enter_context(connect(stack)).sendall(head)
        stack.wait_until(lambda: answer_to(head).startswith(b"HTTP/1.1 503 ") and b"Retry-After" in answer_to(head), what="a refusal")
        still_serves(stack)
    stack.wait_until(lambda: answer_to(head).startswith(b"HTTP/1.1 401 "), what="the budget released by those who disconnected")


def test_the_api_stops_in_time_with_open_connections(stack):
    with contextlib.ExitStack() as open_ones:
        for _ in range(20):
            open_ones.enter_context(connect(stack)).sendall(
                b"POST /v1/sign-in HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n{")
            open_ones.enter_context(connect(stack))
        stack.stop("api")
    assert not any("did not stop in time" in event for event in stack.events)
    stack.start("api")
    stack.wait_ready("api")
    still_serves(stack)
