"""Each case of the ingest design as generated files, and real ones: the results of the server and of the page's scanner. The
table is tools/devtool/ingest_cases/table.py, and `./diaphane bench ingest-cases` prints it."""

from __future__ import annotations

import pytest

from harness import REPO  # noqa: F401  (puts tools/ on the path)
from devtool import build
from devtool.ingest_cases import real, run
from devtool.ingest_cases.table import CASES


ALL = [*CASES, *real.DISCS]


#: What the gate looks at.
FEW = [next(case for case in ALL if case.name == name) for name in ("regular CT", "regular MR", "oblique")]


@pytest.fixture(scope="module")
def rows():
    build.npm_install()
    return run.run(ALL)


def test_selected_cases_give_the_expected_result():
    build.npm_install()
    rows = run.run(FEW)
    assert len(rows) == len(FEW) and not any(row.faults for row in rows)


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(len(ALL)), ids=[f"{case.number or 'real'}: {case.name}" for case in ALL])
def test_every_case_gives_the_expected_result(rows, number):
    assert not rows[number].faults


def test_no_case_is_missing():
    assert {case.number for case in CASES} == set(range(1, 26))
