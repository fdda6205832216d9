"""Requests that schemathesis makes of api/openapi.yaml, right ones and wrong ones, against the live server: no 5xx, and no
answer that the contract does not have. DIAPHANE_FUZZ_EXAMPLES=200 looks longer, DIAPHANE_FUZZ_PHASES=examples,coverage,fuzzing wider."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from api_client import add_worker, api, forget_attempts, person, remove_worker  # noqa: F401
from harness import REPO

CHECKS = ("not_a_server_error", "status_code_conformance", "content_type_conformance", "response_headers_conformance",
          "response_schema_conformance")
#: They would end the session that asks (schemathesis gives back ids that it was given); parts of uploads, which it cannot write;
#: and pictures, which no renderer makes here: the worker is a row in Redis, and 503 the right answer.
LEFT_OUT = ("signOut", "signOutEverywhere", "deleteAccount", "endBrowserSession", "appendToUpload", "getThumbnail")


@pytest.fixture
def administrator(api):  # noqa: F811
    """Whom everything is open to."""
    one = person(api).becomes_administrator()
    add_worker(api, "schemathesis", slots=1000, seconds=3600)
    yield one
    remove_worker(api, "schemathesis")
    forget_attempts(api)


def test_no_generated_request_is_answered_outside_of_the_contract(api, administrator, tmp_path):  # noqa: F811
    left_out = [word for name in LEFT_OUT for word in ("--exclude-operation-id", name)]
    done = subprocess.run(
        [str(Path(sys.executable).with_name("st")), "run", str(REPO / "api" / "openapi.yaml"), "--url", api.url,
         "-H", f"Cookie: diaphane={administrator.http.cookies['diaphane']}", "-H", f"X-CSRF-Token: {administrator.csrf}",
         "--checks", ",".join(CHECKS), "--phases", os.environ.get("DIAPHANE_FUZZ_PHASES", "examples,fuzzing"), "--seed", "1",
         "--max-examples", os.environ.get("DIAPHANE_FUZZ_EXAMPLES", "10"), "--generation-database", "none", "--no-shrink",
         "--workers", "2", "--request-timeout", "30", "--continue-on-failure", "--warnings", "off", "--no-color",
         "--suppress-health-check", "all", *left_out],
        cwd=tmp_path, capture_output=True, text=True)
    assert administrator.http.get("/v1/me").status_code == 200, "the session that asked lives"
    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-2000:]
    assert "No issues found" in done.stdout, done.stdout[-3000:]
