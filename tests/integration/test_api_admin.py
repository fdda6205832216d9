"""Administrators: granted by a command, what they can see and change, the audit log, and render time as a quota."""

from __future__ import annotations

import os
import subprocess

import pytest
from api_client import PASSWORD, Person, add_worker, api, client, forget_attempts, make_ready, person, problem, remove_worker  # noqa: F401


def command(stack, *words: str) -> subprocess.CompletedProcess:
    binary = stack.stack.layout.bin / "diaphane-api"
    return subprocess.run([str(binary), "admin", *words], env={**os.environ, "DIAPHANE_POSTGRES": stack.dsn},
                          capture_output=True, text=True)


@pytest.fixture(scope="module")
def admin(api) -> Person:  # noqa: F811
    one = person(api)
    assert command(api, "grant", one.email.upper()).returncode == 0
    one.sets_up_second_factor()
    return one


def user(admin: Person, one: Person) -> dict:
    [found] = admin.http.get("/v1/admin/users", params={"query": one.email}).json()["items"]
    return found


def entries(admin: Person, account: str, **query: str) -> list[dict]:
    return admin.http.get("/v1/admin/audit", params={"account": account, **query}).json()["items"]


def test_only_the_local_command_grants_and_revokes_the_role(api):  # noqa: F811
    one = person(api)
    problem(one.http.get("/v1/admin/users"), 403, "forbidden")
    done = command(api, "grant", one.email)
    assert done.returncode == 0 and one.email in command(api, "list").stdout
    assert one.http.get("/v1/me").json()["administrator"] is True
    one.sets_up_second_factor()
    assert one.http.get("/v1/admin/users").status_code == 200
    [entry] = entries(one, one.id, action="administrator.")
    assert entry["action"] == "administrator.granted" and entry["actor"] == "machine"
    assert command(api, "revoke", one.email).returncode == 0
    problem(one.http.get("/v1/admin/users"), 403, "forbidden")
    for words, code in ((("grant", "nobody@example.org"), 1), (("grant",), 78), (("crown", one.email), 78)):
        assert command(api, *words).returncode == code


def test_accounts_are_searched_by_address_or_id_with_pages(api, admin):  # noqa: F811
    some = [Person(api, f"findme-{i}-{admin.email}").sign_up() for i in range(3)]
    seen, cursor = [], None
    while True:
        query = {"query": "FINDME-", "limit": 2, **({"cursor": cursor} if cursor else {})}
        page = admin.http.get("/v1/admin/users", params=query).json()
        seen += [item["email"] for item in page["items"]]
        cursor = page["next_cursor"]
        if cursor is None:
            break
    assert sorted(seen) == sorted(one.email for one in some)
    found = user(admin, some[0])
    assert found["verified"] and not found["disabled"] and not found["administrator"] and found["data_sets"] == 0
    [by_id] = admin.http.get("/v1/admin/users", params={"query": found["id"]}).json()["items"]
    assert by_id == found == admin.http.get(f"/v1/admin/users/{found['id']}").json()
    assert admin.http.get("/v1/admin/users", params={"query": "%_'"}).json()["items"] == []


def test_a_new_quota_applies_immediately_and_is_logged(api, admin):  # noqa: F811
    one = person(api)
    path = f"/v1/admin/users/{one.id}"
    changed = admin.http.patch(path, json={"quota_bytes": 1000, "render_quota_ms": 5}).json()
    assert changed["quota"]["bytes"] == 1000 and changed["render_time"]["quota_ms"] == 5
    problem(one.announce(2000), 413, "over-quota")
    assert one.http.get("/v1/me").json()["quota"]["bytes"] == 1000
    for wrong in ({"quota_bytes": -1}, {"quota_bytes": "much"}, {"disabled": 1}, {"administrator": True}):
        problem(admin.http.patch(path, json=wrong), 422, "invalid")
    log = {e["action"]: e for e in entries(admin, one.id)}
    assert log["account.storage-quota-changed"]["details"]["to"] == 1000
    assert log["account.storage-quota-changed"]["actor_email"] == admin.email
    assert log["account.render-quota-changed"]["subject_email"] == one.email


def test_a_disabled_account_is_signed_out_until_it_is_enabled(api, admin):  # noqa: F811
    one = person(api)
    made = one.data_set(10)["data_set"]["id"]
    make_ready(api, made)
    add_worker(api, "admin-test")
    session = one.http.post("/v1/sessions", json={"data_set_id": made}).json()["session_id"]
    path = f"/v1/admin/users/{one.id}"
    assert admin.http.patch(path, json={"disabled": True}).json()["disabled"] is True
    problem(one.http.get("/v1/me"), 401, "unauthenticated")
    assert api.redis.exists(f"diaphane:session:{session}") == 0
    assert api.redis.exists(f"diaphane:session:{session}:ended") == 1, "running pictures end with the next heartbeat"
    forget_attempts(api)
    given = {"email": one.email, "password": PASSWORD}
    problem(client(api).post("/v1/sign-in", json=given), 403, "disabled")
    problem(client(api).post("/v1/sign-in", json={**given, "password": "a wrong one"}), 401, "wrong-credentials")
    before = len(api.mails(one.email))
    assert client(api).post("/v1/password-reset", json={"email": one.email}).status_code == 202
    api.wait_until(lambda: len(api.mails(one.email)) > before, what="the mail")
    mail = api.mails(one.email)[-1]
    assert mail["Subject"] == "Your Diaphane account is disabled" and "token" not in mail.get_content()
    assert admin.http.patch(path, json={"disabled": False}).json()["disabled"] is False
    one.sign_in()
    assert one.http.get(f"/v1/data-sets/{made}").status_code == 200, "nothing was deleted"
    actions = [e["action"] for e in entries(admin, one.id)]
    assert actions[:2] == ["account.enabled", "account.disabled"]
    problem(admin.http.patch(f"/v1/admin/users/{admin.id}", json={"disabled": True}), 409, "conflict")
    remove_worker(api, "admin-test")


def test_the_audit_log_is_filtered_and_paged(api, admin):  # noqa: F811
    me = person(api).id
    path = f"/v1/admin/users/{me}"
    for size in range(5):
        admin.http.patch(path, json={"quota_bytes": 5000 + size})
    admin.http.patch(path, json={"disabled": True})
    assert len(entries(admin, me)) == 6
    assert len(entries(admin, me, action="account.storage")) == 5
    assert len(entries(admin, me, **{"from": "2020-01-01T00:00:00Z", "until": "2021-01-01T00:00:00Z"})) == 0
    first = admin.http.get("/v1/admin/audit", params={"account": me, "limit": 4}).json()
    rest = admin.http.get("/v1/admin/audit", params={"account": me, "limit": 4, "cursor": first["next_cursor"]}).json()
    ids = [e["id"] for e in first["items"] + rest["items"]]
    assert ids == sorted(ids, reverse=True) and len(ids) == 6 and rest["next_cursor"] is None
    for wrong in ({"account": "x"}, {"from": "yesterday"}, {"until": "2026-02-31T00:00:00Z"}, {"cursor": "x"}, {"limit": "0"}):
        problem(admin.http.get("/v1/admin/audit", params=wrong), 422, "invalid")


def test_views_by_administrators_are_logged(api, admin):  # noqa: F811
    one = person(api)

    def looks() -> list[dict]:
        return [e for e in entries(admin, admin.id) if e["action"].endswith(".looked-at")]

    admin.http.get("/v1/admin/users", params={"query": one.email})
    admin.http.get(f"/v1/admin/users/{one.id}")
    admin.http.get("/v1/reports")
    found = looks()
    assert [e["action"] for e in found[:3]] == ["reports.looked-at", "account.looked-at", "accounts.looked-at"]
    assert found[1]["subject_id"] == one.id and found[2]["details"] == {"items": 1} and found[0]["actor"] == "administrator"
    assert looks()[0]["action"] == "audit-log.looked-at" and looks()[0]["details"]["account"] == admin.id
    assert one.email not in api.psql("SELECT string_agg(details::text, ' ') FROM audit_log")[0][0]
    # A request that fails earlier is not an access.
    before = looks()[0]["id"]
    problem(one.http.get(f"/v1/admin/users/{admin.id}"), 403, "forbidden")
    problem(admin.http.get("/v1/admin/users/00000000-0000-4000-8000-000000000000"), 404, "not-found")
    assert [e["id"] for e in looks()[:2]][1] == before, "nothing but the look before this one"


def test_the_fleet_page_matches_redis(api, admin):  # noqa: F811
    add_worker(api, "fleet-test", slots=7)
    fleet = admin.http.get("/v1/admin/fleet").json()
    [worker] = [w for w in fleet["workers"] if w["id"] == "fleet-test"]
    assert worker["slots"] == 7 and worker["engine"] == "cpu" and worker["device"] == "test" and not worker["draining"]
    before = fleet["ingest"]["queued"]
    person(api).upload(b"x" * 10)
    assert admin.http.get("/v1/admin/fleet").json()["ingest"]["queued"] == before + 1
    remove_worker(api, "fleet-test")


# Render time. A worker adds to `diaphane:render_time` with its heartbeat (RegistryTest.ReportsRenderTimeOncePerUser in
# renderd/serve). Here, the test does.

def spend(stack, one: Person, ms: int) -> None:
    before = one.http.get("/v1/me").json()["render_time"]["used_ms"]
    stack.redis.hincrby("diaphane:render_time", one.id, ms)
    stack.wait_until(lambda: one.http.get("/v1/me").json()["render_time"]["used_ms"] == before + ms, what="the account")


def test_render_time_is_counted_and_limited_after_a_grace_period(api, admin):  # noqa: F811
    one = person(api)
    me = one.id
    made = one.data_set(10)["data_set"]["id"]
    make_ready(api, made)
    add_worker(api, "render-time", seconds=600)
    admin.http.patch(f"/v1/admin/users/{me}", json={"render_quota_ms": 60_000})
    session = one.http.post("/v1/sessions", json={"data_set_id": made}).json()["session_id"]
    spend(api, one, 59_000)
    assert one.http.get("/v1/me").json()["render_time"]["pictures_end_at"] is None
    assert one.http.post("/v1/sessions", json={"data_set_id": made}).status_code == 201

    spend(api, one, 2_000)
    spent = one.http.get("/v1/me").json()["render_time"]
    assert spent["pictures_end_at"] is not None and spent["used_ms"] == 61_000
    document = problem(one.http.post("/v1/sessions", json={"data_set_id": made}), 403, "render-time-spent")
    assert "used all of your rendering time" in document["detail"] and "resets on 1 " in document["detail"]
    # A running session continues for a while, also over a reconnection, and then ends.
    assert api.redis.exists(f"diaphane:session:{session}") == 1
    assert one.http.post(f"/v1/sessions/{session}/tickets").status_code == 201
    api.psql("UPDATE render_time SET warned_at = now() - interval '121 seconds' WHERE user_id = %s", me)
    # Sessions are checked every two seconds, so it may already be gone. While it exists, this is the reason for the refusal.
    refused = one.http.post(f"/v1/sessions/{session}/tickets")
    there = api.redis.exists(f"diaphane:session:{session}") == 1
    problem(refused, *((403, "render-time-spent") if there or refused.status_code == 403 else (404, "not-found")))
    api.wait_until(lambda: api.redis.exists(f"diaphane:session:{session}") == 0, what="the end of the picture")

    # An administrator increases the quota, or a month begins.
    admin.http.patch(f"/v1/admin/users/{me}", json={"render_quota_ms": 120_000})
    assert one.http.post("/v1/sessions", json={"data_set_id": made}).status_code == 201
    admin.http.patch(f"/v1/admin/users/{me}", json={"render_quota_ms": 60_000})
    problem(one.http.post("/v1/sessions", json={"data_set_id": made}), 403, "render-time-spent")
    api.psql("UPDATE render_time SET month = month - interval '1 month' WHERE user_id = %s", me)
    assert one.http.post("/v1/sessions", json={"data_set_id": made}).status_code == 201
    remove_worker(api, "render-time")


def test_render_time_of_unknown_accounts_is_dropped(api):  # noqa: F811
    api.redis.hset("diaphane:render_time", mapping={"00000000-0000-4000-8000-000000000000": 5, "nonsense": 7})
    api.wait_until(lambda: not api.redis.exists("diaphane:render_time"), what="it being taken")
    assert api.psql("SELECT 1 FROM render_time WHERE user_id = '00000000-0000-4000-8000-000000000000'") == []
