"""Which tests each worker of a parallel run gets."""

from __future__ import annotations

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
