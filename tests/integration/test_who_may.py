"""Every operation of api/openapi.yaml asked in every role, against one table: who_may.txt."""

from __future__ import annotations

import pytest
from api_client import api, forget_attempts  # noqa: F401
from who_may_table import OPERATIONS, ROWS
from who_may_world import EXPOSURES, ROLES, World, ask, known_hash


@pytest.fixture(scope="module")
def password_hash(api):  # noqa: F811
    return known_hash(api)


def test_every_operation_has_a_row_and_every_row_an_operation():
    assert {name for name in ROWS if ":" not in name} == set(OPERATIONS)
    for name in ROWS:
        operation, _, exposure = name.partition(":")
        assert operation in OPERATIONS and (not exposure or exposure in EXPOSURES), name


def test_nobody_may_what_needs_an_account():
    """The table itself: an operation that the contract guards lets nobody in, whoever wrote the row."""
    for name, (_, _, operation) in OPERATIONS.items():
        security = operation.get("security", [{"cookie": []}])
        guarded = security != [] and {} not in security
        for role in ("nobody", "unverified"):
            assert (ROWS[name][role] == "401") == guarded, (name, role)


@pytest.mark.parametrize("name", sorted({*OPERATIONS, *ROWS}))
def test_who_may(api, password_hash, name):  # noqa: F811
    about, _, exposure = name.partition(":")
    path, method, operation = OPERATIONS[about]
    forget_attempts(api)
    wrong = []
    for role in ROLES:
        wanted = ROWS.get(name, {}).get(role, "a row in who_may.txt")
        answer = ask(World(api, password_hash), role, path, method, operation, exposure)
        fits = answer.is_success if wanted == "+" else str(answer.status_code) == wanted
        if not fits:
            wrong.append(f"{role}: {wanted} wanted, {answer.status_code} {answer.text[:200]}")
    assert wrong == []
