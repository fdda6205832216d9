"""The contract's requests, right ones and wrong ones, against the live server: a few of each, the same each time. All phases at length: `./diaphane bench contract`."""

from __future__ import annotations

import contract_run
from api_client import api  # noqa: F401


def test_no_generated_request_is_answered_outside_of_the_contract(api, tmp_path):  # noqa: F811
    found = contract_run.run(api, tmp_path, phases=("examples", "coverage", "fuzzing"), examples=3)
    assert found.well, found.output[-8000:]
