"""Each case of the design of ingest, as generated files, and real ones: what the server and the page's scanner make of it.

The table is tools/house/ingest_cases/table.py; `./diaphane bench ingest-cases` prints it."""

from __future__ import annotations

import pytest

from harness import REPO  # noqa: F401  (puts tools/ on the path)
from house import build
from house.ingest_cases import real, run
from house.ingest_cases.table import CASES


ALL = [*CASES, *real.DISCS]


@pytest.fixture(scope="module")
def rows():
    build.npm_install()
    return run.run(ALL)


@pytest.mark.parametrize("number", range(len(ALL)), ids=[f"{case.number or 'real'}: {case.name}" for case in ALL])
def test_a_case_becomes_what_it_must(rows, number):
    assert not rows[number].faults


def test_no_case_is_missing():
    assert {case.number for case in CASES} == set(range(1, 26))
