"""Faults between browser and worker (docs/testing.md, "Faults"): their cause gets an error, and nobody else notices."""

from __future__ import annotations

import json
import os
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import datetime

import pytest
from api_client import person, problem
from edge_helpers import connect as connect_raw
from edge_helpers import resident_mb
from devtool import ports
from stream_helpers import PROGRAMS, ClientMessage, Viewer, open_session, store_ball, wait_saved, wait_ticket
from test_gateway_attacks import frame, handshake
from test_gateway_stream import back_again

SIXTEEN = 16


@pytest.fixture(scope="module")
def ball(running, one) -> str:
    return store_ball(running, one, 24)


@pytest.fixture
def opened(running, one, ball):
    """Yields a session and its first stream URL. Ended afterwards."""
    made = open_session(one, ball)
    yield made
    one.http.delete(f"/v1/sessions/{made[0]}")


@pytest.fixture
def unharmed(running, one, ball):
    """Another user's viewer, which sees pictures throughout and at the end."""
    session, url = open_session(one, ball)
    viewer = Viewer(running.url, url)
    viewer.frame()
    pids = dict(running.pids)
    yield viewer
    seq = viewer.turn(5)
    viewer.frame(condition=lambda shown: shown.input_seq >= seq)
    viewer.leave()
    one.http.delete(f"/v1/sessions/{session}")
    assert running.pids == pids, "a program ended"


def test_sixteen_sessions_keep_their_scenes_when_their_worker_is_killed(stack_factory):
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_SLOTS": str(SIXTEEN)})
    people = [person(stack), person(stack)]  # eight each, the maximum
    balls = [store_ball(stack, one, 24) for one in people]
    sessions = [(people[i % 2], *open_session(people[i % 2], balls[i % 2])) for i in range(SIXTEEN)]

    def look(number: int) -> Viewer:
        viewer = Viewer(stack.url, sessions[number][2], side=32)
        seq = viewer.turn(10 + number)
        viewer.frame(condition=lambda shown: shown.input_seq >= seq)
        return viewer

    with ThreadPoolExecutor(SIXTEEN) as together:
        viewers = list(together.map(look, range(SIXTEEN)))
        for viewer, (_, session, _) in zip(viewers, sessions):
            wait_saved(stack, session, viewer.input_seq)
        begun = time.monotonic()
        stack.kill("renderd")

        def come_back(number: int) -> Viewer:
            assert viewers[number].close_code() == 4503
            somebody, session, _ = sessions[number]
            return back_again(stack, somebody, session)

        for viewer, again in zip(viewers, together.map(come_back, range(SIXTEEN))):
            assert again.config.scene == viewer.config.scene
            assert again.config.input_seq == viewer.input_seq
            again.leave()
    print(f"all sixteen back after {time.monotonic() - begun:.2f} s")


def test_a_second_worker_with_the_same_name_is_refused(running, unharmed):
    program = running.stack.running_["renderd"].program
    grpc, admin = list(ports.random_free().values())[:2]
    env = {**program.env, "DIAPHANE_GRPC_ADDRESS": "127.0.0.1", "DIAPHANE_GRPC_PORT": str(grpc), "DIAPHANE_ADVERTISE": f"127.0.0.1:{grpc}",
           "DIAPHANE_ADMIN_PORT": str(admin)}
    second = subprocess.Popen(program.argv, env=env, stderr=subprocess.PIPE, text=True)
    incarnations, key = set(), "diaphane:worker:local"
    try:
        deadline = time.monotonic() + 60
        while second.poll() is None and time.monotonic() < deadline:
            incarnations.add(running.redis.hget(key, "incarnation"))
            time.sleep(0.1)
        assert second.wait(1) == 78
        said = second.stderr.read()
        assert f"another renderd with this name is running at unix:{running.stack.settings.socket('renderd')}" in said, said
        assert len(incarnations - {None}) == 1, "the name went to and fro"    # None: a heartbeat was late
    finally:
        if second.poll() is None:
            second.kill()


def test_ten_thousand_scenes_per_second_close_only_that_stream(running, opened, unharmed):
    viewer = Viewer(running.url, opened[1])
    viewer.frame()
    update = ClientMessage()
    update.scene.scene.CopyFrom(viewer.config.scene)
    sending = threading.Event()

    def flood():
        # Ten times as many, because a busy machine may need a while to send a thousand of them within one second.
        try:
            for number in range(100_000):
                update.scene.input_seq = viewer.input_seq + 1 + number
                viewer.socket.send(update.SerializeToString())
        except Exception:  # noqa: BLE001 - closed: that is the point
            pass
        sending.set()

    thread = threading.Thread(target=flood)
    thread.start()
    assert viewer.close_code() == 4429
    thread.join()
    assert sending.is_set()


def test_a_message_of_100_megabytes_is_not_buffered(running, one, opened, unharmed):
    before = resident_mb(running.pids["gateway"])
    with connect_raw(running.ports["stream"]) as raw:
        raw.sendall(handshake(running.url, opened[1][-64:]))
        assert raw.recv(4096).startswith(b"HTTP/1.1 101 ")
        time.sleep(0.2)
        sent = 0
        try:
            raw.sendall(frame(2, b"", length=100 << 20))
            while sent < 100 << 20:
                sent += raw.send(b"\0" * (1 << 20))
        except OSError:
            pass
        assert sent < 50 << 20, "it was read to the end"
    assert resident_mb(running.pids["gateway"]) - before < 20


def test_an_incomplete_message_does_not_affect_others(running, opened, unharmed):
    files = f"/proc/{running.pids['gateway']}/fd"
    before = len(os.listdir(files))
    with connect_raw(running.ports["stream"]) as raw:
        raw.sendall(handshake(running.url, opened[1][-64:]))
        assert raw.recv(4096).startswith(b"HTTP/1.1 101 ")
        raw.sendall(frame(2, b"x" * 400, length=1000))  # then the connection is cut
        time.sleep(0.3)
        seq = unharmed.turn(1)
        unharmed.frame(condition=lambda shown: shown.input_seq >= seq)
    running.wait_until(lambda: len(os.listdir(files)) <= before + 2, what="its descriptors to be given back")


def test_a_truncated_protobuf_closes_the_stream_but_not_the_session(running, one, opened, unharmed):
    viewer = Viewer(running.url, opened[1])
    seq = viewer.turn(12)
    viewer.frame(condition=lambda shown: shown.input_seq >= seq)
    update = ClientMessage()
    update.scene.input_seq = seq + 1
    update.scene.scene.CopyFrom(viewer.config.scene)
    whole = update.SerializeToString()
    viewer.socket.send(whole[:len(whole) // 2])
    assert viewer.close_code() == 4400
    again = Viewer(running.url, wait_ticket(one, opened[0]))
    assert again.config.scene == viewer.config.scene
    again.leave()


def test_stale_epochs_and_invalid_numbers_are_ignored(running, opened, unharmed):
    viewer = Viewer(running.url, opened[1])
    seq = viewer.turn(15)
    shown = viewer.frame(condition=lambda picture: picture.input_seq >= seq)
    for number, epoch in ((0, 0), (1, 1), (2**63, 0), (shown.seq, shown.epoch - 1), (shown.seq - 1, 2**64 - 1)):
        message = ClientMessage()
        message.ack.seq, message.ack.epoch = number, epoch
        viewer.send(message)
    stale = ClientMessage()
    stale.scene.input_seq = seq  # the previous number
    stale.scene.scene.CopyFrom(viewer.config.scene)
    stale.scene.scene.camera.eye.x += 500
    viewer.send(stale)
    after = viewer.turn(1)
    newer = viewer.frame(condition=lambda picture: picture.input_seq >= after)
    assert newer.epoch > shown.epoch
    viewer.leave()


def test_a_stream_url_works_once_in_time_and_only_for_its_user(running, one, ball, opened, unharmed):
    other = person(running)
    problem(other.http.post(f"/v1/sessions/{opened[0]}/tickets"), 404, "not-found")
    assert other.http.delete(f"/v1/sessions/{opened[0]}").status_code == 404

    viewer = Viewer(running.url, opened[1])
    viewer.frame()
    assert Viewer(running.url, opened[1], greet=False).close_code() == 4401, "used"

    late = wait_ticket(one, opened[0])
    key = f"diaphane:ticket:{late[-64:]}"
    assert 0 < running.redis.ttl(key) <= 30
    running.redis.pexpire(key, 1)
    time.sleep(0.01)
    assert Viewer(running.url, late, greet=False).close_code() == 4401, "too old"
    seq = viewer.turn(3)
    viewer.frame(condition=lambda shown: shown.input_seq >= seq)
    viewer.leave()


FAKETIME = "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1"


def clock_of(stack, name: str) -> float:
    """Returns the program's time in its newest log line."""
    # The last line may be half written.
    newest = stack.log(name).rpartition("\n")[0].rpartition("\n")[2]
    return datetime.fromisoformat(json.loads(newest)["time"]).timestamp()


def test_wall_clock_jumps_do_not_end_streams_or_refuse_users(stack_factory, all_stacks):
    """The clocks of api, gateway and renderd jump an hour ahead and an hour back. The monotonic clock is unaffected, and so is
    Redis, whose time is the only one that two programs share."""
    offset = all_stacks.folder() / "offset"
    offset.write_text("+0\n")
    offset.chmod(0o644)
    stack = stack_factory(only=PROGRAMS)
    for name in ("api", "gateway", "renderd"):
        held = stack.stack.running_[name]
        held.program = replace(held.program, env={
            **held.program.env, "LD_PRELOAD": FAKETIME, "FAKETIME_TIMESTAMP_FILE": str(offset), "FAKETIME_NO_CACHE": "1",
            "FAKETIME_DONT_FAKE_MONOTONIC": "1"})
        stack.stop(name)
        stack.start(name)
    stack.wait_ready("api", "gateway", "renderd")
    somebody = person(stack)
    ball = store_ball(stack, somebody, 24)
    session, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url)
    viewer.frame()
    pids = dict(stack.pids)
    for jump in (3600, -3600):
        offset.write_text(f"{jump:+d}\n")
        begun = time.monotonic()
        while time.monotonic() - begun < 5:  # longer than a heartbeat and two polls of it
            seq = viewer.turn(1)
            viewer.frame(condition=lambda shown, seq=seq: shown.input_seq >= seq)
            time.sleep(0.2)
        _, url = open_session(somebody, ball)
        another = Viewer(stack.url, url)
        another.frame()
        another.leave()
        for name in ("api", "gateway", "renderd"):
            # The gateway logs the end of the stream a moment after the viewer has left.
            stack.wait_until(lambda name=name, jump=jump: abs(clock_of(stack, name) - time.time() - jump) < 600, what=f"the jump of {name}'s clock")
    viewer.leave()
    back_again(stack, somebody, session).leave()
    assert dict(stack.pids) == pids
