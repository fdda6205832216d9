"""Replay a recorded interaction (docs/contracts.md): in a live session in real time, or as pictures."""

from __future__ import annotations

import argparse
import copy
import json
import math
import secrets
import subprocess
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path
from urllib.parse import urlsplit

from . import build, install, paths
from .console import CliError, say

LONGEST_PAUSE_MS = 10_000


def read(path: Path) -> dict:
    """Returns the recording after validation. Reports files that are not recordings."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CliError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise CliError(f"{path} is not JSON") from error
    if not isinstance(document, dict) or document.get("format") != "diaphane-interaction" or document.get("version") != 1:
        raise CliError(f"{path} is not an interaction recording, or its version is not supported")
    events = document.get("events")
    if not isinstance(events, list) or not events or "scene" not in events[0]:
        raise CliError(f"{path}: a recording must begin with a scene")
    before = 0
    for number, event in enumerate(events):
        known = isinstance(event, dict) and isinstance(event.get("at_ms"), int) and ("scene" in event) != ("camera" in event)
        if not known or not 0 <= event["at_ms"] - before <= LONGEST_PAUSE_MS:
            raise CliError(f"{path}: event {number} is invalid")
        before = event["at_ms"]
    return document


def scenes(document: dict) -> list[tuple[int, dict]]:
    """Returns whole scenes with the times at which they were shown, in ms from the first."""
    played, scene = [], {}
    for event in document["events"]:
        scene = copy.deepcopy(event["scene"]) if "scene" in event else {**scene, "camera": event["camera"]}
        played.append((event["at_ms"], scene))
    return played


def shown_at(played: list[tuple[int, dict]], frames_per_second: float) -> list[dict]:
    """Returns the scene of each frame, which is the newest at that time. The last frame shows the last scene."""
    frames, next_one = [], 0
    for frame in range(math.ceil(played[-1][0] * frames_per_second / 1000) + 1):
        while next_one + 1 < len(played) and played[next_one + 1][0] <= frame * 1000 / frames_per_second:
            next_one += 1
        frames.append(played[next_one][1])
    return frames


def to_pictures(document: dict, scan: str, out: Path, frames_per_second: float, samples: int) -> None:
    out.mkdir(parents=True, exist_ok=True)
    size = f"{document['viewport']['width']}x{document['viewport']['height']}"
    program = paths.build_dir() / "bin" / "diaphane-render"
    if not program.exists():
        build.build_programs("diaphane-render")
    frames = shown_at(scenes(document), frames_per_second)
    before: tuple[dict, Path] | None = None
    with tempfile.TemporaryDirectory(prefix="diaphane-replay-") as folder:
        scene_file = Path(folder) / "scene.json"
        for number, scene in enumerate(frames):
            picture = out / f"{number:05}.png"
            if before and before[0] == scene:    # a pause with the same picture
                picture.write_bytes(before[1].read_bytes())
                continue
            scene_file.write_text(json.dumps(scene), encoding="utf-8")
            done = subprocess.run([str(program), scan, "--scene", str(scene_file), "--size", size, "--samples", str(samples),
                                   "--out", str(picture), "--quiet"], stderr=subprocess.PIPE, text=True)
            if done.returncode != 0:
                raise CliError(done.stderr.strip(), code=done.returncode)
            before = (scene, picture)
            say(f"Rendered picture {number + 1} of {len(frames)}")


def join(link: str, name: str) -> tuple[str, str, str]:
    """Returns origin, stream address and participant of a guest who joins by that link."""
    parts = urlsplit(link)
    origin = f"{parts.scheme}://{parts.netloc}"
    if parts.scheme not in ("http", "https") or parts.path != "/join" or len(parts.fragment) != 64:
        raise CliError("not a session link. Copy it from the Share dialog: http://…/join#…")
    body = json.dumps({"token": parts.fragment, "key": secrets.token_hex(32), "name": name}).encode()
    request = urllib.request.Request(origin + "/v1/join", body, {"Content-Type": "application/json", "Origin": origin})
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:
            joined = json.load(answer)
    except urllib.error.HTTPError as refused:
        raise CliError(json.load(refused).get("detail", "the server rejected the link")) from refused
    except OSError as away:
        raise CliError(f"cannot connect to {origin}") from away
    return origin, joined["stream_url"], joined["participant"]


def over_link(document: dict, link: str, patience_s: float = 600) -> int:
    """Plays the recording in a live session once this guest has the presenter's role. Returns the
    number of sent scenes."""
    from google.protobuf import json_format
    from websockets.sync.client import connect

    from .bench_client import messages

    kinds = messages()
    origin, url, me = join(link, "Replay")
    size = document["viewport"]
    with connect(origin.replace("http", "ws", 1) + url, origin=origin, subprotocols=["diaphane.v1"], max_size=None,
                 compression=None) as socket:
        hello = kinds["ClientMessage"]()
        hello.hello.protocol = 1
        hello.hello.codecs.append(1)
        hello.hello.pixel_ratio = 1
        hello.hello.viewport.width, hello.hello.viewport.height = size["width"], size["height"]
        socket.send(hello.SerializeToString())

        def hear(until: float) -> bool:
            """Acknowledges messages until a time. Returns whether this guest presents."""
            nonlocal presents
            while (left := until - time.monotonic()) > 0:
                try:
                    message = kinds["ServerMessage"].FromString(socket.recv(left))
                except TimeoutError:
                    break
                kind = message.WhichOneof("body")
                if kind == "frame":
                    ack = kinds["ClientMessage"]()
                    ack.ack.seq, ack.ack.epoch = message.frame.seq, message.frame.epoch
                    socket.send(ack.SerializeToString())
                elif kind == "audience":
                    presents = message.audience.presenter == me
                elif kind == "problem":
                    raise CliError(message.problem.message)
            return presents

        presents = False
        say("Joined as \"Replay\". In the Share dialog, make \"Replay\" the presenter.")
        waited = time.monotonic() + patience_s
        while not hear(min(waited, time.monotonic() + 0.2)):
            if time.monotonic() >= waited:
                raise CliError("nobody made \"Replay\" the presenter in time")
        played = scenes(document)
        begun = time.monotonic()
        for number, (at_ms, scene) in enumerate(played, 1):
            if not hear(begun + at_ms / 1000) and not presents:
                say("Someone else became the presenter, so the replay stopped.")
                return number - 1
            update = kinds["ClientMessage"]()
            update.scene.input_seq = number
            json_format.ParseDict(scene, update.scene.scene)
            socket.send(update.SerializeToString())
        hear(time.monotonic() + 1)
        return len(played)


def run(rest: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="./diaphane replay", description=__doc__)
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="recording exported from the viewer")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--link", metavar="LINK", help="link to a live session (from the viewer's Share dialog), to replay in real time")
    where.add_argument("--scan", metavar="SCAN", help="folder or file with a scan, to render to pictures; requires --out")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="output folder for the pictures")
    parser.add_argument("--fps", type=float, metavar="N", default=10, help="pictures per second of the recording (default: 10)")
    parser.add_argument("--samples", type=int, metavar="N", default=16, help="samples per pixel (default: 16)")
    options = parser.parse_args(rest)
    document = read(options.recording)
    if options.link:
        install.enter_venv("replay")
        say(f"{over_link(document, options.link)} scenes replayed.")
    else:
        if options.out is None or not 0 < options.fps <= 120 or options.samples < 1:
            parser.error("--scan requires --out FOLDER, --fps above 0 and at most 120, and --samples of at least 1")
        to_pictures(document, options.scan, options.out, options.fps, options.samples)
    return 0
