"""A DICOMweb server that lies. The first part of the path chooses how."""

from __future__ import annotations

import io
import json
import threading
import time
import zlib
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pydicom
from pydicom.uid import DeflatedExplicitVRLittleEndian

STUDY, SERIES = "1.2", "1.2.3"
JSON = "application/dicom+json"
_BOUNDARY = "a-boundary"
_MULTIPART = f'multipart/related; type="application/dicom"; boundary={_BOUNDARY}'


class LyingArchive:
    """Serves the files of a folder as one series, unless it lies. Use `with`."""

    def __init__(self, folder: Path):
        self.files = [path.read_bytes() for path in sorted(folder.glob("*.dcm"))]
        self.uids = [str(pydicom.dcmread(io.BytesIO(data), stop_before_pixels=True).SOPInstanceUID) for data in self.files]
        self.bomb = _bomb(self.files[0])
        self.requests: list[str] = []
        self.elsewhere: list[str] = []      # paths that only followed redirects reach
        self.released = threading.Event()   # lets `stall` continue
        archive = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self) -> None:
                archive.requests.append(self.path)
                self.close_connection = True
                _, lie, *rest = self.path.partition("?")[0].split("/")
                kind = "fetch" if "series" in rest and rest[-1] == SERIES or "instances" in rest and rest[-1] != "instances" else rest[-1]
                try:
                    archive.answer(self, lie, kind, rest)
                except (BrokenPipeError, ConnectionResetError):
                    pass

            def reply(self, body: bytes, content_type: str, length: int | None = None, status: int = 200, **headers: str) -> None:
                self.send_response(status)
                self.send_header("Content-Type", content_type)
                self.send_header("Content-Length", str(len(body) if length is None else length))
                self.send_header("Connection", "close")     # or else the client may send its next request into the closed connection
                for name, value in headers.items():
                    self.send_header(name, value)
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_: object) -> None:
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def url(self, lie: str) -> str:
        return f"http://127.0.0.1:{self.server.server_port}/{lie}"

    def __enter__(self) -> LyingArchive:
        return self

    def __exit__(self, *_: object) -> None:
        self.released.set()
        self.server.shutdown()
        self.server.server_close()

    # What is served

    def answer(self, to, lie: str, kind: str, rest: list[str]) -> None:
        lied: Callable | None = getattr(self, f"{kind}_{lie.replace('-', '_')}", None)
        if lied:
            return lied(to, rest)
        return getattr(self, f"honest_{kind}")(to, rest)

    def honest_studies(self, to, _rest) -> None:
        to.reply(self.study_json(), JSON)

    def study_json(self) -> bytes:
        return json.dumps([{"0020000D": {"vr": "UI", "Value": [STUDY]}, "00100010": {"vr": "PN", "Value": [{"Alphabetic": "Phantasia^Canary"}]}}]).encode()

    def honest_series(self, to, _rest) -> None:
        to.reply(json.dumps([{"0020000E": {"vr": "UI", "Value": [SERIES]}, "00080060": {"vr": "CS", "Value": ["CT"]}}]).encode(), JSON)

    def honest_instances(self, to, _rest) -> None:
        to.reply(json.dumps([{"00080018": {"vr": "UI", "Value": [uid]}} for uid in self.uids]).encode(), JSON)

    def honest_fetch(self, to, rest) -> None:
        to.reply(self.body([self.files[self.uids.index(rest[-1])]] if "instances" in rest else self.files), _MULTIPART)

    def body(self, files: list[bytes], kind: str = "application/dicom") -> bytes:
        parts = b"".join(f"\r\n--{_BOUNDARY}\r\nContent-Type: {kind}\r\n\r\n".encode() + data for data in files)
        return parts + f"\r\n--{_BOUNDARY}--\r\n".encode()

    # Lies in searches

    def studies_html(self, to, _rest) -> None:
        to.reply(b"<html>Please sign in</html>", "text/html")

    def studies_broken(self, to, _rest) -> None:
        to.reply(b'[{"0020000D": ', JSON)

    def studies_object(self, to, _rest) -> None:
        to.reply(b'{"items": []}', JSON)

    def studies_deep(self, to, _rest) -> None:
        to.reply(b"[" * 200_000, JSON)

    def studies_endless(self, to, _rest) -> None:
        to.reply(b"[", JSON, length=1 << 40)
        for _ in range(200):
            to.wfile.write(b" " * (1 << 20))

    def studies_gzip(self, to, _rest) -> None:
        to.reply(zlib.compress(b" " * (64 << 20)), JSON, **{"Content-Encoding": "deflate"})

    def studies_redirect(self, to, _rest) -> None:
        to.reply(b"", JSON, status=302, Location=f"http://localhost:{self.server.server_port}/stolen/studies")

    def honest_stolen(self, to, _rest) -> None:
        self.elsewhere.append(to.path)
        to.reply(b"[]", JSON)

    def studies_stall(self, to, _rest) -> None:
        self.released.wait(60)

    def studies_error(self, to, _rest) -> None:
        to.reply(b"Traceback: Phantasia^Canary", "text/plain", status=500)

    def studies_huge_values(self, to, _rest) -> None:
        one = {"0020000D": {"vr": "UI", "Value": [STUDY]}, "00100010": {"vr": "PN", "Value": [{"Alphabetic": "x" * 1_000_000}]},
               "00081030": {"vr": "LO", "Value": [["nested"], True, None, {"a": 1}]}, "00201206": {"vr": "IS", "Value": ["many"]}}
        to.reply(json.dumps([one, {**one, "0020000D": {"vr": "UI", "Value": ["../../etc/passwd"]}}]).encode(), JSON)

    def series_other_study(self, to, _rest) -> None:
        to.reply(json.dumps([{"0020000D": {"vr": "UI", "Value": ["9.9"]}, "0020000E": {"vr": "UI", "Value": [SERIES]}}]).encode(), JSON)

    # Lies in fetches

    def fetch_html(self, to, _rest) -> None:
        to.reply(b"<html>Please sign in</html>", "text/html")

    def fetch_other_series(self, to, _rest) -> None:
        changed = []
        for data in self.files[:5]:
            image = pydicom.dcmread(io.BytesIO(data))
            image.SeriesInstanceUID = "9.9.9"
            changed.append(_written(image))
        to.reply(self.body(changed), _MULTIPART)

    def fetch_pictures(self, to, _rest) -> None:
        to.reply(self.body([b"\xff\xd8\xff"], "image/jpeg"), _MULTIPART)

    def fetch_noise(self, to, _rest) -> None:
        to.reply(self.body([b"\0" * 128 + b"DICM" + bytes(range(256)) * 50]), _MULTIPART)

    def fetch_bomb(self, to, _rest) -> None:
        to.reply(self.body([self.bomb]), _MULTIPART)

    def fetch_missing(self, to, rest) -> None:
        if "instances" in rest:
            return to.reply(b"", "text/plain", status=404)
        return to.reply(self.body(self.files[:30]), _MULTIPART)

    def fetch_cut_off(self, to, rest) -> None:
        """Ends the connection in the middle of the series. Single images arrive."""
        if "instances" in rest:
            return self.honest_fetch(to, rest)
        body = self.body(self.files)
        return to.reply(body[:len(body) // 2], _MULTIPART, length=len(body))

    def fetch_trickle(self, to, _rest) -> None:
        """Sends a few images, and then a byte now and then until the test ends."""
        body = self.body(self.files)
        to.reply(body[:len(body) // 4], _MULTIPART, length=len(body))
        while not self.released.is_set():
            to.wfile.write(b"\0")
            time.sleep(0.1)


def _bomb(file: bytes) -> bytes:
    """Returns a deflated file that is 768 MiB once inflated."""
    image = pydicom.dcmread(io.BytesIO(file))
    image.file_meta.TransferSyntaxUID = DeflatedExplicitVRLittleEndian
    out = io.BytesIO()
    pydicom.dcmwrite(out, image, enforce_file_format=True)     # with the length of the first group
    meta = out.getvalue()[:132 + 12 + int.from_bytes(out.getvalue()[140:144], "little")]
    packer = zlib.compressobj(1, wbits=-zlib.MAX_WBITS)
    return meta + b"".join(packer.compress(b"\0" * (16 << 20)) for _ in range(48)) + packer.flush()


def _written(image) -> bytes:
    out = io.BytesIO()
    pydicom.dcmwrite(out, image, enforce_file_format=False)
    return out.getvalue()
