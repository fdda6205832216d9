"""How secrets travel: the HTTPS cookie through the edge, and TLS to Postgres."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import httpx
import psycopg
import pytest


@pytest.fixture
def passed_on(stack_factory):
    """Requests the edge with a cookie, and returns what it forwards to api. A stand-in replaces api and records it."""
    stack = stack_factory(only=("postgres", "redis", "edge"))

    class Echo(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            body = self.headers.get("Cookie", "").encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *words: object) -> None:
            pass

    server = HTTPServer(("127.0.0.1", stack.ports["api"]), Echo)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield lambda cookie: httpx.get(stack.url + "/v1/me", headers={"Cookie": cookie}, timeout=30).text
    server.shutdown()
    thread.join()
    server.server_close()


def test_the_edge_prefers_the_https_cookie(passed_on):
    secure, plain = f"__Host-diaphane={'a' * 64}", f"diaphane={'b' * 64}"
    assert passed_on(secure) == secure and passed_on(plain) == plain
    for order in (f"{secure}; {plain}", f"{plain}; {secure}", f"x=1; {plain}; {secure}; y=2"):
        assert passed_on(order) == secure, "what another host could have set does not stand in its way"
    for wrong in (f"__Host-diaphane={'a' * 63}", f"__Host-diaphane={'a' * 65}", f"x__Host-diaphane={'a' * 64}", "x=1"):
        assert passed_on(wrong) == ""
    known, plainly = f"__Host-diaphane_browser={'c' * 64}", f"diaphane_browser={'d' * 64}"
    assert passed_on(f"{known}; {secure}; {plainly}") == f"{secure}; {known}"
    assert passed_on(f"{plainly}; {plain}") == f"{plain}; {plainly}" and passed_on(f"diaphane_browser={'d' * 65}") == ""


def certificate(folder: Path, name: str) -> Path:
    """Creates a self-signed certificate for 127.0.0.1 with its key."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                    "-subj", "/CN=diaphane-test", "-addext", "subjectAltName=IP:127.0.0.1",
                    "-keyout", str(folder / f"{name}.key"), "-out", str(folder / f"{name}.crt")], check=True, capture_output=True)
    return folder / f"{name}.crt"


def test_postgres_connections_require_tls_and_the_right_certificate(stack_factory, tmp_path):
    stack = stack_factory(only=("postgres",))
    database = stack.data_dir / "postgres"
    right, other = certificate(tmp_path, "right"), certificate(tmp_path, "other")
    for suffix in ("crt", "key"):
        there = database / f"server.{suffix}"
        there.write_bytes((tmp_path / f"right.{suffix}").read_bytes())
        there.chmod(0o600)
        stack.stack.run_as.own(there)
    with (database / "postgresql.conf").open("a", encoding="utf-8") as conf:
        conf.write("\nssl = on\n")
    os.kill(stack.pids["postgres"], signal.SIGHUP)

    def by_tls(root: Path) -> str:
        return f"{stack.dsn}?sslmode=verify-full&sslrootcert={root}"

    def answers() -> bool:
        try:
            psycopg.connect(by_tls(right)).close()
            return True
        except psycopg.OperationalError:
            return False

    stack.wait_until(answers, what="TLS")

    def migrate(root: Path) -> subprocess.CompletedProcess:
        layout = stack.stack.layout
        return subprocess.run([str(layout.bin / "diaphane-api"), "migrate", "up", "--migrations", str(layout.migrations)],
                              env={**os.environ, "DIAPHANE_POSTGRES": by_tls(root)}, capture_output=True, text=True)

    assert migrate(right).returncode == 0
    refused = migrate(other)
    assert refused.returncode == 69 and "certificate verify failed" in refused.stderr


def test_the_admin_port_is_local_unless_configured(stack, stack_factory):
    """In a pod, requests for metrics and health come from another machine. On a single machine, none do."""
    programs = ("api-admin", "gateway-admin", "ingestd-admin", "renderd-admin")
    for program in programs:
        with pytest.raises(httpx.ConnectError):
            httpx.get(f"http://127.0.0.2:{stack.ports[program]}/healthz")
    opened = stack_factory(only=("postgres", "redis", "api", "gateway", "ingestd", "renderd"), extra_env={"DIAPHANE_ADMIN_ADDRESS": "0.0.0.0"})
    for program in programs:
        assert httpx.get(f"http://127.0.0.2:{opened.ports[program]}/healthz").status_code == 200, program
