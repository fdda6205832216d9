"""Several workers that render one picture: an assistant is killed and restarted during a session."""

from __future__ import annotations

import pytest
from api_client import person
from stream_helpers import OtherWorker, Viewer, free_port, open_session, store_ball


@pytest.fixture
def assisted(stack_factory):
    port = free_port()
    stack = stack_factory(only=("postgres", "redis", "api", "gateway", "renderd", "edge"),
                          extra_env={"DIAPHANE_ASSIST": f"127.0.0.1:{port}", "DIAPHANE_MAX_ERROR": "0.0005"})
    helper = OtherWorker(stack, "helper", f"--grpc-port={port}")
    helper.start()
    yield stack, helper
    helper.kill()


def test_killing_an_assistant_loses_only_its_samples(assisted):
    stack, helper = assisted
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    _, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url, side=256)
    viewer.frame()
    stack.wait_until(lambda: helper.loads() >= 1, what="the assistant has the volume")
    seq = viewer.turn(30)
    # At rest: while the picture moves it may be smaller, and its whole size is another epoch.
    before = viewer.frame(condition=lambda frame: frame.input_seq >= seq and frame.width == 256 and frame.iteration >= 8)

    helper.kill()
    stack.wait_until(lambda: '"assistant_lost"' in stack.log("renderd"), what="the loss is noticed")
    # Twice the samples, because the estimate of the error varies a little from one pass to the next.
    goes_on = viewer.frame(condition=lambda frame: frame.iteration >= 2 * before.iteration)
    assert goes_on.epoch == before.epoch, "the same picture, better"
    assert goes_on.error < before.error
    seq = viewer.turn(30)
    viewer.frame(condition=lambda frame: frame.input_seq >= seq)

    loads = helper.loads()
    helper.start()
    stack.wait_until(lambda: helper.loads() > loads, what="it is back in the same session")
    seq = viewer.turn(30)
    better = viewer.frame(condition=lambda frame: frame.input_seq >= seq and frame.iteration >= 8)
    assert better.error < 0.5
    assert viewer.config.session_id and stack.pids["renderd"]
    viewer.leave()
