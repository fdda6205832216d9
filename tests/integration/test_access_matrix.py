"""Every operation of api/openapi.yaml in every role, compared with one table: access_matrix.txt."""

from __future__ import annotations

import pytest
from api_client import forget_attempts
from access_matrix import OPERATIONS, ROWS
from access_matrix_fixture import ROLES, STATES, World, ask


@pytest.fixture(scope="module")
def api(all_stacks):
    """A separate stack, because the samples and the worker that the table needs would remain for all other tests."""
    opened = all_stacks.open(only=("postgres", "redis", "api", "edge"))
    yield opened
    all_stacks.shut(opened)


def test_every_operation_has_a_row_and_every_row_an_operation():
    assert {name for name in ROWS if ":" not in name} == set(OPERATIONS)
    for name in ROWS:
        operation, _, state = name.partition(":")
        assert operation in OPERATIONS and (not state or state in STATES), name


def test_operations_that_need_an_account_are_refused_without_one():
    """Checks the table itself: an operation that the contract protects admits no visitor."""
    for name, (_, _, operation) in OPERATIONS.items():
        security = operation.get("security", [{"cookie": []}])
        guarded = security != [] and {} not in security
        for role in ("nobody", "unverified"):
            assert (ROWS[name][role] == "401") == guarded, (name, role)


@pytest.mark.parametrize("name", sorted({*OPERATIONS, *ROWS}))
def test_access_matrix(api, name):
    about, _, state = name.partition(":")
    path, method, operation = OPERATIONS[about]
    forget_attempts(api)
    wrong = []
    world = World(api)
    for role in ROLES:
        wanted = ROWS.get(name, {}).get(role, "a row in access_matrix.txt")
        answer = ask(world, role, path, method, operation, state)
        # A successful request changed something, and a disabled owner creates nothing more, so the next request gets new objects.
        if (answer.is_success and method != "GET") or state == "disabled":
            world = World(api)
        fits = answer.is_success if wanted == "+" else str(answer.status_code) == wanted
        if not fits:
            wrong.append(f"{role}: {wanted} wanted, {answer.status_code} {answer.text[:200]}")
    assert wrong == []
