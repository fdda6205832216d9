"""The house with the stores alone: no program of ours is needed, so these run first and fast."""

from __future__ import annotations

import os
import signal
import time

from house.processes import Identity, wait_gone


def test_the_stores_run_as_an_ordinary_user_and_answer(stores):
    assert stores.psql("SELECT current_user, current_database()") == [("diaphane", "diaphane")]
    assert stores.redis.ping()
    for program in ("postgres", "redis"):
        assert os.stat(f"/proc/{stores.pids[program]}").st_uid != 0


def test_the_programs_role_is_no_superuser(stores):
    assert stores.psql("SELECT rolsuper FROM pg_roles WHERE rolname = current_user") == [(False,)]


def test_a_killed_program_is_started_again(stores):
    before = stores.pids["redis"]
    assert stores.kill("redis") == before
    stores.wait_ready("redis")
    assert stores.pids["redis"] != before


def test_what_was_written_survives_a_kill_of_the_store(stores):
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


def test_stop_and_start_on_the_same_directory_keeps_everything(stack_house):
    first = stack_house.open(only=("postgres", "redis"))
    first.psql("CREATE TABLE kept (value text)")
    first.psql("INSERT INTO kept VALUES ('here')")
    first.redis.set("kept", "here")
    before = time.monotonic()
    stack_house.shut(first, keep_data=True)
    assert time.monotonic() - before < 5
    again = stack_house.open(only=("postgres", "redis"), data_dir=first.data_dir)
    try:
        assert again.psql("SELECT value FROM kept") == [("here",)]
        assert again.redis.get("kept") == "here"
    finally:
        stack_house.shut(again)


def test_nothing_of_a_stopped_stack_is_left_running(stack_house):
    running = stack_house.open(only=("postgres", "redis"))
    identities = [Identity.of(pid) for pid in running.pids.values()]
    stack_house.shut(running)
    assert wait_gone(identities, 0.5) == []


def test_a_recorded_pid_that_is_another_process_by_now_is_left_alone(stack_house):
    from house import datadir

    bystander = os.fork()
    if bystander == 0:
        signal.pause()
        os._exit(0)
    try:
        data = stack_house.folder()
        real = Identity.of(bystander)
        (data / "secrets").mkdir(mode=0o700)
        datadir.write_record(data, {"programs": [{"name": "redis", "pid": real.pid, "start": real.start - 1}]})
        running = stack_house.open(only=("redis",), data_dir=data)
        assert real.alive()
        stack_house.shut(running)
    finally:
        os.kill(bystander, signal.SIGKILL)
        os.waitpid(bystander, 0)
