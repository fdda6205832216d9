"""What other users of the same machine can reach of a running Diaphane: its pages, but neither Redis nor renderd."""

from __future__ import annotations

import contextlib
import os
import pwd
import socket
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from api_client import person
from harness import TestStack
from devtool import datadir
from devtool.console import CliError
from devtool.users import RunAs
from stream_helpers import PROGRAMS, Viewer, open_session, store_ball

NOBODY = pwd.getpwnam("nobody")
#: Run as another user: the result of connecting to a Unix socket and to a port.
KNOCK = """
import socket, sys
for place in sys.argv[1:]:
    one = socket.socket(socket.AF_INET if place.isdigit() else socket.AF_UNIX)
    one.settimeout(5)
    try:
        one.connect(("127.0.0.1", int(place)) if place.isdigit() else place)
        print("open")
    except OSError as why:
        print(type(why).__name__)
"""


def knock(*places: object) -> list[str]:
    as_nobody = {"user": NOBODY.pw_uid, "group": NOBODY.pw_gid, "extra_groups": []} if os.geteuid() == 0 else {}
    if not as_nobody:
        pytest.skip("only root may try as another user")
    done = subprocess.run([sys.executable, "-c", KNOCK, *map(str, places)], cwd="/", capture_output=True, text=True, timeout=60, **as_nobody)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def ports_of(pid: int) -> set[int]:
    """Returns the ports on which the process listens."""
    inodes = set()
    for name in os.listdir(f"/proc/{pid}/fd"):
        with contextlib.suppress(FileNotFoundError):    # closed meanwhile
            target = os.readlink(f"/proc/{pid}/fd/{name}")
            if target.startswith("socket:["):
                inodes.add(target[8:-1])
    found = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and fields[9] in inodes:
                found.add(int(fields[1].rpartition(":")[2], 16))
    return found


def pictures_come(stack: TestStack) -> None:
    somebody = person(stack)
    viewer = Viewer(stack.url, open_session(somebody, store_ball(stack, somebody, 24))[1])
    viewer.frame()
    viewer.leave()


def test_other_local_users_cannot_reach_redis_or_renderd(running):
    settings = running.stack.settings
    sockets = [settings.socket("redis"), settings.socket("renderd")]
    for path in sockets:
        about = path.stat()
        assert stat.S_ISSOCK(about.st_mode) and about.st_mode & 0o077 == 0 and path.parent.stat().st_mode & 0o077 == 0
    assert knock(running.ports["edge"], *sockets) == ["open", "PermissionError", "PermissionError"]
    assert ports_of(running.pids["redis"]) == set()
    assert ports_of(running.pids["renderd"]) == {running.ports["renderd-admin"]}


def test_a_data_directory_with_a_long_path_has_its_sockets_in_a_private_folder(all_stacks):
    data = all_stacks.folder() / ("long" * 25)
    data.mkdir(mode=0o755)
    all_stacks.run_as.own(data)
    stack = all_stacks.open(only=PROGRAMS, data_dir=data)
    try:
        folder = stack.stack.settings.sockets
        assert folder != data / "run" and datadir.is_private(folder, os.stat(data).st_uid)
        assert knock(folder / "redis.sock", folder / "renderd.sock") == ["PermissionError", "PermissionError"]
        pictures_come(stack)
    finally:
        all_stacks.shut(stack)
    assert not folder.exists()


def test_a_folder_open_to_other_users_is_not_used_for_sockets(tmp_path):
    us = RunAs()
    (tmp_path / "run").mkdir(mode=0o755)
    with pytest.raises(CliError, match="chmod 700"):
        datadir.socket_folder(tmp_path, us)
    (tmp_path / "run").chmod(0o700)
    assert datadir.socket_folder(tmp_path, us) == tmp_path / "run"

    # A folder in stack.json from an earlier start is reused only while it is private and not a link.
    long = tmp_path / ("long" * 25)
    long.mkdir()
    elsewhere, link = tmp_path / "elsewhere", tmp_path / "link"
    elsewhere.mkdir(mode=0o700)
    link.symlink_to(elsewhere)
    made = []
    for earlier, again in ((elsewhere, True), (link, False), (tmp_path / "gone", False)):
        datadir.write_record(long, {"sockets": str(earlier)})
        folder = datadir.socket_folder(long, us)
        assert (folder == earlier) is again and datadir.is_private(folder, os.geteuid())
        made += [] if again else [folder]
    elsewhere.chmod(0o755)
    datadir.write_record(long, {"sockets": str(elsewhere)})
    made.append(datadir.socket_folder(long, us))
    assert elsewhere not in made
    for folder in made:
        folder.rmdir()


def test_a_second_renderd_takes_no_socket_from_the_first(running):
    held = running.stack.running_["renderd"].program
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        env = {**held.env, "DIAPHANE_ADMIN_PORT": str(free.getsockname()[1]), "DIAPHANE_WORKER_ID": "another"}
    done = subprocess.run(held.argv, env=env, capture_output=True, text=True, timeout=60, **running.stack.run_as.popen())
    assert done.returncode == 69 and "another process is already listening on" in done.stderr
    pictures_come(running)
