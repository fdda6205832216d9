"""A slow network between a viewer and the programs: a TCP proxy that delays, limits and loses.

    with SlowNetwork(port, round_trip_s=0.1, bits_per_s=2e6) as network:
        connect to network.port

Each way has a link of its own. What arrives waits in a buffer like a router's, leaves at the link's rate, and is there half a
round trip later. A full buffer takes nothing more, so that the sender's TCP stops. A lost packet is what TCP makes of it: all
that follows stands still until it has been sent again, one round trip later."""

from __future__ import annotations

import asyncio
import random
import socket
import threading
from dataclasses import dataclass, field

PACKET = 1448  # bytes of payload
SOCKET_BUFFER = 16 << 10  # as small as possible, so that data waits in the link's own buffer


@dataclass
class Counts:
    """Counts of one direction over all connections."""

    bytes: int = 0
    lost: int = 0
    most_waiting: int = 0


@dataclass(frozen=True)
class Link:
    round_trip_s: float
    bits_per_s: float  # 0: no limit
    buffer_bytes: int
    loss: float  # share of lost packets


@dataclass
class _Way:
    """One direction of one connection."""

    link: Link
    chance: random.Random
    counts: Counts
    record: bytearray | None = None
    waiting: int = 0
    free_at: float = 0.0  # when the link has sent its current data
    last_there: float = 0.0
    queue: asyncio.Queue = field(default_factory=asyncio.Queue)
    room: asyncio.Event = field(default_factory=asyncio.Event)

    async def take(self, reader: asyncio.StreamReader) -> None:
        loop = asyncio.get_running_loop()
        while data := await reader.read(PACKET):
            if self.record is not None:
                self.record += data
            while self.waiting + len(data) > self.link.buffer_bytes:
                self.room.clear()
                await self.room.wait()
            now = loop.time()
            self.free_at = max(now, self.free_at)
            if self.link.bits_per_s:
                self.free_at += 8 * len(data) / self.link.bits_per_s
            there = self.free_at + self.link.round_trip_s / 2
            if self.chance.random() < self.link.loss:
                self.counts.lost += 1
                there += self.link.round_trip_s
            # Later data waits for it. Each delivery gets its own time, because timers with equal times fire in any order.
            self.last_there = max(there, self.last_there + 1e-6)
            self.waiting += len(data)
            self.counts.most_waiting = max(self.counts.most_waiting, self.waiting)
            self.queue.put_nowait((self.free_at, self.last_there, data))
        self.queue.put_nowait(None)

    async def give(self, writer: asyncio.StreamWriter) -> None:
        loop = asyncio.get_running_loop()
        while packet := await self.queue.get():
            left_at, there_at, data = packet
            await asyncio.sleep(max(0.0, left_at - loop.time()))
            self.waiting -= len(data)
            self.room.set()
            # A packet in transit uses no buffer space, and the next one follows while it travels.
            loop.call_at(there_at, self.deliver, writer, data)
        # The last packet may have been lost and arrive a round trip later than others.
        await asyncio.sleep(max(0.0, self.last_there - loop.time()) + 0.001)
        if not writer.is_closing():
            writer.close()

    def deliver(self, writer: asyncio.StreamWriter, data: bytes) -> None:
        if not writer.is_closing():
            self.counts.bytes += len(data)
            writer.write(data)


class SlowNetwork:
    """Runs in its own thread until it is closed."""

    def __init__(self, target_port: int, round_trip_s: float = 0.0, bits_per_s: float = 0.0,
                 buffer_bytes: int = 32 << 10, loss: float = 0.0, seed: int = 1, socks: bool = False,
                 record: bool = False):
        """`socks`: a browser connects with --proxy-server=socks5://..., and every address that it requests is the target.
        `record`: stores what viewers send in `sent`, a bytearray per connection."""
        self.socks, self.record = socks, record
        self.sent: list[bytearray] = []
        self.link = Link(round_trip_s, bits_per_s, buffer_bytes, loss)
        self.target_port = target_port
        self.to_viewer, self.to_server = Counts(), Counts()
        self.port = 0
        self.chance_ = random.Random(seed)
        self.loop_ = asyncio.new_event_loop()
        self.ready_ = threading.Event()
        self.thread_ = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> SlowNetwork:
        self.thread_.start()
        assert self.ready_.wait(60)
        return self

    def __exit__(self, *_: object) -> None:
        self.loop_.call_soon_threadsafe(self.loop_.stop)
        self.thread_.join(5)

    def _run(self) -> None:
        asyncio.set_event_loop(self.loop_)
        listener = socket.socket()
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SOCKET_BUFFER)  # accepted sockets inherit both sizes
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SOCKET_BUFFER)
        listener.bind(("127.0.0.1", 0))
        server = self.loop_.run_until_complete(asyncio.start_server(self._viewer, sock=listener, limit=PACKET))
        self.port = listener.getsockname()[1]
        self.ready_.set()
        self.loop_.run_forever()
        server.close()
        for task in asyncio.all_tasks(self.loop_):
            task.cancel()
        self.loop_.run_until_complete(asyncio.sleep(0))
        self.loop_.run_until_complete(self.loop_.shutdown_asyncgens())
        self.loop_.close()

    @staticmethod
    async def _greet(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """SOCKS 5 without a password: the methods, then the address, of which only the length matters."""
        _, methods = await reader.readexactly(2)
        await reader.readexactly(methods)
        writer.write(b"\5\0")
        *_, kind = await reader.readexactly(4)
        length = {1: 4, 4: 16}.get(kind) or (await reader.readexactly(1))[0]
        await reader.readexactly(length + 2)
        writer.write(b"\5\0\0\1" + bytes(6))

    async def _viewer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self.socks:
            await self._greet(reader, writer)
        upstream = socket.socket()
        upstream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SOCKET_BUFFER)
        upstream.setblocking(False)
        await self.loop_.sock_connect(upstream, ("127.0.0.1", self.target_port))
        from_server, to_server = await asyncio.open_connection(sock=upstream, limit=PACKET)
        for end in (writer, to_server):
            end.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        down = _Way(self.link, self.chance_, self.to_viewer)
        up = _Way(self.link, self.chance_, self.to_server, bytearray() if self.record else None)
        if up.record is not None:
            self.sent.append(up.record)
        work = [down.take(from_server), down.give(writer), up.take(reader), up.give(to_server)]
        try:
            await asyncio.gather(*work)
        except (ConnectionError, asyncio.CancelledError):
            pass
        finally:
            for end in (writer, to_server):
                if not end.is_closing():
                    end.close()
