"""A device's spare time is lent to the sessions of a peer that is asked for more than it has, or to one that is alone."""

from __future__ import annotations

import time

from api_client import person
from harness import metrics_at
from stream_helpers import PROGRAMS, OtherWorker, Viewer, open_session, store_ball


#: Seconds. A viewer who acknowledges nothing for 15 s gets no device time (kStalledAfter).
HEARS_EVERY = 5


def gauge(metrics: str, name: str) -> float:
    return next(float(line.split()[-1]) for line in metrics.splitlines() if line.startswith(f"{name} "))


def test_an_idle_peer_helps_until_it_gets_its_own_session(stack_factory):
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_LEND": "1", "DIAPHANE_MAX_ERROR": "0.0002"})
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    looking = [Viewer(stack.url, open_session(somebody, ball)[1], side=256) for _ in range(2)]
    neighbour = OtherWorker(stack, "neighbour", "--max-error=0.0002", redis=stack.redis_address)

    def moves(*viewers, until):
        """All of them rotate, which overloads their device, until it is so."""
        heard = time.monotonic()

        def step():
            nonlocal heard
            for viewer in viewers:
                viewer.turn(1 if viewer.input_seq % 2 else -1)
            if time.monotonic() - heard > HEARS_EVERY:
                for viewer in viewers:
                    viewer.frame()
                heard = time.monotonic()
            return until()
        return step

    try:
        for viewer in looking:
            viewer.frame()
        neighbour.start()
        worker = "diaphane:worker:neighbour"
        stack.wait_until(moves(*looking, until=lambda: float(stack.redis.hget(worker, "lent") or 0) > 0.1), timeout=60,
                         what="it renders for its neighbour's pictures")
        assert gauge(stack.metrics("renderd"), "diaphane_renderd_helpers") == 1
        assert gauge(metrics_at(neighbour.admin_port), "diaphane_renderd_helped_pictures") >= 1
        assert stack.log("renderd").count('"helper_requested"') == 1, "not to and fro"

        # Lent time does not block new sessions.
        session, url = open_session(somebody, ball)
        assert stack.redis.hget(f"diaphane:session:{session}", "worker") == "neighbour"
        visitor = Viewer(stack.url, url, side=256)
        looking.append(visitor)
        visitor.frame()
        stack.wait_until(moves(*looking, until=lambda: '"helper_released"' in stack.log("renderd")), timeout=60,
                         what="it is given back")
        stack.wait_until(moves(*looking, until=lambda: gauge(metrics_at(neighbour.admin_port), "diaphane_renderd_helped_pictures") == 0),
                         what="it helps nobody")
        for viewer in looking:
            seq = viewer.turn(30)
            viewer.frame(condition=lambda frame, seq=seq: frame.input_seq >= seq)

        visitor.leave()
        looking.remove(visitor)
        stack.wait_until(moves(*looking, until=lambda: stack.log("renderd").count('"helper_requested"') > 1), timeout=60,
                         what="it is asked again")
        neighbour.kill()
        stack.wait_until(moves(*looking, until=lambda: stack.log("renderd").count('"helper_released"') > 1), timeout=60,
                         what="a dead one is let go")
        for viewer in looking:
            seq = viewer.turn(30)
            viewer.frame(condition=lambda frame, seq=seq: frame.input_seq >= seq)
            viewer.leave()
    finally:
        neighbour.kill()


def busy_seconds(metrics: str) -> float:
    return next(float(line.split()[-1]) for line in metrics.splitlines()
                if line.startswith('diaphane_renderd_device_seconds_total{part="busy"}'))


def test_a_session_alone_uses_the_spare_time_of_an_idle_peer(stack_factory):
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_LEND": "1", "DIAPHANE_LEND_SPARE": "1", "DIAPHANE_MAX_ERROR": "0.0002"})
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    neighbour = OtherWorker(stack, "neighbour", "--max-error=0.0002", redis=stack.redis_address)
    worker = "diaphane:worker:neighbour"
    alone = Viewer(stack.url, open_session(somebody, ball)[1], side=256)

    def refines(until):
        def step():
            alone.frame()
            return until()
        return step

    def helped() -> float:
        return gauge(metrics_at(neighbour.admin_port), "diaphane_renderd_helped_pictures")

    try:
        neighbour.start()
        stack.wait_until(refines(lambda: helped() == 1), timeout=60, what="it is asked")
        assert '"worker":"neighbour","spare":true' in stack.log("renderd")
        # Nobody needs its help, so it still counts as idle.
        before = busy_seconds(metrics_at(neighbour.admin_port))
        stack.wait_until(refines(lambda: busy_seconds(metrics_at(neighbour.admin_port)) > before + 2), timeout=60, what="it is busy")
        assert float(stack.redis.hget(worker, "load")) == 0 and stack.redis.hget(worker, "lent") is None

        session, url = open_session(somebody, ball)
        assert stack.redis.hget(f"diaphane:session:{session}", "worker") == "neighbour"
        second = Viewer(stack.url, url, side=256)
        second.frame()
        stack.wait_until(refines(lambda: helped() == 0), timeout=60, what="its own session has it alone")
        seq = second.turn(30)
        second.frame(condition=lambda frame: frame.input_seq >= seq)
        second.leave()
        alone.leave()
    finally:
        neighbour.kill()
