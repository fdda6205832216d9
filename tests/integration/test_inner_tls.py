"""TLS between api, renderd and Redis: everything works with certificates of one authority, and nothing without."""

from __future__ import annotations

import dataclasses
import socket
import ssl
import subprocess
from pathlib import Path

import httpx
import pytest
from api_client import person
from certificates import ROLES, issue, issue_another, with_roles
from harness import files_below
from stream_helpers import PROGRAMS, Viewer, free_port, open_session, store_ball
from websockets.exceptions import ConnectionClosed

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


def test_internal_tls_serves_frames_and_refuses_other_clients(stack_factory, ours, redis_port):
    grpc = free_port()
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_REDIS": f"rediss://127.0.0.1:{redis_port}", **settings(ours), **by_port(grpc)})
    who = person(stack)
    viewer = Viewer(stack.url, open_session(who, store_ball(stack, who))[1])
    assert viewer.frame().iteration > 0
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
    # The log also holds the time before. On a busy machine, Redis may have been slow to answer then.
    stack.wait_until(lambda: '"event":"redis","reason":"TLS: certificate' in stack.log("api"), 60, "its refusal")
    ready = f"http://127.0.0.1:{stack.ports['api-admin']}/readyz"
    assert httpx.get(ready, timeout=20).status_code == 503


def restart_with_certificate(stack, folder: Path, program: str, role: str, **more: str) -> None:
    """Restarts the program with a certificate of this role alone."""
    certificate, key = issue_another(folder, f"{program}-as-{role}", names=with_roles(role))
    for file in (certificate, key):
        stack.stack.run_as.own(Path(file))
    stack.stop(program)
    entry = stack.stack.running_[program]
    env = {**entry.program.env, "DIAPHANE_INNER_TLS_CERTIFICATE": certificate, "DIAPHANE_INNER_TLS_KEY": key, **more}
    entry.program = dataclasses.replace(entry.program, env=env)
    stack.start(program)
    stack.wait_ready(program)


def test_a_certificate_with_the_wrong_role_is_refused_with_a_message(stack_factory, ours, redis_port):
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_REDIS": f"rediss://127.0.0.1:{redis_port}", **settings(ours), **by_port(free_port())})
    for program in ("api", "gateway", "renderd"):
        restart_with_certificate(stack, ours, program, role=program)
    who = person(stack)
    ball = store_ball(stack, who, 24)

    def thumbnail() -> httpx.Response:
        return who.http.get(f"/v1/data-sets/{ball}/thumbnails/bone")

    def stream_closes_with() -> int:
        with pytest.raises(ConnectionClosed) as closed:
            Viewer(stack.url, open_session(who, ball)[1], side=32)
        return closed.value.rcvd.code

    viewer = Viewer(stack.url, open_session(who, ball)[1], side=32)
    assert viewer.frame().iteration > 0
    viewer.leave()
    stack.wait_until(lambda: thumbnail().status_code == 200, 60, "a thumbnail")

    # Only the other program's certificate: without this setting, the gateway would not even start.
    restart_with_certificate(stack, ours, "gateway", role="api", DIAPHANE_INNER_TLS_ROLES="0")
    assert stream_closes_with() == 1011
    words = "Attach requires a certificate with the role gateway (URI spiffe://diaphane/gateway), and the caller's certificate has the role api."
    assert words in stack.log("gateway")
    stack.wait_until(lambda: '"event":"role_refused"' in stack.log("renderd") and words in stack.log("renderd"), what="the worker's log")

    restart_with_certificate(stack, ours, "api", role="gateway", DIAPHANE_INNER_TLS_ROLES="0")
    for file in files_below(stack.data_dir / "cache" / "thumbnails"):
        file.unlink()
    stack.wait_until(lambda: thumbnail().status_code == 503 and "RenderStill requires a certificate with the role api" in stack.log("api"), 60, "its refusal")

    # An installation whose certificates have no roles yet can say so.
    restart_with_certificate(stack, ours, "renderd", role="renderd", DIAPHANE_INNER_TLS_ROLES="0")
    viewer = Viewer(stack.url, stack.wait_until(lambda: open_session(who, ball), 60)[1], side=32)
    assert viewer.frame().iteration > 0


@pytest.mark.parametrize("program", ROLES)
def test_a_program_does_not_start_with_a_certificate_without_its_role(all_stacks, ours, program):
    folder = ours
    other = next(role for role in ROLES if role != program)
    binary = all_stacks.layout().bin / f"diaphane-{program}"

    def said(certificate: tuple[str, str], **more: str) -> str:
        """Returns the errors about settings. Missing settings are included, so nothing starts."""
        env = {**settings(folder), "DIAPHANE_INNER_TLS_CERTIFICATE": certificate[0], "DIAPHANE_INNER_TLS_KEY": certificate[1], **more}
        done = subprocess.run([str(binary)], capture_output=True, text=True, env=env, timeout=60)
        assert done.returncode == 78, done.stderr
        return done.stderr

    none, wrong = issue_another(folder, "none"), issue_another(folder, "wrong", names=with_roles(other))
    needs = f"but this program needs the role {program}. Issue it with the URI spiffe://diaphane/{program}"
    assert f"{none[0]} has no role, {needs}" in said(none)
    assert f"{wrong[0]} has the role {other}, {needs}" in said(wrong)
    assert "role" not in said(issue_another(folder, "right", names=with_roles(program)))
    assert "role" not in said(none, DIAPHANE_INNER_TLS_ROLES="0")


@pytest.mark.parametrize(("program", "setting", "value"), [
    ("api", "redis", "10.0.0.1:6379"), ("renderd", "redis", "redis.example.org:6379"), ("renderd", "grpc-address", "0.0.0.0"),
    ("renderd", "assist", "10.0.0.2:8085"), ("api", "redis", "rediss://127.0.0.1:6379"),
    *((program, "postgres", "postgresql://u:p@db.example.org/d?sslmode=require") for program in ("api", "ingestd", "api migrate up", "api admin list")),
])
def test_remote_hosts_need_tls_unless_it_is_turned_off(all_stacks, tmp_path, program, setting, value):
    name, *command = program.split()
    binary = all_stacks.layout().bin / f"diaphane-{name}"

    def said(*more: str) -> str:
        """Returns the errors about settings. Missing settings are included, so nothing starts."""
        return subprocess.run([str(binary), *command, f"--{setting}", value, *more], capture_output=True, text=True, env={}, timeout=60).stderr

    words = "rediss:// requires --inner-tls-ca" if value.startswith("rediss") else "is a remote host"
    assert words in said()
    if not value.startswith("rediss"):
        assert words not in said("--inner-plain", "1")
