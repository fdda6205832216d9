"""An HTTP server in place of the analysis of studies."""

from __future__ import annotations

import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any


class AnalysisDouble:
    """Answers every export with `answer`, a document or bytes, and keeps the exports."""

    def __init__(self) -> None:
        double = self
        self.status, self.answer, self.seen = 200, {"sections": [], "adoptable": {"comfort": None, "tours": []}}, []  # type: ignore[var-annotated]

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                double.seen.append((self.path, json.loads(body)))
                reply: Any = double.answer if isinstance(double.answer, bytes) else json.dumps(double.answer).encode()
                self.send_response(double.status)
                self.send_header("Content-Length", str(len(reply)))
                self.end_headers()
                self.wfile.write(reply)

            def log_message(self, *_: Any) -> None:
                """Logs nothing."""

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def close(self) -> None:
        self.server.shutdown()
        self.server.server_close()
