"""A user with an account and a viewer of the stream, for end-to-end measurements. Runs in .tools/venv."""

from __future__ import annotations

import base64
import functools
import hashlib
import re
import secrets
import subprocess
import tempfile
import time
from pathlib import Path

from . import paths
from .stack import Stack

PART = 8 << 20


class Person:
    """A user who signs up, confirms the address by the mailed link, and signs in."""

    def __init__(self, stack: Stack, address: str | None = None):
        """Connects from `address` of this machine (127.0.0.0/8), if it is given."""
        import httpx

        self.stack, self.address = stack, address
        self.http = httpx.Client(base_url=stack.settings.url, timeout=60, transport=httpx.HTTPTransport(local_address=address))
        credentials = {"email": f"bench-{secrets.token_hex(6)}@example.org", "password": secrets.token_hex(16)}
        self.email, self.password = credentials["email"], credentials["password"]
        self._post("/v1/accounts", {"email": credentials["email"], "consent": True})
        self._post("/v1/accounts/verify", {"token": self._mailed_token(credentials["email"]), "password": self.password})
        answer = self._post("/v1/sign-in", credentials)
        self.http.headers["X-CSRF-Token"] = answer.json()["csrf_token"]

    def _post(self, path: str, body: dict):
        answer = self.http.post(path, json=body)
        answer.raise_for_status()
        return answer

    def sets_up_second_factor(self) -> None:
        import pyotp

        secret = self._post("/v1/me/second-factor", {"password": self.password}).json()["secret"]
        self._post("/v1/me/second-factor/confirm", {"code": pyotp.TOTP(secret).now()})

    def _mailed_token(self, email: str) -> str:
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline:
            for mail in (self.stack.data / "mail").iterdir():
                text = mail.read_text(encoding="utf-8", errors="replace") if mail.suffix == ".eml" and not mail.name.startswith(".") else ""
                if email in text and (found := re.search(r"#token=(?:3D)?([0-9a-f]{64})", text.replace("=\n", ""))):
                    return found[1]
            time.sleep(0.05)
        raise TimeoutError("the email did not arrive within 20 s")

    def upload(self, bundle: Path) -> str:
        """Uploads a bundle completely. Returns the ID of the new data set."""
        data = bundle.read_bytes()
        made = self._post("/v1/data-sets", {"title": "bench", "bytes": len(data)}).json()
        for offset in range(0, len(data), PART):
            part = data[offset:offset + PART]
            digest = base64.b64encode(hashlib.sha1(part).digest()).decode()
            answer = self.http.patch(made["upload_url"], content=part, headers={
                "Tus-Resumable": "1.0.0", "Upload-Offset": str(offset), "Upload-Checksum": f"sha1 {digest}",
                "Content-Type": "application/offset+octet-stream"})
            answer.raise_for_status()
        return made["data_set"]["id"]

    def wait_ready(self, data_set: str, timeout: float = 120) -> None:
        deadline = time.monotonic() + timeout
        while time.monotonic() < deadline:
            state = self.http.get(f"/v1/data-sets/{data_set}").raise_for_status().json()["state"]
            if state == "ready":
                return
            if state in ("refused", "failed"):
                raise RuntimeError(f"the data set was {state}")
            time.sleep(0.01)
        raise TimeoutError("the data set did not become ready")

    def delete(self, data_set: str) -> None:
        self.http.delete(f"/v1/data-sets/{data_set}").raise_for_status()

    def viewer(self, data_set: str, width: int, height: int, codec: int = 1) -> "Viewer":
        opened = self._post("/v1/sessions", {"data_set_id": data_set}).json()
        return Viewer(self.stack.settings.url, opened["stream_url"], width, height, codec, self.address)


class Viewer:
    """Uses the protocol diaphane.v1 like the page, but only acknowledges frames."""

    def __init__(self, origin: str, stream_url: str, width: int, height: int, codec: int = 1, address: str | None = None):
        from websockets.sync.client import connect

        self.messages = messages()
        self.socket_ = connect(origin.replace("http", "ws", 1) + stream_url, origin=origin, subprotocols=["diaphane.v1"],
                               max_size=None, compression=None, ping_interval=None, **({"source_address": (address, 0)} if address else {}))
        hello = self.messages["ClientMessage"]()
        hello.hello.protocol = 1
        hello.hello.codecs.append(codec)
        hello.hello.pixel_ratio = 1
        hello.hello.viewport.width, hello.hello.viewport.height = width, height
        self.socket_.send(hello.SerializeToString())
        self.config = self._until("config")
        self.input_seq = self.config.input_seq

    def frame(self, timeout: float = 30):
        """Returns the next picture after acknowledging it."""
        frame = self._until("frame", timeout)
        ack = self.messages["ClientMessage"]()
        ack.ack.seq, ack.ack.epoch = frame.seq, frame.epoch
        ack.ack.received_us = ack.ack.decoded_us = ack.ack.presented_us = time.monotonic_ns() // 1000
        self.socket_.send(ack.SerializeToString())
        return frame

    def send_scene(self, scene, rest: bool = False) -> int:
        self.input_seq += 1
        update = self.messages["ClientMessage"]()
        update.scene.input_seq = self.input_seq
        update.scene.scene.CopyFrom(scene)
        update.scene.rest = rest
        self.socket_.send(update.SerializeToString())
        return self.input_seq

    def video(self, request, timeout: float = 3600) -> bytes:
        """Returns the file that a message requests, of the scene with which the connection began."""
        view = self.messages["ClientMessage"]()
        view.key_view.index = 0
        view.key_view.scene.CopyFrom(self.config.scene)
        self.socket_.send(view.SerializeToString())
        self.socket_.send(request.SerializeToString())
        parts = []
        while True:
            part = self._until("file_part", timeout)
            parts.append(part.data)
            taken = self.messages["ClientMessage"]()
            taken.file_taken.seq = part.seq
            self.socket_.send(taken.SerializeToString())
            if part.last:
                return b"".join(parts)

    def close(self) -> None:
        self.socket_.close()

    def _until(self, kind: str, timeout: float = 30):
        deadline = time.monotonic() + timeout
        while True:
            message = self.messages["ServerMessage"].FromString(self.socket_.recv(max(0.0, deadline - time.monotonic())))
            if message.WhichOneof("body") == "problem":
                raise RuntimeError(f"error from the server: {message.problem.message}")
            if message.WhichOneof("body") == kind:
                return getattr(message, kind)


@functools.cache
def messages() -> dict[str, type]:
    """Returns the classes of the stream's messages, generated from the contract at run time."""
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

    with tempfile.NamedTemporaryFile(suffix=".pb") as made:
        subprocess.run(["protoc", "-I", ".", "--include_imports", f"--descriptor_set_out={made.name}",
                        "api/proto/stream.proto"], cwd=paths.REPO, check=True)
        described = descriptor_pb2.FileDescriptorSet.FromString(made.read())
    pool = descriptor_pool.DescriptorPool()
    for file in described.file:
        pool.Add(file)
    return {name: message_factory.GetMessageClass(pool.FindMessageTypeByName(f"diaphane.v1.{name}"))
            for name in ("ClientMessage", "ServerMessage", "Scene")}


def cranium(stack: Stack, folder: Path) -> Path:
    """Returns the sample as a bundle that a browser would upload."""
    bundle = folder / "cranium.tar"
    subprocess.run([str(stack.layout.bin / "diaphane-sample"), "--write-bundle", str(bundle)], check=True,
                   stdout=subprocess.DEVNULL)
    return bundle
