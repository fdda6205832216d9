"""Backups of a running installation, restored into an empty one."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import httpx
import psycopg
import pytest
from api_client import Person, person
from cut_helpers import marked_scan
from devtool import ports
from devtool.plan import POSTGRES_BIN
from harness import REPO
from seeds import PASSWORD

PROGRAMS = ("postgres", "redis", "api", "gateway", "edge", "ingestd", "renderd")
LOCK = 4711820932


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=PROGRAMS)
    yield stack
    all_stacks.shut(stack)


@pytest.fixture
def place(all_stacks) -> Path:
    folder = all_stacks.folder()
    (folder / "key").write_text("b" * 64)
    all_stacks.run_as.own(folder / "key")
    return folder


def environment(stack, place: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(REPO / "backup"), "PYTHONDONTWRITEBYTECODE": "1", "DIAPHANE_BACKUP_DATA": str(stack.data_dir),
            "DIAPHANE_BACKUP_REPOSITORY": str(place / "repository"), "DIAPHANE_BACKUP_KEY": str(place / "key"), "DIAPHANE_POSTGRES": stack.dsn,
            "DIAPHANE_POSTGRES_BIN": str(POSTGRES_BIN)}


def started(stack, place: Path, *arguments: str) -> subprocess.Popen:
    # Python reads the package before it gives up root, which alone may read a checkout below /root.
    package = stack.factory.layout().backup
    env = {**environment(stack, place), "PYTHONPATH": str(package)}
    return subprocess.Popen(["/usr/bin/python3", "-m", "diaphane_backup", *arguments], cwd="/", env=env, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, start_new_session=True, **stack.factory.run_as.popen())


def run(stack, place: Path, *arguments: str) -> str:
    process = started(stack, place, *arguments)
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    return out


def volume(stack, scan: str) -> dict[str, bytes]:
    folder = stack.data_dir / "volumes" / scan
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def restored(all_stacks, running, place: Path):
    """Restores the newest backup into a new data directory, and starts everything there."""
    data = all_stacks.folder()
    empty = all_stacks.open(only=("postgres",), data_dir=data)
    print(run(empty, place, "restore"))
    all_stacks.shut(empty, keep_data=True)
    return all_stacks.open(only=PROGRAMS, data_dir=data)


def signs_in(stack, owner: Person) -> Person:
    again = Person(stack, owner.email)
    again.device = owner.device
    return again.sign_in()


def test_everything_is_there_after_a_restore(all_stacks, running, place):
    owner, guest = person(running), person(running)
    owner.sets_up_second_factor()
    scan, _ = marked_scan(running, owner)
    guest_scan, _ = marked_scan(running, guest)
    run(running, place, "save")
    stored = b"".join(path.read_bytes() for path in (place / "repository").rglob("*") if path.is_file())
    assert owner.email.encode() not in stored and b"INSERT" not in stored
    # What happens afterwards is lost, and nothing else.
    later = person(running)
    before = {one: volume(running, one) for one in (scan, guest_scan)}
    other = restored(all_stacks, running, place)
    try:
        assert {one: volume(other, one) for one in before} == before
        again = signs_in(other, guest)
        assert [one["id"] for one in again.http.get("/v1/data-sets").json()["items"]] == [guest_scan]
        assert again.http.post("/v1/sessions", json={"data_set_id": guest_scan}).status_code == 201
        assert guest.http.cookies and httpx.get(f"{other.url}/v1/me", cookies=dict(guest.http.cookies), trust_env=False).status_code == 401, \
            "a session that may have been ended since"
        assert other.psql("SELECT count(*) FROM users WHERE email = %s", later.email) == [(0,)]
        # Its secret can be read only with the old key.
        signs_in(other, owner)
    finally:
        all_stacks.shut(other)


def test_a_deleted_scan_stays_on_the_disk_while_a_backup_copies_files(running):
    owner = person(running)
    scan, _ = marked_scan(running, owner)
    folder = running.data_dir / "volumes" / scan
    with psycopg.connect(running.dsn, autocommit=True) as backup:
        backup.execute("SELECT pg_advisory_lock(%s)", [LOCK])
        assert owner.http.delete(f"/v1/data-sets/{scan}").status_code in (200, 202, 204)
        end = time.monotonic() + 2    # four times the pause between two deletions
        while time.monotonic() < end:
            assert folder.exists()
            time.sleep(0.1)
    running.wait_until(lambda: not folder.exists(), what="the deletion after the backup")


def test_only_one_backup_runs_and_a_killed_one_harms_none(running, place):
    run(running, place, "save")
    with psycopg.connect(running.dsn, autocommit=True) as backup:
        backup.execute("SELECT pg_advisory_lock(%s)", [LOCK])
        refused = started(running, place, "save")
        _, err = refused.communicate(timeout=120)
        assert refused.returncode == 1 and "another backup is running" in err
    killed = started(running, place, "save")
    running.wait_until(lambda: (running.data_dir / "database").exists() or killed.poll() is not None, what="the dump")
    os.killpg(killed.pid, signal.SIGKILL)
    killed.communicate()
    run(running, place, "save")
    assert len(run(running, place, "list").splitlines()) in (1, 2), "of one hour, or of two"
    run(running, place, "check", "--percent", "100")
    assert not (running.data_dir / "database").exists()


def test_a_running_installation_is_not_overwritten(running, place):
    person(running)
    run(running, place, "save")
    refused = started(running, place, "restore")
    _, err = refused.communicate(timeout=120)
    assert refused.returncode == 1 and "already has users" in err


def test_an_unavailable_database_is_reported_without_its_password(running, place):
    process_env = environment(running, place)
    dead = ports.random_free()
    try:
        env = {**process_env, "PYTHONPATH": str(running.factory.layout().backup), "DIAPHANE_POSTGRES": f"postgresql://anna:topsecret@127.0.0.1:{dead['postgres']}/x"}
        done = subprocess.run(["/usr/bin/python3", "-m", "diaphane_backup", "save"], cwd="/", env=env, text=True, capture_output=True, timeout=120,
                              **running.factory.run_as.popen())
    finally:
        ports.give_back(dead.values())
    assert done.returncode == 1 and done.stderr.startswith("diaphane_backup: the database does not answer") and "topsecret" not in done.stderr
    assert PASSWORD not in done.stderr


def test_the_commands_back_up_one_machine_and_restore_another(all_stacks, running, tmp_path):
    owner = person(running)
    scan, _ = marked_scan(running, owner)
    place, target = all_stacks.folder(), all_stacks.folder()

    def command(*arguments: object) -> subprocess.CompletedProcess[str]:
        return subprocess.run([REPO / "diaphane", *map(str, arguments)], text=True, capture_output=True, timeout=300)

    made = command("backup", place, "--data", running.data_dir)
    assert made.returncode == 0 and "Keep a copy of it elsewhere" in made.stdout, made.stdout + made.stderr
    key = tmp_path / "key"
    key.write_bytes((running.data_dir / "secrets" / "backup-key").read_bytes())
    listed = command("backup", place, "--data", running.data_dir, "--list").stdout.split()
    assert command("backup", place, "--data", running.data_dir, "--check", 100).returncode == 0
    assert "can be restored only with the key" in command("restore", place, "--key", tmp_path / "absent", "--data", target).stderr
    done = command("restore", place, "--key", key, "--data", target, "--backup", listed[0])
    assert done.returncode == 0 and listed[0] in done.stdout, done.stdout + done.stderr
    assert "already has an instance" in command("restore", place, "--key", key, "--data", target).stderr
    other = all_stacks.open(only=PROGRAMS, data_dir=target)
    try:
        assert [one["id"] for one in signs_in(other, owner).http.get("/v1/data-sets").json()["items"]] == [scan]
        assert volume(other, scan) == volume(running, scan)
    finally:
        all_stacks.shut(other)
