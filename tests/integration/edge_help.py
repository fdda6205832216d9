"""What the tests of the edge share: raw connections, an ordinary client alongside, what the programs use."""

from __future__ import annotations

import http.client
import json
import re
import socket
import threading
import time
from pathlib import Path

#: Also right behind a body without a line's end.
STATUS_LINE = re.compile(rb"HTTP/1\.[01] (\d{3}) ?[A-Za-z -]*\r\n")


def connect(port: int, source: str = "127.0.0.66", timeout: float = 5.0) -> socket.socket:
    """From an address of its own, as other people's connections are: limits are by address."""
    return socket.create_connection(("127.0.0.1", port), timeout=timeout, source_address=(source, 0))


def talk(port: int, data: bytes, source: str = "127.0.0.66", timeout: float = 5.0) -> bytes:
    """Everything that comes back until the other side closes; b"" when it just closes."""
    with connect(port, source, timeout) as one:
        try:
            one.sendall(data)
        except OSError:
            pass  # refused while we were still talking
        return read_all(one)


def read_all(one: socket.socket) -> bytes:
    got = bytearray()
    try:
        while part := one.recv(65536):
            got += part
    except ConnectionResetError:
        pass
    except TimeoutError:
        if not got:
            raise  # else: answered, and kept open a while so that the answer arrives
    return bytes(got)


def statuses(answer: bytes) -> list[int]:
    return [int(found) for found in STATUS_LINE.findall(answer)]


def resident_mb(pid: int) -> float:
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


def family(pid: int) -> list[int]:
    """The process and its children."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [pid, *map(int, children)]


class Ordinary(threading.Thread):
    """Somebody signed in who goes on using the page, from another address. Every answer must be theirs."""

    def __init__(self, port: int, cookie: str, user_id: str):
        super().__init__(daemon=True)
        self.port, self.cookie, self.user_id = port, cookie, user_id
        self.stopping = threading.Event()
        self.seconds: list[float] = []
        self.wrong: list[str] = []

    def run(self) -> None:
        connection = None
        while not self.stopping.wait(0.01):
            begun = time.monotonic()
            try:
                connection = connection or http.client.HTTPConnection("127.0.0.1", self.port, timeout=10,
                                                                      source_address=("127.0.0.2", 0))
                self.check(connection, "/v1/me", lambda body: json.loads(body)["id"] == self.user_id)
                self.check(connection, "/v1/data-sets", lambda body: json.loads(body)["items"] == [])
                self.check(connection, "/", lambda body: b"<" in body)
            except Exception as failure:  # noqa: BLE001 - whatever it is, it is a finding
                self.wrong.append(f"{type(failure).__name__}: {failure}")
                connection = None
            self.seconds.append((time.monotonic() - begun) / 3)

    def check(self, connection: http.client.HTTPConnection, path: str, right) -> None:
        connection.request("GET", path, headers={"Cookie": f"diaphane={self.cookie}"})
        answer = connection.getresponse()
        body = answer.read()
        if answer.status != 200 or not right(body):
            self.wrong.append(f"{path}: {answer.status} {body[:200]!r}")

    def p99(self) -> float:
        times = sorted(self.seconds)
        return times[int(len(times) * 0.99)] if times else 0.0

    def finish(self) -> None:
        """Ends it, after a few rounds at least."""
        deadline = time.monotonic() + 10
        while len(self.seconds) < 15 and time.monotonic() < deadline:
            time.sleep(0.02)
        self.stopping.set()
        self.join(15)
