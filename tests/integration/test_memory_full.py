"""A device with full memory: a session without memory continues on another worker, and nobody is affected."""

from __future__ import annotations

import pytest
from api_client import person
from stream_helpers import PROGRAMS, OtherWorker, Viewer, come_back, new_ticket, open_session, store_ball

#: A ball of 64^3 uses 0.6 MB with its tables, so one fits into 1 MB, and two do not.
SIDE, FITS_ONE_MB = 64, "1"


def worker_of(stack, session: str) -> str:
    return stack.redis.hget(f"diaphane:session:{session}", "worker")


@pytest.fixture
def two_workers(stack_factory):
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_VOLUME_MEMORY_MB": FITS_ONE_MB, "DIAPHANE_SLOTS": "50"})
    made = []

    def start_second() -> OtherWorker:
        worker = OtherWorker(stack, "second", "--slots=4", "--volume-memory-mb=50", redis=stack.redis_address)
        made.append(worker)
        worker.start()
        stack.wait_until(lambda: stack.redis.exists("diaphane:worker:second"), what="the second worker")
        return worker

    yield stack, start_second
    for worker in made:
        worker.kill()


def test_a_session_moves_when_a_worker_has_no_memory_for_it(two_workers):
    stack, start_second = two_workers
    somebody = person(stack)
    first, second, third = (store_ball(stack, somebody, SIDE) for _ in range(3))
    here, url = open_session(somebody, first)
    unharmed = Viewer(stack.url, url)
    unharmed.frame()
    worker = start_second()
    filler, url = open_session(somebody, second)
    Viewer(stack.url, url).frame()
    assert worker_of(stack, filler) == "second", "the least used"

    # The second worker has one of four slots in use. The first is the least used, and has no memory for another volume.
    session, url = open_session(somebody, third)
    assert worker_of(stack, session) == worker_of(stack, here)
    refused = Viewer(stack.url, url, greet=False)
    assert refused.close_code() == 4503, "the page asks for another place at once"
    moved = Viewer(stack.url, new_ticket(somebody, session))
    moved.frame()
    assert worker_of(stack, session) == "second"
    seq = unharmed.turn(30)
    unharmed.frame(condition=lambda frame: frame.input_seq >= seq)

    # Without another worker, the user is notified, and the session is kept until there is one.
    worker.kill()
    assert moved.close_code() == 4503
    # A killed process may still accept connections after its streams have broken.
    stack.wait_until(lambda: not stack.redis.exists("diaphane:worker:second"), what="its loss is known")
    answer = somebody.http.post(f"/v1/sessions/{session}/tickets")
    assert answer.status_code == 503 and "memory" in answer.json()["detail"], answer.text
    start_second()
    come_back(lambda: (again := new_ticket(somebody, session)) and Viewer(stack.url, again)).frame()
    seq = unharmed.turn(30)
    unharmed.frame(condition=lambda frame: frame.input_seq >= seq)
    unharmed.leave()
