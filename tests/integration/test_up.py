"""`./diaphane up`, `down` and `status` as a user runs them."""

from __future__ import annotations

import json
import os
import random
import signal
import socket
import subprocess
import urllib.error
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import pytest

from harness import REPO, StackFactory, wait_until
from devtool import bench_client, datadir, ports, supervise
from devtool.processes import Identity, wait_gone

PROGRAMS = {"edge", "api", "gateway", "ingestd", "renderd", "postgres", "redis"}


def free_port() -> int:
    """Returns a free port that the commands can claim themselves. It is beyond those that the stacks of other tests choose
    (ports.random_free), because nothing else keeps them from taking it in the meantime."""
    while not ports.is_free(port := random.randrange(30000, 32000)):
        pass
    return port


class Home:
    """A data directory, and commands on it."""

    def __init__(self, factory: StackFactory):
        self.data = factory.folder()
        self.data.chmod(0o755)
        self.port = free_port()

    def run(self, *words: str, timeout: float = 500, env: dict | None = None) -> subprocess.CompletedProcess:
        return subprocess.run([str(REPO / "diaphane"), *words, "--data", str(self.data)], stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=timeout, env={**os.environ, **(env or {})})

    def up(self, *words: str, **more) -> subprocess.CompletedProcess:
        return self.run("up", "--detach", "--engine", "cpu", "--port", str(self.port), *words, **more)

    def status(self) -> dict:
        return json.loads(self.run("status", "--json").stdout)

    def record(self) -> dict:
        return datadir.read_record(self.data)


@pytest.fixture
def empty_home(all_stacks):
    made = Home(all_stacks)
    yield made
    made.run("down")


OTHER_SAMPLES = [f"sample-{file.partition('.')[0]}.loaded" for _, file, _ in supervise.MORE_SAMPLES]


def used(home: Home, all_stacks: StackFactory) -> Home:
    """As after an earlier start, so that the database is there and the samples do not have to be loaded."""
    all_stacks.give_cluster(home.data)
    for marker in ("sample.loaded", *OTHER_SAMPLES):
        (home.data / marker).write_text("00000000-0000-4000-8000-000000000000\n", encoding="ascii")
    return home


@pytest.fixture
def home(empty_home, all_stacks):
    return used(empty_home, all_stacks)


@pytest.fixture(scope="module")
def running(all_stacks):
    """A home that is up, for tests that leave it so."""
    made = used(Home(all_stacks), all_stacks)
    assert made.run("admin", "list").returncode == 1    # not before it runs
    url_of(made.up())
    yield made
    made.run("down")


class Running:
    """Offers what bench_client.Person needs of a stack, for one started with `up`."""

    def __init__(self, home: Home):
        self.data = home.data
        self.settings = SimpleNamespace(url=home.record()["url"])


def url_of(done: subprocess.CompletedProcess) -> str:
    assert done.returncode == 0, done.stdout + done.stderr
    line = [line for line in done.stdout.splitlines() if line.startswith("Diaphane is at ")][-1]
    return line.split()[3]


def ready_in(status: dict) -> set[str]:
    return {program["name"] for program in status["programs"] if program["ready"]}


def answers(url: str) -> bool:
    try:
        urllib.request.urlopen(url, timeout=30)     # a refusal is immediate, and an answer may take a while
        return True
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False


def test_restarting_with_up_and_down_keeps_all_data(empty_home):
    url = url_of(empty_home.up())
    assert answers(url)
    # A program that answers within a second is ready, which may take several looks on a busy machine.
    status = wait_until(lambda: now if ready_in(now := empty_home.status()) == PROGRAMS else None, what="the state of all programs")
    assert status["engine"] == "cpu"
    secret = (empty_home.data / "secrets" / "postgres").read_text(encoding="ascii")
    sample = (empty_home.data / "sample.loaded").read_text(encoding="ascii")
    wait_until(lambda: all((empty_home.data / marker).exists() for marker in OTHER_SAMPLES), what="the other samples")
    with urllib.request.urlopen(f"{url}v1/gallery", timeout=30) as gallery:
        titles = {item["title"]: item["volume"]["modality"] for item in json.load(gallery)["items"] if item["is_sample"]}
    assert titles == {"Cranium": "CT", "Head": "MR", "Brain of a macaque": "MR"}

    assert empty_home.run("down").returncode == 0
    assert not answers(url)
    assert empty_home.run("status").returncode == 3

    url_of(empty_home.up())    # ./diaphane bench startup measures how long it takes
    assert (empty_home.data / "secrets" / "postgres").read_text(encoding="ascii") == secret
    assert (empty_home.data / "sample.loaded").read_text(encoding="ascii") == sample


def test_the_admin_command_grants_and_revokes_the_role(running):
    def admin(*words: str) -> tuple[int, str, str]:
        done = running.run("admin", *words)
        return done.returncode, done.stdout, done.stderr

    somebody = bench_client.Person(Running(running))
    account = somebody.http.get("/v1/me").json()
    email = account["email"]
    assert not account["administrator"] and somebody.http.get("/v1/admin/users").status_code == 403
    assert admin("list") == (0, "", "")
    code, said, _ = admin("grant", email.upper())
    assert code == 0 and said.startswith(f"{email.upper()} is an administrator.\nThe role takes effect once")
    assert admin("list") == (0, f"{email} (two-factor authentication not set up)\n", "")
    assert somebody.http.get("/v1/admin/users").status_code == 403
    somebody.sets_up_second_factor()
    assert admin("list") == (0, f"{email}\n", "")
    assert somebody.http.get("/v1/me").json()["administrator"] and somebody.http.get("/v1/admin/users").status_code == 200
    entries = somebody.http.get("/v1/admin/audit").json()["items"]
    assert [(e["action"], e["actor"]) for e in entries if e["action"].startswith("administrator.")] == [("administrator.granted", "machine")]
    assert admin("reset-2fa", email)[0] == 0 and somebody.http.get("/v1/admin/users").status_code == 403
    code, _, words = admin("forget-factor", email)
    assert code == 1 and "'forget-factor' is deprecated" in words and "No account with two-factor authentication has this email address." in words
    assert admin("revoke", email)[0] == 0 and admin("list") == (0, "", "")
    assert somebody.http.get("/v1/admin/users").status_code == 403

    code, _, words = admin("grant", "nobody@example.org")
    assert code == 1 and "No confirmed account has this email address." in words
    for wrong, code, said in ((("grant",), 64, "missing argument: EMAIL"), (("list", email), 64, "list takes no EMAIL"),
                              (("crown", email), 2, "invalid choice: 'crown'"), ((), 2, "usage: ./diaphane admin")):
        answer = admin(*wrong)
        assert answer[:2] == (code, "") and said in answer[2], wrong


def test_admin_help_works_without_a_running_instance(empty_home):
    done = empty_home.run("admin", "--help")
    assert done.returncode == 0 and "EMAIL" in done.stdout and "{grant,revoke,list,reset-2fa}" in done.stdout
    assert done.stderr == ""


def test_up_runs_no_program_as_root(running):
    pids = [program["pid"] for program in running.record()["programs"]] + [running.record()["supervisor"]["pid"]]
    assert all(os.stat(f"/proc/{pid}").st_uid != 0 for pid in pids)


def test_up_reports_a_taken_port_and_uses_the_next_one(home):
    with socket.socket() as taken:
        taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        taken.bind(("127.0.0.1", home.port))
        taken.listen()
        done = home.up()
        assert answers(url_of(done))
        assert f":{home.port}/" not in url_of(done)
        assert f"Port {home.port} (edge) is in use. Using " in done.stdout


def test_a_second_up_reports_the_running_instance(running):
    again = running.up()
    assert again.returncode == 0
    assert f"already running: {running.record()['url']}" in again.stdout


def test_the_next_up_cleans_up_after_a_killed_supervisor(home):
    url_of(home.up())
    left = [Identity(p["pid"], p["start"]) for p in home.record()["programs"]]
    supervisor = home.record()["supervisor"]["pid"]
    os.kill(supervisor, signal.SIGKILL)
    assert wait_gone([Identity(supervisor, home.record()["supervisor"]["start"])], 2) == []

    done = home.up()
    assert url_of(done) == f"http://localhost:{home.port}/"
    assert "left behind" in done.stdout
    assert [i for i in left if i.alive()] == []


def test_down_stops_the_programs_of_a_killed_supervisor(home):
    url_of(home.up())
    left = [Identity(p["pid"], p["start"]) for p in home.record()["programs"]]
    os.kill(home.record()["supervisor"]["pid"], signal.SIGKILL)
    assert home.run("down").returncode == 0
    assert wait_gone(left, 0.5) == []


def test_interrupt_stops_everything_in_time(home):
    process = subprocess.Popen([str(REPO / "diaphane"), "up", "--data", str(home.data), "--port", str(home.port),
                                "--engine", "cpu"],
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert any(line.startswith("Diaphane is at ") for line in process.stdout)
    programs = [Identity(p["pid"], p["start"]) for p in home.record()["programs"]]
    process.send_signal(signal.SIGINT)
    said = process.stdout.read()
    assert process.wait(60) == 0
    assert "did not stop in time" not in said
    assert wait_gone(programs, 60) == []
    process.stdout.close()


def test_no_install_lists_what_is_missing_and_installs_nothing(empty_home, tmp_path):
    # A machine on which dpkg knows no package.
    query = tmp_path / "dpkg-query"
    query.write_text("#!/bin/sh\nexit 1\n", encoding="ascii")
    query.chmod(0o755)
    done = empty_home.up("--no-install", env={"PATH": f"{tmp_path}:{os.environ['PATH']}"})
    assert done.returncode == 1
    assert "missing: Debian package libvtk9-dev" in done.stdout
    assert not (empty_home.data / "stack.json").exists()


def test_a_directory_with_other_files_is_refused_and_unchanged(empty_home):
    (empty_home.data / "letters.txt").write_text("mine", encoding="ascii")
    done = empty_home.up()
    assert done.returncode == 1
    assert "contains files that are not Diaphane's" in done.stderr + done.stdout
    assert [p.name for p in empty_home.data.iterdir()] == ["letters.txt"]


def test_up_shows_the_message_of_a_program_that_refuses_its_settings(home):
    done = home.up(env={"DIAPHANE_SLOTS": "many"})
    assert done.returncode == 1
    assert "renderd rejected its configuration (exit 78)" in done.stderr + done.stdout
    assert "slots" in done.stderr + done.stdout
    assert home.run("status").returncode == 3


def test_a_data_directory_that_nginx_could_not_read_is_refused(all_stacks):
    done = subprocess.run([str(REPO / "diaphane"), "up", "--data", "/tmp/a b;c"], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True)
    assert done.returncode == 1
    assert "may contain only" in done.stderr
    assert not Path("/tmp/a b;c").exists()


def test_default_ports_match_the_contract():
    text = (REPO / "docs" / "contracts.md").read_text(encoding="utf-8")
    assert all(str(port) in text for port in ports.DEFAULTS.values())
