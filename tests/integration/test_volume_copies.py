"""A node's copies of volumes: used instead of the store by each worker of the node, and deleted with their originals."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from api_client import Person, person
from cut_helpers import KEEP, MARK, marked_scan
from stream_helpers import OtherWorker, Viewer, come_back, new_ticket, open_session, store_ball

from harness import metrics_at


@pytest.fixture(scope="module")
def node(all_stacks):
    """A stack whose renderd keeps copies, and their folder."""
    copies = all_stacks.folder() / "copies"
    stack = all_stacks.open(only=("postgres", "redis", "api", "gateway", "edge", "ingestd", "renderd"), extra_env={"DIAPHANE_VOLUME_COPIES_DIR": str(copies)})
    yield stack, copies
    all_stacks.shut(stack)


def copies_of(folder: Path, data_set: str) -> list[Path]:
    return sorted(folder.glob(f"{data_set}.*.sealed"))


def copied(stack, folder: Path) -> tuple[Person, str, str]:
    """Returns a user who views a scan with a copy, the scan, and the session."""
    somebody = person(stack)
    data_set = store_ball(stack, somebody)
    session, url = open_session(somebody, data_set)
    Viewer(stack.url, url).frame()
    stack.wait_until(lambda: copies_of(folder, data_set), what="the copy")
    return somebody, data_set, session


def look_again(stack, somebody: Person, session: str) -> None:
    """Sees the session's picture again, as soon as a worker can take the session."""
    come_back(lambda: (url := new_ticket(somebody, session)) and Viewer(stack.url, url)).frame()


def counted(port: int, what: str) -> int:
    found = re.search(rf'^diaphane_renderd_volume_copies_total{{what="{what}"}} (\d+)', metrics_at(port), re.MULTILINE)
    return int(found.group(1)) if found else 0


def test_a_new_worker_reads_the_copy_and_replaces_a_damaged_one(node):
    stack, folder = node
    somebody, data_set, session = copied(stack, folder)
    admin = stack.ports["renderd-admin"]
    stack.wait_until(lambda: counted(admin, "kept") == 1 and counted(admin, "miss") == 1, what="the count")

    # Another renderd of this node finds the copy of the first.
    second = OtherWorker(stack, "second", f"--volume-copies-dir={folder}", redis=stack.redis_address)
    own_admin = int(next(word for word in second.argv if word.startswith("--admin-port=")).partition("=")[2])
    second.start()
    try:
        stack.wait_until(lambda: stack.redis.exists("diaphane:worker:second"), what="the second worker")
        stack.stop("renderd")
        stack.wait_until(lambda: stack.redis.smembers("diaphane:workers") == {"second"} or not stack.redis.exists("diaphane:worker:local"), what="the first one's end")
        look_again(stack, somebody, session)
        stack.wait_until(lambda: counted(own_admin, "hit") == 1, what="the count")
        assert counted(own_admin, "miss") == 0
    finally:
        second.kill()
        stack.start("renderd")
        stack.wait_ready("renderd")

    copy, = copies_of(folder, data_set)
    copy.write_bytes(b"\0" * copy.stat().st_size)
    stack.wait_until(lambda: not stack.redis.exists("diaphane:worker:second"), what="the second one's end")
    look_again(stack, somebody, session)
    stack.wait_until(lambda: counted(admin, "damaged") == 1 and counted(admin, "kept") == 1, what="a good copy")
    assert set(copies_of(folder, data_set)[0].read_bytes()) != {0}


def test_a_deleted_scan_has_no_copy(node):
    stack, folder = node
    somebody, data_set, _ = copied(stack, folder)
    assert somebody.http.delete(f"/v1/data-sets/{data_set}").status_code == 204
    stack.wait_until(lambda: not copies_of(folder, data_set), what="the copy's end")


def test_an_anonymised_scan_has_no_older_copy(node):
    stack, folder = node
    somebody = person(stack)
    data_set, content = marked_scan(stack, somebody)
    _, url = open_session(somebody, data_set)
    Viewer(stack.url, url).frame()
    old, = stack.wait_until(lambda: copies_of(folder, data_set), what="the copy")
    assert MARK.tobytes() not in old.read_bytes(), "a copy is enciphered"
    asked = somebody.http.post(f"/v1/data-sets/{data_set}/anonymise", json={"keep": KEEP, "volume_hash": content, "confirm": "this cannot be undone"})
    assert asked.status_code in (200, 202), asked.text
    stack.wait_until(lambda: somebody.http.get(f"/v1/data-sets/{data_set}/anonymise").json()["state"] == "ready", what="the cut")
    stack.wait_until(lambda: not old.exists(), what="the older copy's end")
    _, url = open_session(somebody, data_set)
    Viewer(stack.url, url).frame()
    new, = stack.wait_until(lambda: copies_of(folder, data_set), what="the copy of what is left")
    assert new.name != old.name


def test_a_worker_runs_without_a_writable_copies_folder(node, all_stacks):
    stack, _ = node
    somebody = person(stack)
    data_set = store_ball(stack, somebody)
    closed = all_stacks.folder() / "closed"
    closed.mkdir(mode=0o555)
    other = OtherWorker(stack, "closed", f"--volume-copies-dir={closed}", redis=stack.redis_address)
    stack.stop("renderd")
    other.start()
    try:
        stack.wait_until(lambda: stack.redis.exists("diaphane:worker:closed") and not stack.redis.exists("diaphane:worker:local"), what="the other worker")
        _, url = open_session(somebody, data_set)
        Viewer(stack.url, url).frame()
        assert '"no_volume_copies"' in other.log.read_text()
    finally:
        other.kill()
        stack.start("renderd")
        shutil.rmtree(closed)
