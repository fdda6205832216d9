"""Every operation of api/openapi.yaml asked in every role, against one table: who_may.txt."""

from __future__ import annotations

from pathlib import Path

import pytest
from api_client import CONTRACT, api, forget_attempts, problem  # noqa: F401
from who_may_world import ROLES, World, ask, known_hash

TABLE = Path(__file__).with_name("who_may.txt")
OPERATIONS = {operation["operationId"]: (path, method, operation) for path, method, operation in CONTRACT.operations()}


def read_table() -> dict[str, dict[str, str]]:
    rows: dict[str, dict[str, str]] = {}
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if words := line.partition("#")[0].split():
            name, *cells = words
            assert len(cells) == len(ROLES), f"{name}: {len(cells)} cells"
            assert name not in rows, f"{name} is there twice"
            assert all(cell == "+" or cell in ("401", "403", "404") for cell in cells), line
            rows[name] = dict(zip(ROLES, cells))
    return rows


ROWS = read_table()


@pytest.fixture(scope="module")
def password_hash(api):  # noqa: F811
    return known_hash(api)


def test_every_operation_has_a_row_and_every_row_an_operation():
    assert set(ROWS) == set(OPERATIONS)


def test_nobody_may_what_needs_an_account():
    """The table itself: an operation that the contract guards lets nobody in, whoever wrote the row."""
    for name, (_, _, operation) in OPERATIONS.items():
        security = operation.get("security", [{"cookie": []}])
        guarded = security != [] and {} not in security
        for role in ("nobody", "unverified"):
            assert (ROWS[name][role] == "401") == guarded, (name, role)


@pytest.mark.parametrize("name", sorted(OPERATIONS))
def test_who_may(api, password_hash, name):  # noqa: F811
    path, method, operation = OPERATIONS[name]
    forget_attempts(api)
    wrong = []
    for role in ROLES:
        wanted = ROWS.get(name, {}).get(role, "a row in who_may.txt")
        answer = ask(World(api, password_hash), role, path, method, operation)
        fits = answer.is_success if wanted == "+" else str(answer.status_code) == wanted
        if not fits:
            wrong.append(f"{role}: {wanted} wanted, {answer.status_code} {answer.text[:200]}")
    assert wrong == []
