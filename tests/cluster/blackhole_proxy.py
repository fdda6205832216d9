"""A connection that dies silently: a proxy in front of the API server that stops forwarding without closing anything."""

from __future__ import annotations

import socket
import threading
import time
from urllib.parse import urlsplit


class _Connection:
    def __init__(self, client: socket.socket, server: socket.socket):
        self.said = time.monotonic()
        self.moves = threading.Event()
        self.moves.set()
        self.sockets = (client, server)
        for source, to, up in ((client, server, True), (server, client, False)):
            threading.Thread(target=self._pass_on, args=(source, to, up), daemon=True).start()

    def _pass_on(self, source: socket.socket, to: socket.socket, up: bool) -> None:
        try:
            while data := source.recv(1 << 16):
                if up:
                    self.said = time.monotonic()
                self.moves.wait()
                to.sendall(data)
        except OSError:
            pass
        self.close()

    def close(self) -> None:
        for one in self.sockets:
            try:
                one.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass


class BlackholeProxy:
    def __init__(self, server: str):
        self._to = (urlsplit(server).hostname, urlsplit(server).port)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"https://127.0.0.1:{self._listener.getsockname()[1]}"
        self._connections: list[_Connection] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
                self._connections.append(_Connection(client, socket.create_connection(self._to)))
            except OSError:
                return

    def stick(self) -> int:
        """From the next message on, blocks both directions of all connections that are silent at that time, which are watches and
        kept connections. New connections work as usual. Returns the number of blocked ones."""
        since = time.monotonic()
        while not any(one.said > since for one in self._connections):
            time.sleep(0.05)
        stuck = [one for one in self._connections if one.said <= since]
        for one in stuck:
            one.moves.clear()
        return len(stuck)

    def close(self) -> None:
        self._listener.close()
        for one in self._connections:
            one.moves.set()
            one.close()
