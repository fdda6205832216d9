"""Attacks directly on the stream port, without the edge."""

from __future__ import annotations

import os
import time

import pytest
from api_client import person
from edge_helpers import connect, resident_mb, statuses, talk
from stream_helpers import open_session, store_ball, wait_ticket

KEY = b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"


def handshake(origin: str, ticket: str = "0" * 64, protocol: str = "diaphane.v1", extra: bytes = b"") -> bytes:
    lines = [f"GET /stream?ticket={ticket} HTTP/1.1", "Host: localhost", "Upgrade: websocket", "Connection: upgrade"]
    lines += [f"Origin: {origin}"] if origin else []
    lines += [f"Sec-WebSocket-Protocol: {protocol}"] if protocol else []
    return "\r\n".join(lines).encode() + b"\r\n" + KEY + extra + b"\r\n"


@pytest.fixture(scope="module")
def port(running) -> int:
    return running.ports["stream"]


@pytest.fixture(autouse=True)
def unharmed(running):
    pid = running.pids["gateway"]
    before = resident_mb(pid)
    yield
    assert running.pids["gateway"] == pid
    assert resident_mb(pid) - before < 100


NO_HANDSHAKES = {
    "TLS": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 200,
    "noise": bytes((i * 7919 + 13) % 256 for i in range(50_000)),
    "zeros": b"\0" * 50_000,
    "empty lines": b"\r\n" * 20_000 + b"x\r\n\r\n",
    "an endless line": b"GET /" + b"a" * 100_000,
    "HTTP/0.9": b"GET /stream\r\n\r\n",
    "the preface of HTTP/2": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
}


@pytest.mark.parametrize("name", NO_HANDSHAKES)
def test_an_invalid_handshake_is_closed(port, name):
    assert all(400 <= status < 500 for status in statuses(talk(port, NO_HANDSHAKES[name])))


def test_a_handshake_is_checked_before_its_ticket(running, port):
    cases = [
        (handshake("http://evil.test"), 403), (handshake(""), 403), (handshake("null"), 403),
        (handshake(running.url, protocol=""), 400), (handshake(running.url, protocol="diaphane.v2"), 400),
        (handshake(running.url, ticket="../../etc"), 400), (handshake(running.url, ticket="0" * 63), 400),
        (handshake(running.url, extra=b"X: " + b"x" * 10_000 + b"\r\n"), 431),
        (handshake(running.url, extra=b"".join(b"X-%d: x\r\n" % i for i in range(2000))), 431),
        (handshake(running.url).replace(b"GET ", b"POST "), 426),
        (handshake(running.url).replace(b"Upgrade: websocket\r\n", b""), 426),
        (handshake(running.url, extra=b"Content-Length: 5\r\n") + b"hello", 400),
        (handshake(running.url, extra=b"Transfer-Encoding: chunked\r\n") + b"-1\r\n", 426),
    ]
    for data, status in cases:
        assert statuses(talk(port, data)) == [status], data[:300]


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
def ticket(running):
    """Creates tickets of one session with a real worker."""
    somebody = person(running)
    session, _ = open_session(somebody, store_ball(running, somebody, 16))
    return lambda: wait_ticket(somebody, session)[-64:]


MESSAGES = {
    "a message over the limit": (frame(2, b"x" * 65_537), 1009),
    "a message that claims 2^62 bytes": (frame(2, b"x", length=2**62), 1009),
    "a message in endless pieces": (bytes([0x02, 0x80]) + b"\0" * 4
                                    + (bytes([0x00, 0xFE]) + (30_000).to_bytes(2, "big") + b"\0" * 30_004) * 4, 1009),
    "no message of the protocol": (frame(2, b"\xff" * 100), 4400),
    "groups nested 30,000 deep": (frame(2, b"\x7b" * 30_000 + b"\x7c" * 30_000), 4400),
    "text": (frame(1, b"hello"), 4400),
    "not masked": (frame(2, b"hello", masked=False), 1002),
    "a reserved opcode": (frame(3, b"hello"), 1002),
    "reserved bits": (bytes([0xF2, 0x80]) + b"\0" * 4, 1002),
    "a long ping": (frame(9, b"x" * 126), 1002),
    "a close of one byte": (frame(8, b"x"), 1002),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_an_invalid_message_closes_the_stream_with_a_code(running, port, ticket, name):
    data, code = MESSAGES[name]
    with connect(port, timeout=60) as one:
        one.sendall(handshake(running.url, ticket()))
        assert one.recv(4096).startswith(b"HTTP/1.1 101 ")
        time.sleep(0.2)  # the ticket is redeemed
        try:
            one.sendall(data)
        except OSError:
            pass
        wanted, got = code.to_bytes(2, "big"), b""
        while wanted not in got and (part := one.recv(65536)):
            got += part
    assert wanted in got, got[:100]


def test_slow_handshakes_time_out_while_others_are_served(running, port):
    slow = [connect(port) for _ in range(300)]
    for one in slow[:150]:
        one.sendall(b"GET /stream")
    assert statuses(talk(port, handshake("http://evil.test"))) == [403]
    for one in slow:
        one.settimeout(60)
        assert one.recv(1) == b"", "closed after 10 s"
        one.close()


def test_a_thousand_aborted_connections_leak_no_descriptors(running, port):
    files = f"/proc/{running.pids['gateway']}/fd"
    before = len(os.listdir(files))
    for _ in range(20):
        several = [connect(port) for _ in range(50)]
        for number, one in enumerate(several):
            one.sendall(handshake(running.url)[:number * 5])
            one.close()
    running.wait_until(lambda: len(os.listdir(files)) <= before + 5, what="the descriptors to be given back")
