"""Signing up, in and out, through the edge."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest
from seeds import PRIVACY_NOTICE
from api_client import PASSWORD, Person, api, client, forget_attempts, link_token, make_ready, problem, signed_up  # noqa: F401


def test_sign_up_confirmation_and_sign_in_succeed(api):  # noqa: F811
    one = Person(api)
    forget_attempts(api)
    given = {"email": one.email, "password": PASSWORD}
    assert one.http.post("/v1/accounts", json={"email": one.email, "consent": True}).status_code == 202
    problem(one.http.post("/v1/sign-in", json=given), 401, "wrong-credentials")
    chosen = {"token": link_token(api, one.email), "password": PASSWORD}
    confirmed = one.http.post("/v1/accounts/verify", json=chosen)
    later = client(api)
    problem(later.post("/v1/accounts/verify", json=chosen), 410, "link-expired")
    problem(later.get("/v1/me"), 401, "unauthenticated")
    is_signed_in(one, confirmed)
    is_signed_in(one, one.http.post("/v1/sign-in", json=given))


def is_signed_in(one: Person, signed_in: httpx.Response) -> None:
    """The browser that got this answer is signed in until it signs out."""
    assert signed_in.status_code == 200
    cookies = signed_in.headers.get_list("set-cookie")
    assert sorted(cookie.split("=")[0] for cookie in cookies) == ["diaphane", "diaphane_browser"]
    for cookie in cookies:
        assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= {part.strip() for part in cookie.split(";")}
    me = one.http.get("/v1/me").json()
    assert me == signed_in.json()
    assert me["email"] == one.email and me["quota"]["used_bytes"] == 0

    problem(one.http.post("/v1/sign-out"), 403, "csrf")
    assert one.http.post("/v1/sign-out", headers={"X-CSRF-Token": me["csrf_token"]}).status_code == 204
    problem(one.http.get("/v1/me"), 401, "unauthenticated")


def test_a_cookie_is_invalid_after_signing_out(api):  # noqa: F811
    one = signed_up(api)
    kept = one.http.cookies["diaphane"]
    assert one.http.post("/v1/sign-out").status_code == 204
    other = client(api)
    other.cookies.set("diaphane", kept)
    problem(other.get("/v1/me"), 401, "unauthenticated")


def test_responses_do_not_reveal_who_has_an_account(api):  # noqa: F811
    known = Person(api).sign_up()
    stranger = client(api)
    again = stranger.post("/v1/accounts", json={"email": known.email.upper(), "consent": True})
    fresh = stranger.post("/v1/accounts", json={"email": "fresh-" + known.email, "consent": True})
    assert (again.status_code, again.content) == (fresh.status_code, fresh.content)
    api.wait_until(lambda: any("already" in m["Subject"] for m in api.mails()), what="the mail that says so")
    wrong = stranger.post("/v1/sign-in", json={"email": known.email, "password": "not the password"})
    unknown = stranger.post("/v1/sign-in", json={"email": "nobody@example.org", "password": "not the password"})
    a, b = problem(wrong, 401, "wrong-credentials"), problem(unknown, 401, "wrong-credentials")
    assert {k: v for k, v in a.items() if k != "request_id"} == {k: v for k, v in b.items() if k != "request_id"}


def test_an_account_needs_consent_to_the_processing_of_health_data(api):  # noqa: F811
    one = Person(api)
    forget_attempts(api)
    for given in ({}, {"consent": False}, {"consent": "yes"}):
        document = problem(one.http.post("/v1/accounts", json={"email": one.email, **given}), 422, "invalid")
        assert [error["field"] for error in document["errors"]] == ["consent"]
    assert api.psql("SELECT count(*) FROM users WHERE email = %s", one.email) == [(0,)]
    one.sign_up().sign_in()
    consent = one.http.get("/v1/me").json()["consent"]
    assert consent["version"] == PRIVACY_NOTICE and consent["given_at"]


def test_an_account_without_the_current_consent_is_asked_for_it(api):  # noqa: F811
    one = signed_up(api)
    api.psql("UPDATE users SET consent_version = 'older', consent_at = '2020-01-01' WHERE email = %s", one.email)
    assert one.http.get("/v1/me").json()["consent"] == {"version": PRIVACY_NOTICE, "given_at": None}
    problem(one.http.post("/v1/data-sets", json={"title": "x", "bytes": 10}), 403, "consent-needed")
    assert one.http.get("/v1/data-sets").status_code == 200
    problem(one.http.post("/v1/me/consent", json={"version": "older"}), 422, "invalid")
    problem(one.http.post("/v1/me/consent", json={"version": "x" * 41}), 422, "invalid")
    assert one.http.post("/v1/me/consent", json={"version": PRIVACY_NOTICE}).status_code == 204
    assert one.http.get("/v1/me").json()["consent"]["given_at"]
    assert one.http.post("/v1/data-sets", json={"title": "x", "bytes": 10}).status_code == 201
    assert api.psql("SELECT details->>'version' FROM audit_log WHERE action = 'account.consent-given' AND actor_id = "
                    "(SELECT id FROM users WHERE email = %s)", one.email) == [(PRIVACY_NOTICE,)]


def signs_up(api, email: str, mails: int) -> str:  # noqa: F811
    """Signs up this many times and returns the token in the newest mail."""
    assert client(api).post("/v1/accounts", json={"email": email, "consent": True}).status_code == 202
    api.wait_until(lambda: len(api.mails(email)) == mails, what="the mail")
    return link_token(api, email)


@pytest.mark.parametrize("opened", ["first", "last"])
def test_signing_up_with_the_address_of_somebody_else_gives_no_access(api, opened):  # noqa: F811
    """Neither before nor after the owner, nor by sending so many mails that the owner's own is not sent."""
    owner = Person(api)
    sharing = signed_up(api)
    scan = sharing.data_set(10)["data_set"]["id"]
    make_ready(api, scan)
    shared = {"email": owner.email, "may": "view"}
    assert sharing.http.post(f"/v1/data-sets/{scan}/people", json=shared).status_code == 204
    forget_attempts(api)
    api.wait_until(lambda: len(api.mails(owner.email)) == 1, what="the invitation")
    attacker = client(api)
    tokens = [signs_up(api, owner.email, mails) for mails in (2, 3, 4, 5)]
    assert owner.http.post("/v1/accounts", json={"email": owner.email, "consent": True}).status_code == 202  # no further mail
    password = "what the stranger would like"
    problem(attacker.post("/v1/accounts", json={"email": owner.email, "consent": True, "password": password}), 422, "invalid")

    token = tokens[0] if opened == "first" else tokens[-1]
    assert owner.http.post("/v1/accounts/verify", json={"token": token, "password": PASSWORD}).status_code == 200
    owner.sign_in()
    assert [item["id"] for item in owner.http.get("/v1/data-sets").json()["items"]] == [scan]
    problem(attacker.post("/v1/sign-in", json={"email": owner.email, "password": password}), 401, "wrong-credentials")
    for other in tokens:
        problem(attacker.post("/v1/accounts/verify", json={"token": other, "password": password}), 410, "link-expired")
    # A later sign-up changes nothing either.
    forget_attempts(api)
    assert attacker.post("/v1/accounts", json={"email": owner.email, "consent": True}).status_code == 202
    owner.sign_in()


def test_mails_of_one_kind_do_not_use_up_the_limit_of_others(api):  # noqa: F811
    """Four resets for an address without an account do not prevent its owner from signing up, and four sign-ups do not prevent
    the owner of an account from getting a new password."""
    one = Person(api)
    forget_attempts(api)
    for _ in range(5):
        assert client(api).post("/v1/password-reset", json={"email": one.email}).status_code == 202
    api.wait_until(lambda: len(api.mails(one.email)) == 4, what="the mails that say that there is no account")
    chosen = {"token": signs_up(api, one.email, 5), "password": PASSWORD}
    assert one.http.post("/v1/accounts/verify", json=chosen).status_code == 200
    forget_attempts(api)
    for _ in range(5):
        assert client(api).post("/v1/accounts", json={"email": one.email, "consent": True}).status_code == 202
    assert client(api).post("/v1/password-reset", json={"email": one.email}).status_code == 202
    link_token(api, one.email, "reset")


def test_only_one_of_two_concurrent_confirmations_sets_the_password(api):  # noqa: F811
    one = Person(api)
    forget_attempts(api)
    tokens = [signs_up(api, one.email, 1), signs_up(api, one.email, 2)]
    with ThreadPoolExecutor(2) as both:
        passwords = [PASSWORD + str(i) for i in range(2)]
        answers = list(both.map(lambda i: client(api).post("/v1/accounts/verify", json={"token": tokens[i], "password": passwords[i]})
                                .status_code, range(2)))
    assert sorted(answers) == [200, 410]
    for answer, password in zip(answers, passwords, strict=True):
        status = client(api).post("/v1/sign-in", json={"email": one.email, "password": password}).status_code
        assert status == (200 if answer == 200 else 401)


def test_mails_per_address_are_limited(api):  # noqa: F811
    forget_attempts(api)
    one = Person(api)
    for _ in range(8):
        assert one.http.post("/v1/accounts", json={"email": one.email, "consent": True}).status_code == 202
    api.wait_until(lambda: api.psql("SELECT count(*) FROM mail_queue") == [(0,)], what="the queue's end")
    assert 1 <= len(api.mails(one.email)) <= 4


def test_weak_passwords_and_invalid_addresses_are_refused(api):  # noqa: F811
    http = client(api)
    forget_attempts(api)
    one = Person(api)
    token = signs_up(api, one.email, 1)
    for password in ("short", "kq7 zr4 vm2", "password1234", "x" * 201, one.email.capitalize()):
        document = problem(http.post("/v1/accounts/verify", json={"token": token, "password": password}), 422, "invalid")
        assert document["errors"][0]["field"] == "password"
    for address in ("nobody", "a@b@c", "a b@example.org", "<x@example.org>"):
        document = problem(http.post("/v1/accounts", json={"email": address, "consent": True}), 422, "invalid")
        assert document["errors"][0]["field"] == "email"


def test_too_many_wrong_passwords_delay_the_right_one_too(api):  # noqa: F811
    one = Person(api, Person(api).sign_up().email)
    forget_attempts(api)
    for _ in range(10):
        problem(one.http.post("/v1/sign-in", json={"email": one.email, "password": "guessing it"}),
                401, "wrong-credentials")
    for password in ("guessing it", PASSWORD):
        answer = one.http.post("/v1/sign-in", json={"email": one.email, "password": password})
        problem(answer, 429, "too-many-attempts")
        assert 1 <= int(answer.headers["retry-after"]) <= 15 * 60
    # Another account is not affected, and the limit expires.
    Person(api).sign_up()
    api.psql("UPDATE attempts SET happened_at = happened_at - interval '16 minutes'")
    one.sign_in()


def test_strangers_do_not_lock_out_a_browser_that_has_signed_in_before(api):  # noqa: F811
    one = signed_up(api)
    returning = signed_up(api)
    assert returning.http.post("/v1/sign-out").status_code == 204
    for target in (one, returning):
        forget_attempts(api)
        stranger = client(api)
        for _ in range(10):
            problem(stranger.post("/v1/sign-in", json={"email": target.email, "password": "guessing it"}), 401, "wrong-credentials")
        problem(stranger.post("/v1/sign-in", json={"email": target.email, "password": PASSWORD}), 429, "too-many-attempts")
        if target is returning:
            assert set(returning.http.cookies) == {"diaphane_browser"}
            returning.sign_in()
        else:
            wanted = {"current": PASSWORD, "password": "another long and quiet one"}
            assert one.http.post("/v1/me/password", json=wanted).status_code == 204


def test_forged_and_expired_cookies_are_rejected(api):  # noqa: F811
    one = signed_up(api)
    for forged in ("0" * 64, "nonsense", one.http.cookies["diaphane"][:-1] + "x", ""):
        other = client(api)
        other.cookies.set("diaphane", forged)
        problem(other.get("/v1/me"), 401, "unauthenticated")
    api.psql("UPDATE web_sessions SET expires_at = now() - interval '1 second' WHERE user_id = %s", one.id)
    problem(one.http.get("/v1/me"), 401, "unauthenticated")


def test_activity_extends_a_web_session_up_to_a_limit(api):  # noqa: F811
    one = signed_up(api)
    me = one.id
    api.psql("UPDATE web_sessions SET expires_at = now() + interval '1 day' WHERE user_id = %s", me)
    answer = one.http.get("/v1/me")
    assert "Max-Age=1209600" in answer.headers["set-cookie"]
    assert "set-cookie" not in one.http.get("/v1/me").headers
    api.psql("""UPDATE web_sessions SET created_at = now() - interval '29 days', expires_at = now() + interval '1 hour'
                WHERE user_id = %s""", me)
    one.http.get("/v1/me")
    [(left,)] = api.psql("SELECT extract(epoch FROM expires_at - now())::float FROM web_sessions WHERE user_id = %s", me)
    assert left < 86400 + 60


def test_cross_site_requests_are_refused(api):  # noqa: F811
    one = signed_up(api)
    for origin in ("https://evil.example", "null", api.url + ".evil.example"):
        problem(one.announce(1000, Origin=origin), 403, "origin")
        problem(one.http.post("/v1/sign-in", json={"email": one.email, "password": PASSWORD},
                              headers={"Origin": origin}), 403, "origin")
    assert one.announce(1000, Origin=api.url).status_code == 201
    without = client(api)
    without.cookies.set("diaphane", one.http.cookies["diaphane"])
    for csrf in ({}, {"X-CSRF-Token": "0" * 64}):
        problem(without.post("/v1/data-sets", json={"bytes": 5}, headers=csrf), 403, "csrf")


def test_secrets_are_not_in_the_database_or_the_logs(api):  # noqa: F811
    one = signed_up(api)
    token = one.http.cookies["diaphane"]
    assert api.psql("SELECT 1 FROM web_sessions WHERE token_hash = %s", token) == []
    assert all(h.startswith("$argon2id$") for (h,) in api.psql("SELECT password_hash FROM users WHERE verified_at IS NOT NULL"))
    time.sleep(0.1)
    log = api.log("api") + api.log("edge") + api.log("postgres")
    for secret in (token, PASSWORD, one.email, one.csrf):
        assert secret not in log


@pytest.mark.parametrize("wanted,subject", [("de-AT,de;q=0.9,en;q=0.5", "Bestätigen Sie Ihre E-Mail-Adresse für Diaphane"),
                                            ("fr,en;q=0.5", "Confirm your email address for Diaphane"),
                                            ("de\"<script>", "Confirm your email address for Diaphane")])
def test_a_mail_is_in_the_language_that_the_request_prefers(api, wanted, subject):
    one = Person(api)
    api.psql("DELETE FROM attempts")
    assert one.http.post("/v1/accounts", json={"email": one.email, "consent": True}, headers={"Accept-Language": wanted}).status_code == 202
    [mail] = api.wait_until(lambda: api.mails(one.email), what="the mail")
    assert mail["Subject"] == subject
