"""Attacks on TLS between Diaphane's programs: clients without a valid certificate are not served, and a stream continues
meanwhile."""

from __future__ import annotations

import dataclasses
import os
import socket
import ssl
import subprocess
import threading
import time
from pathlib import Path

import pytest
from api_client import person
from certificates import issue, issue_another
from stream_helpers import PROGRAMS, Viewer, free_port, open_session, store_ball
from test_gateway_process import Watcher
from test_inner_tls import by_port, ours, redis_port, settings  # noqa: F401

#: The start of an HTTP/2 connection, which a gRPC server answers with its settings, a frame of type 4.
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0"
#: Limits of unfinished handshakes in renderd/serve/grpc_server.cpp: seconds, connections in total and per address.
HANDSHAKE_S = 10
MOST_UNFINISHED = 256
MOST_PER_ADDRESS = 32


def context(folder: Path, own: tuple[str, str] | None, minimum=ssl.TLSVersion.TLSv1_2, maximum=ssl.TLSVersion.TLSv1_3, ciphers: str = "") -> ssl.SSLContext:
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    made.check_hostname = False
    made.load_verify_locations(folder / "ca.pem")
    made.set_ciphers(ciphers or "DEFAULT")
    made.minimum_version, made.maximum_version = minimum, maximum
    made.set_alpn_protocols(["h2"])
    if own:
        made.load_cert_chain(*own)
    return made


def served(port: int, by: ssl.SSLContext | None, hello: bytes, answer: bytes, address: str = "127.0.0.1") -> bool:
    """Whether `hello`, sent from this address, is answered as one of Diaphane's servers would."""
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=20, source_address=(address, 0)) as plain:
            inside = by.wrap_socket(plain, server_hostname="127.0.0.1") if by else plain
            inside.sendall(hello)
            got = b""
            while len(got) < len(answer) and (part := inside.recv(100)):
                got += part
            # The length of the settings frame is up to the server.
            return got[3:4] == answer[3:4] if hello == PREFACE else got.startswith(answer)
    except OSError:
        return False


def attackers(folder: Path, foreign: Path) -> dict[str, ssl.SSLContext | None]:
    """Returns clients that must not be served."""
    own = (str(folder / "own.pem"), str(folder / "own.key"))
    old = ssl.TLSVersion.TLSv1_1
    return {
        "without TLS": None,
        "without a certificate": context(folder, None),
        "of another authority": context(folder, (str(foreign / "own.pem"), str(foreign / "own.key"))),
        "signed by itself": context(folder, issue_another(folder, "itself", signed=False)),
        "expired": context(folder, issue_another(folder, "expired", days=-1)),
        "with a server's certificate": context(folder, issue_another(folder, "server", usage="serverAuth")),
        "with TLS 1.1": context(folder, own, old, old, "ALL:@SECLEVEL=0"),
        "with a cipher that ciphers nothing": context(folder, own, maximum=ssl.TLSVersion.TLSv1_2, ciphers="NULL:@SECLEVEL=0"),
    }


#: Sent instead of a handshake, followed by silence.
NO_HANDSHAKES = {
    "nothing": b"",
    "noise": bytes((i * 7919 + 13) % 256 for i in range(50_000)),
    "half a hello": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 40,
    "a record longer than any": b"\x16\x03\x01\xff\xff" + b"\x01" * 70_000,
    "a hello that claims 16 MB": b"\x16\x03\x01\x40\x00\x01\xff\xff\xff" + b"\0" * 16_380,
    "an alert": b"\x15\x03\x03\x00\x02\x02\x28",
    "data before any handshake": b"\x17\x03\x03\x00\x10" + b"\0" * 16,
}


@pytest.fixture
def foreign(all_stacks) -> Path:
    folder = all_stacks.folder()
    issue(folder)
    return folder


@pytest.fixture
def tls_stack(stack_factory, ours, redis_port):  # noqa: F811
    """A stack with TLS and a running stream in it: stack, port of renderd, until_pictures()."""
    grpc = free_port()
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_REDIS": f"rediss://127.0.0.1:{redis_port}", **settings(ours), **by_port(grpc)})
    who = person(stack)
    viewer = Viewer(stack.url, open_session(who, store_ball(stack, who, 24))[1], side=32)
    viewer.frame()
    pids = dict(stack.pids)
    watcher = Watcher(viewer)
    watcher.start()

    def until_pictures() -> None:
        mark = watcher.turns + 3
        stack.wait_until(lambda: watcher.fault or watcher.turns >= mark, 60, "pictures")
        assert watcher.fault is None, watcher.fault

    until_pictures()
    yield stack, grpc, until_pictures
    watcher.finish()
    assert dict(stack.pids) == pids, "a program ended"


def test_attacks_on_renderd_and_redis_do_not_disturb_a_stream(tls_stack, ours, redis_port, foreign):  # noqa: F811
    stack, grpc, until_pictures = tls_stack
    right = context(ours, (str(ours / "own.pem"), str(ours / "own.key")))
    doors = {"renderd": (grpc, PREFACE, b"\0\0\0\4"), "redis": (redis_port, b"PING\r\n", b"+PONG")}
    for name, (port, hello, answer) in doors.items():
        assert served(port, right, hello, answer), f"{name} serves who has a right certificate"
        for who, by in attackers(ours, foreign).items():
            assert not served(port, by, hello, answer), f"{name} served a client {who}"
    until_pictures()

    # A TLS 1.2 client with a valid certificate requests renegotiation and sends nothing else.
    anew = subprocess.Popen(["openssl", "s_client", "-connect", f"127.0.0.1:{grpc}", "-tls1_2", "-alpn", "h2", "-CAfile", str(ours / "ca.pem"),
                             "-cert", str(ours / "own.pem"), "-key", str(ours / "own.key")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    anew.stdin.write(b"R\n")
    anew.stdin.flush()
    # Meanwhile, many clients send something other than a handshake, followed by silence.
    held = [socket.create_connection(("127.0.0.1", grpc), timeout=5, source_address=(f"127.0.0.{2 + i % 7}", 0)) for _ in range(40) for i in range(len(NO_HANDSHAKES))]
    for one, data in zip(held, list(NO_HANDSHAKES.values()) * 40):
        try:
            one.sendall(data)
        except OSError:
            pass            # already refused
    until_pictures()
    assert served(grpc, right, *doors["renderd"][1:]), "another client is served meanwhile"
    for one in held:
        one.settimeout(60)
        try:
            while one.recv(4096):
                pass
        except ConnectionResetError:
            pass            # also ended
        one.close()
    said, _ = anew.communicate(timeout=60)
    assert b"RENEGOTIATING" in said and said.count(b"Verify return code") <= 1 and anew.returncode != 0, said[-1500:]
    until_pictures()


def held_open(connections: list[socket.socket]) -> list[socket.socket]:
    """Returns the connections that the server has not closed."""
    still = []
    for one in connections:
        one.setblocking(False)
        try:
            if one.recv(1, socket.MSG_PEEK):
                still.append(one)
        except BlockingIOError:
            still.append(one)
        except OSError:
            pass
    return still


def attack(port: int, address: str, count: int) -> list[socket.socket]:
    """Opens connections from this address that begin a handshake and fall silent."""
    made = []
    for _ in range(count):
        one = socket.create_connection(("127.0.0.1", port), timeout=5, source_address=(address, 0))
        try:
            one.sendall(NO_HANDSHAKES["half a hello"])
        except OSError:
            pass            # already closed
        made.append(one)
    return made


def test_unfinished_handshakes_are_limited_per_address_and_in_total(tls_stack, ours):  # noqa: F811
    stack, grpc, until_pictures = tls_stack
    right = context(ours, (str(ours / "own.pem"), str(ours / "own.key")))
    pid = stack.pids["renderd"]

    def descriptors() -> int:
        return len(list(Path(f"/proc/{pid}/fd").iterdir()))

    def memory() -> int:
        return next(int(line.split()[1]) * 1024 for line in Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith("VmRSS"))

    def is_served(address: str) -> bool:
        return served(grpc, right, PREFACE, b"\0\0\0\4", address)

    @dataclasses.dataclass(frozen=True)
    class Seen:
        of_one: int         # connections of one address that are open
        served_after_one: tuple[bool, bool]    # this address, and the gateway's
        of_all: int
        served_after_all: tuple[bool, bool]    # the gateway's address, and a new one
        descriptors: int

    def seen_while_attacked(held: list[socket.socket]) -> Seen:
        held += attack(grpc, "127.0.0.2", 100)
        stack.wait_until(lambda: len(held_open(held)) <= MOST_PER_ADDRESS, what="the limit of one address")
        of_one, served_after_one = len(held_open(held)), (is_served("127.0.0.2"), is_served("127.0.0.1"))
        for last in range(3, 23):    # a thousand more, from many addresses
            held += attack(grpc, f"127.0.0.{last}", 50)
        stack.wait_until(lambda: len(held_open(held)) <= MOST_UNFINISHED, what="the limit in all")
        served_after_all = is_served("127.0.0.1"), is_served("127.0.0.99")
        return Seen(of_one, served_after_one, len(held_open(held)), served_after_all, descriptors() - before)

    before, memory_before = descriptors(), memory()
    for _ in range(10):
        begun, held = time.monotonic(), []
        seen = seen_while_attacked(held)
        if time.monotonic() - begun < HANDSHAKE_S:
            break
        # On a busy machine, the deadline ended some of them before the limits could be told from it.
        stack.wait_until(lambda held=held: not held_open(held), what="the end of a slow attempt")
    assert seen.of_one == MOST_PER_ADDRESS and seen.served_after_one == (False, True), "the limit is one of each address"
    assert seen.served_after_all == (True, False), "only the gateway's address, from which calls came, is served"
    assert MOST_UNFINISHED - 2 <= seen.of_all and seen.descriptors <= MOST_UNFINISHED + 4
    grown = memory() - memory_before
    assert grown < 128 << 20, f"{grown >> 20} MiB for {MOST_UNFINISHED} handshakes"
    until_pictures()

    stack.wait_until(lambda: not held_open(held), what="their end")
    assert time.monotonic() - begun > HANDSHAKE_S - 1
    stack.wait_until(lambda: is_served("127.0.0.2") and is_served("127.0.0.1"), what="room again")
    stack.wait_until(lambda: descriptors() - before <= 4, what="the end of the connections of those clients")
    assert '"event":"too_many_unfinished_handshakes"' in stack.log("renderd")
    until_pictures()
    for one in held:
        one.close()


@pytest.mark.nightly
def test_a_handshake_that_trickles_bytes_times_out(tls_stack):
    _, grpc, until_pictures = tls_stack
    until = time.monotonic() + 3 * HANDSHAKE_S
    with socket.create_connection(("127.0.0.1", grpc), timeout=1) as slow, pytest.raises(OSError):
        for byte in b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 200:
            slow.send(bytes([byte]))
            time.sleep(0.2)
            assert time.monotonic() < until, "it was not stopped"
    until_pictures()


# Postgres, with api as the client

class FalsePostgres(threading.Thread):
    """Responds to the TLS request with `answer`, then shakes hands with that certificate. `heard` contains what the client sent
    over TLS."""

    def __init__(self, own: tuple[str, str] | None, answer: bytes = b"S"):
        super().__init__(daemon=True)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.own, self.answer, self.heard = own, answer, b""
        self.start()

    def run(self) -> None:
        while True:
            try:
                plain, _ = self.listener.accept()
            except OSError:
                return
            try:
                with plain:
                    plain.settimeout(10)
                    assert plain.recv(8) == b"\0\0\0\x08\x04\xd2\x16\x2f", "no wish for TLS"
                    plain.sendall(self.answer)
                    inside = plain
                    if self.own and self.answer == b"S":
                        by = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
                        by.load_cert_chain(*self.own)
                        inside = by.wrap_socket(plain, server_side=True)
                    with inside:    # wrapping has taken the connection from `plain`
                        self.heard += inside.recv(1000)
            except (OSError, AssertionError):
                pass


def test_an_impostor_postgres_gets_no_credentials(all_stacks, ours, foreign):  # noqa: F811
    layout = all_stacks.layout()

    def asked(server: FalsePostgres) -> bytes:
        url = f"postgresql://diaphane:s3cret@127.0.0.1:{server.port}/diaphane?sslmode=verify-full&sslrootcert={ours / 'ca.pem'}"
        done = subprocess.run([str(layout.bin / "diaphane-api"), "migrate", "up", "--migrations", str(layout.migrations)],
                              env={**os.environ, "DIAPHANE_POSTGRES": url}, capture_output=True, text=True, timeout=60)
        server.listener.close()
        assert done.returncode == 69 and "s3cret" not in done.stderr, done.stderr
        return server.heard

    assert b"diaphane" in asked(FalsePostgres(issue_another(ours, "right"))), "one that has a right certificate is told who we are"
    false = {
        "that has no TLS": FalsePostgres(None, b"N"),
        "of another authority": FalsePostgres((str(foreign / "own.pem"), str(foreign / "own.key"))),
        "that signed itself": FalsePostgres(issue_another(ours, "itself", signed=False)),
        "of another name": FalsePostgres(issue_another(ours, "other", names="DNS:elsewhere")),
        "that has expired": FalsePostgres(issue_another(ours, "expired", days=-1)),
        "with a client's certificate": FalsePostgres(issue_another(ours, "client", usage="clientAuth")),
    }
    for what, server in false.items():
        assert asked(server) == b"", f"a server {what} was spoken to"
