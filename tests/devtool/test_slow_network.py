"""The tests' slow network behaves as specified, on which measurements through it rely."""

from __future__ import annotations

import socket
import struct
import sys
import threading
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from slow_network import SlowNetwork  # noqa: E402


def counted(begin: int, size: int) -> bytes:
    """Returns a piece of an endless text without long repetitions."""
    first, skip = divmod(begin, 4)
    return struct.pack(f">{size // 4 + 2}I", *range(first, first + size // 4 + 2))[skip:skip + size]


class Server:
    """Sends a counted text of that size to every client, or echoes what it receives."""

    def __init__(self, size: int = 0):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.size = size
        self.said = 0
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        peer, _ = self.listener.accept()
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        try:
            while self.said < self.size:
                self.said += peer.send(counted(self.said, min(4096, self.size - self.said)))
            while not self.size and (heard := peer.recv(1000)):
                peer.sendall(heard)
        except OSError:
            pass
        peer.close()


def read(connection: socket.socket, size: int) -> float:
    """Returns the seconds until this much of the counted text has arrived, in order."""
    begin, come = time.monotonic(), 0
    while come < size:
        data = connection.recv(65536)
        assert data and data == counted(come, len(data))
        come += len(data)
    return time.monotonic() - begin


def test_a_response_takes_a_round_trip():
    with SlowNetwork(Server().port, round_trip_s=0.1) as network, socket.create_connection(("127.0.0.1", network.port)) as here:
        for _ in range(3):
            begin = time.monotonic()
            here.sendall(counted(0, 8))
            read(here, 8)
            assert time.monotonic() - begin >= 0.1


@pytest.mark.parametrize("loss", [0.0, 0.3, 1.0])
def test_throughput_is_limited_and_a_loss_costs_a_round_trip(loss: float):
    size = 100_000
    with SlowNetwork(Server(size).port, round_trip_s=0.05, bits_per_s=4e6, loss=loss) as network, \
            socket.create_connection(("127.0.0.1", network.port)) as here:
        took = read(here, size)
        lost = network.to_viewer.lost
    assert took >= 8 * size / 4e6
    assert (lost > 0) == (loss > 0)
    assert network.to_viewer.bytes == size


def test_a_full_buffer_blocks_the_sender():
    server = Server(10_000_000)
    with SlowNetwork(server.port, bits_per_s=1e5, buffer_bytes=20_000) as network, \
            socket.create_connection(("127.0.0.1", network.port)):
        time.sleep(0.5)
        assert network.to_viewer.most_waiting <= 20_000
        assert server.said < 400_000  # the size of the kernel's buffers, rather than ten million
