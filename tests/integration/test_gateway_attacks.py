"""Attacks on the stream port itself, as if the edge were not there."""

from __future__ import annotations

import os
import socket
import time

import pytest
from api_client import add_worker, api, make_ready, person  # noqa: F401
from edge_help import connect, read_all, resident_mb, statuses, talk

KEY = b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"


def handshake(origin: str, ticket: str = "0" * 64, protocol: str = "diaphane.v1", extra: bytes = b"") -> bytes:
    lines = [f"GET /stream?ticket={ticket} HTTP/1.1", "Host: localhost", "Upgrade: websocket", "Connection: upgrade"]
    lines += [f"Origin: {origin}"] if origin else []
    lines += [f"Sec-WebSocket-Protocol: {protocol}"] if protocol else []
    return "\r\n".join(lines).encode() + b"\r\n" + KEY + extra + b"\r\n"


@pytest.fixture(scope="module")
def port(api) -> int:  # noqa: F811
    return api.ports["stream"]


@pytest.fixture(autouse=True)
def unharmed(api):  # noqa: F811
    pid = api.pids["api"]
    before = resident_mb(pid)
    yield
    assert api.pids["api"] == pid
    assert resident_mb(pid) - before < 100


@pytest.mark.parametrize("name, data", [
    ("TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 200),
    ("noise", bytes((i * 7919 + 13) % 256 for i in range(50_000))),
    ("zeros", b"\0" * 50_000),
    ("empty lines", b"\r\n" * 20_000 + b"x\r\n\r\n"),
    ("an endless line", b"GET /" + b"a" * 100_000),
    ("HTTP/0.9", b"GET /stream\r\n\r\n"),
    ("the preface of HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
])
def test_what_is_no_handshake_is_closed(port, name, data):
    assert all(400 <= status < 500 for status in statuses(talk(port, data)))


def test_a_handshake_is_checked_before_a_ticket_is_looked_at(api, port):  # noqa: F811
    cases = [
        (handshake("http://evil.test"), 403), (handshake(""), 403), (handshake("null"), 403),
        (handshake(api.url, protocol=""), 400), (handshake(api.url, protocol="diaphane.v2"), 400),
        (handshake(api.url, ticket="../../etc"), 400), (handshake(api.url, ticket="0" * 63), 400),
        (handshake(api.url, extra=b"X: " + b"x" * 10_000 + b"\r\n"), 431),
        (handshake(api.url, extra=b"".join(b"X-%d: x\r\n" % i for i in range(2000))), 431),
        (handshake(api.url).replace(b"GET ", b"POST "), 426),
        (handshake(api.url).replace(b"Upgrade: websocket\r\n", b""), 426),
        (handshake(api.url, extra=b"Content-Length: 5\r\n") + b"hello", 426),
        (handshake(api.url, extra=b"Transfer-Encoding: chunked\r\n") + b"-1\r\n", 426),
    ]
    for data, status in cases:
        got = statuses(talk(port, data))
        assert got in ([status], []) and (got or status == 431), f"{data[:80]!r}: {got}"


def frame(opcode: int, payload: bytes = b"", masked: bool = True, length: int | None = None) -> bytes:
    size = len(payload) if length is None else length
    head = bytes([0x80 | opcode])
    mask = 0x80 if masked else 0
    if size < 126:
        head += bytes([mask | size])
    elif size < 65536:
        head += bytes([mask | 126]) + size.to_bytes(2, "big")
    else:
        head += bytes([mask | 127]) + size.to_bytes(8, "big")
    return head + (b"\0\0\0\0" if masked else b"") + payload


@pytest.fixture(scope="module")
def ticket(api):  # noqa: F811
    """Makes tickets of a session whose worker takes connections and says nothing: no stream gets further than that."""
    mute = socket.create_server(("127.0.0.1", 0), backlog=100)
    somebody = person(api)
    data_set = somebody.upload(b"x" * 100)["id"]
    make_ready(api, data_set)
    add_worker(api, "mute", slots=1000)
    api.redis.hset("diaphane:worker:mute", "address", f"127.0.0.1:{mute.getsockname()[1]}")
    session = somebody.http.post("/v1/sessions", json={"data_set_id": data_set}).json()["session_id"]
    yield lambda: somebody.http.post(f"/v1/sessions/{session}/tickets").json()["stream_url"][-64:]
    api.redis.delete("diaphane:worker:mute", "diaphane:worker:mute:sessions")
    mute.close()


@pytest.mark.parametrize("name, data, code", [
    ("a message over the limit", frame(2, b"x" * 65_537), 1009),
    ("a message that claims 2^62 bytes", frame(2, b"x", length=2**62), 1009),
    ("a message in endless pieces", bytes([0x02, 0x80]) + b"\0" * 4 + (bytes([0x00, 0xFE]) + (30_000).to_bytes(2, "big")
                                                                         + b"\0" * 30_004) * 4, 1009),
    ("text", frame(1, b"hello"), 4400),
    ("not masked", frame(2, b"hello", masked=False), 1002),
    ("a reserved opcode", frame(3, b"hello"), 1002),
    ("reserved bits", bytes([0xF2, 0x80]) + b"\0" * 4, 1002),
    ("a long ping", frame(9, b"x" * 126), 1002),
    ("a close of one byte", frame(8, b"x"), 1002),
    ("1100 messages at once", frame(2, b"x") * 1100, 4429),
])
def test_what_is_no_message_closes_with_a_code(api, port, ticket, name, data, code):  # noqa: F811
    with connect(port, timeout=8) as one:
        one.sendall(handshake(api.url, ticket()))
        assert one.recv(4096).startswith(b"HTTP/1.1 101 ")
        time.sleep(0.1)  # the ticket is redeemed
        try:
            one.sendall(data)
        except OSError:
            pass
        got = read_all(one)
    assert code.to_bytes(2, "big") in got, got[:100]


def test_slow_handshakes_are_ended_and_others_are_served_meanwhile(api, port):  # noqa: F811
    slow = [connect(port) for _ in range(300)]
    for one in slow[:150]:
        one.sendall(b"GET /stream")
    begun = time.monotonic()
    assert statuses(talk(port, handshake("http://evil.test"))) == [403]
    assert time.monotonic() - begun < 1
    for one in slow:
        one.settimeout(max(0.1, begun + 13 - time.monotonic()))
        assert one.recv(1) == b"", "closed after 10 s"
        one.close()


def test_a_thousand_connections_that_vanish_leave_nothing(api, port):  # noqa: F811
    files = f"/proc/{api.pids['api']}/fd"
    before = len(os.listdir(files))
    for _ in range(20):
        several = [connect(port) for _ in range(50)]
        for number, one in enumerate(several):
            one.sendall(handshake(api.url)[:number * 5])
            one.close()
    api.wait_until(lambda: len(os.listdir(files)) <= before + 5, 5, "the descriptors to be given back")
