"""A worker with several devices, here CPU engines: each session is at home on one of them."""

from __future__ import annotations

import pytest
from api_client import person
from stream_helpers import Viewer, open_session, store_ball


@pytest.fixture
def two_devices(stack_factory):
    return stack_factory(only=("postgres", "redis", "api", "gateway", "renderd", "edge"),
                         extra_env={"DIAPHANE_DEVICES": "0,1", "DIAPHANE_MAX_ERROR": "0.02"})


def test_sessions_of_several_devices_get_their_pictures(two_devices):
    stack = two_devices
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    viewers = []
    for _ in range(2):
        _, url = open_session(somebody, ball)
        viewers.append(Viewer(stack.url, url, side=128))
    for viewer in viewers:
        viewer.frame()
        assert viewer.config.device.startswith("2 x ")
    # Both move, so that each device is needed by its own session.
    for _ in range(3):
        turns = [(viewer, viewer.turn(20)) for viewer in viewers]
        for viewer, seq in turns:
            viewer.frame(condition=lambda frame, seq=seq: frame.input_seq >= seq)
    # One rests and the other device helps the last one, until its picture is finished.
    viewers[0].leave()
    seq = viewers[1].turn(30)
    done = viewers[1].frame(condition=lambda frame: frame.input_seq >= seq and frame.error <= 0.02)
    assert done.width == 128
    viewers[1].leave()
