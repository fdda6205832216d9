"""Forgotten and changed passwords, email changes, and signed-in browsers, through the edge."""

from __future__ import annotations

import uuid

from api_client import (PASSWORD, Person, add_worker, api, client, forget_attempts, link_token, make_ready,  # noqa: F401
                        problem, remove_worker, signed_up)

NEW = "another long and quiet one"


def fields(document: dict) -> list[str]:
    return [error["field"] for error in document["errors"]]


def reset_token(api, one: Person) -> str:  # noqa: F811
    forget_attempts(api)
    before = len(api.mails(one.email))
    assert client(api).post("/v1/password-reset", json={"email": one.email}).status_code == 202
    api.wait_until(lambda: len(api.mails(one.email)) > before, what="the mail")
    return link_token(api, one.email, "reset")


def open_picture(api, one: Person, data_set: str | None = None) -> str:  # noqa: F811
    """Returns the id of a session on a worker that exists only in Redis."""
    made = data_set or one.data_set(10)["data_set"]["id"]
    make_ready(api, made)
    add_worker(api, "account-changes")
    answer = one.http.post("/v1/sessions", json={"data_set_id": made})
    assert answer.status_code == 201, answer.text
    return answer.json()["session_id"]


def signed_in_with(api, one: Person, password: str) -> int:  # noqa: F811
    forget_attempts(api)
    return client(api).post("/v1/sign-in", json={"email": one.email, "password": password}).status_code


def test_resetting_a_password_signs_out_all_browsers(api):  # noqa: F811
    one = signed_up(api)
    session = open_picture(api, one)
    stale = reset_token(api, one)
    token = reset_token(api, one)
    assert stale != token
    http = client(api)
    problem(http.post("/v1/password-reset/confirm", json={"token": stale, "password": NEW}), 410, "link-expired")
    for weak in ("short", one.email, "password1234", "x" * 40):
        document = problem(http.post("/v1/password-reset/confirm", json={"token": token, "password": weak}), 422, "invalid")
        assert fields(document) == ["password"]
    assert http.post("/v1/password-reset/confirm", json={"token": token, "password": NEW}).status_code == 204
    problem(http.post("/v1/password-reset/confirm", json={"token": token, "password": NEW}), 410, "link-expired")
    problem(one.http.get("/v1/me"), 401, "unauthenticated")
    assert api.redis.exists(f"diaphane:session:{session}") == 0, "open pictures end"
    assert signed_in_with(api, one, PASSWORD) == 401 and signed_in_with(api, one, NEW) == 200
    api.wait_until(lambda: any("was changed" in m["Subject"] for m in api.mails(one.email)), what="the mail that tells of it")


def test_a_reset_looks_the_same_for_every_address(api):  # noqa: F811
    one = Person(api).sign_up()
    never = f"never-{uuid.uuid4().hex}@example.org"
    forget_attempts(api)
    answers = [client(api).post("/v1/password-reset", json={"email": e}) for e in (one.email, one.email.upper(), never)]
    assert {(a.status_code, a.content) for a in answers} == {(202, b"")}
    api.wait_until(lambda: api.mails(never), what="the mail")
    assert "no Diaphane account" in api.mails(never)[0]["Subject"] and "token" not in api.mails(never)[0].get_content()
    link_token(api, one.email, "reset")
    # Nor can a mailbox be flooded, or addresses be probed without limit.
    forget_attempts(api)
    for _ in range(8):
        assert client(api).post("/v1/password-reset", json={"email": never}).status_code == 202
    api.wait_until(lambda: api.psql("SELECT count(*) FROM mail_queue") == [(0,)], what="the queue's end")
    assert len(api.mails(never)) <= 1 + 4
    got = [client(api).post("/v1/password-reset", json={"email": f"x{i}@example.org"}).status_code for i in range(31)]
    assert got[-1] == 429


def test_a_reset_link_is_single_purpose_and_expires(api):  # noqa: F811
    one = signed_up(api)
    token = reset_token(api, one)
    for path, body in (("/v1/accounts/verify", {"password": NEW}), ("/v1/email-change/confirm", {})):
        problem(one.http.post(path, json={"token": token, **body}), 410, "link-expired")
    api.psql("UPDATE email_tokens SET expires_at = now() - interval '1 second' WHERE user_id = %s", one.id)
    problem(one.http.post("/v1/password-reset/confirm", json={"token": token, "password": NEW}), 410, "link-expired")


def test_a_changed_password_keeps_this_browser_and_ends_the_others(api):  # noqa: F811
    one = signed_up(api)
    other = Person(api, one.email).sign_in()
    token = reset_token(api, one)
    document = problem(one.http.post("/v1/me/password", json={"current": "not this one", "password": NEW}), 422, "invalid")
    assert fields(document) == ["current"]
    document = problem(one.http.post("/v1/me/password", json={"current": PASSWORD, "password": "qwertyuiop12"}), 422, "invalid")
    assert fields(document) == ["password"]
    assert one.http.post("/v1/me/password", json={"current": PASSWORD, "password": NEW}).status_code == 204
    assert one.http.get("/v1/me").status_code == 200
    problem(other.http.get("/v1/me"), 401, "unauthenticated")
    assert signed_in_with(api, one, NEW) == 200
    problem(other.http.post("/v1/password-reset/confirm", json={"token": token, "password": PASSWORD}), 410, "link-expired")


def test_password_guesses_to_change_it_are_limited(api):  # noqa: F811
    one = signed_up(api)
    forget_attempts(api)
    for path, body in (("/v1/me/password", {"current": "guess", "password": NEW}),
                       ("/v1/me/email", {"email": "x@example.org", "password": "guess"})):
        for _ in range(5):
            problem(one.http.post(path, json=body), 422, "invalid")
    answer = one.http.post("/v1/me/password", json={"current": PASSWORD, "password": NEW})
    problem(answer, 429, "too-many-attempts")
    forget_attempts(api)
    assert one.http.post("/v1/me/password", json={"current": PASSWORD, "password": NEW}).status_code == 204


def test_a_new_address_must_be_confirmed_and_the_old_one_is_notified(api):  # noqa: F811
    one = signed_up(api)
    old, new = one.email, f"New-{one.email}"
    forget_attempts(api)
    document = problem(one.http.post("/v1/me/email", json={"email": new, "password": "not this one"}), 422, "invalid")
    assert fields(document) == ["password"]
    assert one.http.post("/v1/me/email", json={"email": new, "password": PASSWORD}).status_code == 202
    token = link_token(api, new, "confirm-email")
    assert one.http.get("/v1/me").json()["email"] == old, "nothing changes before it is confirmed"
    # Opened by the reader of the new address's mail, who may never have requested it.
    problem(client(api).post("/v1/email-change/confirm", json={"token": token}), 401, "unauthenticated")
    problem(signed_up(api).http.post("/v1/email-change/confirm", json={"token": token}), 403, "forbidden")
    api.wait_until(lambda: any("about to change" in m["Subject"] for m in api.mails(old)), what="the old one is told")
    assert one.http.post("/v1/email-change/confirm", json={"token": token}).status_code == 204
    assert one.http.get("/v1/me").json()["email"] == new
    problem(one.http.post("/v1/email-change/confirm", json={"token": token}), 410, "link-expired")
    assert signed_in_with(api, one, PASSWORD) == 401
    one.email = new
    assert signed_in_with(api, one, PASSWORD) == 200
    api.wait_until(lambda: any("address of your Diaphane account was changed" in m["Subject"] for m in api.mails(old)), what="the old one is told again")


def test_an_address_with_an_account_is_neither_revealed_nor_taken(api):  # noqa: F811
    one, other = signed_up(api), signed_up(api)
    forget_attempts(api)
    free = one.http.post("/v1/me/email", json={"email": "free-" + one.email, "password": PASSWORD})
    taken = one.http.post("/v1/me/email", json={"email": other.email.upper(), "password": PASSWORD})
    assert (free.status_code, free.content) == (taken.status_code, taken.content) == (202, b"")
    api.wait_until(lambda: any("already" in m["Subject"] for m in api.mails(other.email.upper())), what="the mail")
    # The address is taken between the mail and the click.
    token_of = link_token(api, "free-" + one.email, "confirm-email")
    # another change was requested since
    problem(one.http.post("/v1/email-change/confirm", json={"token": token_of}), 410, "link-expired")
    forget_attempts(api)
    late = "late-" + one.email
    one.http.post("/v1/me/email", json={"email": late, "password": PASSWORD})
    token = link_token(api, late, "confirm-email")
    Person(api, late).sign_up()
    problem(one.http.post("/v1/email-change/confirm", json={"token": token}), 410, "link-expired")
    assert one.http.get("/v1/me").json()["email"] == one.email


def test_browsers_are_listed_roughly_and_signed_out_one_by_one(api):  # noqa: F811
    agents = {
        "Firefox on Windows": "Mozilla/5.0 (Windows NT 10.0; Win64; x64; rv:132.0) Gecko/20100101 Firefox/132.0",
        "Safari on iOS": "Mozilla/5.0 (iPhone; CPU iPhone OS 17_5 like Mac OS X) AppleWebKit/605.1.15 (KHTML, like Gecko) "
                         "Version/17.5 Mobile/15E148 Safari/604.1",
        "Chrome on Android": "Mozilla/5.0 (Linux; Android 14) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/130.0.0.0 Mobile "
                             "Safari/537.36",
        "Edge on Windows": "Mozilla/5.0 (Windows NT 10.0; Win64; x64) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/130.0.0.0 "
                           "Safari/537.36 Edg/130.0.0.0",
        "Unknown browser": "\x01<script>curl",
    }
    first = Person(api).sign_up()
    assert first.http.post("/v1/sign-out").status_code == 204
    signed_in = {}
    for name, agent in agents.items():
        signed_in[name] = Person(api, first.email)
        signed_in[name].http.headers["User-Agent"] = agent.replace("\x01", "")
        signed_in[name].sign_in()
    mine = signed_in["Firefox on Windows"]
    listed = mine.http.get("/v1/me/browser-sessions").json()["items"]
    assert {item["browser"] for item in listed} == set(agents)
    assert [item["browser"] for item in listed if item["current"]] == ["Firefox on Windows"]
    assert "127.0.0.1" not in str(listed) and "Mozilla" not in str(api.psql("SELECT * FROM web_sessions"))

    phone = next(item["id"] for item in listed if item["browser"] == "Safari on iOS")
    stranger = signed_up(api)
    problem(stranger.http.delete(f"/v1/me/browser-sessions/{phone}"), 404, "not-found")
    assert signed_in["Safari on iOS"].http.get("/v1/me").status_code == 200
    assert mine.http.delete(f"/v1/me/browser-sessions/{phone}").status_code == 204
    problem(signed_in["Safari on iOS"].http.get("/v1/me"), 401, "unauthenticated")
    problem(mine.http.delete(f"/v1/me/browser-sessions/{phone}"), 404, "not-found")
    assert len(mine.http.get("/v1/me/browser-sessions").json()["items"]) == len(agents) - 1


def pictures(api, *ids: str) -> list[int]:  # noqa: F811
    return [api.redis.exists(f"diaphane:session:{one}") for one in ids]


def test_signing_out_ends_only_the_sessions_of_that_browser(api):  # noqa: F811
    one = signed_up(api)
    phone, laptop = Person(api, one.email).sign_in(), Person(api, one.email).sign_in()
    mine, on_phone, on_laptop = (open_picture(api, each) for each in (one, phone, laptop))
    [current] = [b for b in phone.http.get("/v1/me/browser-sessions").json()["items"] if b["current"]]
    assert one.http.delete(f"/v1/me/browser-sessions/{current['id']}").status_code == 204
    assert pictures(api, mine, on_phone, on_laptop) == [1, 0, 1]
    assert laptop.http.post("/v1/sign-out").status_code == 204
    assert pictures(api, mine, on_phone, on_laptop) == [1, 0, 0]
    assert one.http.get("/v1/me").status_code == 200
    remove_worker(api, "account-changes")


def test_a_second_factor_ends_the_sessions_of_other_browsers(api):  # noqa: F811
    one = signed_up(api)
    other = Person(api, one.email).sign_in()
    mine, theirs = open_picture(api, one), open_picture(api, other)
    one.sets_up_second_factor()
    assert pictures(api, mine, theirs) == [1, 0]
    remove_worker(api, "account-changes")


def test_a_stream_ends_when_the_sign_in_that_opened_it_expires(api):  # noqa: F811
    one = signed_up(api)
    picture = open_picture(api, one)
    api.psql("UPDATE web_sessions SET expires_at = now() - interval '1 second' WHERE user_id = %s", one.id)
    problem(one.http.get("/v1/me"), 401, "unauthenticated")
    api.wait_until(lambda: pictures(api, picture) == [0], what="the end of the picture")
    remove_worker(api, "account-changes")


def test_an_administrator_stays_signed_in_for_at_most_twelve_hours(api):  # noqa: F811
    one = signed_up(api).becomes_administrator()
    assert one.http.get("/v1/me").status_code == 200
    [(hours,)] = api.psql("SELECT max(extract(epoch FROM expires_at - created_at))::float / 3600 FROM web_sessions "
                          "WHERE user_id = %s AND expires_at > now()", one.id)
    assert hours == 12, "what goes by the stored time, streams among it, ends then"


def test_signing_out_everywhere_ends_all_sessions(api):  # noqa: F811
    one = signed_up(api)
    other = Person(api, one.email).sign_in()
    session = open_picture(api, one)
    assert api.redis.exists(f"diaphane:session:{session}") == 1
    answer = other.http.delete("/v1/me/browser-sessions")
    assert answer.status_code == 204 and "Max-Age=0" in answer.headers["set-cookie"]
    for each in (one, other):
        problem(each.http.get("/v1/me"), 401, "unauthenticated")
    assert api.redis.exists(f"diaphane:session:{session}") == 0
    assert api.redis.exists(f"diaphane:session:{session}:ended") == 1, "the worker's next heartbeat ends it"
    remove_worker(api, "account-changes")


def test_each_change_is_in_the_audit_log_without_an_address(api):  # noqa: F811
    one = signed_up(api)
    me = one.id
    one.http.post("/v1/me/password", json={"current": PASSWORD, "password": NEW})
    one.http.delete("/v1/me/browser-sessions")
    rows = api.psql("SELECT actor, action, subject, subject_id::text, details FROM audit_log WHERE actor_id = %s ORDER BY id", me)
    assert [row[1] for row in rows] == ["account.password-changed", "account.signed-out-everywhere"]
    assert all(row[0] == "person" and row[2:4] == ("account", me) for row in rows)
    assert "@" not in str(api.psql("SELECT * FROM audit_log"))


def test_the_audit_log_is_append_only(api):  # noqa: F811
    import psycopg
    import pytest

    one = signed_up(api)
    one.http.delete("/v1/me/browser-sessions")
    [(entry,)] = api.psql("SELECT max(id) FROM audit_log")
    for statement in ("DELETE FROM audit_log WHERE id = %s", "UPDATE audit_log SET action = 'a.b' WHERE id = %s",
                      "UPDATE audit_log SET actor_id = gen_random_uuid() WHERE id = %s",
                      "UPDATE audit_log SET happened_at = now() - interval '2 years' WHERE id = %s"):
        with pytest.raises(psycopg.errors.RaiseException):
            api.psql(statement, entry)
    with pytest.raises(psycopg.Error):
        api.psql("TRUNCATE audit_log")
    api.psql("UPDATE audit_log SET actor_id = NULL WHERE id = %s", entry)  # its account was deleted
    api.psql("INSERT INTO audit_log (happened_at, actor, action, subject) VALUES (now() - interval '366 days', 'machine', "
             "'test.old', 'test')")
    api.psql("DELETE FROM audit_log WHERE action = 'test.old'")
