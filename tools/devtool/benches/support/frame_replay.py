"""A moving picture, recorded from a real worker and played to a page at any rate. It measures the page alone on machines whose
renderer is slower. Runs in .tools/venv."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from dataclasses import dataclass
from typing import Iterator

from ...bench_client import Person

H264 = 2


@dataclass(frozen=True)
class Recorded:
    """The first messages of a connection and its frames, which start with a key frame: messages of `kinds`."""

    kinds: dict[str, type]
    config: object
    frames: list


def record(person: Person, data_set: str, width: int, height: int, turns: int) -> Recorded:
    """Records a rotation around the patient with a full-size frame per step, as a GPU would send them."""
    viewer = person.viewer(data_set, width, height, codec=H264)
    try:
        scene = viewer.config.scene
        eye, target = scene.camera.eye, scene.camera.target
        across, deep = eye.x - target.x, eye.y - target.y
        frames = [viewer.frame()]
        for turn in range(1, turns + 1):
            angle = 2 * math.pi * turn / turns
            eye.x = target.x + across * math.cos(angle) - deep * math.sin(angle)
            eye.y = target.y + across * math.sin(angle) + deep * math.cos(angle)
            wanted = viewer.send_scene(scene, rest=True)
            while frames[-1].input_seq < wanted or frames[-1].width < width:
                frames.append(viewer.frame())
        return Recorded(viewer.messages, viewer.config, frames)
    finally:
        viewer.close()


#: Limit of renderd: no picture is sent while this many are unacknowledged
#: (renderd/session/pictures.h).
IN_FLIGHT = 2


class Played:
    """What was played: the sent pictures and the acknowledgements of the page."""

    def __init__(self) -> None:
        self.over = threading.Event()
        self.sent: list[float] = []     # seconds since the first one, by number
        self.held_back = 0              # pictures that were skipped because too many were unacknowledged
        self.presented: set[int] = set()
        self._acknowledged: set[int] = set()
        self._wants_key = False
        self._lock = threading.Lock()

    def hear(self, message) -> None:
        with self._lock:
            self._wants_key |= message.HasField("need_key")
            if message.ack.seq:
                self._acknowledged.add(message.ack.seq)
            if message.ack.presented_us:
                self.presented.add(message.ack.seq)

    def has_room(self) -> bool:
        with self._lock:
            return len(self.sent) - len(self._acknowledged) < IN_FLIGHT

    def take_key_wish(self) -> bool:
        with self._lock:
            wanted, self._wants_key = self._wants_key, False
            return wanted


def _play(socket, recorded: Recorded, rate: float, seconds: float, played: Played) -> None:
    """Plays the recorded frames in a loop, numbered as those of one connection."""
    begun, turn = time.monotonic(), 0
    message = recorded.kinds["ServerMessage"]()
    for tick in range(int(rate * seconds)):
        time.sleep(max(0.0, begun + tick / rate - time.monotonic()))
        if not played.has_room():
            played.held_back += 1
            continue
        if played.take_key_wish():
            turn = 0
        message.frame.CopyFrom(recorded.frames[turn % len(recorded.frames)])
        message.frame.seq = message.frame.epoch = len(played.sent) + 1
        turn += 1
        played.sent.append(time.monotonic() - begun)
        socket.send(message.SerializeToString())
    played.over.set()


@contextlib.contextmanager
def player(recorded: Recorded, rate: float, seconds: float) -> Iterator[tuple[int, Played]]:
    """Yields the port of a WebSocket server that plays to its visitor, and the result."""
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.server import serve

    played = Played()

    def hear(socket) -> None:
        with contextlib.suppress(ConnectionClosed):
            for received in socket:
                played.hear(recorded.kinds["ClientMessage"].FromString(received))

    def meet(socket) -> None:
        socket.recv()  # Hello
        socket.send(recorded.kinds["ServerMessage"](config=recorded.config).SerializeToString())
        hearing = threading.Thread(target=hear, args=(socket,), daemon=True)
        hearing.start()
        with contextlib.suppress(ConnectionClosed):
            _play(socket, recorded, rate, seconds, played)
        hearing.join()  # the page closes first

    with serve(meet, "127.0.0.1", 0, subprotocols=["diaphane.v1"], compression=None, max_size=None) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.socket.getsockname()[1], played
        server.shutdown()
