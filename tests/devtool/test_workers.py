"""Which tests each worker of a parallel run gets."""

from __future__ import annotations

import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import workers
from harness import REPO


def test_tests_of_a_file_share_a_worker_unless_the_file_is_split():
    one = {workers.unit_of(f"integration/test_stores.py::test_{number}") for number in range(50)}
    divided = {workers.unit_of(f"integration/test_access_matrix.py::test_access_matrix[{number}]") for number in range(50)}
    assert len(one) == 1 and len(divided) == workers.PARTS["test_access_matrix.py"]
    assert workers.unit_of("integration/test_faults.py::test_a") != workers.unit_of("e2e/test_faults.py::test_a")


def test_the_longest_files_start_first():
    names = ["test_stores.py", workers.LONGEST[1], "test_up_and_down.py", workers.LONGEST[0]]
    assert sorted(names, key=workers.rank_of) == [workers.LONGEST[0], workers.LONGEST[1], "test_stores.py", "test_up_and_down.py"]


def test_each_configured_file_exists():
    existing = {path.name for path in (REPO / "tests").glob("*/test_*.py")}
    assert existing >= {*workers.LONGEST, *workers.PARTS}


def test_a_file_belongs_to_the_first_run_that_claims_it(tmp_path):
    first, second = workers.Claims(tmp_path / "claims"), workers.Claims(tmp_path / "claims")
    assert first.ours("e2e/test_a.py::one") and first.ours("e2e/test_a.py::two")
    assert not second.ours("e2e/test_a.py::three") and second.ours("e2e/test_b.py::one") and not first.ours("e2e/test_b.py::two")


def test_a_claimed_file_is_never_divided(tmp_path):
    first, second = workers.Claims(tmp_path / "claims"), workers.Claims(tmp_path / "claims")
    tests = [f"e2e/test_canaries.py::test_{number}" for number in range(20)]
    assert len({workers.unit_of(one) for one in tests}) > 1 and first.ours(tests[0])
    assert not any(second.ours(one) for one in tests) and all(first.ours(one) for one in tests)


def test_two_runs_of_pytest_run_each_test_once(tmp_path):
    (tmp_path / "conftest.py").write_text((REPO / "tests" / "conftest.py").read_text())
    (tmp_path / "test_b.py").write_text("import pytest\n@pytest.mark.parametrize('number', range(3))\ndef test_it(number): pass\n")

    def command(report: Path) -> list[str]:
        return [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", str(tmp_path), "--claims", str(tmp_path / "claims"),
                f"--junitxml={report}", str(tmp_path)]

    # The second run begins and ends during the first file, which the first run has claimed.
    (tmp_path / "test_a.py").write_text(f"import subprocess\ndef test_it(): subprocess.run({command(tmp_path / 'second.xml')}, check=True)\n")
    subprocess.run(command(tmp_path / "first.xml"), check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})

    def ran(report: str) -> list[str]:
        return [str(case.get("name")) for case in ElementTree.parse(tmp_path / report).getroot().iter("testcase")]

    assert ran("first.xml") == ["test_it"] and ran("second.xml") == ["test_it[0]", "test_it[1]", "test_it[2]"]
