"""The stream on real components: browser side, edge, gateway, Redis, renderd."""

from __future__ import annotations

import os
import signal
import threading
import time
import uuid

import pytest
from api_client import person, problem
from stream_helpers import (PATIENCE_S, PROGRAMS, ClientMessage, Viewer, come_back, new_ticket, open_session, store_ball, wait_saved,
                            wait_ticket)
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect


@pytest.fixture
def breakable(stack_factory):
    """A separate stack with a user and a ball: stack, person, data set."""
    stack = stack_factory(only=PROGRAMS)
    somebody = person(stack)
    return stack, somebody, store_ball(stack, somebody)


def test_a_scene_changes_the_picture_and_the_epoch(running, session):
    viewer = Viewer(running.url, session[1])
    assert viewer.config.session_id == session[0]
    assert {preset.name for preset in viewer.config.presets} == {"skin", "muscle", "bone", "through", "airways"}
    # On a slow machine, a smaller preview may come before it.
    first = viewer.frame(condition=lambda frame: frame.width == 96)
    assert first.data[:2] == b"\xff\xd8" and first.height == 96
    seq = viewer.turn(40)
    after = viewer.frame(condition=lambda frame: frame.input_seq >= seq)
    assert after.epoch > first.epoch and after.data != first.data
    # On a slow machine, a picture that moves is smaller, and its whole size is another epoch.
    first_errors = {after.epoch: after.error}
    viewer.frame(condition=lambda frame: frame.error < first_errors.setdefault(frame.epoch, frame.error))
    viewer.leave()


def test_the_error_curve_of_a_session_has_a_point_for_each_pass(running, one, session):
    path = f"/v1/sessions/{session[0]}/error-curve"
    assert one.http.get(path).json()["points"] == [], "nobody has looked yet"
    viewer = Viewer(running.url, session[1])
    shown = viewer.frame(condition=lambda frame: frame.iteration >= 16)
    curve = one.http.get(path).json()
    assert curve["epoch"] == shown.epoch
    samples = [point["samples"] for point in curve["points"]]
    assert samples == sorted(set(samples)) and samples[-1] >= 16
    assert curve["points"][-1]["error"] < curve["points"][0]["error"]
    viewer.leave()


def test_an_invalid_scene_is_refused_and_the_session_continues(running, session):
    viewer = Viewer(running.url, session[1])
    viewer.frame()
    for value in (float("nan"), float("inf")):
        update = ClientMessage()
        viewer.input_seq += 1
        update.scene.input_seq = viewer.input_seq
        update.scene.scene.CopyFrom(viewer.config.scene)
        update.scene.scene.camera.eye.x = value
        viewer.send(update)
        refusal = viewer.until("problem")
        assert refusal.input_seq == viewer.input_seq and not refusal.fatal
    seq = viewer.turn(20)
    viewer.frame(condition=lambda frame: frame.input_seq >= seq)
    viewer.leave()


def test_a_reload_restores_the_scene(running, one, session):
    viewer = Viewer(running.url, session[1])
    viewer.frame()
    viewer.turn(33)
    viewer.leave()  # at once: the last message still counts

    def is_there() -> bool:
        # The new connection may get the state from before the old one's last message.
        again = Viewer(running.url, wait_ticket(one, session[0]))
        again.leave()
        return again.config.scene == viewer.config.scene

    running.wait_until(is_there, what="the scene that was sent last")


def test_a_second_window_takes_over_the_session(running, one, session):
    first = Viewer(running.url, session[1])
    first.frame()
    second = Viewer(running.url, wait_ticket(one, session[0]))
    assert first.close_code() == 4409
    second.frame()
    second.leave()


def test_ending_a_session_ends_its_stream(running, one, ball):
    session, url = open_session(one, ball)
    viewer = Viewer(running.url, url)
    viewer.frame()
    assert one.http.delete(f"/v1/sessions/{session}").status_code == 204
    assert viewer.close_code() == 4404
    problem(one.http.post(f"/v1/sessions/{session}/tickets"), 404, "not-found")


def test_a_ticket_opens_one_connection(running, session):
    viewer = Viewer(running.url, session[1])
    assert Viewer(running.url, session[1], greet=False).close_code() == 4401
    assert Viewer(running.url, "/stream?ticket=" + "0" * 64, greet=False).close_code() == 4401
    viewer.frame()
    viewer.leave()


def test_a_foreign_origin_is_refused_without_using_up_the_ticket(running, session):
    with pytest.raises(InvalidStatus) as refused:
        connect(running.url.replace("http", "ws", 1) + session[1], origin="http://evil.test", subprotocols=["diaphane.v1"], open_timeout=PATIENCE_S)
    assert refused.value.response.status_code == 403
    viewer = Viewer(running.url, session[1])
    viewer.frame()
    viewer.leave()


def test_a_viewer_that_stops_reading_does_not_slow_others(running, one, ball, session):
    """It acknowledges without reading, so that frames accumulate, while the other viewer continues at its pace."""
    stalled_session, url = open_session(one, ball)
    stalled = Viewer(running.url, url, side=512)
    stalled.frame()
    other = Viewer(running.url, session[1])
    stopping = threading.Event()

    def acknowledge_blindly():
        # Nothing calls `receive` from now on, so the client's queue fills and it stops reading from its socket.
        seq = 1
        while not stopping.wait(0.02):
            seq += 1
            message = ClientMessage()
            message.ack.seq, message.ack.epoch = seq, 1
            try:
                stalled.send(message)
            except Exception:  # noqa: BLE001 - closed by the gateway: that is the point
                return

    thread = threading.Thread(target=acknowledge_blindly)
    thread.start()
    waits = []
    for _ in range(20):
        seq = other.turn(1)
        begun = time.monotonic()
        other.frame(condition=lambda frame, seq=seq: frame.input_seq >= seq)
        waits.append(time.monotonic() - begun)
    stopping.set()
    thread.join()
    other.leave()
    stalled.socket.socket.close()
    one.http.delete(f"/v1/sessions/{stalled_session}")
    # The gateway gives a stalled viewer up after 10 s. A viewer that waited for the stalled one would have waited that long once.
    assert max(waits) < 8


def test_a_thumbnail_is_rendered_by_a_worker_and_then_cached(running, one, ball):
    # A busy worker may need longer than a request waits, which is then told to come again.
    running.wait_until(lambda: one.http.get(f"/v1/data-sets/{ball}/thumbnails/bone").status_code != 503, what="the picture")
    for _ in range(2):
        answer = one.http.get(f"/v1/data-sets/{ball}/thumbnails/bone")
        assert answer.status_code == 200 and answer.content[:2] == b"\xff\xd8"


def test_the_gateway_exports_metrics(running, session):
    viewer = Viewer(running.url, session[1])
    viewer.frame()
    assert Viewer(running.url, session[1], greet=False).close_code() == 4401, "a ticket is for one use"
    # Streams of earlier tests may still be ending.
    running.wait_until(lambda: "diaphane_stream_attached 1" in running.metrics("gateway").splitlines(), what="one stream")
    assert 'diaphane_stream_refusals_total{reason="ticket"}' in running.metrics("gateway")
    viewer.leave()


def back_again(stack, somebody, session: str) -> Viewer:
    """Reconnects like the page: requests tickets until a picture arrives."""

    def with_picture() -> Viewer | None:
        if not (url := new_ticket(somebody, session)):
            return None
        viewer = Viewer(stack.url, url)
        viewer.frame()
        return viewer

    return come_back(with_picture)


def test_a_session_recovers_with_its_scene_after_its_worker_was_killed(breakable):
    stack, somebody, ball = breakable
    session, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url)
    viewer.frame()
    viewer.turn(77)
    viewer.frame(condition=lambda frame: frame.input_seq >= viewer.input_seq)
    wait_saved(stack, session, viewer.input_seq)
    begun = time.monotonic()
    stack.kill("renderd")
    assert viewer.close_code() == 4503
    again = back_again(stack, somebody, session)
    assert again.config.scene == viewer.config.scene
    assert again.config.input_seq == viewer.input_seq
    print(f"picture back after {time.monotonic() - begun:.2f} s")
    again.leave()


def test_sessions_leave_a_worker_that_hangs(breakable):
    stack, somebody, ball = breakable
    _, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url)
    viewer.frame()
    pid = stack.pids["renderd"]
    os.kill(pid, signal.SIGSTOP)
    try:
        assert viewer.close_code() == 4503
    finally:
        os.kill(pid, signal.SIGCONT)


def test_streams_survive_an_outage_of_redis(breakable):
    stack, somebody, ball = breakable
    _, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url)
    viewer.frame()
    stack.stop("redis")
    for _ in range(8):
        seq = viewer.turn(3)
        viewer.frame(condition=lambda frame, seq=seq: frame.input_seq >= seq)
        time.sleep(0.5)
    answer = somebody.http.post("/v1/sessions", json={"data_set_id": ball}, headers={"Idempotency-Key": uuid.uuid4().hex})
    problem(answer, 503, "unavailable")
    assert "retry-after" in answer.headers
    stack.start("redis")
    made = stack.wait_until(lambda: somebody.http.post("/v1/sessions", json={"data_set_id": ball}).status_code == 201,
                            what="a new session")
    assert made
    seq = viewer.turn(3)
    viewer.frame(condition=lambda frame: frame.input_seq >= seq)
    viewer.leave()


def test_a_stopping_gateway_asks_its_viewers_to_reconnect(breakable):
    stack, somebody, ball = breakable
    session, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url)
    viewer.frame()
    stopping = threading.Thread(target=stack.stop, args=("gateway",))
    stopping.start()
    assert viewer.close_code() == 1001
    stopping.join()
    assert not any("did not stop in time" in event for event in stack.events)
    stack.start("gateway")
    stack.wait_ready("gateway")
    back_again(stack, somebody, session).leave()
