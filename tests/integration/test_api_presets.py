"""Presets: saved, changed under If-Match, voted for, made the default, read from and written to XML; hostile ones refused."""

from __future__ import annotations

import copy
import json

import pytest
from api_client import CONTRACT, api, client, make_ready, one, other, person, problem  # noqa: F401

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


def test_the_whole_scene_comes_back_as_it_was_saved(api, one):  # noqa: F811
    made = private(api, one)
    scene = copy.deepcopy(SCENE) | {"bounces": 3, "clip": {"boxLow": {"x": -1}, "boxHigh": {"x": 1}},
                                    "slices": {"axial": {"shown": True, "position": 0.1}, "windowWidth": 400}}
    answer = save(one, made, "All of it", scene)
    assert answer.status_code == 201
    back = one.http.get(answer.headers["location"]).json()
    assert back["scene"] == scene and back["version"] == 1 and back["mine"]
    assert names(one, made) == ["All of it"]


def test_a_change_needs_the_version_that_it_is_about(api, one):  # noqa: F811
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


def test_of_two_changes_of_one_version_one_is_made(api, one):  # noqa: F811
    from concurrent.futures import ThreadPoolExecutor

    preset = saved(one, private(api, one))
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda n: change(one, preset, {"name": f"n{n}"}, preset["etag"]).status_code, range(8)))
    assert sorted(answers) == [200] + [412] * 7


def test_who_may_only_look_saves_none_and_changes_nobodys(api, one, other):  # noqa: F811
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
    problem(other.http.post(f"/v1/presets/{preset['id']}/vote", json={"value": 1}), 403, "forbidden")   # private: no votes
    assert delete(one, theirs).status_code == 204   # the owner of the scan may


def test_the_crowd_votes_once_each_and_the_best_comes_first(api, one, other, third, shown):  # noqa: F811
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
    problem(client(api).get(f"/v1/data-sets/{shown}/presets"), 404, "not-found")   # nobody sees samples alone


def test_there_are_only_so_many_of_a_person(api, one, other, shown):  # noqa: F811
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


def test_a_later_version_and_a_huge_one_are_refused_by_name(api, one, shown):  # noqa: F811
    answer = one.http.post(f"/v1/data-sets/{shown}/presets", json={"name": "a", "scene": SCENE, "version": 2})
    document = problem(answer, 422, "invalid")
    assert document["errors"] == [{"field": "version", "message": "is a later one than this server reads (1)"}]
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


def test_xml_goes_out_and_comes_in_the_same_and_keeps_what_it_does_not_know(api, one, other, shown):  # noqa: F811
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


def test_xml_that_is_too_large_is_not_read(api, one, shown):  # noqa: F811
    problem(import_xml(one, shown, HEAD + " " * 300_000 + "</preset>"), 413, "body-too-large")
