"""TLS between api, renderd and Redis: everything works with certificates of one authority, and nothing without."""

from __future__ import annotations

import socket
import ssl
import subprocess
from pathlib import Path

import httpx
import pytest
from api_client import person
from certificates import issue
from stream_helpers import PROGRAMS, Viewer, free_port, open_session, store_ball

@pytest.fixture
def ours(all_stacks) -> Path:
    folder = all_stacks.folder()
    issue(folder)
    for file in folder.iterdir():
        all_stacks.run_as.own(file)
    return folder


@pytest.fixture
def redis_port(all_stacks, ours):
    """A Redis that accepts only TLS, with a certificate of the authority."""
    port, data = free_port(), all_stacks.folder()
    files = ("--tls-ca-cert-file", str(ours / "ca.pem"), "--tls-cert-file", str(ours / "own.pem"), "--tls-key-file", str(ours / "own.key"))
    server = subprocess.Popen(["/usr/bin/redis-server", "--port", "0", "--tls-port", str(port), "--bind", "127.0.0.1", "--dir", str(data), "--save", "",
                               "--tls-auth-clients", "yes", *files], stdout=subprocess.DEVNULL, **all_stacks.run_as.popen())
    yield port
    server.kill()
    server.wait()


def settings(folder: Path) -> dict[str, str]:
    return {"DIAPHANE_INNER_TLS_CA": str(folder / "ca.pem"), "DIAPHANE_INNER_TLS_CERTIFICATE": str(folder / "own.pem"),
            "DIAPHANE_INNER_TLS_KEY": str(folder / "own.key")}


def by_port(port: int) -> dict[str, str]:
    """Settings for renderd as between machines, instead of the Unix socket on one machine."""
    return {"DIAPHANE_GRPC_ADDRESS": "127.0.0.1", "DIAPHANE_GRPC_PORT": str(port), "DIAPHANE_ADVERTISE": f"127.0.0.1:{port}"}


def hears_in_plain(port: int, said: bytes) -> bytes:
    """Returns the response to a client without TLS."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as one:
        one.sendall(said)
        try:
            return one.recv(100)
        except OSError:
            return b""


def test_a_picture_comes_over_tls_to_redis_and_renderd_and_nobody_else_gets_in(stack_factory, ours, redis_port):
    grpc = free_port()
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_REDIS": f"rediss://127.0.0.1:{redis_port}", **settings(ours), **by_port(grpc)})
    who = person(stack)
    viewer = Viewer(stack.url, open_session(who, store_ball(stack, who))[1])
    assert viewer.frame(timeout=60).iteration > 0
    assert stack.redis.dbsize() == 0, "the Redis without TLS was not used"

    assert b"PONG" not in hears_in_plain(redis_port, b"PING\r\n")
    # A plain gRPC server answers the HTTP/2 preface with its settings (a frame of type 4).
    assert b"\0\0" not in hears_in_plain(grpc, b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0")[:3]
    nobody = ssl.create_default_context(cafile=str(ours / "ca.pem"))
    nobody.set_alpn_protocols(["h2"])
    with pytest.raises(OSError), socket.create_connection(("127.0.0.1", grpc), timeout=10) as one:
        with nobody.wrap_socket(one, server_hostname="127.0.0.1") as inside:    # trusts the server, but has no certificate
            inside.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0")
            if not inside.recv(9):
                raise ConnectionError("closed")

    # With certificates of another authority, api reaches neither.
    viewer.leave()
    issue(ours)
    stack.kill("api", restart=False)
    for file in ours.iterdir():
        stack.stack.run_as.own(file)
    stack.start("api")
    stack.wait_until(lambda: '"event":"redis","reason":"TLS: ' in stack.log("api"), 60, "its refusal")
    ready = f"http://127.0.0.1:{stack.ports['api-admin']}/readyz"
    assert httpx.get(ready).status_code == 503


@pytest.mark.parametrize(("program", "setting", "value"), [
    ("api", "redis", "10.0.0.1:6379"), ("renderd", "redis", "redis.example.org:6379"), ("renderd", "grpc-address", "0.0.0.0"),
    ("renderd", "assist", "10.0.0.2:8085"), ("api", "redis", "rediss://127.0.0.1:6379"),
    *((program, "postgres", "postgresql://u:p@db.example.org/d?sslmode=require") for program in ("api", "ingestd", "api migrate up", "api admin list")),
])
def test_another_machine_is_not_reached_without_tls_unless_somebody_says_so(all_stacks, tmp_path, program, setting, value):
    name, *command = program.split()
    binary = all_stacks.layout().bin / f"diaphane-{name}"

    def said(*more: str) -> str:
        """Returns the errors about settings. Missing settings are included, so nothing starts."""
        return subprocess.run([str(binary), *command, f"--{setting}", value, *more], capture_output=True, text=True, env={}, timeout=60).stderr

    words = "rediss:// requires --inner-tls-ca" if value.startswith("rediss") else "is a remote host"
    assert words in said()
    if not value.startswith("rediss"):
        assert words not in said("--inner-plain", "1")
