"""All data about a person as one file, and the deletion of an account, which leaves nothing behind anywhere."""

from __future__ import annotations

import io
import json
import subprocess
import uuid
import zipfile
from pathlib import Path

from api_client import PASSWORD, Person, add_worker, api, forget_attempts, link_token, make_ready, person, problem, remove_worker  # noqa: F401
from harness import contents_below
from redis import Redis
from access_matrix_fixture import RECORDING, SCENE, put_picture

VOXELS = bytes(range(256)) * 40


def store_volume(stack, data_set: str) -> None:
    folder = stack.data_dir / "volumes" / data_set
    folder.mkdir(parents=True)
    (folder / "volume.json").write_text('{"format": 1}')
    (folder / "voxels.i16").write_bytes(VOXELS)
    thumbnails = stack.data_dir / "cache" / "thumbnails" / data_set
    thumbnails.mkdir(parents=True)
    (thumbnails / "bone.jpg").write_bytes(b"\xff\xd8\xff")
    for path in (folder, *folder.iterdir(), thumbnails.parent, thumbnails, *thumbnails.iterdir()):
        stack.stack.run_as.own(path)
    make_ready(stack, data_set)


def with_everything(stack) -> tuple[Person, str, str]:
    """A user who has used everything, with a ready scan, and one that is being uploaded."""
    one = person(stack)
    one.sets_up_second_factor()
    ready = one.upload(b"x" * 100, title=f"Title of {one.email}")["id"]
    store_volume(stack, ready)
    unfinished = one.data_set(1000, title="Half of it")
    one.patch(unfinished["upload_url"], 0, b"y" * 500)
    one.announce(10, **{"Idempotency-Key": "k"})
    one.http.post("/v1/recording-consent")
    one.http.post("/v1/recordings", json=RECORDING)
    preset = one.http.post(f"/v1/data-sets/{ready}/presets", json={"name": f"Look of {one.email}", "scene": SCENE}).json()["id"]
    put_picture(stack, preset, b"\xff\xd8 picture of " + preset.encode())
    add_worker(stack, "privacy")
    one.http.post("/v1/sessions", json={"data_set_id": ready})
    stack.redis.hincrby("diaphane:render_time", one.id, 1234)
    stack.wait_until(lambda: one.http.get("/v1/me").json()["render_time"]["used_ms"] == 1234, what="render time")
    return one, ready, unfinished["data_set"]["id"]


def exported(stack, one: Person) -> zipfile.ZipFile:
    assert one.http.post("/v1/me/export").status_code == 202
    stack.wait_until(lambda: one.http.get("/v1/me/export").json()["state"] == "ready", what="the export")
    answer = one.http.get("/v1/me/export/file")
    assert answer.status_code == 200 and answer.headers["content-type"] == "application/zip"
    assert "attachment" in answer.headers["content-disposition"] and answer.headers["cache-control"] == "no-store"
    assert len(answer.content) == one.http.get("/v1/me/export").json()["bytes"]
    return zipfile.ZipFile(io.BytesIO(answer.content))


def test_an_export_has_all_data_of_its_account_and_none_of_others(api):  # noqa: F811
    other, other_ready, _ = with_everything(api)
    one, ready, unfinished = with_everything(api)
    file = exported(api, one)
    assert file.testzip() is None
    names = set(file.namelist())
    assert file.read(f"scans/{ready}/voxels.i16") == VOXELS and f"scans/{ready}/volume.json" in names
    [(preset,)] = api.psql("SELECT id::text FROM presets WHERE data_set_id = %s", ready)
    assert file.read(f"scans/{ready}/presets/{preset}.jpg") == b"\xff\xd8 picture of " + preset.encode()
    records = {name: json.loads(file.read(name)) for name in names if name.endswith(".json") and name.startswith("records/")}
    [account] = records["records/users.id.json"]
    assert account["consent_version"] and account["consent_at"]
    assert account["email"] == one.email and "password_hash" not in account
    assert {d["id"] for d in records["records/data_sets.owner_id.json"]} >= {ready, unfinished}
    assert [r["events"] for r in records["records/recordings.user_id.json"]] == [1]
    assert records["records/render_time.user_id.json"][0]["device_ms"] == 1234
    [factor] = records["records/second_factors.user_id.json"]
    assert factor["confirmed_at"] and len(records["records/recovery_codes.user_id.json"]) == 10
    assert "account.export-asked" in {entry["action"] for entry in json.loads(file.read("audit.json"))}
    assert b"voxels.i16" in file.read("README.txt")
    whole = b"".join(file.read(name) for name in names)
    for secret in (other.email, other.id, other_ready, one.http.cookies["diaphane"], one.csrf, "$argon2id$", one.device.totp.secret,
                   *api.psql("SELECT sealed_secret FROM second_factors")[0], *api.psql("SELECT code_hash FROM recovery_codes")[0]):
        assert secret.encode() not in whole
    # Every table with rows of users is in it, including future tables.
    tables = {t for (t,) in api.psql("""SELECT DISTINCT conrelid::regclass::text FROM pg_constraint
                                        WHERE contype = 'f' AND confrelid = 'users'::regclass""")}
    assert {name.split("/")[1].split(".")[0] for name in records} >= tables
    remove_worker(api, "privacy")


def test_an_export_is_private_and_expires_after_a_day(api):  # noqa: F811
    one, other = person(api), person(api)
    problem(one.http.get("/v1/me/export"), 404, "not-found")
    problem(one.http.get("/v1/me/export/file"), 404, "not-found")
    exported(api, one)
    problem(other.http.get("/v1/me/export/file"), 404, "not-found")
    problem(one.http.post("/v1/me/export"), 429, "too-many")
    [(name,)] = api.psql("SELECT id::text FROM exports WHERE user_id = %s", one.id)
    path = api.data_dir / "cache" / "exports" / f"{name}.zip"
    assert path.exists()
    assert one.http.get(f"/_cache/exports/{name}.zip").status_code == 404, "nobody gets at it but by the route"
    assert one.http.delete("/v1/me/export").status_code == 204
    api.wait_until(lambda: not path.exists(), what="the file's end")
    problem(one.http.delete("/v1/me/export"), 404, "not-found")
    exported(api, one)
    api.psql("UPDATE exports SET expires_at = now() - interval '1 second' WHERE user_id = %s", one.id)
    problem(one.http.get("/v1/me/export/file"), 404, "not-found")


def everything_on_disk(folder: Path) -> dict[str, bytes]:
    """Except sent mails, the databases' own files (which are dumped), and request logs."""
    left_out = {"postgres", "redis", "mail", "logs", "secrets"}
    return {str(path.relative_to(folder)): content for path, content in contents_below(folder)
            if path.relative_to(folder).parts[0] not in left_out}


def dump(stack) -> bytes:
    return subprocess.run(["pg_dump", "--inserts", stack.dsn], check=True, capture_output=True).stdout


def redis_dump(stack, lasting: bool = False) -> bytes:
    """Returns everything. `lasting`: without tickets and ended-session notices for workers, which expire within a minute."""
    found = b""
    raw = Redis(unix_socket_path=str(stack.stack.settings.socket("redis")))  # scenes are not text
    for key in stack.redis.scan_iter("*"):
        passing = key.startswith("diaphane:ticket:") or key.endswith(":ended")
        if lasting and passing and -1 != stack.redis.ttl(key) <= 60:    # 0 in the last half second, -2 once it has expired
            continue
        kind = stack.redis.type(key)
        if kind == "none":
            continue  # expired since
        found += key.encode() + b"\n"
        read = {"hash": raw.hgetall, "set": raw.smembers, "string": raw.get, "zset": lambda k: raw.zrange(k, 0, -1)}[kind]
        found += str(read(key)).encode() + b"\n"
    return found


def test_a_deleted_account_leaves_nothing_behind(api):  # noqa: F811
    bystander, bystander_ready, _ = with_everything(api)
    one, ready, unfinished = with_everything(api)
    me = one.id
    exported(api, one)
    one.http.post("/v1/me/password", json={"current": PASSWORD, "password": PASSWORD + " 2"})  # an entry in the audit log
    session = one.http.get("/v1/sessions").json()["items"]
    if not session:
        session = [one.http.post("/v1/sessions", json={"data_set_id": ready}).json()]
    watching = bystander.http.get("/v1/sessions").json()["items"]
    [(export,)] = api.psql("SELECT id::text FROM exports WHERE user_id = %s", me)
    [(preset,)] = api.psql("SELECT id::text FROM presets WHERE author_id = %s", me)
    # What the user wrote about another user's scan. What remains does not identify its author.
    api.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", bystander_ready)
    bystander.http.post(f"/v1/data-sets/{bystander_ready}/visibility", json={"visibility": "public"})
    words = f"I am their neighbour {uuid.uuid4().hex}"
    told = one.http.post(f"/v1/data-sets/{bystander_ready}/reports", json={"reason": "not_theirs", "words": words})
    assert told.status_code == 204
    traces = [me, one.email, ready, unfinished, export, session[0]["session_id"], preset, words]
    assert all(any(t.encode() in text for text in (dump(api), redis_dump(api), str(everything_on_disk(api.data_dir)).encode()))
               for t in traces), "the search finds each of them while it is there"

    forget_attempts(api)
    document = problem(one.http.post("/v1/me/deletion", json={"password": "not this one"}), 422, "invalid")
    assert document["errors"][0]["field"] == "password" and one.http.get("/v1/me").status_code == 200
    answer = one.http.post("/v1/me/deletion", json={"password": PASSWORD + " 2", "code": one.device.code()})
    assert answer.status_code == 204 and "Max-Age=0" in answer.headers["set-cookie"]
    problem(one.http.get("/v1/me"), 401, "unauthenticated")
    assert api.redis.exists(f"diaphane:session:{session[0]['session_id']}") == 0
    # Only theirs, because other tests may have left some that wait.
    of_theirs = "SELECT count(*) FROM disposals WHERE id::text = ANY(%s)"
    api.wait_until(lambda: api.psql(of_theirs, [ready, unfinished, export, preset]) == [(0,)], what="the disposal")
    api.wait_until(lambda: api.psql("SELECT count(*) FROM mail_queue WHERE recipient = %s", one.email) == [(0,)], what="the last mail")
    assert "was deleted" in api.mails(one.email)[-1]["Subject"]

    places = {"database": dump(api), "redis": redis_dump(api, lasting=True)}
    for name, data in everything_on_disk(api.data_dir).items():
        places[name] = name.encode() + b"\n" + data
    for trace in traces:
        for form in (trace, trace.replace("-", ""), trace.upper()):
            for coding in ("utf-8", "utf-16-le"):
                assert [place for place, text in places.items() if form.encode(coding) in text] == []
    assert api.psql("SELECT reason, words, reporter_id FROM reports WHERE data_set_id = %s", bystander_ready) == [("not_theirs", "", None)]
    log = api.log("api") + api.log("edge")
    assert one.email not in log and me not in log
    # Nobody else has lost anything, and the address is free again.
    assert bystander.http.get(f"/v1/data-sets/{bystander_ready}").status_code == 200
    assert bystander.http.get("/v1/sessions").json()["items"] == watching
    assert (api.data_dir / "volumes" / bystander_ready / "voxels.i16").read_bytes() == VOXELS
    # The log still contains that an account was deleted, and that its password was changed before, but not whose.
    rows = api.psql("SELECT action, actor_id, subject_id FROM audit_log ORDER BY id DESC LIMIT 9")
    assert rows[0] == ("account.deleted", None, None) and ("account.password-changed", None, None) in rows
    before = len(api.mails(one.email))
    forget_attempts(api)
    fresh = Person(api, one.email)
    assert fresh.http.post("/v1/accounts", json={"email": one.email, "consent": True}).status_code == 202
    api.wait_until(lambda: len(api.mails(one.email)) > before, what="the mail")
    chosen = {"token": link_token(api, one.email), "password": PASSWORD}
    assert fresh.http.post("/v1/accounts/verify", json=chosen).status_code == 200
    listed = fresh.sign_in().http.get("/v1/data-sets").json()["items"]
    assert [item for item in listed if not item["is_sample"]] == []     # other tests load samples
    remove_worker(api, "privacy")


def test_an_account_with_a_second_factor_is_deleted_only_with_a_code(api):  # noqa: F811
    one = person(api)
    one.sets_up_second_factor()
    forget_attempts(api)
    problem(one.http.post("/v1/me/deletion", json={"password": PASSWORD}), 401, "code-needed")
    problem(one.http.post("/v1/me/deletion", json={"password": PASSWORD, "code": "000000"}), 401, "wrong-code")
    assert one.http.get("/v1/me").status_code == 200
    assert one.http.post("/v1/me/deletion", json={"password": PASSWORD, "code": one.device.code()}).status_code == 204


def test_password_guesses_to_delete_an_account_are_limited(api):  # noqa: F811
    one = person(api)
    forget_attempts(api)
    for _ in range(10):
        problem(one.http.post("/v1/me/deletion", json={"password": uuid.uuid4().hex}), 422, "invalid")
    problem(one.http.post("/v1/me/deletion", json={"password": PASSWORD}), 429, "too-many-attempts")
