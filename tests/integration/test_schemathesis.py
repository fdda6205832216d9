"""A few of the contract's valid and invalid requests against the live server, always the same. All phases at length: `./diaphane
bench contract`."""

from __future__ import annotations

import contract_run
import pytest
from api_client import api  # noqa: F401


@pytest.mark.parametrize("phases", [("examples",), pytest.param(("examples", "coverage", "fuzzing"), marks=pytest.mark.nightly)],
                         ids=["examples", "all phases"])
def test_every_response_to_generated_requests_follows_the_contract(api, tmp_path, phases):  # noqa: F811
    found = contract_run.run(api, tmp_path, phases=phases, examples=3)
    assert found.well, found.output[-8000:]
