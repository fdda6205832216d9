"""The second factor: set up, requested, single-use, protected against guessing, and lost. Also an administrator without one."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest
from api_client import PASSWORD, Device, Person, api, client, forget_attempts, link_token, person, problem  # noqa: F401
from test_api_admin import command
from access_matrix import OPERATIONS, ROWS
from access_matrix_fixture import World, question


def sign_in(stack, one: Person, code: str | None = None, password: str = PASSWORD) -> httpx.Response:
    """Signs in from another browser."""
    given = {"email": one.email, "password": password, **({} if code is None else {"code": code})}
    return client(stack).post("/v1/sign-in", json=given)


def subjects(stack, one: Person) -> list[str]:
    return [mail["Subject"] for mail in stack.mails(one.email)]


def told(stack, one: Person, words: str) -> None:
    stack.wait_until(lambda: any(words in subject for subject in subjects(stack, one)), what=f"a mail: {words}")


def actions(stack, one: Person) -> list[str]:
    return [row[0] for row in stack.psql("SELECT action FROM audit_log WHERE subject_id = %s ORDER BY id", one.id)]


def step_now() -> int:
    return int(time.time() // Device.STEP)


def test_set_up_sign_in_and_removal_of_a_second_factor(api):  # noqa: F811
    one, path = person(api), "/v1/me/second-factor"
    elsewhere = Person(api, one.email).sign_in()
    assert one.http.get(path).json() == {"set_up_at": None, "recovery_codes": 0, "required": False}
    assert problem(one.http.post(path, json={"password": "not this one"}), 422, "invalid")["errors"][0]["field"] == "password"
    made = one.http.post(path, json={"password": PASSWORD}).json()
    assert made["uri"].startswith("otpauth://totp/Diaphane:person-") and f"secret={made['secret']}&issuer=Diaphane" in made["uri"]
    assert sign_in(api, one).status_code == 200, "begun counts for nothing"
    one.device = Device(made["secret"])
    assert problem(one.http.post(f"{path}/confirm", json={"code": "12345x"}), 422, "invalid")["errors"][0]["field"] == "code"
    answer = one.http.post(f"{path}/confirm", json={"code": one.device.code()})
    codes = answer.json()["recovery_codes"]
    assert len(set(codes)) == 10
    problem(elsewhere.http.get("/v1/me"), 401, "unauthenticated")
    assert one.http.get("/v1/me").json()["second_factor"] is True and one.http.get(path).json()["recovery_codes"] == 10
    problem(one.http.post(path, json={"password": PASSWORD}), 409, "conflict")
    problem(one.http.post(f"{path}/confirm", json={"code": "123456"}), 409, "conflict")
    told(api, one, "Two-factor authentication is now on")

    problem(sign_in(api, one), 401, "code-needed")
    problem(sign_in(api, one, password="not the password"), 401, "wrong-credentials")
    problem(sign_in(api, one, "000000", "not the password"), 401, "wrong-credentials")
    problem(sign_in(api, one, "abc"), 401, "wrong-code")
    assert sign_in(api, one, one.device.code()).status_code == 200
    assert actions(api, one) == ["account.second-factor-added"]

    fresh = one.http.post(f"{path}/recovery-codes", json={"password": PASSWORD, "code": codes[0]}).json()["recovery_codes"]
    assert not set(fresh) & set(codes)
    problem(sign_in(api, one, codes[1]), 401, "wrong-code")
    told(api, one, "new recovery codes")
    for wrong, field in (({"password": "no", "code": fresh[0]}, "password"), ({"password": PASSWORD, "code": "000000"}, "code")):
        assert problem(one.http.post(f"{path}/removal", json=wrong), 422, "invalid")["errors"][0]["field"] == field
    assert one.http.post(f"{path}/removal", json={"password": PASSWORD, "code": fresh[0]}).status_code == 204
    told(api, one, "Two-factor authentication is now off")
    assert sign_in(api, one).status_code == 200
    problem(one.http.post(f"{path}/removal", json={"password": PASSWORD, "code": fresh[0]}), 409, "conflict")
    assert actions(api, one) == ["account.second-factor-added", "account.recovery-code-used", "account.recovery-codes-renewed",
                                 "account.recovery-code-used", "account.second-factor-removed"]


def test_a_code_works_once_even_in_concurrent_requests(api):  # noqa: F811
    one = person(api)
    one.sets_up_second_factor()
    problem(sign_in(api, one, one.device.at(one.device.given)), 401, "wrong-code")
    told(api, one, "was used twice")
    assert actions(api, one)[-1] == "account.code-reused"
    code = one.device.code()
    forget_attempts(api)
    with ThreadPoolExecutor(4) as pool:
        answers = [done.result().status_code for done in [pool.submit(sign_in, api, one, code) for _ in range(4)]]
    assert sorted(answers) == [200, 401, 401, 401]
    # The previous code, too, even while its step has not passed.
    problem(sign_in(api, one, one.device.at(one.device.given - 1)), 401, "wrong-code")


def test_a_small_clock_difference_is_accepted(api):  # noqa: F811
    """For the exact tolerance: Totp.ToleratesClockSkewOfOneStep."""
    one = person(api)
    one.sets_up_second_factor()
    for apart, status in ((5, 401), (-5, 401), (0, 200), (1, 200)):
        api.psql("UPDATE second_factors SET last_step = 0 WHERE user_id = %s", one.id)
        assert sign_in(api, one, one.device.at(step_now() + apart)).status_code == status, apart


def test_guesses_of_codes_are_limited(api):  # noqa: F811
    one = person(api)
    codes = one.sets_up_second_factor()
    forget_attempts(api)
    for i in range(5):
        problem(sign_in(api, one, f"00000{i}"), 401, "wrong-code")
    waits = problem(sign_in(api, one, one.device.code()), 429, "too-many-attempts")
    assert "Try again in" in waits["detail"]
    problem(sign_in(api, one, codes[0]), 429, "too-many-attempts")
    removal = one.http.post("/v1/me/second-factor/removal", json={"password": PASSWORD, "code": codes[0]})
    problem(removal, 429, "too-many-attempts")
    api.psql("UPDATE attempts SET happened_at = happened_at - interval '16 minutes'")
    assert sign_in(api, one, codes[0]).status_code == 200
    for _ in range(4):
        for i in range(5):
            problem(sign_in(api, one, f"00000{i}"), 401, "wrong-code")
        api.psql("UPDATE attempts SET happened_at = happened_at - interval '16 minutes'")
    problem(sign_in(api, one, codes[1]), 429, "too-many-attempts")
    forget_attempts(api)


def test_a_recovery_code_works_once_and_its_use_is_mailed(api):  # noqa: F811
    one = person(api)
    codes = one.sets_up_second_factor()
    typed = codes[0].upper().replace("-", " ").replace("O", "0").replace("L", "1").replace("B", "8")
    assert sign_in(api, one, f" {typed} ").status_code == 200
    problem(sign_in(api, one, codes[0]), 401, "wrong-code")
    assert one.http.get("/v1/me/second-factor").json()["recovery_codes"] == 9
    told(api, one, "recovery code of your Diaphane account was used")


def test_stored_data_cannot_produce_a_code(api):  # noqa: F811
    one = person(api)
    codes = one.sets_up_second_factor()
    [[sealed]] = api.psql("SELECT sealed_secret FROM second_factors WHERE user_id = %s", one.id)
    secret = one.device.totp.secret
    everything = str(api.psql("SELECT * FROM second_factors")) + str(api.psql("SELECT * FROM recovery_codes")) + api.log("api")
    for hidden in (secret, one.device.totp.byte_secret().hex(), *codes, *(code.replace("-", "") for code in codes)):
        assert hidden.lower() not in everything.lower()
    # Another user's sealed secret does not help an attacker who can write to the database.
    other = person(api)
    other.sets_up_second_factor()
    api.psql("UPDATE second_factors SET sealed_secret = %s, last_step = 0 WHERE user_id = %s", sealed, other.id)
    problem(sign_in(api, other, one.device.at(step_now())), 500, "internal")
    key = api.data_dir / "secrets" / "factor-key"
    assert key.stat().st_mode & 0o777 == 0o600 and len(key.read_text(encoding="ascii").strip()) == 64


def test_an_unfinished_set_up_expires_after_an_hour(api):  # noqa: F811
    one = person(api)
    device = Device(one.http.post("/v1/me/second-factor", json={"password": PASSWORD}).json()["secret"])
    api.psql("UPDATE second_factors SET begun_at = begun_at - interval '61 minutes' WHERE user_id = %s", one.id)
    problem(one.http.post("/v1/me/second-factor/confirm", json={"code": device.code()}), 409, "conflict")


def test_a_password_reset_does_not_bypass_the_second_factor(api):  # noqa: F811
    one, new = person(api), "another long and quiet one"
    one.sets_up_second_factor()
    one.http.post("/v1/password-reset", json={"email": one.email})
    token = link_token(api, one.email, "reset")
    assert client(api).post("/v1/password-reset/confirm", json={"token": token, "password": new}).status_code == 204
    problem(sign_in(api, one, password=new), 401, "code-needed")


def test_only_the_command_line_resets_a_lost_second_factor(api):  # noqa: F811
    one = person(api)
    assert command(api, "reset-2fa", one.email).returncode == 1, "there is none"
    one.sets_up_second_factor()
    done = command(api, "reset-2fa", one.email.upper())
    assert done.returncode == 0 and "password alone" in done.stdout
    assert sign_in(api, one).status_code == 200
    assert one.http.get("/v1/me/second-factor").json()["recovery_codes"] == 0
    [entry] = api.psql("SELECT actor FROM audit_log WHERE subject_id = %s AND action = 'account.second-factor-removed'", one.id)
    assert entry[0] == "machine"
    told(api, one, "Two-factor authentication is now off")


def test_an_administrator_must_set_up_a_second_factor_first(api):  # noqa: F811
    one = person(api)
    done = command(api, "grant", one.email)
    assert "once this user turns on two-factor authentication" in done.stdout
    assert f"{one.email} (two-factor authentication not set up)" in command(api, "list").stdout
    me = one.http.get("/v1/me").json()
    assert me["administrator"] is True and me["second_factor"] is False
    assert one.http.get("/v1/me/second-factor").json()["required"] is True
    problem(one.http.get("/v1/admin/users"), 403, "second-factor-required")
    codes = one.sets_up_second_factor()
    assert one.http.get("/v1/admin/users").status_code == 200
    assert f"{one.email}\n" in command(api, "list").stdout
    assert "two-factor" not in command(api, "grant", one.email).stdout
    one.http.post("/v1/me/second-factor/removal", json={"password": PASSWORD, "code": codes[0]})
    problem(one.http.get("/v1/admin/users"), 403, "second-factor-required")


#: Operations that an administrator may perform and an unrelated user may not.
OF_THE_ROLE = sorted(name for name, row in ROWS.items() if row["administrator"] == "+" and row["other"] != "+")


@pytest.mark.parametrize("name", OF_THE_ROLE)
def test_administrators_without_a_second_factor_have_no_special_rights(api, name):  # noqa: F811
    forget_attempts(api)
    world = World(api)
    operation, _, exposure = name.partition(":")
    request = question(world, "administrator", *OPERATIONS[operation], exposure)
    boss = world.someone("administrator")
    api.psql("DELETE FROM second_factors WHERE user_id = %s", boss.known_id)
    answer = boss.http.send(request)
    assert answer.status_code == int(ROWS[name]["other"]), answer.text
    # Operations for administrators alone explain the refusal. Owners may perform the others, but samples have no owner.
    if ROWS[name]["other"] == ROWS[operation]["owner"] == "403":
        problem(answer, 403, "second-factor-required")
