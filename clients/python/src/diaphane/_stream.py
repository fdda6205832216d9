"""The stream between a client and its render worker (api/proto/stream.proto), over a WebSocket."""

from __future__ import annotations

import contextlib
import io
import time
from typing import Any

from google.protobuf.message import DecodeError
from PIL import Image
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import connect

from ._generated import stream_pb2 as pb
from .errors import ConnectionLost, StreamError, WaitedTooLong

_SUBPROTOCOL: Any = "diaphane.v1"
_PROTOCOL = 1


class Stream:
    """A connection that acknowledges every picture, because the renderer stops after a few unacknowledged ones."""

    def __init__(self, origin: str, stream_url: str, width: int, height: int, timeout: float):
        self.timeout = timeout
        # Newer versions of websockets connect only on entering the context.
        self._open = contextlib.ExitStack()
        try:
            self._socket = self._open.enter_context(connect(
                "ws" + origin.removeprefix("http") + stream_url, origin=origin, subprotocols=[_SUBPROTOCOL],  # type: ignore[arg-type]
                compression=None, max_size=None, open_timeout=timeout, close_timeout=2))
        except (OSError, InvalidHandshake, TimeoutError) as error:
            raise ConnectionLost(f"the stream of {origin} cannot be opened: {error}") from error
        try:
            self.config = self._greet(width, height)
        except BaseException:
            self.close()
            raise
        self.viewport = (width, height)
        self._input_seq = int(self.config.input_seq)

    def _greet(self, width: int, height: int) -> pb.Config:
        hello = pb.Hello(protocol=_PROTOCOL, codecs=[pb.JPEG], stills=[pb.PNG], pixel_ratio=1, viewport=pb.Viewport(width=width, height=height))
        self.send(pb.ClientMessage(hello=hello))
        config: pb.Config = self.until("config")
        return config

    def close(self) -> None:
        self._open.close()

    def send(self, message: pb.ClientMessage) -> None:
        try:
            self._socket.send(message.SerializeToString())
        except ConnectionClosed as error:
            raise ConnectionLost(f"the stream was closed: {error}") from error

    def send_scene(self, scene: Any, width: int, height: int, error: float, samples: int) -> int:
        """Requests one picture, without denoising. Returns the number of the input."""
        self._input_seq += 1
        effort = pb.Effort(stop_error=error, stop_samples=samples)
        self.viewport = (width, height)
        self.send(pb.ClientMessage(scene=pb.SceneUpdate(input_seq=self._input_seq, scene=scene, viewport=pb.Viewport(width=width, height=height),
                                                        raw=True, rest=True, effort=effort)))
        return self._input_seq

    def receive(self, deadline: float) -> pb.ServerMessage:
        """Returns the next message. Raises StreamError for a refusal."""
        try:
            data = self._socket.recv(max(0.0, deadline - time.monotonic()))
        except TimeoutError as error:
            raise WaitedTooLong("the renderer did not answer in time") from error
        except ConnectionClosed as closed:
            raise ConnectionLost(f"the stream was closed: {closed}") from closed
        if not isinstance(data, bytes):
            raise StreamError("invalid", "the server sent text instead of a message")
        try:
            message = pb.ServerMessage.FromString(data)
        except DecodeError as error:
            raise StreamError("invalid", "the server sent a message that cannot be read") from error
        kind = message.WhichOneof("body")
        if kind == "problem":
            problem = message.problem
            raise StreamError(problem.code, problem.message, problem.field)
        if kind == "frame":
            self._acknowledge(message.frame.seq, message.frame.epoch)
        elif kind == "still":
            self._acknowledge(message.still.seq, message.still.epoch)
        return message

    def until(self, kind: str) -> Any:
        """Returns the content of the next message of this kind."""
        deadline = time.monotonic() + self.timeout
        while True:
            message = self.receive(deadline)
            if message.WhichOneof("body") == kind:
                return getattr(message, kind)

    def _acknowledge(self, seq: int, epoch: int) -> None:
        now = time.monotonic_ns() // 1000
        self.send(pb.ClientMessage(ack=pb.Ack(seq=seq, epoch=epoch, received_us=now, decoded_us=now, presented_us=now)))


class FinalPicture:
    """Collects the messages of one input until its final picture is complete."""

    def __init__(self, input_seq: int):
        self._input_seq = input_seq
        self._tiles: dict[int, pb.Still] = {}
        self._frame: pb.Frame | None = None
        self._state: pb.State | None = None

    def add(self, message: pb.ServerMessage) -> None:
        kind = message.WhichOneof("body")
        if kind == "frame" and message.frame.input_seq >= self._input_seq:
            if self._frame is None or message.frame.epoch != self._frame.epoch:
                self._tiles.clear()
                self._state = None
            self._frame = message.frame
        elif kind == "still" and self._frame is not None and message.still.epoch == self._frame.epoch:
            if any(one.iteration != message.still.iteration for one in self._tiles.values()):
                self._tiles.clear()
            self._tiles[message.still.tile] = message.still
        elif kind == "state" and self._frame is not None and message.state.epoch == self._frame.epoch:
            self._state = message.state

    @property
    def complete(self) -> bool:
        if self._state is None or not self._state.converged or not self._state.lossless:
            return False
        return bool(self._tiles) and len(self._tiles) == next(iter(self._tiles.values())).tiles

    @property
    def error(self) -> float:
        return next(iter(self._tiles.values())).error

    @property
    def samples(self) -> int:
        return next(iter(self._tiles.values())).iteration

    def image(self) -> Image.Image:
        width = max(one.x + one.width for one in self._tiles.values())
        height = max(one.y + one.height for one in self._tiles.values())
        image = Image.new("RGB", (width, height))
        for one in self._tiles.values():
            image.paste(Image.open(io.BytesIO(one.data)).convert("RGB"), (one.x, one.y))
        return image
