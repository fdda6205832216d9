"""Shared helpers of the edge's tests: raw connections, an ordinary client in parallel, and the resources of the programs."""

from __future__ import annotations

import http.client
import json
import re
import socket
import threading
import time
from collections import Counter
from pathlib import Path

#: May directly follow a body without a line end.
STATUS_LINE = re.compile(rb"HTTP/1\.[01] (\d{3}) ?[A-Za-z -]*\r\n")


def connect(port: int, source: str = "127.0.0.66", timeout: float = 60.0) -> socket.socket:
    """Connects from another address, because limits are by address."""
    return socket.create_connection(("127.0.0.1", port), timeout=timeout, source_address=(source, 0))


def talk(port: int, data: bytes, source: str = "127.0.0.66", silence_s: float = 5.0) -> bytes:
    """Returns everything until the other side closes or is silent after an answer, or b"" if it just closes."""
    with connect(port, source) as one:
        try:
            one.sendall(data)
        except OSError:
            pass  # refused while still sending
        return read_all(one, silence_s)


def read_all(one: socket.socket, silence_s: float = 5.0) -> bytes:
    got = bytearray()
    try:
        while part := one.recv(65536):
            got += part
            one.settimeout(silence_s)
    except ConnectionResetError:
        pass
    except TimeoutError:
        if not got:
            raise  # else: answered, and kept open for a while so that the response arrives
    return bytes(got)


def statuses(answer: bytes) -> list[int]:
    return [int(found) for found in STATUS_LINE.findall(answer)]


def resident_mb(pid: int) -> float:
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


def requests_of(stack) -> Counter[str]:
    """Returns the number of requests that reached the API by operation ("none": without an operation)."""
    counted: Counter[str] = Counter()
    for name, value in re.findall(r'requests_total\{operation="(\w+)"[^}]*\} (\S+)', stack.metrics("api")):
        counted[name] += int(float(value))
    return counted


def family(pid: int) -> list[int]:
    """Returns the process and its children."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [pid, *map(int, children)]


def spooled(stack) -> int:
    """Returns the bytes of request bodies that the edge currently stores on disk, in unlinked files."""
    folder, found = str(stack.data_dir / "run" / "edge-body"), 0
    for pid in family(stack.pids["edge"]):
        for link in Path(f"/proc/{pid}/fd").iterdir():
            try:
                if str(link.readlink()).startswith(folder):
                    found += link.stat().st_size
            except FileNotFoundError:
                pass  # closed meanwhile
    return found


def part_head(url: str, length: int, *headers: str, offset: int = 0) -> bytes:
    """Returns the headers of a part of an upload."""
    lines = (f"PATCH {url} HTTP/1.1", "Host: localhost", "Tus-Resumable: 1.0.0", f"Upload-Offset: {offset}",
             "Content-Type: application/offset+octet-stream", f"Content-Length: {length}", *headers)
    return "".join(f"{line}\r\n" for line in lines).encode() + b"\r\n"


def signed(somebody) -> tuple[str, str]:
    """Returns the headers with which the page identifies its user."""
    return f"Cookie: diaphane={somebody.http.cookies['diaphane']}", f"X-CSRF-Token: {somebody.csrf}"


class Undisturbed:
    """A signed-in user who uses the page during an attack. Afterwards, reports errors and the size of the programs."""

    def __init__(self, stack, somebody, source: str = "127.0.0.2"):
        self.stack = stack
        self.pids = dict(stack.pids)
        self.before_mb = resident_mb(self.pids["api"])
        self.ordinary = Ordinary(stack.ports["edge"], somebody.http.cookies["diaphane"], somebody.id, source)
        self.ordinary.start()

    def faults(self, api_grows_mb: float = 100, edge_mb: float = 250) -> list[str]:
        """Ends it and returns the faults."""
        self.ordinary.finish()
        found = [f"{name} died" for name, pid in self.pids.items() if self.stack.pids.get(name) != pid]
        found += self.ordinary.wrong
        if len(self.ordinary.seconds) < 15:
            found.append(f"the ordinary client came round {len(self.ordinary.seconds)} times only")
        if not found:
            self.grown_mb = resident_mb(self.pids["api"]) - self.before_mb
            self.edge_mb = sum(resident_mb(pid) for pid in family(self.pids["edge"]))
            found += [f"the API grew by {self.grown_mb:.0f} MB"] if self.grown_mb >= api_grows_mb else []
            found += [f"the edge has {self.edge_mb:.0f} MB"] if self.edge_mb >= edge_mb else []
        return found


class Ordinary(threading.Thread):
    """A signed-in user who uses the page, by default from another address. Every response must belong to them."""

    def __init__(self, port: int, cookie: str, user_id: str, source: str = "127.0.0.2"):
        super().__init__(daemon=True)
        self.port, self.cookie, self.user_id, self.source = port, cookie, user_id, source
        self.stopping = threading.Event()
        self.seconds: list[float] = []
        self.wrong: list[str] = []

    def run(self) -> None:
        connection = None
        while not self.stopping.wait(0.01):
            begun = time.monotonic()
            try:
                connection = connection or http.client.HTTPConnection("127.0.0.1", self.port, timeout=10,
                                                                      source_address=(self.source, 0))
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
        """Ends it after at least a few rounds."""
        deadline = time.monotonic() + 60    # that they came at all is judged; how fast, by p99()
        while len(self.seconds) < 15 and time.monotonic() < deadline:
            time.sleep(0.02)
        self.stopping.set()
        self.join(15)
