"""CPU priorities of programs that lead sessions of their own."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import pytest

from harness import wait_until  # also puts tools/ on the path
from devtool import plan
from devtool.priority import GroupPriorities, family, first_cores

needs_groups = pytest.mark.skipif(not Path("/proc/self/autogroup").exists(), reason="this kernel does not group sessions")


@pytest.fixture
def server():
    """A program like Postgres: it leads a session, and so does its child."""
    process = subprocess.Popen(["/bin/sh", "-c", "setsid sleep 600 & wait"], start_new_session=True)
    wait_until(lambda: len(sessions(process.pid)) == 2, what="the child's session")
    yield process
    for pid in list(family(process.pid))[::-1]:
        os.kill(pid, signal.SIGKILL)
    process.wait()


def sessions(pid: int) -> set[int]:
    return {os.getsid(one) for one in family(pid)}


def nice_of_group(pid: int) -> int:
    return int(Path(f"/proc/{pid}/autogroup").read_text(encoding="ascii").split()[-1])


@needs_groups
def test_sessions_of_a_program_and_its_children_get_its_priority(server):
    GroupPriorities().apply([(server.pid, 7)])
    pids = list(family(server.pid))
    assert len(pids) == 2
    # An ordinary user may change one group per 0.1 s.
    assert all(nice_of_group(pid) == 7 for pid in pids) or os.geteuid() != 0


@needs_groups
def test_the_priority_of_each_session_is_set_once(server):
    priorities = GroupPriorities()
    priorities.apply([(server.pid, 7)])
    Path(f"/proc/{server.pid}/autogroup").write_text("3", encoding="ascii")
    priorities.apply([(server.pid, 7)])
    assert nice_of_group(server.pid) == 3


def test_a_refused_priority_change_is_retried(tmp_path, monkeypatch):
    # In an empty folder, this process has no children, whatever other tests have started.
    priorities, answers = GroupPriorities(tmp_path), [BlockingIOError(), None]

    def write(self, *_, **__):
        answer = answers.pop(0)
        if answer:
            raise answer

    monkeypatch.setattr(Path, "write_text", write)
    for _ in range(3):
        priorities.apply([(os.getpid(), 7)])
    assert not answers


def test_programs_that_nobody_waits_for_have_lower_priorities(tmp_path):
    from devtool import ports
    from devtool.layout import Layout

    settings = plan.Settings(data=tmp_path, ports=dict(ports.DEFAULTS), layout=Layout(tmp_path, tmp_path, tmp_path, tmp_path),
                             postgres_password="x")
    nice = {program.name: program.nice for program in plan.programs(settings)}
    assert nice["renderd"] == nice["gateway"] == nice["edge"] == 0
    assert 0 < nice["api"] <= nice["postgres"] <= nice["ingestd"]


def test_background_work_gets_the_first_cores_that_may_be_used():
    assert first_cores(2, {7, 3, 5}) == [3, 5]
    assert first_cores(9, {7, 3}) == [3, 7]
    assert first_cores(0, {7, 3}) == [3, 7]
    assert first_cores(1) == [min(os.sched_getaffinity(0))]
