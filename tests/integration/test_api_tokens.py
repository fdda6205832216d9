"""API tokens: creation, scopes, expiry, last use and revocation, through the edge."""

from __future__ import annotations

import re
import uuid

import httpx
import pytest
from access_matrix import OPERATIONS
from api_client import (PASSWORD, Person, add_worker, api, client, forget_attempts, make_ready, one, person,  # noqa: F401
                        problem, remove_worker)

SCOPES = ("read", "write", "share", "archive")


def create(who: Person, *scopes: str, **changes: object) -> dict:
    answer = who.http.post("/v1/me/tokens", json={"name": "Notebook", "scopes": list(scopes or SCOPES), "days": 30, "password": PASSWORD, **changes})
    assert answer.status_code == 201, answer.text
    return answer.json()


def program(stack, token: str) -> httpx.Client:
    """Returns a client that has only the token. Every response is validated against the contract."""
    made = client(stack)
    made.headers["Authorization"] = f"Bearer {token}"
    return made


def scope_of(operation: dict) -> str | None:
    return next((way["token"][0] for way in operation.get("security", []) if "token" in way), None)


def test_a_token_is_shown_once_listed_and_revoked(api):  # noqa: F811
    owner, stranger = person(api), person(api)
    made = create(owner, "read")
    token = made.pop("token")
    assert re.fullmatch("diaphane_[0-9a-f]{64}", token) and made["used_at"] is None
    assert owner.http.get("/v1/me/tokens").json()["items"] == [made]
    assert token not in str(api.psql("SELECT * FROM api_tokens"))
    assert program(api, token).get("/v1/data-sets").status_code == 200
    [listed] = owner.http.get("/v1/me/tokens").json()["items"]
    assert listed["used_at"] is not None
    problem(stranger.http.delete(f"/v1/me/tokens/{made['id']}"), 404, "not-found")
    assert owner.http.delete(f"/v1/me/tokens/{made['id']}").status_code == 204
    problem(program(api, token).get("/v1/data-sets"), 401, "unauthenticated")
    problem(owner.http.delete(f"/v1/me/tokens/{made['id']}"), 404, "not-found")
    actions = [row[0] for row in api.psql("SELECT action FROM audit_log WHERE actor_id = %s ORDER BY id", owner.id)]
    assert actions == ["account.token-created", "account.token-revoked"]
    api.wait_until(lambda: any("API token" in mail["Subject"] for mail in api.mails(owner.email)), what="the mail about it")


def test_the_server_permits_exactly_what_the_contract_says(api):  # noqa: F811
    """Every operation with a token of every scope. What the contract does not open to a token answers 403, whatever the scope."""
    owner = person(api)
    api.psql("UPDATE users SET archive_access = true WHERE email = %s", owner.email)
    programs = {scope: program(api, create(owner, scope)["token"]) for scope in SCOPES}
    wrong = []
    for name, (path, method, operation) in OPERATIONS.items():
        if operation.get("security") == []:
            continue
        for scope, http in programs.items():
            # The body of a refused request is not read, and that of another one is wrong on purpose.
            answer = http.request(method, re.sub(r"\{\w+\}", str(uuid.uuid4()), path), json={} if "requestBody" in operation else None,
                                  headers={"Tus-Resumable": "1.0.0"} if path.startswith("/v1/uploads") else {})
            if (answer.status_code in (401, 403)) != (scope_of(operation) != scope):
                wrong.append(f"{name} with {scope}: {answer.status_code}")
    assert wrong == []
    assert {scope_of(operation) for _, _, operation in OPERATIONS.values()} == {None, *SCOPES}


def test_no_scope_reaches_the_account_or_the_administration(api):  # noqa: F811
    boss = person(api).becomes_administrator()
    forget_attempts(api)
    made = program(api, create(boss, code=boss.device.code())["token"])
    tags = {"accounts", "my-account", "administration"}
    asked = [(path, method) for path, method, operation in OPERATIONS.values() if tags & set(operation["tags"]) and operation.get("security") != []]
    assert len(asked) > 25
    for path, method in asked:
        problem(made.request(method, re.sub(r"\{\w+\}", str(uuid.uuid4()), path)), 403, "forbidden")


def test_a_program_uploads_and_changes_with_write_alone(api):  # noqa: F811
    owner = Person(api)
    made = person(api)
    owner.http = program(api, create(made, "write")["token"])
    data_set = owner.upload(b"x" * 1000)
    assert data_set["title"] == "" and owner.http.delete(f"/v1/data-sets/{data_set['id']}").status_code == 204
    problem(owner.http.get("/v1/data-sets"), 403, "forbidden")


def test_a_revoked_token_ends_its_streams_and_no_others(api):  # noqa: F811
    owner = person(api)
    data_set = owner.data_set(10)["data_set"]["id"]
    make_ready(api, data_set)
    add_worker(api, "api-tokens")
    made = create(owner, "read")
    sessions = [who.post("/v1/sessions", json={"data_set_id": data_set}).json()["session_id"] for who in (program(api, made["token"]), owner.http)]
    assert owner.http.delete(f"/v1/me/tokens/{made['id']}").status_code == 204
    assert [api.redis.exists(f"diaphane:session:{one}") for one in sessions] == [0, 1]
    remove_worker(api, "api-tokens")


@pytest.mark.parametrize("change", ["password", "everywhere", "disabled", "expired"])
def test_a_token_ends_with_what_it_depends_on(api, change):  # noqa: F811
    forget_attempts(api)
    owner = person(api)
    http = program(api, create(owner, "read")["token"])
    assert http.get("/v1/data-sets").status_code == 200
    me = owner.id
    if change == "password":
        assert owner.http.post("/v1/me/password", json={"current": PASSWORD, "password": PASSWORD + " two"}).status_code == 204
    elif change == "everywhere":
        assert owner.http.delete("/v1/me/browser-sessions").status_code == 204
    elif change == "disabled":
        api.psql("UPDATE users SET disabled_at = now() WHERE id = %s", me)
    else:
        api.psql("UPDATE api_tokens SET expires_at = now() - interval '1 second' WHERE user_id = %s", me)
    problem(http.get("/v1/data-sets"), 401, "unauthenticated")
    if change != "disabled":
        api.wait_until(lambda: api.psql("SELECT 1 FROM api_tokens WHERE user_id = %s", me) == [], what="the end of its row")


def test_creating_one_requires_what_signing_in_does(api, one):  # noqa: F811
    given = {"name": "a", "scopes": ["read"], "days": 1, "password": PASSWORD}
    for wrong in ({"scopes": []}, {"scopes": ["read", "read"]}, {"scopes": ["admin"]}, {"scopes": "read"}, {"days": 0}, {"days": 366}, {"name": ""},
                  {"name": "x" * 61}, {"password": "wrong"}):
        document = problem(one.http.post("/v1/me/tokens", json={**given, **wrong}), 422, "invalid")
        assert [error["field"] for error in document["errors"]] == list(wrong)
    owner = person(api)
    owner.sets_up_second_factor()
    problem(owner.http.post("/v1/me/tokens", json=given), 401, "code-needed")
    problem(owner.http.post("/v1/me/tokens", json={**given, "code": "000000"}), 401, "wrong-code")
    assert create(owner, "read", code=owner.device.code())["scopes"] == ["read"]


def test_guesses_of_the_password_are_limited(api):  # noqa: F811
    owner = person(api)
    given = {"name": "a", "scopes": ["read"], "days": 1, "password": "wrong wrong"}
    for _ in range(10):
        problem(owner.http.post("/v1/me/tokens", json=given), 422, "invalid")
    problem(owner.http.post("/v1/me/tokens", json={**given, "password": PASSWORD}), 429, "too-many-attempts")
    forget_attempts(api)


def test_an_account_has_at_most_twenty_tokens(api):  # noqa: F811
    owner = person(api)
    for _ in range(20):
        create(owner, "read")
    given = {"name": "a", "scopes": ["read"], "days": 1, "password": PASSWORD}
    problem(owner.http.post("/v1/me/tokens", json=given), 409, "conflict")
    assert owner.http.delete(f"/v1/me/tokens/{owner.http.get('/v1/me/tokens').json()['items'][0]['id']}").status_code == 204
    create(owner, "read")


def test_without_the_consent_a_token_only_reads_and_deletes(api):  # noqa: F811
    owner = person(api)
    http = program(api, create(owner)["token"])
    api.psql("UPDATE users SET consent_version = 'old' WHERE id = %s", owner.id)
    assert http.get("/v1/data-sets").status_code == 200
    problem(http.post("/v1/data-sets", json={"bytes": 10}), 403, "consent-needed")
