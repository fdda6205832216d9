"""Studies: what researchers do with them, and what participants without an account do in them."""

from __future__ import annotations

import csv
import io
import json
import secrets
import zipfile
from concurrent.futures import ThreadPoolExecutor

import psycopg
import pytest
from api_client import add_worker, api, client, forget_attempts, other, person, problem, remove_worker  # noqa: F401
from study_helpers import (ANSWERS, BOTH, CAMERA, SCENE, Participant, create, definition, every_kind, export, in_days, joined, opened, picture,
                           rating, researcher, scan_of, set_state, step, view)


@pytest.fixture(scope="module")
def lab(api):  # noqa: F811
    """A researcher."""
    return researcher(api)


@pytest.fixture(scope="module")
def scan(api, lab) -> str:  # noqa: F811
    return scan_of(api, lab)


@pytest.fixture(autouse=True)
def attempts(api):  # noqa: F811
    forget_attempts(api)


@pytest.fixture
def worker(api):  # noqa: F811
    add_worker(api, "studies-test", slots=64)
    yield
    remove_worker(api, "studies-test")


def test_only_researchers_have_studies_and_an_administrator_gives_the_role(api, other):  # noqa: F811
    problem(other.http.get("/v1/studies"), 403, "forbidden")
    assert other.http.get("/v1/me").json()["researcher"] is False
    boss = person(api).becomes_administrator()
    problem(boss.http.get("/v1/studies"), 403, "forbidden")
    granted = boss.http.patch(f"/v1/admin/users/{other.id}", json={"researcher": True})
    assert granted.status_code == 200 and granted.json()["researcher"] is True
    assert other.http.get("/v1/me").json()["researcher"] is True
    study, token = opened(other, definition())
    one = joined(api, token)
    assert boss.http.patch(f"/v1/admin/users/{other.id}", json={"researcher": False}).json()["researcher"] is False
    problem(other.http.get(f"/v1/studies/{study}/export"), 403, "forbidden")
    problem(one.answer("rating", {"rating": 1}), 410, "study-closed")
    boss.http.patch(f"/v1/admin/users/{other.id}", json={"researcher": True})
    assert other.http.get(f"/v1/studies/{study}").json()["state"] == "closed", "the study was closed with the role"
    assert {entry["action"] for entry in boss.http.get("/v1/admin/audit", params={"account": other.id}).json()["items"]} >= {
        "researcher.granted", "researcher.revoked", "study.opened"}
    boss.is_no_administrator()


def test_a_study_is_listed_read_and_deleted_by_its_researcher_only(api, lab):  # noqa: F811
    study = create(lab, definition())
    stranger = researcher(api)
    path = f"/v1/studies/{study}"
    for answer in (stranger.http.get(path), stranger.http.delete(path), set_state(stranger, study, "open"), stranger.http.post(f"{path}/link"),
                   stranger.http.get(f"{path}/export"), stranger.http.get(f"{path}/analysis"),
                   stranger.http.post(f"{path}/preview", json={"key": "0" * 64}),
                   stranger.http.put(path, json={"definition": definition()}, headers={"If-Match": '"1"'})):
        problem(answer, 404, "not-found")
    assert stranger.http.get("/v1/studies").json()["items"] == []
    assert study in [item["id"] for item in lab.http.get("/v1/studies").json()["items"]]
    assert lab.http.get(path).json()["title"] == BOTH
    assert lab.http.delete(path).status_code == 204
    problem(lab.http.get(path), 404, "not-found")


def test_lists_are_paginated_newest_first(api):  # noqa: F811
    who = researcher(api)
    made = [create(who, definition()) for _ in range(3)]
    first = who.http.get("/v1/studies", params={"limit": 2}).json()
    rest = who.http.get("/v1/studies", params={"limit": 2, "cursor": first["next_cursor"]}).json()
    assert [item["id"] for item in first["items"] + rest["items"]] == made[::-1] and rest["next_cursor"] is None


def test_a_repeated_creation_with_the_same_key_creates_one_study(lab):
    headers, body = {"Idempotency-Key": secrets.token_hex(8)}, {"definition": definition()}
    made = [lab.http.post("/v1/studies", json=body, headers=headers).json()["id"] for _ in range(2)]
    assert made[0] == made[1]
    problem(lab.http.post("/v1/studies", json={"definition": definition(places=3)}, headers=headers), 422, "idempotency-key-reused")


def test_a_researcher_has_at_most_a_hundred_studies(api):  # noqa: F811
    who = researcher(api)
    study = create(who, definition())
    api.psql("""INSERT INTO studies (id, owner_id, definition, title, places, ends_at, state, created_at)
                SELECT gen_random_uuid(), owner_id, definition, title, places, ends_at, state, created_at
                  FROM studies, generate_series(1, 99) WHERE id = %s""", study)
    problem(who.http.post("/v1/studies", json={"definition": definition()}), 429, "too-many")


WRONG = {
    "no consent": lambda scan: definition(steps=[rating()]),
    "two consents": lambda scan: definition(step("consent")),
    "no steps": lambda scan: definition(steps=[]),
    "101 steps": lambda scan: definition(*({**rating(), "id": f"s-{i}"} for i in range(100))),
    "same id": lambda scan: definition(rating(), rating()),
    "id with capitals": lambda scan: definition({**rating(), "id": "A"}),
    "unknown kind": lambda scan: definition(step("guess")),
    "unknown field": lambda scan: definition(step("text", note="a")),
    "missing field": lambda scan: definition(step("rating")),
    "empty text": lambda scan: definition(step("text", text={"en": ""})),
    "no language": lambda scan: definition(step("text", text={})),
    "other language": lambda scan: definition(step("text", text={"fr": "a"})),
    "long text": lambda scan: definition(step("text", text={"en": "a" * 2001})),
    "long title": lambda scan: definition(title={"en": "a" * 121}),
    "no places": lambda scan: definition(places=0),
    "many places": lambda scan: definition(places=1001),
    "end in two years": lambda scan: definition(ends_at=in_days(730)),
    "no end": lambda scan: definition(ends_at="soon"),
    "scale upside down": lambda scan: definition({**rating(), "low": 5, "high": 5}),
    "one picture": lambda scan: definition(step("order", pictures=[{"id": "a", "comfort": 0}])),
    "comfort of 3": lambda scan: definition(step("order", pictures=[{"id": "a", "comfort": 0}, {"id": "b", "comfort": 3}])),
    "one option": lambda scan: definition(step("choice", options=[{"id": "a", "text": BOTH}], multiple=True)),
    "delay of 401": lambda scan: definition(step("latency", view=view(scan), delays_ms=[401])),
    "latency from the preset": lambda scan: definition(step("latency", view=view(scan, start="preset"), delays_ms=[1])),
    "broken scene": lambda scan: definition(step("viewpoint", view=view(scan, scene={"camera": 1}))),
    "no scan": lambda scan: definition(step("viewpoint", view=view("none"))),
    "radius of 0": lambda scan: definition(step("viewpoint", view=view(scan, region={"name": BOTH, "centre": [0, 0, 0], "radius": 0}))),
    "changes of all": lambda scan: definition(step("viewpoint", view=view(scan, may_change=["all"]))),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_definition_is_refused_with_the_field(lab, scan, what):
    found = problem(lab.http.post("/v1/studies", json={"definition": WRONG[what](scan)}), 422, "invalid")
    assert all(error["field"].startswith("definition") for error in found["errors"])


def test_a_definition_changes_until_somebody_joins(api, lab):  # noqa: F811
    study = create(lab, definition())
    path = f"/v1/studies/{study}"
    etag = lab.http.get(path).headers["etag"]
    problem(lab.http.put(path, json={"definition": definition()}), 428, "precondition-required")
    changed = lab.http.put(path, json={"definition": definition(places=3)}, headers={"If-Match": etag})
    assert changed.status_code == 200 and changed.json()["places"] == 3 and changed.json()["etag"] != etag
    problem(lab.http.put(path, json={"definition": definition()}, headers={"If-Match": etag}), 412, "precondition")
    set_state(lab, study, "open")
    token = lab.http.post(f"{path}/link").json()["path"].removeprefix("/study#")
    one = joined(api, token)
    problem(lab.http.put(path, json={"definition": definition()}, headers={"If-Match": changed.headers["etag"]}), 409, "conflict")
    one.post("withdrawal")
    problem(lab.http.put(path, json={"definition": definition()}, headers={"If-Match": changed.headers["etag"]}), 409, "conflict")


def test_opening_needs_the_pictures_and_scans_that_may_be_used(api, lab, scan, other):  # noqa: F811
    two = [{"id": "a", "comfort": 0}, {"id": "b", "comfort": 1}]
    study = create(lab, definition(step("order", pictures=two)))
    assert "picture" in problem(set_state(lab, study, "open"), 409, "conflict")["detail"]
    foreign = scan_of(api, other)
    for scan_of_other in (foreign, "00000000-0000-4000-8000-000000000000"):
        study = create(lab, definition(step("viewpoint", view=view(scan_of_other))))
        problem(set_state(lab, study, "open"), 409, "conflict")
    other.http.post(f"/v1/data-sets/{foreign}/people", json={"email": lab.email, "may": "view"})
    problem(set_state(lab, create(lab, definition(step("viewpoint", view=view(foreign)))), "open"), 409, "conflict")
    api.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", foreign)
    other.http.post(f"/v1/data-sets/{foreign}/visibility", json={"visibility": "public"})
    assert set_state(lab, create(lab, definition(step("viewpoint", view=view(foreign)))), "open").status_code == 200
    study = create(lab, definition(ends_at=in_days(-1)))
    problem(set_state(lab, study, "open"), 409, "conflict")


def test_pictures_lose_their_metadata_and_must_decode(lab):
    two = [{"id": "a", "comfort": 0}, {"id": "b", "comfort": 1}]
    study = create(lab, definition(step("order", pictures=two)))
    path = f"/v1/studies/{study}/pictures"
    from PIL import Image, PngImagePlugin
    exif = Image.Exif()
    exif[0x010E] = "GPS of the patient"
    noted = PngImagePlugin.PngInfo()
    noted.add_text("Comment", "GPS of the patient")
    for kind, file in (("image/jpeg", picture("JPEG", exif=exif, comment=b"GPS of the patient")), ("image/png", picture("PNG", pnginfo=noted)),
                       ("image/jpeg", picture("JPEG", progressive=True))):
        assert lab.http.put(f"{path}/a", content=file, headers={"Content-Type": kind}).status_code == 204
        got = lab.http.get(f"{path}/a")
        assert got.headers["content-type"] == kind and b"patient" not in got.content
        assert Image.open(io.BytesIO(got.content)).convert("RGB").tobytes() == Image.open(io.BytesIO(file)).convert("RGB").tobytes()
    png, jpeg = picture(), picture("JPEG")
    for wrong in (b"", b"GIF89a", png[:-20], jpeg[:-30], jpeg[:40], png[:60] + b"\0" * 8 + png[68:], png[:8] + b"\xff" * 40):
        problem(lab.http.put(f"{path}/a", content=wrong, headers={"Content-Type": "image/png"}), 422, "invalid")
    problem(lab.http.put(f"{path}/c", content=png, headers={"Content-Type": "image/png"}), 404, "not-found")
    problem(lab.http.get(f"{path}/b"), 404, "not-found")


def test_a_participant_answers_every_kind_and_the_exports_hold_it(api, lab, scan):  # noqa: F811
    study, token = opened(lab, every_kind(scan))
    invited = client(api).post("/v1/study/invitation", json={"token": token}).json()
    assert invited["open"] and invited["places_left"] == 10 and invited["steps"] == 9 and invited["languages"] == ["en", "de"]
    one = Participant(api, token)
    first = one.join(record=True, language="de")
    assert first.status_code == 201 and "set-cookie" not in first.headers
    assert "secret preset" not in first.text and "comfort" not in first.text, "a note for the researcher"
    for name, value in ANSWERS.items():
        assert one.answer(name, value).status_code == 204, name
    again = one.join().json()
    assert again["seed"] == first.json()["seed"] and set(again["answered"]) == set(ANSWERS)
    assert first.json()["sequence"] == 0 and again["sequence"] == one.sequence
    assert one.post("pictures", picture="a").content == picture()
    assert one.post("finish").status_code == 204
    exported = export(lab, study)
    [participant] = exported["participants"]
    assert exported["format"] == "diaphane-study" and participant["state"] == "finished" and participant["language"] == "de"
    assert {answer["step"]: answer["value"] for answer in participant["answers"]} == ANSWERS
    assert exported["study"]["definition"]["steps"][5]["pictures"][0]["comfort"] == -2
    assert lab.http.get(f"/v1/studies/{study}").json()["finished"] == 1
    answer = lab.http.get(f"/v1/studies/{study}/export", params={"format": "csv"})
    assert answer.headers["content-type"] == "application/zip" and "no-store" in answer.headers["cache-control"]
    packed = zipfile.ZipFile(io.BytesIO(answer.content))
    assert sorted(packed.namelist()) == ["answers.csv", "data_dictionary.csv", "definition.json"]
    rows = list(csv.DictReader(io.StringIO(packed.read("answers.csv").decode("utf-8-sig"), newline="")))
    values = {row["field"]: row["value"] for row in rows}
    assert packed.read("answers.csv").startswith(b"\xef\xbb\xbf"), "Excel reads UTF-8 only after a byte order mark"
    assert values["rating"] == "7" and values["trials.1.delay_ms"] == "0" and values["words"] == "'" + ANSWERS["words"]["words"]
    assert list(csv.DictReader(io.StringIO(packed.read("data_dictionary.csv").decode("utf-8-sig"))))


WRONG_ANSWERS = [
    ("rating", {"rating": 11}), ("rating", {"rating": -1}), ("rating", {"rating": 1.5}), ("rating", {"rating": True}), ("rating", {}),
    ("rating", {"rating": 1, "more": 1}), ("rating", []), ("rating", None), ("rating", {"rating": 2**64 - 1}), ("text", {"a": 1}),
    ("words", {"words": "a" * 2001}), ("words", {"words": 1}), ("colours", {"colours": []}),
    ("colours", {"colours": [{"channel": "skin", "from": "#ffffff", "to": "#ffffff"}]}),
    ("colours", {"colours": [{"channel": "bone", "from": "white", "to": "#ffffff"}]}), ("order", {"order": ["a"], "shown": ["a", "b"]}),
    ("order", {"order": ["a", "a"], "shown": ["a", "b"]}), ("order", {"order": ["a", "c"], "shown": ["a", "b"]}),
    ("viewpoint", {"camera": CAMERA}), ("viewpoint", {"camera": {**CAMERA, "eye": [0, 0, 0]}, "start": CAMERA}),
    ("viewpoint", {"camera": {**CAMERA, "up": [0, 1, 0]}, "start": CAMERA}), ("viewpoint", {"camera": {**CAMERA, "eye": [0, 1]}, "start": CAMERA}),
    ("choice", {"choice": ["yes", "no"]}), ("choice", {"choice": ["maybe"]}), ("choice", {"choice": []}),
    ("latency", {"trials": ANSWERS["latency"]["trials"][:1]}), ("latency", {"trials": ANSWERS["latency"]["trials"][:1] * 2}),
    ("consent", {}), ("nothing", {}),
]


def test_answers_that_do_not_fit_their_step_are_refused(api, lab, scan):  # noqa: F811
    study, token = opened(lab, every_kind(scan))
    one = joined(api, token)
    for name, value in WRONG_ANSWERS:
        answer = one.answer(name, value)
        assert answer.status_code == 422, (name, value, answer.text)
    problem(one.post("answers", step="rating", value={"rating": 1}, duration_ms=-1, sequence=1), 422, "invalid")
    problem(one.post("answers", step="words", value={"words": "a"}, duration_ms=1, sequence=1, more="a" * 20_000), 413, "body-too-large")
    assert export(lab, study)["participants"][0]["answers"] == []


def test_the_answer_with_the_highest_sequence_stays(api, lab):  # noqa: F811
    study, token = opened(lab, definition())
    one = joined(api, token)
    for value, sequence in ((1, 5), (2, 7), (3, 6), (4, 7)):
        assert one.answer("rating", {"rating": value}, sequence).status_code == 204
    [answer] = export(lab, study)["participants"][0]["answers"]
    assert answer["value"] == {"rating": 2}, "sequence 7 as it came first"


def test_places_bound_a_study_and_a_closed_one_takes_nobody(api, lab):  # noqa: F811
    study, token = opened(lab, definition(places=2))
    first, second = joined(api, token), joined(api, token)
    problem(Participant(api, token).join(), 410, "study-full")
    assert first.join().status_code == 201, "who has joined stays"
    second.post("withdrawal")
    joined(api, token)
    set_state(lab, study, "closed")
    problem(first.answer("rating", {"rating": 1}), 410, "study-closed")
    problem(first.post("finish"), 410, "study-closed")
    problem(Participant(api, token).join(), 410, "study-closed")
    assert client(api).post("/v1/study/invitation", json={"token": token}).json()["open"] is False
    set_state(lab, study, "open")
    api.psql("UPDATE studies SET ends_at = now() WHERE id = %s", study)
    problem(first.answer("rating", {"rating": 1}), 410, "study-closed")
    assert lab.http.get(f"/v1/studies/{study}").json()["state"] == "closed"
    api.wait_until(lambda: api.psql("SELECT 1 FROM studies WHERE id = %s AND state = 'closed'", study), what="the study to close")


def at_once(api, people, act):  # noqa: F811
    """Returns the status codes of simultaneous requests."""
    with ThreadPoolExecutor(len(people)) as pool:
        return [answer.status_code for answer in pool.map(act, people)]


def test_concurrent_joins_do_not_exceed_the_places(api, lab):  # noqa: F811
    _, token = opened(lab, definition(places=1))
    assert sorted(at_once(api, [Participant(api, token) for _ in range(30)], lambda one: one.join())) == [201] + [410] * 29


def test_a_change_that_waits_for_a_join_keeps_the_participant(api, lab):  # noqa: F811
    study, token = opened(lab, definition())
    etag = lab.http.get(f"/v1/studies/{study}").headers["etag"]
    change = {"json": {"definition": definition()}, "headers": {"If-Match": etag}}
    with psycopg.connect(api.dsn) as held, ThreadPoolExecutor(2) as pool:
        held.execute("SELECT 1 FROM studies WHERE id = %s FOR UPDATE", (study,))
        held.execute("INSERT INTO study_participants (id, study_id, number, key_hash, language, seed, day, recorded) VALUES "
                     "(gen_random_uuid(), %s, 1, 'a', 'en', 1, now(), false)", (study,))
        answer = pool.submit(lambda: lab.http.put(f"/v1/studies/{study}", **change))
        api.wait_until(lambda: api.psql("SELECT 1 FROM pg_stat_activity WHERE wait_event_type = 'Lock'"), what="the change to wait")
        held.commit()
        problem(answer.result(), 409, "conflict")
    assert lab.http.get(f"/v1/studies/{study}").json()["joined"] == 1


def test_pictures_that_a_definition_no_longer_has_make_room(api, lab):  # noqa: F811
    def pictures(*ids):
        return definition(step("order", pictures=[{"id": one, "comfort": 0} for one in ids]))
    study = create(lab, pictures("a", "b"))
    for one in ("a", "b"):
        lab.http.put(f"/v1/studies/{study}/pictures/{one}", content=picture(), headers={"Content-Type": "image/png"})
    etag = lab.http.get(f"/v1/studies/{study}").headers["etag"]
    assert lab.http.put(f"/v1/studies/{study}", json={"definition": pictures("b", "c")}, headers={"If-Match": etag}).status_code == 200
    assert api.psql("SELECT picture_id FROM study_pictures WHERE study_id = %s", study) == [("b",)]


def test_previews_are_few_and_have_no_numbers_of_participants(api, lab):  # noqa: F811
    study, token = opened(lab, definition())
    for _ in range(12):
        assert lab.http.post(f"/v1/studies/{study}/preview", json={"key": secrets.token_hex(32)}).status_code == 201
    assert api.psql("SELECT count(*) FROM study_participants WHERE study_id = %s", study) == [(10,)]
    joined(api, token)
    assert [one["number"] for one in export(lab, study)["participants"]] == [1]


def test_sessions_of_the_gone_and_of_a_lost_role_end(api, scan, lab, worker):  # noqa: F811
    study, token = opened(lab, every_kind(scan))
    gone, stays = joined(api, token), joined(api, token)
    sessions = [one.post("visits", step="viewpoint").json()["session_id"] for one in (gone, stays)]
    api.psql("DELETE FROM study_participants WHERE study_id = %s AND number = 1", study)
    api.wait_until(lambda: not api.redis.exists(f"diaphane:session:{sessions[0]}"), what="the session of the deleted one to end")
    assert api.redis.exists(f"diaphane:session:{sessions[1]}")
    api.psql("UPDATE users SET is_researcher = false WHERE id = %s", lab.id)
    api.wait_until(lambda: not api.redis.exists(f"diaphane:session:{sessions[1]}"), what="the session of the lost role to end")
    api.psql("UPDATE users SET is_researcher = true WHERE id = %s", lab.id)
    api.wait_until(lambda: api.psql("SELECT count(*) FROM study_ended_sessions") == [(0,)], what="ended sessions to be forgotten")


def test_the_time_of_a_participants_session_is_the_researchers(api, lab, scan, worker):  # noqa: F811
    study, token = opened(lab, every_kind(scan))
    joined(api, token)
    [(participant,)] = api.psql("SELECT id::text FROM study_participants WHERE study_id = %s", study)
    before = spent(api, lab)
    api.redis.hincrby("diaphane:render_time", participant, 5000)
    api.wait_until(lambda: spent(api, lab) == before + 5000, what="the time to be charged")


def spent(api, who) -> int:  # noqa: F811
    return api.psql("SELECT COALESCE(sum(device_ms), 0)::bigint FROM render_time WHERE user_id = %s", who.id)[0][0]


def test_a_draft_can_not_be_closed_and_latency_needs_a_marked_side(api, lab, scan):  # noqa: F811
    problem(set_state(lab, create(lab, definition()), "closed"), 409, "conflict")
    for region in ({}, {"region": {"name": BOTH, "centre": [0.5, 0, 0], "radius": 5}}):
        shown = {**view(scan, **region), "scene": {**SCENE, "camera": {**SCENE["camera"], "target": {}}}}
        answer = lab.http.post("/v1/studies", json={"definition": definition(step("latency", view=shown, delays_ms=[0]))})
        problem(answer, 422, "invalid")


def test_a_new_link_ends_the_earlier_one(api, lab):  # noqa: F811
    study, token = opened(lab, definition())
    early = joined(api, token)
    new = lab.http.post(f"/v1/studies/{study}/link").json()["path"].removeprefix("/study#")
    problem(client(api).post("/v1/study/invitation", json={"token": token}), 404, "not-found")
    problem(Participant(api, token).join(), 404, "not-found")
    joined(api, new)
    assert early.join().status_code == 201, "who has joined stays"


def test_withdrawal_deletes_everything_and_can_be_repeated(api, lab):  # noqa: F811
    study, token = opened(lab, definition())
    one, stays = joined(api, token, record=True), joined(api, token)
    one.answer("rating", {"rating": 1})
    assert one.post("recordings", step="rating", recording=RECORDING).status_code == 204
    one.post("finish")
    set_state(lab, study, "closed")
    for _ in range(2):
        assert one.post("withdrawal").status_code == 204
    problem(one.answer("rating", {"rating": 1}), 410, "participation-ended")
    set_state(lab, study, "open")
    problem(one.join(), 410, "participation-ended")
    set_state(lab, study, "closed")
    exported = export(lab, study)
    assert exported["study"]["withdrawn"] == 1 and [p["number"] for p in exported["participants"]] == [2]
    assert api.psql("SELECT count(*) FROM study_answers a JOIN study_participants p ON p.id = a.participant_id WHERE p.study_id = %s", study) == [(0,)]
    assert stays.post("withdrawal").status_code == 204
    assert api.psql("""SELECT count(*) FROM study_recordings r JOIN study_participants p ON p.id = r.participant_id WHERE p.study_id = %s""", study) == [(0,)]


RECORDING = {"format": "diaphane-interaction", "version": 1, "viewport": {"width": 64, "height": 64},
             "events": [{"at_ms": 0, "scene": {"camera": {"eye": {"x": 1}}}}]}


def test_recordings_need_consent_and_a_large_one_the_key_in_its_header(api, lab):  # noqa: F811
    study, token = opened(lab, definition())
    silent, one = joined(api, token), joined(api, token, record=True)
    problem(silent.post("recordings", step="rating", recording=RECORDING), 403, "forbidden")
    large = {**RECORDING, "events": [{"at_ms": at, "scene": {"camera": {"eye": {"x": 1, "y": 2, "z": 3}}}} for at in range(2000)]}
    body = {"key": one.key, "step": "rating", "recording": large}
    problem(one.http.post("/v1/study/recordings", json=body), 413, "body-too-large")
    for key, status, kind in ((secrets.token_hex(32), 410, "participation-ended"), (silent.key, 403, "forbidden")):
        problem(one.http.post("/v1/study/recordings", json=body, headers={"Authorization": f"Bearer {key}"}), status, kind)
    assert one.http.post("/v1/study/recordings", json=body, headers={"Authorization": f"Bearer {one.key}"}).status_code == 204
    assert one.post("recordings", step="rating", recording={"events": []}).status_code == 422
    assert one.post("recordings", step="none", recording=RECORDING).status_code == 422
    [recording] = export(lab, study)["participants"][1]["recordings"]
    assert recording["step"] == "rating" and len(recording["events"]) == 2000
    study, token = opened(lab, definition(record=False))
    problem(joined(api, token, record=True).post("recordings", step="rating", recording=RECORDING), 403, "forbidden")


def test_a_preview_works_for_a_draft_and_is_never_counted_or_exported(api, lab, scan, worker):  # noqa: F811
    study = create(lab, every_kind(scan))
    one = Participant(api, "")
    made = lab.http.post(f"/v1/studies/{study}/preview", json={"key": one.key})
    assert made.status_code == 201 and made.json()["answered"] == []
    assert one.answer("rating", {"rating": 3}).status_code == 204
    assert one.post("visits", step="viewpoint").status_code == 201
    found = lab.http.get(f"/v1/studies/{study}").json()
    assert (found["joined"], found["finished"]) == (0, 0) and export(lab, study)["participants"] == []
    changed = lab.http.put(f"/v1/studies/{study}", json={"definition": definition()}, headers={"If-Match": found["etag"]})
    assert changed.status_code == 200, "a preview does not freeze a study"
    problem(one.answer("rating", {"rating": 3}), 410, "participation-ended")


def test_a_visit_shows_the_scene_of_the_step_and_counts_as_the_researchers(api, lab, scan, worker):  # noqa: F811
    study, token = opened(lab, every_kind(scan))
    one = joined(api, token)
    problem(one.post("visits", step="rating"), 422, "invalid")
    first = one.post("visits", step="viewpoint").json()
    again = one.post("visits", step="viewpoint").json()
    assert first["session_id"] == again["session_id"] and first["stream_url"] != again["stream_url"]
    session = f"diaphane:session:{first['session_id']}"
    [(participant,)] = api.psql("SELECT id::text FROM study_participants WHERE study_id = %s", study)
    assert api.redis.hget(session, "user") == participant and api.redis.hexists(session, "scene")
    assert api.redis.hget(session, "charged_to") == lab.id
    path = f"/v1/sessions/{first['session_id']}"
    assert first["session_id"] not in lab.http.get("/v1/sessions").text, "nobody watches a participant"
    for answer in (lab.http.get(path), lab.http.post(f"{path}/tickets"), lab.http.post(f"{path}/links"), lab.http.delete(path)):
        problem(answer, 404, "not-found")
    second = one.post("visits", step="colours").json()["session_id"]
    assert not api.redis.exists(f"diaphane:session:{first['session_id']}"), "a participant has one session"
    set_state(lab, study, "closed")
    assert not api.redis.exists(f"diaphane:session:{second}")
    set_state(lab, study, "open")
    api.psql("UPDATE users SET render_quota_ms = 0 WHERE id = %s", lab.id)
    answer = one.post("visits", step="colours")
    problem(answer, 503, "busy")
    assert "rendering time" not in answer.text, "the researcher's account is none of the participant's business"
    api.psql("UPDATE users SET render_quota_ms = 36000000 WHERE id = %s", lab.id)


def test_a_lecture_hall_joins_from_one_address_but_no_flood(api, lab):  # noqa: F811
    _, token = opened(lab, definition(places=1000))
    for _ in range(3):
        joined(api, token)
    [(busiest, at, second)] = api.psql("SELECT key_hash, happened_at, extract(epoch FROM happened_at) FROM attempts "
                                       "GROUP BY 1, 2 HAVING count(*) = 3")
    assert second % 900 == 0, "the time of joining is not stored"
    api.psql("INSERT INTO attempts (key_hash, happened_at) SELECT %s, %s FROM generate_series(1, 297) i", busiest, at)
    problem(Participant(api, token).join(), 429, "too-many-attempts")


def test_without_the_analysis_nothing_is_calculated_or_adopted(api, lab):  # noqa: F811
    study = create(lab, definition())
    problem(lab.http.get(f"/v1/studies/{study}/analysis", params={"language": "de"}), 503, "unavailable")
    assert client(api).get("/v1/perception").json() == {"comfort": None}
    problem(lab.http.post(f"/v1/studies/{study}/adoption", json={"comfort": True}), 403, "forbidden")


def test_deleting_a_study_or_its_researcher_deletes_everything(api):  # noqa: F811
    who = researcher(api)
    study, token = opened(who, definition())
    joined(api, token).answer("rating", {"rating": 1})
    api.psql("DELETE FROM users WHERE id = %s", who.id)
    assert api.psql("SELECT count(*) FROM studies WHERE id = %s", study) == [(0,)]
    assert api.psql("SELECT count(*) FROM study_participants WHERE study_id = %s", study) == [(0,)]


def test_malformed_keys_and_tokens_are_refused(api):  # noqa: F811
    http = client(api)
    problem(http.post("/v1/study/invitation", json={"token": "a"}), 404, "not-found")
    problem(http.post("/v1/study/answers", json={"key": "z" * 64, "step": "a", "value": {}, "duration_ms": 0, "sequence": 0}), 410, "participation-ended")
    problem(http.post("/v1/study/finish", json={"key": "short"}), 422, "invalid")
    assert http.post("/v1/study/withdrawal", json={"key": "0" * 64}).status_code == 204
    assert json.dumps(SCENE)
