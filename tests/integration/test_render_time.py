"""Render time on real components: who is charged for which picture, who is stopped and how, and that others are not affected."""

from __future__ import annotations

import pytest
from api_client import CONTRACT, client, person, problem
from stream_helpers import PROGRAMS, Viewer, open_session, store_ball

SCENE = CONTRACT.spec["components"]["schemas"]["Scene"]["example"]
KEY = "3" * 64


@pytest.fixture(scope="module")
def running(all_stacks):
    """Pictures that are rendered for as long as someone views them."""
    stack = all_stacks.open(only=PROGRAMS, extra_env={"DIAPHANE_MAX_ERROR": "0.0001"})
    yield stack
    all_stacks.shut(stack)


def used(who) -> int:
    """Returns milliseconds."""
    return who.http.get("/v1/me").json()["render_time"]["used_ms"]


def turn_until(running, viewers: list[Viewer], done) -> None:
    """Each viewer rotates and receives the picture, until it is so."""
    def go_on() -> bool:
        for viewer in viewers:
            seq = viewer.turn(3)
            viewer.frame(condition=lambda frame, seq=seq: frame.input_seq >= seq, timeout=60)
        return done()
    running.wait_until(go_on, 120, "it")


def test_a_user_without_render_time_is_disconnected_with_a_message(running, one, ball):
    other = person(running)
    theirs = store_ball(running, other)
    running.psql("UPDATE users SET render_quota_ms = 1500 WHERE email = %s", one.email)
    session, url = open_session(one, ball)
    mine, other_view = Viewer(running.url, url), Viewer(running.url, open_session(other, theirs)[1])
    turn_until(running, [mine, other_view], lambda: used(one) >= 1500)
    spent = one.http.get("/v1/me").json()["render_time"]
    assert spent["pictures_end_at"] is not None and spent["quota_ms"] == 1500
    document = problem(one.http.post("/v1/sessions", json={"data_set_id": ball}), 403, "render-time-spent")
    assert "used all of your rendering time" in document["detail"]
    # The picture continues during its grace period.
    turn_until(running, [mine], lambda: True)
    running.psql("UPDATE render_time SET warned_at = now() - interval '10 minutes' WHERE user_id = %s", one.id)
    assert mine.close_code() == 4404, "the session has ended"
    problem(one.http.post(f"/v1/sessions/{session}/tickets"), 404, "not-found")
    # The other user's picture was neither ended nor charged for this.
    turn_until(running, [other_view], lambda: used(other) > 0)
    assert other.http.get("/v1/me").json()["render_time"]["pictures_end_at"] is None
    other_view.leave()
    running.psql("UPDATE users SET render_quota_ms = DEFAULT WHERE email = %s", one.email)


def test_an_idle_session_also_ends_after_the_grace_period(stack_factory):
    """A finished picture uses no time, so nothing more is recorded."""
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_MAX_ERROR": "0.05"})
    who = person(stack)
    scan = store_ball(stack, who)
    session, url = open_session(who, scan)
    viewer = Viewer(stack.url, url)
    viewer.until("state", 120, lambda state: state.converged)
    stack.wait_until(lambda: used(who) > 0, 60, "what it took")
    # An administrator sets a quota below the used time, and nobody touches the picture.
    stack.psql("UPDATE users SET render_quota_ms = 0 WHERE email = %s", who.email)
    stack.wait_until(lambda: who.http.get("/v1/me").json()["render_time"]["pictures_end_at"], 30, "its end said")
    assert who.http.post(f"/v1/sessions/{session}/tickets").status_code == 201, "within its grace it continues"
    stack.psql("UPDATE render_time SET warned_at = now() - interval '3 minutes' WHERE user_id = %s", who.id)
    assert viewer.close_code() == 4404, "the session has ended"
    problem(who.http.post("/v1/sessions", json={"data_set_id": scan}), 403, "render-time-spent")


def test_preset_pictures_and_visitors_use_no_render_time(running):
    owner, payer = person(running), person(running)
    scan = store_ball(running, owner)
    preset = owner.http.post(f"/v1/data-sets/{scan}/presets", json={"name": "Mine", "scene": SCENE}).json()
    path = f"/v1/data-sets/{scan}/presets/{preset['id']}/thumbnail"
    picture = running.wait_until(lambda: (answer := owner.http.get(path)).status_code == 200 and answer, 120, "the picture")
    assert picture.content[:2] == b"\xff\xd8" and picture.headers["etag"]
    assert owner.http.get(path, headers={"If-None-Match": picture.headers["etag"]}).status_code == 304
    owner.http.post(f"/v1/data-sets/{scan}/default-preset", json={"preset_id": preset["id"]})
    link = owner.http.post(f"/v1/data-sets/{scan}/links", json={"hours": 1}).json()["token"]
    came = client(running).post("/v1/visits", json={"token": link, "key": KEY})
    assert came.status_code == 201, came.text
    visitor = Viewer(running.url, came.json()["stream_url"])
    assert visitor.config.scene.camera.eye.y == -500 and visitor.config.input_seq == 0
    assert [c.name for c in visitor.config.scene.transfer_function.channels] == ["bone"]
    first = visitor.frame()
    assert first.input_seq == 0, "what is seen first is the default"
    # Once the user's own picture is counted, all previous ones would have been counted.
    paying = Viewer(running.url, open_session(payer, store_ball(running, payer))[1])
    turn_until(running, [visitor, paying], lambda: used(payer) > 0)
    assert used(owner) == 0
    assert running.psql("SELECT 1 FROM render_time WHERE user_id = %s", owner.id) == []
    for viewer in (visitor, paying):
        viewer.leave()
