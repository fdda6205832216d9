"""Presets: saving, changing with If-Match, voting, defaults, reading and writing XML, and refusing hostile ones."""

from __future__ import annotations

import copy
import json

import pytest
from api_client import CONTRACT, add_worker, api, client, make_ready, one, other, person, problem, remove_worker  # noqa: F401
from access_matrix_fixture import put_picture

SCENE = CONTRACT.spec["components"]["schemas"]["Scene"]["example"]
XML = {"Content-Type": "application/xml"}


@pytest.fixture(scope="module")
def third(api):  # noqa: F811
    return person(api)


@pytest.fixture
def shown(api, one) -> str:  # noqa: F811
    """A public data set."""
    made = private(api, one)
    api.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", made)
    assert one.http.post(f"/v1/data-sets/{made}/visibility", json={"visibility": "public"}).status_code == 200
    return made


def private(api, owner) -> str:  # noqa: F811
    made = owner.upload(b"x" * 100)["id"]
    make_ready(api, made)
    return made


def save(who, data_set: str, name: str = "Mine", scene: dict | None = None):
    return who.http.post(f"/v1/data-sets/{data_set}/presets", json={"name": name, "scene": scene or SCENE})


def saved(who, data_set: str, name: str = "Mine") -> dict:
    answer = save(who, data_set, name)
    assert answer.status_code == 201, answer.text
    assert answer.headers["etag"] == answer.json()["etag"]
    return answer.json()


def names(who, data_set: str) -> list[str]:
    return [p["name"] for p in who.http.get(f"/v1/data-sets/{data_set}/presets").json()["items"]]


def change(who, preset: dict, body: dict, etag: str | None = None):
    return who.http.patch(f"/v1/presets/{preset['id']}", json=body, headers={"If-Match": etag} if etag else {})


def delete(who, preset: dict, etag: str | None = None):
    return who.http.delete(f"/v1/presets/{preset['id']}", headers={"If-Match": etag or preset["etag"]})


def test_a_saved_scene_is_returned_unchanged(api, one):  # noqa: F811
    made = private(api, one)
    scene = copy.deepcopy(SCENE) | {"bounces": 3, "clip": {"boxLow": {"x": -1}, "boxHigh": {"x": 1}},
                                    "slices": {"axial": {"shown": True, "position": 0.1}, "windowWidth": 400}}
    answer = save(one, made, "All of it", scene)
    assert answer.status_code == 201
    back = one.http.get(answer.headers["location"]).json()
    assert back["scene"] == scene and back["version"] == 1 and back["mine"]
    assert names(one, made) == ["All of it"]


def test_a_change_needs_the_current_version(api, one):  # noqa: F811
    preset = saved(one, private(api, one))
    problem(change(one, preset, {"name": "New"}), 428, "precondition-required")
    problem(one.http.delete(f"/v1/presets/{preset['id']}"), 428, "precondition-required")
    renamed = change(one, preset, {"name": "New"}, preset["etag"])
    assert renamed.status_code == 200 and renamed.headers["etag"] != preset["etag"]
    for stale in (preset["etag"], '"99"', "W/x", "malformed", "*"):
        problem(change(one, preset, {"name": "Newer"}, stale), 412, "precondition")
        problem(delete(one, preset, stale), 412, "precondition")
    assert one.http.get(f"/v1/presets/{preset['id']}").json()["name"] == "New"
    assert delete(one, preset, renamed.headers["etag"]).status_code == 204
    problem(one.http.get(f"/v1/presets/{preset['id']}"), 404, "not-found")


def test_only_one_of_two_changes_to_the_same_version_succeeds(api, one):  # noqa: F811
    from concurrent.futures import ThreadPoolExecutor

    preset = saved(one, private(api, one))
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda n: change(one, preset, {"name": f"n{n}"}, preset["etag"]).status_code, range(8)))
    assert sorted(answers) == [200] + [412] * 7


def test_view_only_users_cannot_save_or_change_presets(api, one, other):  # noqa: F811
    made = private(api, one)
    preset = saved(one, made)
    problem(save(other, made), 404, "not-found")
    problem(other.http.get(f"/v1/presets/{preset['id']}"), 404, "not-found")
    people = f"/v1/data-sets/{made}/people"
    one.http.post(people, json={"email": other.email, "may": "view"})
    assert names(other, made) == ["Mine"]
    problem(save(other, made), 403, "forbidden")
    one.http.post(people, json={"email": other.email, "may": "save"})
    theirs = saved(other, made, "Theirs")
    problem(change(other, preset, {"name": "x"}, preset["etag"]), 403, "forbidden")
    problem(delete(other, preset), 403, "forbidden")
    problem(change(one, theirs, {"name": "x"}, theirs["etag"]), 403, "forbidden")
    problem(other.http.post(f"/v1/data-sets/{made}/default-preset", json={"preset_id": theirs["id"]}), 403, "forbidden")
    # private presets have no votes
    problem(other.http.post(f"/v1/presets/{preset['id']}/vote", json={"value": 1}), 403, "forbidden")
    assert delete(one, theirs).status_code == 204   # the owner of the scan may


def test_each_user_has_one_vote_and_presets_are_sorted_by_votes(api, one, other, third, shown):  # noqa: F811
    first, second = saved(one, shown, "First"), saved(other, shown, "Second")
    vote = lambda who, preset, value: who.http.post(f"/v1/presets/{preset['id']}/vote", json={"value": value}).json()  # noqa: E731
    assert names(third, shown) == ["First", "Second"]
    assert vote(third, second, 1) == {"votes": 1, "my_vote": 1}
    assert vote(third, second, 1) == {"votes": 1, "my_vote": 1}
    assert names(third, shown) == ["Second", "First"]
    assert vote(one, second, -1) == {"votes": 0, "my_vote": -1}
    assert vote(third, second, -1) == {"votes": -2, "my_vote": -1}
    assert names(third, shown) == ["First", "Second"]
    assert vote(third, second, 0) == {"votes": -1, "my_vote": 0}
    problem(third.http.post(f"/v1/presets/{first['id']}/vote", json={"value": 2}), 422, "invalid")
    other.http.patch("/v1/me/public-name", json={"public_name": "Otto"})
    shown_to_all = third.http.get(f"/v1/data-sets/{shown}/presets").text
    assert "Otto" in shown_to_all and other.email not in shown_to_all and "author_id" not in shown_to_all
    assert one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": second["id"]}).status_code == 204
    assert names(third, shown) == ["Second", "First"]
    assert one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": None}).status_code == 204
    problem(one.http.post(f"/v1/data-sets/{private(api, one)}/default-preset", json={"preset_id": first["id"]}), 404, "not-found")
    problem(client(api).get(f"/v1/data-sets/{shown}/presets"), 404, "not-found")   # samples are not private to anyone


def test_presets_per_user_are_limited(api, one, other, shown):  # noqa: F811
    for n in range(20):
        saved(other, shown, f"n{n}")
    problem(save(other, shown), 429, "too-many")
    assert save(one, shown).status_code == 201


@pytest.mark.parametrize("broken, field", [
    ({"camera": {"eye": {"x": 1e9}, "target": {}, "up": {"z": 1}, "verticalFovDegrees": 30}}, "scene.camera.eye.x"),
    ({"camera": {"eye": {"x": "NaN"}, "target": {}, "up": {"z": 1}, "verticalFovDegrees": 30}}, "scene.camera.eye.x"),
    ({"bounces": 5000}, "scene.bounces"),
    ({"holograms": True}, "scene.holograms"),
    ({"phase": {"g": 0, "colour": 1}}, "scene.phase.colour"),
    ({"lights": [{"name": "none"}]}, "scene.lights[0]"),
    ({"lights": [{"environment": {"texture": {"picture": "AAAA"}}}]}, "scene.lights[0].environment.texture"),
    ({"transferFunction": {"channels": []}}, "scene.transferFunction.channels"),
])
def test_a_hostile_scene_is_refused_by_its_field(api, one, shown, broken, field):  # noqa: F811
    document = problem(save(one, shown, scene=SCENE | broken), 422, "invalid")
    assert [e["field"] for e in document["errors"]] == [field], document


def test_newer_versions_and_huge_scenes_are_refused_by_field(api, one, shown):  # noqa: F811
    answer = one.http.post(f"/v1/data-sets/{shown}/presets", json={"name": "a", "scene": SCENE, "version": 2})
    document = problem(answer, 422, "invalid")
    assert document["errors"] == [{"field": "version", "message": "is newer than this server supports (1)"}]
    points = [{"value": n, "opacity": 0.5} for n in range(1024)]
    wide = SCENE | {"transferFunction": {"channels": [{"opacity": points} for _ in range(4)]}}
    document = problem(save(one, shown, scene=wide), 422, "invalid")
    assert document["errors"][0]["field"] == "scene" and "60 KB" in document["errors"][0]["message"]
    huge = SCENE | {"lights": [{"name": "x" * 300_000, "environment": {}}]}
    problem(save(one, shown, scene=huge), 413, "body-too-large")
    deep = b'{"name": "a", "scene": ' + b'{"camera":' * 20_000 + b"1" + b"}" * 20_000 + b"}"
    answer = one.http.post(f"/v1/data-sets/{shown}/presets", content=deep, headers={"Content-Type": "application/json"})
    assert answer.status_code in (400, 422)


def import_xml(who, data_set: str, xml: str | bytes, **headers: str):
    return who.http.post(f"/v1/data-sets/{data_set}/presets/xml", content=xml, headers=XML | headers)


def test_xml_round_trips_with_unknown_parts(api, one, other, shown):  # noqa: F811
    preset = saved(one, shown, 'Bone & "skin" <1>')
    out = other.http.get(f"/v1/presets/{preset['id']}/xml")
    assert out.headers["content-type"] == "application/xml" and out.headers["etag"] == preset["etag"]
    assert "attachment" in out.headers["content-disposition"]
    foreign = out.text.replace("<transferFunction>", '<clinic room="4"><bed>2</bed></clinic><transferFunction>')
    back = import_xml(other, shown, foreign)
    assert back.status_code == 201, back.text
    assert back.json()["name"] == preset["name"] and back.json()["scene"] == preset["scene"]
    renamed = change(other, back.json(), {"name": "Ours", "scene": SCENE | {"bounces": 7}}, back.headers["etag"])
    assert renamed.status_code == 200
    again = other.http.get(f"/v1/presets/{back.json()['id']}/xml").text
    for kept in ('<clinic room="4">', "<bed>2</bed>", "<bounces>7</bounces>", 'name="Ours"'):
        assert kept in again
    problem(import_xml(other, shown, foreign, **{"Content-Type": "text/plain"}), 415, "media-type")


HEAD = '<preset xmlns="urn:diaphane:preset" version="1" name="a">'
LAUGHS = "<!DOCTYPE preset [" + '<!ENTITY a0 "ha">' + "".join(
    f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 10)) + f"]>{HEAD}<lights><name>&a9;</name></lights></preset>"


@pytest.mark.parametrize("xml, field", [
    (LAUGHS, "preset"),
    (f'<!DOCTYPE p [<!ENTITY f SYSTEM "file:///etc/hostname">]>{HEAD}<lights><name>&f;</name></lights></preset>', "preset"),
    (f'<!DOCTYPE p SYSTEM "http://127.0.0.1:1/p.dtd">{HEAD}</preset>', "preset"),
    (HEAD + "<a>" * 20_000 + "</a>" * 20_000 + "</preset>", "preset"),
    (HEAD + "<a/>" * 40_000 + "</preset>", "preset"),
    (HEAD + "<unfinished", "preset"),
    ("", "preset"),
    ("{}", "preset"),
    ('<preset xmlns="urn:diaphane:preset" version="7" name="a"/>', "version"),
    (f"{HEAD}<bounces>many</bounces></preset>", "bounces"),
    (f"{HEAD}</preset>", "transferFunction.channels"),
], ids=["laughs", "file", "remote", "deep", "many", "half", "empty", "json", "future", "number", "bare"])
def test_hostile_xml_is_refused_by_its_element(api, one, shown, xml, field):  # noqa: F811
    document = problem(import_xml(one, shown, xml), 422, "invalid")
    assert [e["field"] for e in document["errors"]] == [field]
    assert "root:" not in json.dumps(document)
    assert names(one, shown) == []
    assert import_xml(one, shown, one_good_xml(one, shown)).status_code == 201


def one_good_xml(who, data_set: str) -> str:
    preset = saved(who, data_set)
    xml = who.http.get(f"/v1/presets/{preset['id']}/xml").text
    delete(who, preset)
    return xml


def test_too_large_xml_is_refused_unread(api, one, shown):  # noqa: F811
    problem(import_xml(one, shown, HEAD + " " * 300_000 + "</preset>"), 413, "body-too-large")


def test_the_same_idempotency_key_creates_one_preset(api, one, other, shown):  # noqa: F811
    from concurrent.futures import ThreadPoolExecutor

    key = {"Idempotency-Key": "a-try-of-mine"}
    path = f"/v1/data-sets/{shown}/presets"
    body = {"name": "Once", "scene": SCENE}
    with ThreadPoolExecutor(6) as pool:
        answers = list(pool.map(lambda _: one.http.post(path, json=body, headers=key), range(6)))
    assert {answer.status_code for answer in answers} == {201}
    [made] = {answer.json()["id"] for answer in answers}
    assert names(one, shown) == ["Once"]
    problem(one.http.post(path, json=body | {"name": "Another"}, headers=key), 422, "idempotency-key-reused")
    problem(one.http.post(f"/v1/data-sets/{private(api, one)}/presets", json=body, headers=key), 422, "idempotency-key-reused")
    assert other.http.post(path, json=body, headers=key).json()["id"] != made   # keys belong to a user
    xml = one.http.get(f"/v1/presets/{made}/xml").text
    imported = [import_xml(other, shown, xml, **{"Idempotency-Key": "a-file"}).json()["id"] for _ in range(2)]
    assert imported[0] == imported[1]
    assert delete(one, answers[0].json()).status_code == 204
    problem(one.http.post(path, json=body, headers=key), 409, "conflict")
    problem(one.http.post(path, json=body, headers={"Idempotency-Key": "a b"}), 422, "invalid")


def wait_disposed(api, preset: dict) -> None:  # noqa: F811
    """Waits until the picture is gone, and the note that it has to go. While the note is there, the API makes no new picture, and a test
    must not, because the removal of the note would be that of the next one, too."""
    folder = api.data_dir / "cache" / "presets" / preset["id"]
    api.wait_until(lambda: not folder.exists() and not api.psql("SELECT 1 FROM disposals WHERE id = %s", preset["id"]), what="the picture's end")


def picture_of(who, preset: dict, data_set: str | None = None, **headers: str):
    return who.http.get(f"/v1/data-sets/{data_set or preset['data_set_id']}/presets/{preset['id']}/thumbnail", headers=headers)


def test_every_reader_of_a_preset_gets_its_picture(api, one, other):  # noqa: F811
    made = private(api, one)
    preset = saved(one, made)
    assert preset["pictured_at"] is None
    problem(picture_of(one, preset), 404, "not-found")
    file = put_picture(api, preset["id"])
    answer = picture_of(one, preset)
    assert answer.status_code == 200 and answer.content == b"\xff\xd8\xff" and "no-cache" in answer.headers["cache-control"]
    assert picture_of(one, preset, **{"If-None-Match": answer.headers["etag"]}).status_code == 304
    assert one.http.get(f"/v1/presets/{preset['id']}").json()["pictured_at"]
    problem(picture_of(other, preset), 404, "not-found")
    problem(picture_of(one, preset, data_set=private(api, one)), 404, "not-found")
    assert one.http.get(f"/_cache/presets/{preset['id']}/picture.jpg").status_code == 404, "nobody gets at it but by the route"
    one.http.post(f"/v1/data-sets/{made}/people", json={"email": other.email, "may": "view"})
    assert picture_of(other, preset).status_code == 200
    renamed = change(one, preset, {"name": "Renamed"}, preset["etag"]).json()
    assert picture_of(one, preset).status_code == 200, "of the same scene"
    changed = change(one, preset, {"scene": SCENE | {"bounces": 2}}, renamed["etag"]).json()
    problem(picture_of(one, preset), 404, "not-found")
    wait_disposed(api, preset)
    put_picture(api, preset["id"])
    file.unlink()   # a cache may lose its entries, which are then made again
    problem(picture_of(one, preset), 404, "not-found")
    assert one.http.get(f"/v1/presets/{preset['id']}").json()["pictured_at"] is None
    wait_disposed(api, preset)
    put_picture(api, preset["id"])
    assert delete(one, changed).status_code == 204
    wait_disposed(api, preset)


def test_a_preset_picture_is_deleted_with_its_data_set_or_author(api, one, shown):  # noqa: F811
    from api_client import PASSWORD, forget_attempts

    author = person(api)
    of_the_crowd, of_the_owner = saved(author, shown, "Theirs"), saved(one, shown, "Mine")
    theirs, mine = (put_picture(api, preset["id"]) for preset in (of_the_crowd, of_the_owner))
    forget_attempts(api)
    assert author.http.post("/v1/me/deletion", json={"password": PASSWORD}).status_code == 204
    api.wait_until(lambda: not theirs.parent.exists(), what="the end of the author's")
    assert mine.exists()
    assert one.http.delete(f"/v1/data-sets/{shown}").status_code == 204
    api.wait_until(lambda: not mine.parent.exists(), what="the end of the data set's")


def test_a_scan_opens_with_the_owners_default_preset(api, one, other, third, shown):  # noqa: F811
    """The scene of a new session, as sent to the worker."""
    import secrets

    from stream_helpers import MESSAGES

    add_worker(api, "presets-test", slots=64, seconds=600)

    def first_scene(answer) -> dict | None:
        assert answer.status_code == 201, answer.text
        hexed = api.redis.eval("""local kept = redis.call('HGET', KEYS[1], 'scene') or ''
                                  return (kept:gsub('.', function(c) return string.format('%02x', string.byte(c)) end))""",
                               1, f"diaphane:session:{answer.json()['session_id']}")
        return MESSAGES["Scene"].FromString(bytes.fromhex(hexed)) if hexed else None

    def opened(who) -> dict | None:
        return first_scene(who.http.post("/v1/sessions", json={"data_set_id": shown}))

    link = one.http.post(f"/v1/data-sets/{shown}/links", json={"hours": 1}).json()["token"]

    def visited() -> dict | None:
        return first_scene(client(api).post("/v1/visits", json={"key": secrets.token_hex(32), "token": link}))

    assert opened(one) is None and opened(other) is None and visited() is None
    save(one, shown, "Not this one")
    crowd = save(other, shown, "This one", SCENE | {"bounces": 9}).json()
    one.http.post(f"/v1/data-sets/{shown}/people", json={"email": third.email, "may": "view"})
    assert one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": crowd["id"]}).status_code == 204
    first = [opened(one), opened(other), opened(third), visited()]
    assert [scene.bounces for scene in first] == [9] * 4 and all(scene.camera.eye.y == -500 for scene in first)
    # Later changes by its author do not affect the owner's choice until the owner chooses it again.
    crowd = other.http.patch(f"/v1/presets/{crowd['id']}", json={"scene": SCENE | {"bounces": 7}},
                             headers={"If-Match": crowd["etag"]}).json()
    assert crowd["is_default"] and crowd["changed_since_default"] and crowd["scene"]["bounces"] == 7
    assert [scene.bounces for scene in (opened(one), opened(other), visited())] == [9] * 3
    assert one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": crowd["id"]}).status_code == 204
    assert opened(other).bounces == 7 and not other.http.get(f"/v1/presets/{crowd['id']}").json()["changed_since_default"]
    mine = save(one, shown, "The owner's").json()
    assert one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": mine["id"]}).status_code == 204
    mine = one.http.patch(f"/v1/presets/{mine['id']}", json={"scene": SCENE | {"bounces": 5}}, headers={"If-Match": mine["etag"]}).json()
    assert opened(other).bounces == 5 and not mine["changed_since_default"], "an owner sees what they change"
    assert one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": crowd["id"]}).status_code == 204
    # An existing session is unchanged and shows its current scene.
    kept = one.http.post("/v1/sessions", json={"data_set_id": shown}, headers={"Idempotency-Key": "mine"}).json()["session_id"]
    api.redis.hset(f"diaphane:session:{kept}", "scene", "as it is")
    assert one.http.post(f"/v1/sessions/{kept}/tickets").status_code == 201
    assert api.redis.hget(f"diaphane:session:{kept}", "scene") == "as it is"
    assert delete(other, crowd).status_code == 204
    assert opened(one) is None and visited() is None
    remove_worker(api, "presets-test")


def test_an_offensive_preset_can_be_reported_and_taken_down(api, one, other, third, shown):  # noqa: F811
    boss = person(api)
    offending = saved(other, shown, "A bad word")
    assert one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": offending["id"]}).status_code == 204
    file = put_picture(api, offending["id"])
    report = lambda who, **words: who.http.post(f"/v1/presets/{offending['id']}/reports", json={"reason": "offensive", **words})  # noqa: E731
    for words in ("At first.", "Read its name."):
        assert report(third, words=words).status_code == 204
    problem(report(other), 403, "forbidden")   # own preset
    problem(report(one), 403, "forbidden")     # its owner can delete it
    down = lambda who: who.http.post(f"/v1/presets/{offending['id']}/take-down", json={"reason": "A slur."})  # noqa: E731
    for who in (one, other, third):
        problem(down(who), 403, "forbidden")
    boss.becomes_administrator()
    [seen] = [r for r in boss.http.get("/v1/reports").json()["items"] if r["data_set_id"] == shown]
    assert (seen["preset_id"], seen["preset_name"], seen["words"], seen["taken_down"]) == (
        offending["id"], "A bad word", "Read its name.", False)
    assert third.email not in str(seen)

    assert down(boss).status_code == 204
    assert names(third, shown) == [] and names(one, shown) == [] and names(other, shown) == names(boss, shown) == ["A bad word"]
    for path in ("", "/xml"):
        problem(third.http.get(f"/v1/presets/{offending['id']}{path}"), 404, "not-found")
        problem(one.http.get(f"/v1/presets/{offending['id']}{path}"), 404, "not-found")
    problem(picture_of(third, offending), 404, "not-found")
    told = other.http.get(f"/v1/presets/{offending['id']}").json()
    assert told["taken_down"] == {"reason": "A slur."} and not told["is_default"] and file.exists()
    problem(other.http.post(f"/v1/presets/{offending['id']}/vote", json={"value": 1}), 403, "forbidden")
    problem(one.http.post(f"/v1/data-sets/{shown}/default-preset", json={"preset_id": offending["id"]}), 404, "not-found")
    assert [r for r in boss.http.get("/v1/reports").json()["items"] if r["data_set_id"] == shown] == []
    [entry] = api.psql("SELECT actor, action, subject, details::text FROM audit_log WHERE subject_id = %s", offending["id"])
    assert entry[:3] == ("administrator", "preset.taken-down", "preset") and "slur" not in entry[3]
    [listed] = [one for one in boss.http.get("/v1/take-downs").json()["items"] if one["data_set_id"] == shown]
    assert (listed["preset_id"], listed["preset_name"], listed["reason"]) == (offending["id"], "A bad word", "A slur.")
    assert boss.http.delete(f"/v1/presets/{offending['id']}/take-down").status_code == 204
    assert [one for one in boss.http.get("/v1/take-downs").json()["items"] if one["data_set_id"] == shown] == []
    assert names(third, shown) == ["A bad word"]
    # A wrong report is dismissed. Administrators cannot see private presets.
    report(third)
    [again] = [r for r in boss.http.get("/v1/reports").json()["items"] if r["data_set_id"] == shown]
    assert boss.http.delete(f"/v1/reports/{again['id']}").status_code == 204
    one.http.post(f"/v1/data-sets/{shown}/visibility", json={"visibility": "private"})
    problem(down(boss), 404, "not-found")
    boss.is_no_administrator()
