"""Several workers that make one picture: an assistant killed and back in mid-session."""

from __future__ import annotations

import os
import signal
import socket
import subprocess

import pytest
from api_client import person
from stream_help import Viewer, open_session, store_ball


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Helper:
    """A renderd that helps and has no sessions of its own: no Redis is where it looks for one."""

    def __init__(self, stack, port: int):
        self.stack, self.port, self.process = stack, port, None
        self.log = stack.data_dir / "logs" / "helper.log"

    def start(self) -> None:
        user = self.stack.stack.run_as
        binary = self.stack.stack.layout.bin / "diaphane-renderd"
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [str(binary), "--worker-id=helper", f"--redis=127.0.0.1:{free_port()}", f"--grpc-port={self.port}",
                 f"--advertise=127.0.0.1:{self.port}", f"--admin-port={free_port()}", "--engine=cpu", "--threads=1",
                 f"--volume-dir={self.stack.data_dir / 'volumes'}"],
                stderr=log, **user.popen())

    def kill(self) -> None:
        os.kill(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def loads(self) -> int:
        return self.log.read_text().count('"volume_loaded"')


@pytest.fixture
def assisted(stack_factory):
    port = free_port()
    stack = stack_factory(only=("postgres", "redis", "api", "renderd", "edge"),
                          extra_env={"DIAPHANE_ASSIST": f"127.0.0.1:{port}", "DIAPHANE_MAX_ERROR": "0.0005"})
    helper = Helper(stack, port)
    helper.start()
    yield stack, helper
    helper.kill()


def test_an_assistant_killed_in_mid_session_costs_only_its_share(assisted):
    stack, helper = assisted
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    _, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url, side=256)
    viewer.frame()
    stack.wait_until(lambda: helper.loads() == 1, what="the assistant has the volume")
    seq = viewer.turn(30)
    before = viewer.frame(condition=lambda frame: frame.input_seq >= seq and frame.iteration >= 8)

    helper.kill()
    stack.wait_until(lambda: '"assistant_lost"' in stack.log("renderd"), what="the loss is noticed")
    goes_on = viewer.frame(condition=lambda frame: frame.iteration > before.iteration)
    assert goes_on.epoch == before.epoch, "the same picture, better"
    assert goes_on.error < before.error
    seq = viewer.turn(30)
    viewer.frame(condition=lambda frame: frame.input_seq >= seq)

    helper.start()
    stack.wait_until(lambda: helper.loads() == 2, what="it is back in the same session")
    seq = viewer.turn(30)
    better = viewer.frame(condition=lambda frame: frame.input_seq >= seq and frame.iteration >= 8)
    assert better.error < 0.5
    assert viewer.config.session_id and stack.pids["renderd"]
    viewer.leave()
