"""Attackers for `./diaphane bench abuse`, in a separate process with the lowest priority.

Real attackers would not use this machine's processors, so what they send is prepared once. They attack only this machine, and
stop at a given time or after a maximum number of requests. Usage: python -m devtool.benches.support.abuse_clients FILE. FILE contains the task as
JSON. The results are written to standard output."""

from __future__ import annotations

import asyncio
import functools
import http.client
import json
import os
import random
import secrets
import struct
import sys
import threading
import time
import zlib
from collections import Counter
from urllib.parse import urlsplit

from ...bench_client import Viewer
from ...priority import GroupPriorities

MOST_REQUESTS = 200_000    # per process
JSON_BYTES = 200_000
SIDE = 4096                # of a texture: a file of 7 KB that decodes to 270 MB


class Attack:
    """The target, the end time, and the answers so far."""

    def __init__(self, plan: dict):
        self.plan, self.counts, self.lock = plan, Counter(), threading.Lock()
        parts = urlsplit(plan["url"])
        self.host, self.port, self.origin = parts.hostname, parts.port, plan["url"]
        if self.host != "localhost" and not self.host.startswith("127."):
            raise SystemExit("only this machine is attacked")
        self.host = "127.0.0.1" if self.host == "localhost" else self.host
        self.until = time.monotonic() + plan["seconds"]

    def note(self, what: str) -> None:
        with self.lock:
            self.counts[what] += 1

    @property
    def over(self) -> bool:
        return time.monotonic() > self.until or sum(self.counts.values()) > MOST_REQUESTS


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


@functools.cache
def pixels() -> bytes:
    """Returns a PNG of one bit per pixel, without its end."""
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", SIDE, SIDE, 1, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress((b"\0" + b"\xff" * (SIDE // 8)) * SIDE, 9)))


def texture(number: int) -> bytes:
    """Returns a PNG with the same pixels for each number, but different bytes, which no cache
    contains."""
    return pixels() + chunk(b"tEXt", b"Comment\0%d" % number) + chunk(b"IEND", b"")


@functools.cache
def large_json() -> bytes:
    return b'{"a":' + b"[" * 2000 + b"]" * 2000 + b',"b":"' + b"x" * JSON_BYTES + b'"}'


def request(method: str, path: str, origin: str, body: bytes = b"", more: str = "", length: int | None = None) -> bytes:
    host = urlsplit(origin).netloc
    kind = "" if "Content-Type" in more else "Content-Type: application/json\r\n"
    return (f"{method} {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\n{kind}{more}"
            f"Content-Length: {len(body) if length is None else length}\r\n\r\n").encode() + body


# Attacks by 250 connections from one address without an account.

async def one_of_a_crowd(attack: Attack, number: int) -> None:
    kinds = ("slow body", "slow body", "json", "join", "visit", "thumbnail", "upload")
    kind = kinds[number % len(kinds)]
    plan = attack.plan
    while not attack.over:
        writer = None
        try:
            reader, writer = await asyncio.open_connection(attack.host, attack.port, local_addr=(plan["address"], 0))
            if kind == "slow body":
                writer.write(request("POST", "/v1/sign-in", attack.origin, b"{", length=10_000))
                while not attack.over:
                    await asyncio.sleep(1)
                    writer.write(b" ")
                    await writer.drain()
                    if reader.at_eof():
                        break
                attack.note("slow body: ended")
                continue
            answer = await asyncio.wait_for(_one(attack, kind, reader, writer), 30)
            attack.note(f"{kind}: {answer}")
            await asyncio.sleep(0.25)
        except (OSError, asyncio.TimeoutError, asyncio.IncompleteReadError) as failed:
            attack.note(f"{kind}: {type(failed).__name__}")
            await asyncio.sleep(0.25)
        finally:
            if writer:
                writer.close()


async def _one(attack: Attack, kind: str, reader, writer) -> str:
    plan, origin, key = attack.plan, attack.origin, secrets.token_hex(32)
    if kind == "json":
        sent = request("POST", "/v1/sign-in", origin, large_json())
    elif kind == "join":
        sent = request("POST", "/v1/join", origin, json.dumps({"token": plan["live_link"], "key": key}).encode())
    elif kind == "visit":
        sent = request("POST", "/v1/visits", origin, json.dumps({"token": plan["share_link"], "key": key}).encode())
    elif kind == "thumbnail":
        sent = request("GET", f"/v1/data-sets/{plan['data_set']}/thumbnails/bone", origin)
    else:
        sent = request("PATCH", f"/v1/uploads/{plan['data_set']}", origin, b"x" * 1_000_000,
                       "Content-Type: application/offset+octet-stream\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: 0\r\n")
    writer.write(sent)
    await writer.drain()
    line = (await reader.readline()).decode("ascii", "replace").split()
    return line[1] if len(line) > 1 else "closed"


async def crowd(attack: Attack) -> None:
    await asyncio.gather(*(one_of_a_crowd(attack, number) for number in range(attack.plan["connections"])))


# Attacks on the stream, through a link or with an account.

def flood_of_a_stream(attack: Attack, viewer: Viewer, name: str, seed: int) -> None:
    """Sends scenes with large textures, and requests slices."""
    chance = random.Random(seed)
    make = viewer.messages["ClientMessage"]
    taken = [0]    # number of the newest slice
    reading = threading.Thread(target=_read, args=(viewer, attack, taken), daemon=True)
    reading.start()
    while not attack.over:
        update = make()
        viewer.input_seq += 1
        update.scene.input_seq = viewer.input_seq
        update.scene.scene.CopyFrom(viewer.config.scene)
        light = update.scene.scene.lights.add()
        light.environment.radiance.r = 1
        light.environment.texture.picture = texture(chance.randrange(1 << 31))
        viewer.socket_.send(update.SerializeToString())
        attack.note(f"{name}: texture")
        for number in range(20):
            wanted = make()
            wanted.slices.slices.add(plane=1 + number % 3, index=chance.randrange(64))
            wanted.slices.taken = taken[0]
            viewer.socket_.send(wanted.SerializeToString())
        attack.note(f"{name}: slices")
        time.sleep(0.2)


def _read(viewer: Viewer, attack: Attack, taken: list[int]) -> None:
    """Receives messages and acknowledges them like a page."""
    make, server = viewer.messages["ClientMessage"], viewer.messages["ServerMessage"]
    try:
        while not attack.over:
            message = server.FromString(viewer.socket_.recv(5))
            if message.WhichOneof("body") == "slice":
                taken[0] = message.slice.seq
            if message.WhichOneof("body") == "problem":
                attack.note(f"problem: {message.problem.code} {message.problem.field}")
            if message.WhichOneof("body") != "frame":
                continue
            ack = make()
            ack.ack.seq, ack.ack.epoch = message.frame.seq, message.frame.epoch
            viewer.socket_.send(ack.SerializeToString())
    except Exception as ended:  # noqa: BLE001 - the stream was closed, or nothing arrives
        attack.note(f"stream ended: {type(ended).__name__}")


class Requests:
    """Requests over one connection that is kept open."""

    def __init__(self, attack: Attack, address: str, headers: dict[str, str] | None = None):
        self.connection = http.client.HTTPConnection(attack.host, attack.port, timeout=30, source_address=(address, 0))
        self.headers = {"Host": urlsplit(attack.origin).netloc, "Origin": attack.origin, **(headers or {})}

    def send(self, method: str, path: str, body: bytes | None = None, **headers: str) -> tuple[int, bytes]:
        try:
            self.connection.request(method, path, body, self.headers | {name.replace("_", "-"): value for name, value in headers.items()})
            answer = self.connection.getresponse()
            return answer.status, answer.read()
        except Exception:
            self.connection.close()    # the next request opens it again
            raise

    def send_json(self, path: str, body: dict) -> tuple[int, bytes]:
        return self.send("POST", path, json.dumps(body).encode(), Content_Type="application/json")


def guest(attack: Attack, number: int) -> None:
    plan = attack.plan
    requests = Requests(attack, plan["address"])
    while not attack.over:
        try:
            status, joined = requests.send_json("/v1/join", {"token": plan["live_link"], "key": secrets.token_hex(32)})
            attack.note(f"guest joins: {status}")
            if status == 201:
                viewer = Viewer(attack.origin, json.loads(joined)["stream_url"], 1920, 1080, address=plan["address"])
                own = viewer.messages["ClientMessage"]()
                own.free_camera.on = True
                viewer.socket_.send(own.SerializeToString())
                flood_of_a_stream(attack, viewer, "guest", number)
        except Exception as failed:  # noqa: BLE001 - any refusal is fine
            attack.note(f"guest: {type(failed).__name__}")
        time.sleep(0.5)


def account(attack: Attack, number: int) -> None:
    """Attacks with a stream, uploads, and large JSON and thumbnails at the same time."""
    plan = attack.plan
    mine = plan["accounts"][number]
    signed_in = mine["headers"] | {"Cookie": "; ".join(f"{name}={value}" for name, value in mine["cookies"].items())}

    def opened() -> Requests:
        return Requests(attack, mine["address"], signed_in)

    def stream() -> None:
        status, session = opened().send_json("/v1/sessions", {"data_set_id": plan["data_set"]})
        attack.note(f"account opens: {status}")
        if status == 201:
            flood_of_a_stream(attack, Viewer(attack.origin, json.loads(session)["stream_url"], 640, 360, address=mine["address"]),
                              "account", number)

    def uploads() -> None:
        client, body = opened(), secrets.token_bytes(200_000)
        while not attack.over:
            status, made = client.send_json("/v1/data-sets", {"title": "x", "bytes": len(body)})
            attack.note(f"account announces: {status}")
            if status == 201:
                url = urlsplit(json.loads(made)["upload_url"])
                status, _ = client.send("PATCH", url.path + (f"?{url.query}" if url.query else ""), body, Tus_Resumable="1.0.0",
                                        Upload_Offset="0", Content_Type="application/offset+octet-stream")
                attack.note(f"account uploads: {status}")
            time.sleep(0.2)

    def requests() -> None:
        client = opened()
        deep = b'{"keep":' + b"[" * 50_000 + b"]" * 50_000 + b"}"
        while not attack.over:
            status, _ = client.send("POST", f"/v1/data-sets/{plan['data_set']}/anonymise", deep, Content_Type="application/json")
            attack.note(f"account sends deep JSON: {status}")
            status, _ = client.send("GET", f"/v1/data-sets/{plan['data_set']}/thumbnails/{random.choice(('bone', 'skin', 'muscle'))}")
            attack.note(f"account asks for a thumbnail: {status}")
            status, _ = client.send_json("/v1/join", {"token": plan["live_link"], "key": secrets.token_hex(32)})
            attack.note(f"account joins: {status}")
            time.sleep(0.05)

    def lasting(work) -> None:
        while not attack.over:
            try:
                work()
            except Exception as failed:  # noqa: BLE001 - any refusal is fine
                attack.note(f"account {work.__name__}: {type(failed).__name__}")
            time.sleep(0.5)

    together = [threading.Thread(target=lasting, args=(work,), daemon=True) for work in (stream, uploads, requests)]
    for thread in together:
        thread.start()
    for thread in together:
        thread.join(max(0.0, attack.until + 2 - time.monotonic()))


def main() -> None:
    os.nice(19)
    GroupPriorities().apply([(os.getpid(), 19)])
    with open(sys.argv[1], encoding="utf-8") as file:
        attack = Attack(json.load(file))
    threads = [threading.Thread(target=work, args=(attack, number), daemon=True)
               for work, count in ((guest, attack.plan["guests"]), (account, len(attack.plan["accounts"]))) for number in range(count)]
    for thread in threads:
        thread.start()
    if attack.plan["connections"]:
        asyncio.run(crowd(attack))
    for thread in threads:
        thread.join(max(0.0, attack.until + 3 - time.monotonic()))
    print(json.dumps(attack.counts))


if __name__ == "__main__":
    main()
