"""ClamAV scans uploads before Diaphane's code reads them. The daemon is real and has only the signature of EICAR's test file."""

from __future__ import annotations

import io
import os
import subprocess
import tarfile

import pytest
from hostile.canary_scan import CanaryScan
from ingest_helpers import enqueue, nothing_left, upload_path, volume_path, wait_end

from canaries import Search
from devtool import clamav

PROGRAMS = ("postgres", "redis", "api", "ingestd")


@pytest.fixture
def daemon(all_stacks):
    if not clamav.CLAMD.exists():
        pytest.fail(f"{clamav.CLAMD} is not there; ./diaphane test fetches it")
    one = clamav.Daemon(all_stacks.run_as, all_stacks.folder())
    one.start()
    yield one
    one.kill()


def metric(stack, result: str) -> float:
    return next(float(line.split()[-1]) for line in stack.metrics("ingestd").splitlines() if line.startswith(f'diaphane_ingest_antivirus_total{{result="{result}"}}'))


def temporary_files(daemon) -> list[str]:
    return [name for _, folders, files in os.walk(daemon.folder) for name in (*folders, *files) if name.startswith("clamav-")]


def with_file(upload: bytes, data: bytes) -> bytes:
    """Returns the upload with another file at its end."""
    out = io.BytesIO()
    with tarfile.open(fileobj=io.BytesIO(upload)) as old, tarfile.open(fileobj=out, mode="w", format=tarfile.USTAR_FORMAT) as new:
        for entry in old.getmembers():
            new.addfile(entry, old.extractfile(entry))
        entry = tarfile.TarInfo("99999.dcm")
        entry.size = len(data)
        new.addfile(entry, io.BytesIO(data))
    return out.getvalue()


def test_infected_uploads_are_refused_and_unscanned_ones_wait(stack_factory, daemon):
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_ANTIVIRUS": str(daemon.path), "DIAPHANE_ANTIVIRUS_SILENCE_S": "5"})
    clean = CanaryScan().upload()
    assert wait_end(stack, enqueue(stack, clean))[0] == "ready"
    assert metric(stack, "clean") == 1

    scan = CanaryScan()
    good = scan.upload()
    # As a separate file, in the middle of a slice, and after the end of the tar.
    for infected in (with_file(good, clamav.EICAR), good.replace(b"SV10", b"SV10" + clamav.EICAR, 1), good + bytes(1024) + clamav.EICAR):
        data_set = enqueue(stack, infected)
        ended, code, words = wait_end(stack, data_set)
        assert (ended, code) == ("refused", "infected") and "malicious" in words and "the upload was deleted" in words
        nothing_left(stack, data_set)
        assert not volume_path(stack, data_set).exists()
    assert metric(stack, "infected") == 3
    assert Search([*scan.all_words(), "EICAR-STANDARD"]).in_stack(stack) == []
    # clamd answers before it deletes its temporary files.
    stack.wait_until(lambda: temporary_files(daemon) == [], what="the end of clamd's own temporary files")

    daemon.kill()
    data_set = enqueue(stack, good)
    stack.wait_until(lambda: stack.psql("SELECT waiting_for FROM ingest_jobs WHERE data_set_id = %s", data_set) == [("service",)], what="it waits")
    assert upload_path(stack, data_set).read_bytes() == good
    assert metric(stack, "unchecked") >= 1 and '"event":"virus_scanner_unavailable"' in stack.log("ingestd")
    daemon.start()
    assert wait_end(stack, data_set)[0] == "ready", "it resumes by itself"


def test_unscanned_uploads_pass_if_configured(stack_factory, tmp_path):
    stack = stack_factory(only=PROGRAMS, extra_env={"DIAPHANE_ANTIVIRUS": str(tmp_path / "nobody"), "DIAPHANE_ANTIVIRUS_AWAY": "pass",
                                                    "DIAPHANE_ANTIVIRUS_SILENCE_S": "1"})
    assert wait_end(stack, enqueue(stack, CanaryScan().upload()))[0] == "ready"
    assert metric(stack, "unchecked") == 1 and metric(stack, "clean") == 0


@pytest.mark.parametrize(("address", "words"), [("clamd", "neither an absolute path"), ("10.0.0.1:3310", "would not use TLS")])
def test_invalid_antivirus_addresses_are_refused(all_stacks, address, words):
    def said(*more: str) -> str:
        return subprocess.run([str(all_stacks.layout().bin / "diaphane-ingestd"), "--antivirus", address, *more], capture_output=True, text=True, env={},
                              timeout=60).stderr

    assert words in said()
    assert ("TLS" in words) is (words not in said("--inner-plain", "1"))
