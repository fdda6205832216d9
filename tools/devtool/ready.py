"""Checks from outside whether a program is ready. Each check takes at most one second."""

from __future__ import annotations

import http.client
import json
import socket
import subprocess

from .plan import POSTGRES_BIN, Ready


def is_ready(probe: Ready) -> bool:
    try:
        return _PROBES[probe.kind](probe)
    except (OSError, http.client.HTTPException, subprocess.SubprocessError):
        return False


def readyz(port: int) -> dict:
    """Returns the JSON of a program's /readyz, ready or not, or an empty result without an answer."""
    try:
        answer = json.loads(_get(port, "/readyz")[1])
        return answer if isinstance(answer, dict) else {}
    except (OSError, http.client.HTTPException, ValueError):
        return {}


def redis_command(path: str, *arguments: str) -> bytes:
    """Returns the raw response (RESP) to one small command."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        connection.settimeout(1.0)
        connection.connect(path)
        parts = [f"${len(w.encode())}\r\n{w}\r\n" for w in arguments]
        connection.sendall(f"*{len(arguments)}\r\n{''.join(parts)}".encode())
        return connection.recv(65536)


def _get(port: int, path: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=1.0)
    try:
        connection.request("GET", path, headers={"Connection": "close"})
        answer = connection.getresponse()
        return answer.status, answer.read(65536)
    finally:
        connection.close()


def _http(probe: Ready) -> bool:
    return _get(probe.port, probe.path)[0] == 200


def _answers(probe: Ready) -> bool:
    return _get(probe.port, probe.path)[0] > 0


def _postgres(probe: Ready) -> bool:
    command = [str(POSTGRES_BIN / "pg_isready"), "-q", "-h", "127.0.0.1", "-p", str(probe.port), "-t", "1"]
    return subprocess.run(command, timeout=3, cwd="/").returncode == 0


def _redis(probe: Ready) -> bool:
    return redis_command(probe.path, "PING").startswith(b"+PONG")


_PROBES = {"http": _http, "answers": _answers, "postgres": _postgres, "redis": _redis}
