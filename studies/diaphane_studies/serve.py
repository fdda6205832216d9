"""The analysis as a service without state: POST /analyse?language=en with an export. It stores and logs no contents."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from . import export
from .texts import LANGUAGES

#: Seconds of one analysis. The API waits 60.
MOST_SECONDS = 50
MOST_ANSWER_BYTES = 8 << 20
#: Seconds without a byte after which a connection ends.
_IDLE_SECONDS = 15
#: Analyses run one after another, and a request waits this long for its turn.
_TURN_SECONDS = 8
_turn = threading.Lock()


class Handler(BaseHTTPRequestHandler):
    server_version, sys_version = "diaphane-studies", ""
    protocol_version = "HTTP/1.1"
    timeout = _IDLE_SECONDS

    def do_GET(self) -> None:
        known = self.path in ("/healthz", "/readyz")
        self._answer(HTTPStatus.OK if known else HTTPStatus.NOT_FOUND, {"status": "ok"} if known else {"error": "not found"})

    def do_POST(self) -> None:
        url = urlsplit(self.path)
        language = parse_qs(url.query).get("language", ["en"])[0]
        self.close_connection = True    # a body that was refused is not read
        if url.path != "/analyse":
            return self._answer(HTTPStatus.NOT_FOUND, {"error": "not found"})
        if language not in LANGUAGES:
            return self._answer(HTTPStatus.BAD_REQUEST, {"error": "language must be one of: " + ", ".join(LANGUAGES)})
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit()):
            return self._answer(HTTPStatus.LENGTH_REQUIRED, {"error": "the length of the body is missing"})
        if int(length) > export.MOST_BYTES:
            return self._answer(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, {"error": f"the export has more than {export.MOST_BYTES >> 20} MiB"})
        if not _turn.acquire(timeout=_TURN_SECONDS):
            return self._answer(HTTPStatus.SERVICE_UNAVAILABLE, {"error": "another analysis is running"})
        try:
            body = self.rfile.read(int(length))
            if len(body) == int(length):
                self._answer(*analysed(body, language))
        finally:
            _turn.release()

    def _answer(self, status: HTTPStatus, value: dict[str, Any] | bytes) -> None:
        body = value if isinstance(value, bytes) else json.dumps(value).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Logs nothing, because an address or a query is nobody's business."""


class Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: object, client_address: object) -> None:
        """Logs no trace of a connection that broke off, because that has the address."""


def analysed(body: bytes, language: str, seconds: float = MOST_SECONDS) -> tuple[HTTPStatus, dict[str, Any] | bytes]:
    """Analyses an export in a process of its own, which ends with the time, and takes nothing else down."""
    try:
        done = subprocess.run([sys.executable, "-m", f"{__package__}.serve", "--analyse", language], input=body, capture_output=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return HTTPStatus.SERVICE_UNAVAILABLE, {"error": f"the analysis takes longer than {seconds:g} s"}
    if done.returncode == _REFUSED:
        return HTTPStatus.UNPROCESSABLE_ENTITY, done.stdout
    if done.returncode != 0:
        print(f"an analysis ended with {done.returncode}", file=sys.stderr, flush=True)
        return HTTPStatus.INTERNAL_SERVER_ERROR, {"error": "the analysis failed"}
    if len(done.stdout) > MOST_ANSWER_BYTES:
        return HTTPStatus.INTERNAL_SERVER_ERROR, {"error": "the result is too large"}
    return HTTPStatus.OK, done.stdout


_REFUSED = 3


def _analyse(language: str) -> int:
    from . import report

    try:
        result: dict[str, Any] = report.as_json(report.analyse(export.parse(sys.stdin.buffer.read()), language))
        code = 0
    except export.ExportError as error:
        result, code = {"error": str(error)}, _REFUSED
    sys.stdout.write(json.dumps(result, ensure_ascii=False, allow_nan=False))
    return code


def main() -> int:
    if sys.argv[1:2] == ["--analyse"]:
        return _analyse(sys.argv[2])
    address, port = os.environ.get("DIAPHANE_ADDRESS", "127.0.0.1"), int(os.environ.get("DIAPHANE_PORT", "8095"))
    server = Server((address, port), Handler)
    signal.signal(signal.SIGTERM, lambda *_: threading.Thread(target=server.shutdown).start())
    print(f"listening on {address}:{port}", file=sys.stderr, flush=True)
    server.serve_forever()
    return 0


if __name__ == "__main__":
    sys.exit(main())
