"""Valid and invalid requests that schemathesis generates from api/openapi.yaml, sent to the live server as an administrator with
all permissions. The server must not return a 5xx that the contract does not state for the operation, or any response outside the
contract."""

from __future__ import annotations

import copy
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator

import yaml
from api_client import CONTRACT, add_worker, forget_attempts, remove_worker
from harness import TestStack
from seeds import write_person

PHASES = ("examples", "coverage", "fuzzing", "stateful")
CHECKS = ("not_a_server_error", "status_code_conformance", "content_type_conformance", "response_headers_conformance",
          "response_schema_conformance", "ignored_auth", "unsupported_method", "missing_required_header", "use_after_free",
          "ensure_resource_availability")
#: Maximum items of generated lists.
MANY = 100


@dataclass(frozen=True)
class Found:
    output: str
    well: bool

    @property
    def cases(self) -> int:
        """Returns the number of requests, or in the stateful phase of chains of them."""
        return int(found[1]) if (found := re.search(r"^ +(\d+) generated", self.output, re.M)) else 0

    @property
    def findings(self) -> int:
        return int(found[1]) if (found := re.search(r" found (\d+) unique failures", self.output)) else 0


def _each(node: Any) -> Iterator[dict[str, Any]]:
    if isinstance(node, dict):
        yield node
        node = list(node.values())
    for one in node if isinstance(node, list) else ():
        yield from _each(one)


def for_generation(spec: dict[str, Any]) -> dict[str, Any]:
    """Returns the contract with changes for generation.

    Texts of headers get no pattern, because schemathesis would search for a number that matches none of them, a thousand times in
    each of some hundred cases. The CSRF token is the session's (test_api_contract.py has wrong ones). Bodies that are not JSON
    are bytes (contract_hooks.py). Lists have at most MANY items, because generating twenty thousand takes minutes."""
    made = copy.deepcopy(spec)
    csrf = {"$ref": "#/components/parameters/Csrf"}
    for node in _each(made):
        if node.get("in") == "header" and node["schema"].get("type") == "string":
            node["schema"] = {"type": "string"}
        if isinstance(node.get("parameters"), list):
            node["parameters"] = [one for one in node["parameters"] if one != csrf]
        if isinstance(node.get("maxItems"), int) and node["maxItems"] > MANY:
            del node["maxItems"]
        for media, content in (node.get("content") or {}).items() if isinstance(node.get("content"), dict) else ():
            if media in ("application/xml", "application/offset+octet-stream", "application/octet-stream"):
                content.clear()
                content["schema"] = {"type": "string", "format": "binary"}
    return made


def settings(spec: dict[str, Any]) -> str:
    """Returns schemathesis.toml: which operation may fail with which status. A missing header gives 412 for Tus-Resumable (tus
    1.0), 404 if there is no such upload, and otherwise 422."""
    lines = ["[checks]\nmissing_required_header.expected-statuses = [404, 412, 422]\n"]
    for _, _, operation in CONTRACT.operations():
        if stated := [status for status in operation["responses"] if status.startswith("5")]:
            lines.append(f'[[operations]]\ninclude-operation-id = "{operation["operationId"]}"\n'
                         f'checks.not_a_server_error.expected-statuses = ["2xx", "3xx", "4xx", {", ".join(stated)}]\n')
    return "\n".join(lines)


def run(stack: TestStack, folder: Path, phases: tuple[str, ...] = PHASES, examples: int = 10, seed: int = 1,
        only: tuple[str, ...] = ()) -> Found:
    """`examples`: generated examples per operation. `only`: restricts the operations."""
    # A single worker, because two of them conflict in Hypothesis 6.148's cache of sources.
    (folder / "openapi.yaml").write_text(yaml.safe_dump(for_generation(CONTRACT.spec), sort_keys=False), encoding="utf-8")
    (folder / "schemathesis.toml").write_text(settings(CONTRACT.spec), encoding="utf-8")
    add_worker(stack, "schemathesis", slots=1000, seconds=3600)
    _, token, csrf = write_person(stack.psql, "schemathesis@example.org", "administrator")
    forget_attempts(stack)
    chosen = [word for name in only for word in ("--include-operation-id", name)]
    done = subprocess.run(
        [str(Path(sys.executable).with_name("st")), "run", "openapi.yaml", "--url", stack.url,
         "--generation-with-security-parameters", "false",
         "--checks", ",".join(CHECKS), "--phases", ",".join(phases), "--seed", str(seed), "--max-examples", str(examples),
         "--generation-database", "none", "--no-shrink", "--workers", "1", "--request-timeout", "30", "--continue-on-failure",
         "--warnings", "off", "--no-color", "--suppress-health-check", "all", *chosen],
        cwd=folder, capture_output=True, text=True, env={
            **os.environ, "SCHEMATHESIS_HOOKS": "contract_hooks", "PYTHONPATH": f"{Path(__file__).parent}:{Path(__file__).parents[1]}",
            "DIAPHANE_FUZZ_DSN": stack.dsn, "DIAPHANE_FUZZ_COOKIE": token, "DIAPHANE_FUZZ_CSRF": csrf})
    remove_worker(stack, "schemathesis")
    forget_attempts(stack)
    lives = stack.psql("SELECT 1 FROM web_sessions s JOIN users u ON u.id = s.user_id WHERE s.expires_at > now() "
                       "AND u.email = 'schemathesis@example.org'")
    stack.psql("DELETE FROM users WHERE email = 'schemathesis@example.org'")
    output = done.stdout + done.stderr + ("" if lives else "\nthe session that asked was ended")
    return Found(output, done.returncode == 0 and "No issues found" in done.stdout and "Traceback" not in output and bool(lives))
