"""Hostile uploads: each is refused with a message within the limits that the sandbox enforces, and the next one works."""

from __future__ import annotations

import pytest
from hostile.cases import Case, cases
from hostile.dicom_bytes import tar_header
from hostile.run import LIMITS, Outcome, outcomes, table

PROGRAMS = ("postgres", "redis", "api", "ingestd")


@pytest.fixture(scope="module")
def small(all_stacks):
    """An ingestd whose children have 1 GB of address space and 10 s."""
    running = all_stacks.open(only=PROGRAMS, extra_env=LIMITS)
    yield running
    all_stacks.shut(running)


@pytest.mark.parametrize("step", [10, pytest.param(1, marks=pytest.mark.nightly)], ids=["every tenth", "all"])
def test_each_hostile_upload_is_refused_and_the_next_one_works(small, step: int):
    assert len(cases()) > 250
    pid = small.pids["ingestd"]
    found = outcomes(small, cases()[::step], good_each=8)
    missed = [outcome for outcome in found if outcome.fault]
    assert not missed, "\n" + table(missed)
    assert small.pids["ingestd"] == pid, "ingestd itself never ended"
    # The last original is deleted just after its refusal.
    for folder in ("uploads", "scratch"):
        small.wait_until(lambda folder=folder: not any((small.data_dir / folder).iterdir()), what=f"an empty directory {folder}")


def test_each_kind_of_failure_is_detected():
    # Tests each kind of failure, because the test above shows none.
    case = Case("", "x", ("damaged",), lambda: [])
    words = "These are words for it."
    assert Outcome(case, "damaged", words, True, 0, 0).fault == ""
    for miss in (Outcome(case, "too_slow", words, True, 0, 0), Outcome(case, "unreadable", words, True, 0, 0),
                 Outcome(case, "damaged", "This needs more memory.", True, 0, 0), Outcome(case, "ready", "", True, 0, 0),
                 Outcome(case, "damaged", "", True, 0, 0), Outcome(case, "damaged", words, False, 0, 0)):
        assert miss.fault and miss.fault.upper() in table([miss])


def test_the_memory_limit_is_enforced(small):
    # Harmless zeros, but too many for 1 GB, which shows that the limit applies.
    many = Case("", "many zeros", ("too_large",), lambda: [tar_header(size=980 << 20), 980 << 20, bytes(1024)])
    (end,) = outcomes(small, [many])
    assert (end.code, end.text) == ("too_large", "This upload needs more memory than allowed.")
    assert end.next_is_ready
