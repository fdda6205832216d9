"""The gateway as a service. api sends JSON with the shared key, and the edge passes on what senders store with STOW-RS."""

from __future__ import annotations

import hmac
import json
import logging
import os
import re
import signal
import socket
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from . import limits, results, settings, stow
from .errors import STATUS, ArchiveError
from .intake import Intake
from .jobs import Jobs, Order, client_of
from .metrics import METRICS
from .receiver import StoreReceiver
from .series_file import is_uid
from .spool import Spool, SpoolError

#: Seconds without a byte after which a connection ends.
_CONNECTION_SECONDS = 30
#: Seconds for which the rest of a refused body is read after the response.
_LINGER_SECONDS = 5
_MOST_BODY = 64 << 10
_stow_places = threading.BoundedSemaphore(limits.MOST_STOW)


class Gateway:
    """The operations that api calls. Each takes and returns a JSON object."""

    def __init__(self, known: settings.Settings, api_url: str, key: str, spool: Spool):
        self.settings, self.key = known, key
        self.jobs = Jobs(known, api_url)
        self.intake = Intake(api_url, known.quiet_seconds, spool, known.receiver.callers if known.receiver else None)
        self.operations: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
            "/archives": self.archives, "/studies": self.studies, "/series": self.series,
            "/fetch": self.fetch, "/fetch/status": self.status, "/fetch/cancel": self.cancel}

    def archives(self, _body: dict[str, Any]) -> dict[str, Any]:
        return {"items": [{"name": one.name, "title": one.title} for one in self.settings.archives.values()]}

    def studies(self, body: dict[str, Any]) -> dict[str, Any]:
        search = results.Search.of(body)
        return self._ask(body, "search", lambda client: results.studies(client.studies(search)))

    def series(self, body: dict[str, Any]) -> dict[str, Any]:
        study = _uid(body, "study")
        return self._ask(body, "series", lambda client: results.series(client.series(study), study))

    def fetch(self, body: dict[str, Any]) -> dict[str, Any]:
        archive = self._archive(body)
        return self.jobs.start(Order(archive.name, _text(body, "account"), _text(body, "token"), _uid(body, "study"), _uid(body, "series"),
                                     _text(body, "title"))).shown()

    def status(self, body: dict[str, Any]) -> dict[str, Any]:
        return self.jobs.find(_text(body, "archive"), _text(body, "account"), _text(body, "id")).shown()

    def cancel(self, body: dict[str, Any]) -> dict[str, Any]:
        job = self.jobs.find(_text(body, "archive"), _text(body, "account"), _text(body, "id"))
        job.stopped.set()
        return job.shown()

    def _archive(self, body: dict[str, Any]) -> settings.WebArchive | settings.DimseArchive:
        found = self.settings.archives.get(_text(body, "archive"))
        if found is None:
            raise ArchiveError("not-found", "there is no such archive")
        return found

    def _ask(self, body: dict[str, Any], operation: str, ask: Callable[[Any], dict[str, Any]]) -> dict[str, Any]:
        archive = self._archive(body)
        with METRICS.measure(archive.name, operation) as measured:
            client = client_of(archive)
            # Ends a search whose response arrives too slowly to be seen as idle.
            late = threading.Timer(limits.SEARCH_SECONDS, client.close)
            late.start()
            try:
                return ask(client)
            except ArchiveError as error:
                measured.failed = error.kind
                print(f"{operation} in {archive.name} failed: {error}", file=sys.stderr, flush=True)
                raise
            finally:
                late.cancel()
                client.close()


def _text(body: dict[str, Any], name: str) -> str:
    value = body.get(name)
    if not isinstance(value, str) or len(value) > 400:
        raise ArchiveError("invalid", f"{name} is missing or invalid")
    return value


def _uid(body: dict[str, Any], name: str) -> str:
    value = _text(body, name)
    if not is_uid(value):
        raise ArchiveError("invalid", f"{name} is not a UID")
    return value


class Handler(BaseHTTPRequestHandler):
    server: Server
    server_version, sys_version = "diaphane-pacs", ""
    protocol_version = "HTTP/1.1"
    timeout = _CONNECTION_SECONDS

    def do_GET(self) -> None:
        if self.path == "/metrics":
            return self._answer(HTTPStatus.OK, METRICS.text(), "text/plain; version=0.0.4")
        known = self.path in ("/healthz", "/readyz")
        return self._json(HTTPStatus.OK if known else HTTPStatus.NOT_FOUND, {"status": "ok"} if known else {"error": "not-found"})

    def do_POST(self) -> None:
        self.close_connection = True    # a body that was refused is not read
        length = self.headers.get("Content-Length", "")
        chunked = self.headers.get("Transfer-Encoding", "").lower() == "chunked"
        if self.path == "/dicom-web/studies" and chunked and not length:
            return self._stow(None)
        if chunked or not (length.isascii() and length.isdigit() and len(length) < 16):
            return self._json(HTTPStatus.LENGTH_REQUIRED, {"error": "invalid"})
        if self.path == "/dicom-web/studies":
            return self._stow(int(length))
        gateway, operation = self.server.gateway, self.server.gateway.operations.get(self.path)
        if not hmac.compare_digest(self._bearer().encode(), gateway.key.encode()):
            return self._json(HTTPStatus.UNAUTHORIZED, {"error": "unauthenticated"})
        if operation is None or int(length) > _MOST_BODY:
            return self._json(HTTPStatus.NOT_FOUND, {"error": "not-found"})
        try:
            body = json.loads(self.rfile.read(int(length)))
            if not isinstance(body, dict):
                raise ArchiveError("invalid", "the body is not an object")
            return self._json(HTTPStatus.OK, operation(body))
        except ArchiveError as error:
            return self._json(HTTPStatus(STATUS[error.kind]), {"error": error.kind, "detail": str(error)})
        except ValueError:
            return self._json(HTTPStatus.BAD_REQUEST, {"error": "invalid"})

    def _stow(self, length: int | None) -> None:
        """Stores what a sender sends. A body without a length is chunked."""
        intake = self.server.gateway.intake
        if (length or 0) > min(limits.MOST_SERIES_BYTES, intake.spool.most_bytes):
            return self._json(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, {"error": "too-large"})
        if (length or 1) > intake.spool.free:
            return self._json(HTTPStatus.SERVICE_UNAVAILABLE, {"error": "no-room"})
        if not _stow_places.acquire(blocking=False):
            return self._json(HTTPStatus.SERVICE_UNAVAILABLE, {"error": "busy"})
        try:
            pieces = self._chunks() if length is None else self._pieces(length)
            status, document = stow.receive(intake, self._bearer(), self.headers.get("Content-Type", ""), pieces)
            return self._answer(status, json.dumps(document).encode(), "application/dicom+json")
        except ArchiveError as error:
            status = {"unauthorised": HTTPStatus.FORBIDDEN, "busy": HTTPStatus.SERVICE_UNAVAILABLE}.get(error.kind, HTTPStatus.BAD_REQUEST)
            return self._json(status, {"error": error.kind, "detail": str(error)})
        finally:
            _stow_places.release()

    def _pieces(self, length: int) -> Iterator[bytes]:
        while length > 0:
            try:
                piece = self.rfile.read1(min(length, 1 << 20))
            except OSError:
                return
            if not piece:
                return
            length -= len(piece)
            yield piece

    def _chunks(self) -> Iterator[bytes]:
        """Yields a chunked body (RFC 9112, 7.1). One that is malformed ends early, like one that is cut off."""
        while True:
            try:
                line = self.rfile.readline(limits.MOST_CHUNK_LINE)
            except OSError:
                return
            size = line.partition(b";")[0].strip()
            if not line.endswith(b"\n") or not re.fullmatch(rb"[0-9A-Fa-f]{1,8}", size) or int(size, 16) == 0:
                return
            yield from self._pieces(int(size, 16))
            if self.rfile.read(2) != b"\r\n":
                return

    def _bearer(self) -> str:
        return self.headers.get("Authorization", "").removeprefix("Bearer ")

    def _json(self, status: HTTPStatus, value: dict[str, Any]) -> None:
        self._answer(status, json.dumps(value, ensure_ascii=False).encode(), "application/json")

    def _answer(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Logs no request. What fails is logged where it fails."""


class Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address: tuple[str, int], gateway: Gateway):
        super().__init__(address, Handler)
        self.gateway = gateway

    def shutdown_request(self, request: socket.socket | tuple[bytes, socket.socket]) -> None:
        """Ends a connection without losing the response. Closing one whose body is unread resets it, and a sender that is still
        writing then never sees why it was refused.
        """
        assert isinstance(request, socket.socket)
        end = time.monotonic() + _LINGER_SECONDS
        try:
            request.shutdown(socket.SHUT_WR)
            while (left := end - time.monotonic()) > 0:
                request.settimeout(left)
                if not request.recv(1 << 16):
                    break
        except OSError:
            pass    # the other side is gone, or was too slow
        self.close_request(request)

    def handle_error(self, request: object, client_address: object) -> None:
        """Logs only the type of an error, because its message may quote what was sent."""
        print(f"a request failed with {type(sys.exc_info()[1]).__name__}", file=sys.stderr, flush=True)


def spool_bytes(megabytes: str) -> int:
    """Returns the limit of the spool. Raises SpoolError for an invalid one."""
    if not megabytes:
        return limits.SPOOL_BYTES
    if not (megabytes.isascii() and megabytes.isdigit() and 0 < len(megabytes) < 10 and int(megabytes) > 0):
        raise SpoolError("DIAPHANE_SPOOL_MB must be a number of MiB")
    return int(megabytes) << 20


def main() -> int:
    environment = os.environ
    # The libraries quote values of files in their messages.
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    address, port = environment.get("DIAPHANE_ADDRESS", "127.0.0.1"), int(environment.get("DIAPHANE_PORT", "8096"))
    try:
        known = settings.read(Path(environment.get("DIAPHANE_ARCHIVES", "archives.toml")))
        key = settings.read_secret(Path(environment.get("DIAPHANE_ARCHIVE_KEY", "archive-key")), settings.LEAST_SECRET)
    except settings.SettingsError as error:
        print(error, file=sys.stderr, flush=True)
        return os.EX_CONFIG    # a restart would not help
    try:
        spool = Spool(Path(environment.get("DIAPHANE_SPOOL_DIR", "spool")), spool_bytes(environment.get("DIAPHANE_SPOOL_MB", "")), key)
    except SpoolError as error:
        print(error, file=sys.stderr, flush=True)
        return os.EX_TEMPFAIL
    gateway = Gateway(known, environment.get("DIAPHANE_API_URL", "http://127.0.0.1:8080"), key, spool)
    receiver = StoreReceiver(known.receiver, gateway.intake) if known.receiver else None
    if receiver:
        receiver.start()
    server = Server((address, port), gateway)
    signal.signal(signal.SIGTERM, lambda *_: threading.Thread(target=server.shutdown).start())
    print(f"listening on {address}:{port}", file=sys.stderr, flush=True)
    server.serve_forever()
    gateway.jobs.stop()
    gateway.intake.stop()
    if receiver:
        receiver.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
