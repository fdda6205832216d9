"""Shared helpers of the gateway's tests: a viewer of the stream, and a scan to view."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import struct
import subprocess
import time
import uuid
from typing import Callable

from api_client import Person, ready_without_upload
from harness import TestStack, free_port, wait_until
from devtool.bench_client import messages
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

MESSAGES = messages()
ClientMessage, ServerMessage = MESSAGES["ClientMessage"], MESSAGES["ServerMessage"]

#: Seconds after which something that a viewer waits for will not come. No test is decided by it, because machines are busy.
PATIENCE_S = 60
# Programs that a stream needs.
PROGRAMS = ("postgres", "redis", "api", "gateway", "renderd", "edge")


def store_ball(stack: TestStack, owner: Person, size: int = 48) -> str:
    """Stores a ball of bone in air as a ready data set, as ingest would."""
    data_set = ready_without_upload(stack, owner)
    middle, radius = (size - 1) / 2, size * 0.35
    voxels = bytearray()
    for z in range(size):
        for y in range(size):
            for x in range(size):
                inside = (x - middle) ** 2 + (y - middle) ** 2 + (z - middle) ** 2 < radius**2
                voxels += struct.pack("<h", 1200 if inside else -1000)
    folder = stack.data_dir / "volumes" / data_set
    folder.mkdir()
    header = {
        "format": 1, "size": [size] * 3, "spacing": [2.0] * 3, "direction": [1, 0, 0, 0, 1, 0, 0, 0, 1], "modality": "CT",
        "minimum": -1000, "maximum": 1200, "percentiles": [-1000.0] * 5 + [1200.0] * 3,
        "contentHash": "blake2b:" + hashlib.blake2b(voxels, digest_size=32).hexdigest(),
    }
    (folder / "volume.json").write_text(json.dumps(header))
    (folder / "voxels.i16").write_bytes(voxels)
    for path in (folder, *folder.iterdir()):
        stack.stack.run_as.own(path)
    return data_set


def open_session(person: Person, data_set: str) -> tuple[str, str]:
    """Returns the session id and the stream URL. Like the page, it asks again after a 503: on a busy machine, a worker's heartbeat may
    be late, and then there is no worker for a moment."""
    def answered():
        answer = person.http.post("/v1/sessions", json={"data_set_id": data_set}, headers={"Idempotency-Key": uuid.uuid4().hex})
        return answer if answer.status_code != 503 else None

    answer = wait_until(answered, PATIENCE_S, "a worker for the session")
    assert answer.status_code == 201, answer.text
    return answer.json()["session_id"], answer.json()["stream_url"]


def new_ticket(person: Person, session: str) -> str | None:
    """Returns another stream URL, or None while no worker has a free slot."""
    answer = person.http.post(f"/v1/sessions/{session}/tickets")
    if answer.status_code == 503:
        assert "retry-after" in answer.headers
        return None
    assert answer.status_code == 201, answer.text
    return answer.json()["stream_url"]


def wait_ticket(person: Person, session: str) -> str:
    """Returns another stream URL as soon as a worker has a free slot."""
    return wait_until(lambda: new_ticket(person, session), PATIENCE_S, "a ticket")


def wait_saved(stack: TestStack, session: str, input_seq: int) -> None:
    """Waits until the worker has saved the scene with this number, with which a successor would continue."""
    wait_until(lambda: int(stack.redis.hget(f"diaphane:session:{session}", "input_seq") or 0) >= input_seq, PATIENCE_S, "the saved scene")


class OtherWorker:
    """A second renderd on the stack's volumes. Without `redis`, it looks for one where none is, and so gets no sessions."""

    def __init__(self, stack: TestStack, name: str, *options: str, redis: str | None = None):
        self.stack, self.port, self.admin_port, self.process = stack, free_port(), free_port(), None
        self.log = stack.data_dir / "logs" / f"{name}.log"
        self.argv = [str(stack.stack.layout.bin / "diaphane-renderd"), f"--worker-id={name}", f"--redis={redis or f'127.0.0.1:{free_port()}'}",
                     f"--grpc-port={self.port}", f"--advertise=127.0.0.1:{self.port}", f"--admin-port={self.admin_port}", "--engine=cpu",
                     "--threads=1", f"--volume-dir={stack.data_dir / 'volumes'}", *options]

    def start(self) -> None:
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(self.argv, stderr=log, **self.stack.stack.run_as.popen())

    def kill(self) -> None:
        if self.process and self.process.poll() is None:
            os.kill(self.process.pid, signal.SIGKILL)
            self.process.wait()

    def loads(self) -> int:
        return self.log.read_text().count('"volume_loaded"')


class Viewer:
    """Speaks diaphane.v1 like the page: greets, acknowledges each frame, and sends scenes."""

    def __init__(self, origin: str, stream_url: str, side: int = 96, greet: bool = True, port: int | None = None,
                 codec: int = 1):
        base = f"ws://127.0.0.1:{port}" if port else origin.replace("http", "ws", 1)
        # Like a browser, it sends no pings. Their answers would wait behind frames that a test does not read.
        self.socket = connect(base + stream_url, origin=origin, subprotocols=["diaphane.v1"], compression=None, max_size=None,
                              open_timeout=PATIENCE_S, close_timeout=2, ping_interval=None)
        self.input_seq = 0
        self.config = None
        if greet:
            hello = ClientMessage()
            hello.hello.protocol = 1
            hello.hello.codecs.append(codec)
            hello.hello.pixel_ratio = 1
            hello.hello.viewport.width = hello.hello.viewport.height = side
            self.send(hello)
            self.config = self.until("config")
            self.input_seq = self.config.input_seq

    def send(self, message) -> None:
        self.socket.send(message.SerializeToString())

    def receive(self, timeout: float = PATIENCE_S):
        message = ServerMessage.FromString(self.socket.recv(timeout))
        if message.WhichOneof("body") == "frame":
            ack = ClientMessage()
            ack.ack.seq, ack.ack.epoch = message.frame.seq, message.frame.epoch
            ack.ack.received_us = ack.ack.decoded_us = ack.ack.presented_us = time.monotonic_ns() // 1000
            self.send(ack)
        return message

    def until(self, kind: str, timeout: float = PATIENCE_S, condition=lambda _: True):
        deadline = time.monotonic() + timeout
        while (left := deadline - time.monotonic()) > 0:
            message = self.receive(left)
            if message.WhichOneof("body") == kind and condition(getattr(message, kind)):
                return getattr(message, kind)
        raise AssertionError(f"no such {kind} within {timeout} s")

    def frame(self, timeout: float = PATIENCE_S, condition=lambda _: True):
        return self.until("frame", timeout, condition)

    def turn(self, degrees_like: float) -> int:
        """Moves the eye and returns the number of the input."""
        update = ClientMessage()
        self.input_seq += 1
        update.scene.input_seq = self.input_seq
        update.scene.scene.CopyFrom(self.config.scene)
        update.scene.scene.camera.eye.x += degrees_like
        self.config.scene.CopyFrom(update.scene.scene)
        self.send(update)
        return self.input_seq

    def close_code(self, timeout: float = PATIENCE_S) -> int:
        """Reads to the end. Returns the close code of the stream, or 1006 if the connection was lost."""
        deadline = time.monotonic() + timeout
        try:
            while True:
                self.socket.recv(max(0.0, deadline - time.monotonic()))
        except ConnectionClosed as closed:
            return closed.rcvd.code if closed.rcvd else 1006

    def leave(self) -> None:
        self.socket.close()


def come_back(viewer_of: Callable[[], Viewer | None]) -> Viewer:
    """Tries to connect again until there is a viewer."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        try:
            if viewer := viewer_of():
                return viewer
        except Exception:  # noqa: BLE001 - not yet
            pass
        time.sleep(0.05)
    raise AssertionError(f"the picture was not back within {PATIENCE_S} s")
