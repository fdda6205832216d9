"""The stack with only the stores. It needs none of Diaphane's programs, so these tests run first and fast."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

from harness import REPO
from devtool import datadir, ports
from devtool.processes import Identity, boot, kill_group, wait_gone
from devtool.stack import Stack


def test_the_stores_run_as_an_ordinary_user(stores):
    assert stores.psql("SELECT current_user, current_database()") == [("diaphane", "diaphane")]
    assert stores.redis.ping()
    for program in ("postgres", "redis"):
        assert os.stat(f"/proc/{stores.pids[program]}").st_uid != 0


def test_the_database_role_is_not_a_superuser(stores):
    assert stores.psql("SELECT rolsuper FROM pg_roles WHERE rolname = current_user") == [(False,)]


def test_a_killed_program_is_restarted(stores):
    before = stores.pids["redis"]
    assert stores.kill("redis") == before
    stores.wait_ready("redis")
    assert stores.pids["redis"] != before


def test_writes_survive_killing_the_store(stores):
    stores.psql("CREATE TABLE IF NOT EXISTS house_test (value int)")
    stores.psql("INSERT INTO house_test VALUES (%s)", 42)
    stores.kill("postgres")
    stores.wait_ready("postgres")
    rows = stores.psql("SELECT value FROM house_test")
    stores.psql("DROP TABLE house_test")
    assert rows == [(42,)]


def test_a_stopped_program_stays_stopped_until_it_is_started(stores):
    stores.stop("redis")
    time.sleep(0.5)
    assert "redis" not in stores.pids
    stores.start("redis")
    stores.wait_ready("redis")


def test_stop_and_start_on_the_same_directory_keeps_everything(all_stacks):
    first = all_stacks.open(only=("postgres", "redis"))
    first.psql("CREATE TABLE kept (value text)")
    first.psql("INSERT INTO kept VALUES ('here')")
    first.redis.set("kept", "here")
    all_stacks.shut(first, keep_data=True)
    assert not any("did not stop in time" in event for event in first.events)
    again = all_stacks.open(only=("postgres", "redis"), data_dir=first.data_dir)
    try:
        assert again.psql("SELECT value FROM kept") == [("here",)]
        assert again.redis.get("kept") == "here"
    finally:
        all_stacks.shut(again)


def test_stopping_a_stack_leaves_no_process_running(all_stacks):
    running = all_stacks.open(only=("postgres", "redis"))
    identities = [Identity.of(pid) for pid in running.pids.values()]
    all_stacks.shut(running)
    assert wait_gone(identities, 0.5) == []


def test_a_recorded_pid_of_an_unrelated_process_is_left_alone(all_stacks):
    bystander = os.fork()
    if bystander == 0:
        signal.pause()
        os._exit(0)
    try:
        data = all_stacks.folder()
        real = Identity.of(bystander)
        (data / "secrets").mkdir(mode=0o700)
        datadir.write_record(data, {"programs": [{"name": "redis", "pid": real.pid, "start": real.start - 1}]})
        running = all_stacks.open(only=("redis",), data_dir=data)
        assert real.alive()
        all_stacks.shut(running)
    finally:
        os.kill(bystander, signal.SIGKILL)
        os.waitpid(bystander, 0)


def workers_of(running) -> list[Identity]:
    """Returns nginx's workers once they exist."""
    master = running.pids["edge"]
    return [one for one in Identity.of(master).group() if one.pid != master]


def test_a_killed_edge_is_restarted_without_orphaned_workers(all_stacks):
    running = all_stacks.open(only=("edge",))
    try:
        workers = running.wait_until(lambda: workers_of(running), what="workers")
        before = running.kill("edge")
        running.wait_ready("edge")
        assert running.pids["edge"] != before
        assert wait_gone(workers, 5) == [], "they would keep the port"
        assert "Address already in use" not in running.log("edge") and "bind()" not in running.log("edge")
    finally:
        all_stacks.shut(running)


def leave_workers(all_stacks) -> tuple[Path, list[Identity]]:
    """Kills an edge's supervisor and then its master. Returns the remaining workers."""
    data, given = all_stacks.folder(), ports.random_free()
    (data / "secrets").mkdir(mode=0o700)
    all_stacks.run_as.own(data / "secrets")
    app = all_stacks.layout()
    supervisor = os.fork()
    if supervisor == 0:
        Stack(data=data, ports=given, layout=app, run_as=all_stacks.run_as, durable=False, only=("edge",)).start()
        signal.pause()
        os._exit(0)
    try:
        deadline = time.monotonic() + 30
        master = None
        while time.monotonic() < deadline and not (master and len(master.group()) > 1 and datadir.read_record(data).get("ready")):
            time.sleep(0.05)
            master = next((datadir.recorded(entry) for entry in datadir.read_record(data).get("programs", [])), None)
        assert master
    finally:
        os.kill(supervisor, signal.SIGKILL)
        os.waitpid(supervisor, 0)
        ports.give_back(given.values())    # not before the edge listens, because other tests choose ports meanwhile
    workers = [one for one in master.group() if one != master]
    master.send(signal.SIGKILL)
    assert wait_gone([master], 5) == []
    assert workers and all(one.alive() for one in workers), "nginx's workers outlive their master"
    return data, workers


def test_down_ends_orphaned_edge_workers(all_stacks):
    data, workers = leave_workers(all_stacks)
    done = subprocess.run([str(REPO / "diaphane"), "down", "--data", str(data)], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "Stopped" in done.stdout, done.stdout + done.stderr
    assert wait_gone(workers, 1) == []


def test_the_next_start_ends_orphaned_edge_workers(all_stacks):
    data, workers = leave_workers(all_stacks)
    running = all_stacks.open(only=("edge",), data_dir=data)
    try:
        assert wait_gone(workers, 1) == []
    finally:
        all_stacks.shut(running)


def test_a_process_group_of_another_boot_or_leader_is_left_alone(all_stacks):
    bystander = subprocess.Popen(["/bin/sleep", "100"], start_new_session=True)
    try:
        real = Identity.of(bystander.pid)
        recorded = {"name": "edge", "pid": real.pid, "start": real.start}
        assert datadir.left_running({"boot": boot(), "programs": [recorded]}) == [("edge", real)]
        assert datadir.left_running({"boot": "another", "programs": [recorded]}) == []
        assert datadir.left_running({"boot": boot(), "programs": [{**recorded, "start": real.start - 1}]}) == []
        assert kill_group(Identity(real.pid, real.start - 1)) == [] and real.alive()
    finally:
        bystander.kill()
        bystander.wait()
