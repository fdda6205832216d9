"""Several users in one session on real components: links, roles, a worker that dies, and a Redis that loses its data."""

from __future__ import annotations

import os
import secrets
import signal
import subprocess
import threading
import time
from pathlib import Path

import pytest
from api_client import client, person, problem
from google.protobuf import json_format
from harness import REPO
from devtool import ports, replay
from stream_helpers import PATIENCE_S, PROGRAMS, ClientMessage, Viewer, come_back, new_ticket, open_session, store_ball

#: Of FrameQuality (api/proto/stream.proto).
SETTLED = 2


class Guest:
    """A user with a link, without an account."""

    def __init__(self, stack, token: str, name: str = ""):
        self.stack, self.token, self.name, self.key = stack, token, name, secrets.token_hex(32)
        self.http = client(stack)

    def ask(self):
        return self.http.post("/v1/join", json={"token": self.token, "key": self.key, "name": self.name})

    def join(self) -> Viewer:
        answer = self.ask()
        assert answer.status_code == 201, answer.text
        self.id = answer.json()["participant"]
        return Viewer(self.stack.url, answer.json()["stream_url"])


def link_of(somebody, session: str, slices: bool | None = None) -> str:
    answer = somebody.http.post(f"/v1/sessions/{session}/links", **({} if slices is None else {"json": {"slices": slices}}))
    assert answer.status_code == 201, answer.text
    return answer.json()["token"]


def hand_over(viewer: Viewer, to: str) -> None:
    message = ClientMessage()
    message.handover.to = to
    viewer.send(message)


def test_a_guest_follows_the_presenter_and_cannot_change_the_view(running, one, session):
    owner = Viewer(running.url, session[1])
    guest = Guest(running, link_of(one, session[0]), " Ann\u202e ")
    follower = guest.join()
    assert follower.config.follower and not owner.config.follower
    assert follower.config.scene == owner.config.scene
    there = follower.until("audience")
    assert [(p.name, p.owner, p.presenter) for p in there.participants] == [("", True, True), ("Ann", False, False)]
    assert there.you == guest.id
    seq = owner.turn(40)
    # On a busy machine, a picture that moves is smaller and of an epoch of its own, which the follower may never see.
    shown = owner.frame(condition=lambda frame: frame.input_seq >= seq and frame.quality == SETTLED)
    same = follower.frame(condition=lambda frame: frame.epoch == shown.epoch)
    assert (same.width, same.height) == (shown.width, shown.height)
    follower.turn(5)
    refusal = follower.until("problem")
    assert refusal.code == "forbidden" and not refusal.fatal
    owner.leave()
    follower.leave()


def test_the_presenter_role_can_be_passed_on_and_only_the_owner_takes_it_back(running, one, session):
    owner = Viewer(running.url, session[1])
    guest = Guest(running, link_of(one, session[0]))
    follower = guest.join()
    owner.until("audience", condition=lambda who: len(who.participants) == 2)
    hand_over(owner, guest.id)
    follower.until("audience", condition=lambda who: who.presenter == guest.id)
    seq = follower.turn(25)
    follower.frame(condition=lambda frame: frame.input_seq >= seq)
    owner.frame(condition=lambda frame: frame.input_seq >= seq)
    # The owner takes the role back while the presenter is still there.
    hand_over(owner, "owner")
    follower.until("audience", condition=lambda who: who.presenter == "owner")
    follower.turn(5)
    assert follower.until("problem").code == "forbidden"
    seq = owner.turn(1)
    owner.frame(condition=lambda frame: frame.input_seq >= seq)
    owner.leave()
    follower.leave()


def test_disabling_a_link_disconnects_only_its_guests(running, one, session):
    owner = Viewer(running.url, session[1])
    guest = Guest(running, link_of(one, session[0]))
    follower = guest.join()
    follower.frame()
    assert one.http.delete(f"/v1/sessions/{session[0]}/links").status_code == 204
    assert follower.close_code() == 4410
    problem(guest.ask(), 404, "not-found")
    owner.until("audience", condition=lambda who: len(who.participants) == 1)
    seq = owner.turn(3)
    owner.frame(condition=lambda frame: frame.input_seq >= seq)
    # Another link has another token.
    again = Guest(running, link_of(one, session[0])).join()
    again.frame()
    again.leave()
    owner.leave()


def test_a_session_link_gives_access_to_nothing_else(running, one, session):
    other = person(running)
    problem(other.http.post(f"/v1/sessions/{session[0]}/links"), 404, "not-found")
    problem(other.http.delete(f"/v1/sessions/{session[0]}/links"), 404, "not-found")
    token = link_of(one, session[0])
    problem(Guest(running, "0" * 64).ask(), 404, "not-found")
    assert token not in "".join(running.redis.keys("*")), "only its hash is kept"
    for path in (f"/v1/sessions/{session[0]}", "/v1/data-sets", "/v1/me"):
        problem(Guest(running, token).http.get(path), 401, "unauthenticated")
    for _ in range(7):
        link_of(one, session[0])
    problem(one.http.post(f"/v1/sessions/{session[0]}/links"), 429, "too-many")


def test_a_free_camera_follows_only_the_settings(running, one, session):
    owner = Viewer(running.url, session[1])
    owner.frame()
    follower = Guest(running, link_of(one, session[0])).join()
    message = ClientMessage()
    message.free_camera.on = True
    follower.send(message)
    follower.config = follower.until("config", condition=lambda config: not config.follower)
    follower.input_seq = follower.config.input_seq
    seq = follower.turn(60)
    mine = follower.frame(condition=lambda frame: frame.input_seq >= seq)
    theirs = owner.frame()
    assert mine.data != theirs.data
    message.free_camera.on = False
    follower.send(message)
    back = follower.until("config", condition=lambda config: config.follower)
    assert back.scene == owner.config.scene
    assert follower.frame().seq == 1
    owner.leave()
    follower.leave()


def test_a_recording_plays_in_a_live_session_at_its_original_speed(running, one, session):
    owner = Viewer(running.url, session[1])
    scene = json_format.MessageToDict(owner.config.scene)
    for named in (*scene["transferFunction"]["channels"], *scene["lights"]):
        named.pop("name", None)  # as a recording is stored
    camera = {"eye": {"x": 0.0}, **scene["camera"]}
    camera["eye"] = {"x": 0.0, **camera["eye"]}
    events = [{"at_ms": 0, "scene": scene}]
    for step in range(1, 11):
        events.append({"at_ms": step * 60, "camera": {**camera, "eye": {**camera["eye"], "x": camera["eye"]["x"] + step}}})
    document = {"format": "diaphane-interaction", "version": 1, "viewport": {"width": 96, "height": 96}, "events": events}
    answer = one.http.post("/v1/recordings", json=document)
    problem(answer, 403, "forbidden")
    assert one.http.post("/v1/recording-consent").status_code == 204
    kept = one.http.get(one.http.post("/v1/recordings", json=document).headers["location"]).json()
    assert kept == document

    link = f"{running.url}/join#{link_of(one, session[0])}"
    played = []
    player = threading.Thread(target=lambda: played.append(replay.over_link(kept, link, patience_s=PATIENCE_S)))
    player.start()
    there = owner.until("audience", condition=lambda who: len(who.participants) == 2)
    replayer = next(p for p in there.participants if p.id != there.you)
    assert replayer.name == "Replay"
    begun = time.monotonic()
    hand_over(owner, replayer.id)
    last = owner.until("look", condition=lambda look: look.input_seq == len(events))
    assert time.monotonic() - begun > 0.5, "not at its own pace"
    assert last.scene.camera.eye.x == pytest.approx(camera["eye"]["x"] + 10)
    player.join()
    assert played == [len(events)]
    owner.leave()


class SecondWorker:
    """Another renderd beside the stack's, which nothing restarts."""

    def __init__(self, stack, worker_id: str):
        build = Path(os.environ.get("DIAPHANE_BUILD", REPO / "build" / "release"))
        grpc, admin = list(ports.random_free().values())[:2]
        self.id = worker_id
        self.process = subprocess.Popen([
            build / "bin" / "diaphane-renderd", "--worker-id", worker_id, "--redis", stack.redis_address,
            "--grpc-port", str(grpc), "--advertise", f"127.0.0.1:{grpc}", "--admin-port", str(admin),
            "--volume-dir", stack.data_dir / "volumes", "--engine", "cpu", "--threads", "1", "--slots", "8"],
            stderr=subprocess.DEVNULL)
        stack.wait_until(lambda: stack.redis.exists(f"diaphane:worker:{worker_id}"), what="the second worker")

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()


def test_a_session_moves_off_a_dead_worker_with_its_scene_and_guests(stack_factory):
    stack = stack_factory(only=PROGRAMS)
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    second = SecondWorker(stack, "second")
    try:
        # Placed on the worker that will die, because the other one is stopped.
        stack.stop("renderd")
        stack.wait_until(lambda: not stack.redis.exists("diaphane:worker:local"), what="the first worker's end")
        session, url = open_session(somebody, ball)
        assert stack.redis.hget(f"diaphane:session:{session}", "worker") == second.id
        owner = Viewer(stack.url, url)
        stack.start("renderd")
        stack.wait_until(lambda: stack.redis.exists("diaphane:worker:local"), what="the first worker")
        guest = Guest(stack, link_of(somebody, session))
        follower = guest.join()
        seq = owner.turn(77)
        follower.frame(condition=lambda frame: frame.input_seq >= seq)
        stack.wait_until(lambda: stack.redis.hget(f"diaphane:session:{session}", "input_seq") == str(seq), what="the kept scene")
        before = owner.frame(condition=lambda frame: frame.input_seq >= seq)
        begun = time.monotonic()
        second.kill()
        assert owner.close_code() == 4503
        assert follower.close_code() == 4503

        def again() -> Viewer | None:
            url = new_ticket(somebody, session)
            return Viewer(stack.url, url) if url else None

        # In either order: the first to arrive has it placed.
        followed = come_back(guest.join)
        picture = followed.frame()
        presented = come_back(again)
        presented.frame()
        took = time.monotonic() - begun
        assert stack.redis.hget(f"diaphane:session:{session}", "worker") != second.id
        assert presented.config.scene == owner.config.scene and followed.config.scene == owner.config.scene
        assert followed.config.follower and not presented.config.follower
        assert picture.epoch > before.epoch, "no frame of the old worker can pass for a new one"
        print(f"a killed worker's picture was at another, for owner and guest, after {took:.2f} s")
        presented.leave()
        followed.leave()
    finally:
        second.kill()


def test_an_empty_redis_is_refilled_from_heartbeats(stack_factory):
    stack = stack_factory(only=PROGRAMS)
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    session, url = open_session(somebody, ball)
    owner = Viewer(stack.url, url)
    guest = Guest(stack, link_of(somebody, session))
    follower = guest.join()
    seq = owner.turn(12)
    follower.frame(condition=lambda frame: frame.input_seq >= seq)
    stack.redis.flushall()
    begun = time.monotonic()
    key = f"diaphane:session:{session}"
    stack.wait_until(lambda: stack.redis.hexists(key, "scene"), timeout=5, what="the session's place")
    print(f"an empty Redis had the session again after {time.monotonic() - begun:.2f} s")
    assert stack.redis.hget(key, "input_seq") == str(seq)
    # Nobody was disconnected, and everybody can reconnect in the same way.
    seq = owner.turn(3)
    follower.frame(condition=lambda frame: frame.input_seq >= seq)
    owner.leave()
    back = Viewer(stack.url, new_ticket(somebody, session))
    assert back.config.scene == owner.config.scene
    follower.leave()
    guest.join().frame()
    assert [s["session_id"] for s in somebody.http.get("/v1/sessions").json()["items"]] == [session]
