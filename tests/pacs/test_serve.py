"""The HTTP server of the PACS gateway."""

from __future__ import annotations

import select
import socket
import threading
from types import SimpleNamespace

from diaphane_pacs.serve import Server

MEGABYTE = 1 << 20


def test_a_sender_that_is_still_writing_sees_why_it_is_refused():
    server = Server(("127.0.0.1", 0), SimpleNamespace(intake=SimpleNamespace(spool=SimpleNamespace(most_bytes=MEGABYTE, free=MEGABYTE))))
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        with socket.create_connection(server.server_address, timeout=30) as sender:
            sender.sendall(f"POST /dicom-web/studies HTTP/1.1\r\nContent-Length: {8 * MEGABYTE}\r\n\r\n".encode() + bytes(MEGABYTE))
            select.select([sender], [], [], 30)
            for _ in range(7):    # the response is already there
                sender.sendall(bytes(MEGABYTE))
            sender.shutdown(socket.SHUT_WR)
            answer = sender.makefile("rb").read()
        assert answer.startswith(b"HTTP/1.1 413 ") and answer.endswith(b'{"error": "too-large"}'), answer
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
