"""A scan with a canary word in every text that it can contain. Whatever happens to its upload, no word is found afterwards."""

from __future__ import annotations

import os
import resource
import signal
import tempfile
import time
from pathlib import Path

import pytest
from api_client import Person, person
from canaries import Search, forms
from harness import files_below
from hostile.canary_scan import PLACES, CanaryScan
from ingest_helpers import upload_path, wait_end
from test_ingest_faults import children, freeze

PROGRAMS = ("postgres", "redis", "api", "edge", "ingestd")
#: Fault points in ingestd where tests kill it (common/fault_point.h), in order.
STEPS = ("claimed", "built", "written", "stored", "said", "removed")
#: Of these, the gate has one before the volume is stored, and one after it.
GATE_STEPS = ("written", "said")


@pytest.fixture(scope="module")
def faults(all_stacks) -> Path:
    return all_stacks.folder()


@pytest.fixture(scope="module")
def kept(all_stacks, faults):
    """A stack that keeps as much as possible, with core files enabled."""
    before = resource.getrlimit(resource.RLIMIT_CORE)
    resource.setrlimit(resource.RLIMIT_CORE, (before[1], before[1]))
    running = all_stacks.open(only=PROGRAMS, extra_env={
        "DIAPHANE_FAULT_DIR": str(faults), "DIAPHANE_LEASE_MS": "3000", "DIAPHANE_TIME_LIMIT_S": "8"})
    yield running
    all_stacks.shut(running)
    resource.setrlimit(resource.RLIMIT_CORE, before)


@pytest.fixture(scope="module")
def one(kept) -> Person:
    return person(kept)


@pytest.fixture(scope="module")
def scan() -> CanaryScan:
    return CanaryScan()


@pytest.fixture(scope="module")
def search(scan) -> Search:
    return Search(scan.all_words(), begun=time.time())


def announced(one: Person, scan: CanaryScan, data: bytes) -> tuple[str, str]:
    """Returns data set and address of an upload with all the information about its files that a client can send."""
    answer = one.http.post("/v1/uploads", headers={"Tus-Resumable": "1.0.0", "Upload-Length": str(len(data)), **scan.metadata()})
    assert answer.status_code == 201, answer.text
    url = answer.headers["location"]
    return url.rsplit("/", 1)[1], url


def sent(one: Person, scan: CanaryScan, data: bytes | None = None) -> str:
    """Returns a completely uploaded data set."""
    data = scan.upload() if data is None else data
    data_set, url = announced(one, scan, data)
    for start in range(0, len(data), 30_000):
        answer = one.patch(url, start, data[start:start + 30_000], **scan.metadata())
        assert answer.status_code == 204, answer.text
    return data_set


def nothing_is_left(kept, search: Search, still: str | None = None) -> None:
    """`still`: an upload that is still needed, whose own file alone may contain words."""
    assert search.in_stack(kept, leave_out=[upload_path(kept, still)] if still else []) == []
    assert [path for path in files_below(kept.data_dir) if path.name.startswith("core") and not path.suffix] == [], "core files"


def reads_its_input(child: int) -> bool:
    """Whether the child has started to read its input (kChildInput)."""
    try:
        position = int(Path(f"/proc/{child}/fdinfo/3").read_text(encoding="ascii").split()[1])
        return position > 0 and "/uploads/" in os.readlink(f"/proc/{child}/fd/3")
    except OSError:
        return False


def frozen(kept, one: Person, scan: CanaryScan) -> tuple[str, int]:
    """Returns a data set whose child is stopped while it reads the upload. A child lives for some milliseconds only, and on a busy machine
    it may end before it is seen. Then, there is another upload."""
    kept.wait_ready("ingestd")
    ingestd, data = kept.pids["ingestd"], scan.upload(400)
    deadline = time.monotonic() + 120
    while True:
        data_set = sent(one, scan, data)
        while upload_path(kept, data_set).exists():
            assert time.monotonic() < deadline, "no child was seen that reads an upload"
            for child in children(ingestd):
                if reads_its_input(child) and freeze(child, reading=False):
                    return data_set, child
            time.sleep(0.0005)


def test_the_canary_scan_has_words_everywhere_and_the_search_finds_each_form(scan, tmp_path):
    search = Search(scan.all_words())
    assert len(search.inside(scan.upload())) == len(PLACES) - 1 + 2, "all but that of the upload's metadata, once each"
    for word in scan.all_words():
        for name, form in forms(word).items():
            (tmp_path / "hidden").write_bytes(b"before" + form + b"behind")
            assert any(f"{word} in {name}: " in hit for hit in search.below(tmp_path)), (word, name)
    (tmp_path / "hidden").write_bytes(b"nothing")
    assert search.below(tmp_path) == []
    (tmp_path / scan.words["names"]).mkdir()
    assert search.below(tmp_path), "in a name"


def test_a_leak_is_detected(kept, scan, search):
    """Plants a word in each place that is searched."""
    word = scan.words["person"]
    leaks = [kept.data_dir / place / "leak" for place in ("logs", "scratch", "volumes", "run", "postgres")]
    for leak in leaks:
        leak.write_text(f"x{word.encode().hex()}x")
    kept.redis.set("leak", word)
    kept.psql("CREATE TABLE leak AS SELECT convert_to(%s, 'UTF8') AS bytes", word)
    found = search.in_stack(kept)
    for place in (*map(str, leaks), str(kept.data_dir / "redis"), "dump of the database"):
        assert any(place in hit for hit in found), place
    for leak in leaks:
        leak.unlink()
    # Postgres and Redis keep deleted data in their files for a while, so its word is not searched from here on.
    search.needles = {name: needle for name, needle in search.needles.items() if not name.startswith(word)}
    kept.redis.delete("leak")
    kept.psql("DROP TABLE leak")
    with tempfile.NamedTemporaryFile() as file:
        file.write(scan.words["header"].encode("utf-16-le"))
        file.flush()
        assert any(file.name in hit for hit in search.in_temporary_files())
    assert search.in_stack(kept) == []


def test_nothing_is_left_after_success(kept, one, scan, search):
    data_set = sent(one, scan)
    assert wait_end(kept, data_set)[0] == "ready"
    nothing_is_left(kept, search)


def test_nothing_is_left_after_a_refusal(kept, one, scan, search):
    few, broken = scan.upload(3), scan.upload()[:-40_000]
    assert wait_end(kept, sent(one, scan, few))[:2] == ("refused", "too_few_slices")
    assert wait_end(kept, sent(one, scan, broken))[0] == "refused"
    nothing_is_left(kept, search)


@pytest.mark.parametrize("by", [signal.SIGSEGV])
def test_nothing_is_left_after_a_crash_of_the_child(kept, one, scan, search, by):
    data_set, child = frozen(kept, one, scan)
    os.kill(child, by)
    os.kill(child, signal.SIGCONT)
    assert wait_end(kept, data_set)[1] == "unreadable"
    nothing_is_left(kept, search)


@pytest.mark.parametrize("step", [step if step in GATE_STEPS else pytest.param(step, marks=pytest.mark.nightly) for step in STEPS])
def test_nothing_is_left_after_kill_9_at_each_step(kept, one, scan, search, faults, step):
    kept.wait_ready("ingestd")
    armed = faults / step
    armed.touch()
    killed = kept.pids["ingestd"]
    data_set = sent(one, scan)
    kept.wait_until(lambda: not armed.exists(), what=f"the kill at {step}")
    # Immediately, before any recovery, only the upload itself, which is still needed, may exist.
    nothing_is_left(kept, search, still=data_set)
    assert wait_end(kept, data_set)[0] == "ready"
    # The last step kills it after the data set was reported as ready. It restarts a moment later.
    kept.wait_until(lambda: kept.pids.get("ingestd", killed) != killed, what="another ingestd")
    nothing_is_left(kept, search)


@pytest.mark.parametrize("by", [signal.SIGABRT])
def test_nothing_is_left_when_ingestd_stops_during_a_build(kept, one, scan, search, by):
    data_set, child = frozen(kept, one, scan)
    os.kill(kept.pids["ingestd"], by)
    nothing_is_left(kept, search, still=data_set)
    assert wait_end(kept, data_set)[0] == "ready"
    nothing_is_left(kept, search)


@pytest.mark.parametrize("by", [signal.SIGKILL, pytest.param(signal.SIGABRT, marks=pytest.mark.nightly)])
def test_nothing_is_left_when_api_stops_during_an_upload_that_is_cancelled(kept, one, scan, search, by):
    data = scan.upload()
    data_set, url = announced(one, scan, data)
    assert one.patch(url, 0, data[:30_000], **scan.metadata()).status_code == 204
    ended = kept.pids["api"]
    os.kill(ended, by)
    kept.wait_until(lambda: kept.pids.get("api") not in (None, ended), what="the api again")
    kept.wait_ready("api")
    nothing_is_left(kept, search, still=data_set)
    assert one.http.delete(url, headers={"Tus-Resumable": "1.0.0"}).status_code == 204
    kept.wait_until(lambda: not upload_path(kept, data_set).exists(), what="the end of the upload")
    nothing_is_left(kept, search)


def test_nothing_is_left_after_deleting_a_scan_during_its_build(kept, one, scan, search):
    data_set, child = frozen(kept, one, scan)
    assert one.http.delete(f"/v1/data-sets/{data_set}").status_code == 204
    kept.wait_until(lambda: not upload_path(kept, data_set).exists(), what="the end of the upload")
    nothing_is_left(kept, search)


def test_nothing_is_left_after_an_upload_expires(kept, one, scan, search):
    data = scan.upload()
    data_set, url = announced(one, scan, data)
    assert one.patch(url, 0, data[:30_000]).status_code == 204
    kept.psql("UPDATE uploads SET expires_at = now() - interval '1 second' WHERE id = %s", data_set)
    kept.wait_until(lambda: not upload_path(kept, data_set).exists(), what="the end of the upload")
    nothing_is_left(kept, search)


def test_nothing_is_left_in_temporary_files(kept, search):
    assert search.in_temporary_files() == []
