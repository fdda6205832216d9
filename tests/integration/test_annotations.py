"""Saved marks and measurements: what is checked and cleaned, who sees them, and when they are deleted."""

from __future__ import annotations

import json

import pytest
from api_client import PASSWORD, api, client, make_ready, one, other, person, problem  # noqa: F401


def mark(**more) -> dict:
    return {"id": 1, "kind": "ARROW", "text": "Here", "place": {"x": 1, "y": 2, "z": 3}, "tail": {"x": 20}, **more}


def content(*marks: dict) -> dict:
    return {"marks": {"items": list(marks)}, "measurements": {"items": [{"kind": "RULER", "plane": "AXIAL", "slice": 3, "points": [{"x": 1}, {"x": 2}]}]}}


def save(who, scan: str, name: str = "Mine", given: dict | None = None, **more):
    return who.http.post(f"/v1/data-sets/{scan}/annotations", json={"name": name, "content": given or content(mark()), **more})


def listed(who, scan: str) -> list[dict]:
    answer = who.get(f"/v1/data-sets/{scan}/annotations")
    assert answer.status_code == 200, answer.text
    return answer.json()["items"]


@pytest.fixture
def scan(api, one) -> str:  # noqa: F811
    made = one.upload(b"x" * 10)["id"]
    make_ready(api, made)
    return made


def test_saved_marks_are_checked_and_cleaned(api, one, scan):  # noqa: F811
    made = save(one, scan, given=content(mark(text="Here \u202e\n and there"), mark(id=2, kind="CIRCLE", radius=5)))
    assert made.status_code == 201, made.text
    assert [each["text"] for each in made.json()["content"]["marks"]["items"] if "text" in each] == ["Here and there", "Here"]
    for broken in (mark(kind="STAR"), mark(place={"x": "NaN"}), mark(colour=8), mark(radius=-1), mark(colour=-1), mark(other=1)):
        refused = problem(save(one, scan, given=content(broken)), 422, "invalid")
        assert refused["errors"][0]["field"] == "content" and "Here" not in str(refused)
    problem(save(one, scan, given=content(mark(), mark())), 422, "invalid")
    problem(save(one, scan, given=content(*(mark(id=i) for i in range(51)))), 422, "invalid")
    problem(save(one, scan, name=""), 422, "invalid")


def test_sets_are_changed_shared_and_deleted(api, one, other, scan):  # noqa: F811
    made = save(one, scan).json()
    path = f"/v1/data-sets/{scan}/annotations/{made['id']}"
    assert made["shown"] and not made["shared"] and made["mine"]
    one.http.post(f"/v1/data-sets/{scan}/people", json={"email": other.email, "may": "save"})
    assert listed(other.http, scan) == []
    assert one.http.patch(path, json={"name": "Ours", "shown": False, "shared": True}).json()["name"] == "Ours"
    seen, = listed(other.http, scan)
    assert not seen["mine"] and not seen["shown"] and seen["content"] == made["content"]
    problem(other.http.patch(path, json={"name": "Theirs"}), 403, "forbidden")
    problem(other.http.delete(path), 403, "forbidden")
    # Whoever may save presets saves marks for themselves, and shares them with nobody.
    assert save(other, scan, "Only mine").status_code == 201
    problem(save(other, scan, "For all", shared=True), 403, "forbidden")
    assert [each["name"] for each in listed(one.http, scan)] == ["Ours"]
    assert one.http.delete(path).status_code == 204
    assert [each["name"] for each in listed(other.http, scan)] == ["Only mine"]


def test_a_change_of_older_content_is_refused(api, one, scan):  # noqa: F811
    made = save(one, scan).json()
    path = f"/v1/data-sets/{scan}/annotations/{made['id']}"
    changed = one.http.patch(path, json={"content": content(mark(text="First")), "revision": made["revision"]}).json()
    assert changed["revision"] != made["revision"]
    problem(one.http.patch(path, json={"content": content(mark(text="Late")), "revision": made["revision"]}), 412, "precondition")
    assert [each["revision"] for each in listed(one.http, scan)] == [changed["revision"]]
    assert one.http.patch(path, json={"content": content(), "revision": changed["revision"]}).status_code == 200


def test_a_preset_carries_marks_if_it_was_saved_with_them(api, one, scan):  # noqa: F811
    from test_api_presets import SCENE

    presets = f"/v1/data-sets/{scan}/presets"
    bare = one.http.post(presets, json={"name": "a", "scene": SCENE})
    assert bare.json()["annotations"] is None
    marked = one.http.post(presets, json={"name": "b", "scene": SCENE, "annotations": content(mark())})
    assert marked.json()["annotations"]["marks"]["items"][0]["text"] == "Here"
    path = f"/v1/presets/{marked.json()['id']}"
    renamed = one.http.patch(path, json={"name": "c"}, headers={"If-Match": marked.headers["etag"]})
    assert renamed.json()["annotations"] == marked.json()["annotations"]
    removed = one.http.patch(path, json={"annotations": None}, headers={"If-Match": renamed.headers["etag"]})
    assert removed.json()["annotations"] is None
    problem(one.http.post(presets, json={"name": "d", "scene": SCENE, "annotations": content(mark(kind="STAR"))}), 422, "invalid")


def test_visitors_without_an_account_see_the_marks_that_the_owner_shares(api, one, other, scan):  # noqa: F811
    save(one, scan, "Private")
    shared = save(one, scan, "For all", shared=True).json()
    link = one.http.post(f"/v1/data-sets/{scan}/links", json={"hours": 1}).json()
    follow = lambda token: client(api).post("/v1/follow/annotations", json={"token": token})  # noqa: E731
    seen, = follow(link["token"]).json()["items"]
    assert seen == shared | {"mine": False}
    problem(follow("0" * 64), 404, "not-found")
    problem(follow("short"), 422, "invalid")
    # Without the link, nobody else sees them, until the scan is public.
    everyone = lambda who: who.get(f"/v1/data-sets/{scan}/annotations")  # noqa: E731
    problem(everyone(client(api)), 404, "not-found")
    problem(everyone(other.http), 404, "not-found")
    api.psql("UPDATE data_sets SET is_sample = true, visibility = 'public', anonymised_at = now(), published_at = now() WHERE id = %s", scan)
    for visitor in (client(api), other.http):
        assert [each["name"] for each in everyone(visitor).json()["items"]] == ["For all"]
    api.psql("UPDATE data_sets SET is_sample = false, visibility = 'private', published_at = NULL WHERE id = %s", scan)
    assert one.http.patch(f"/v1/data-sets/{scan}/annotations/{shared['id']}", json={"shared": False}).status_code == 200
    assert follow(link["token"]).json()["items"] == []
    assert one.http.delete(f"/v1/data-sets/{scan}/links/{link['id']}").status_code == 204
    problem(follow(link["token"]), 404, "not-found")


def test_the_xml_of_a_preset_contains_its_marks(api, one, scan):  # noqa: F811
    from test_api_presets import SCENE, change, import_xml

    marked = one.http.post(f"/v1/data-sets/{scan}/presets", json={"name": "b", "scene": SCENE, "annotations": content(mark(text="<Here>"))}).json()
    xml = one.http.get(f"/v1/presets/{marked['id']}/xml").text
    assert "<text>&lt;Here&gt;</text>" in xml
    foreign = xml.replace("<transferFunction>", "<clinic/><transferFunction>")
    back = import_xml(one, scan, foreign)
    assert back.status_code == 201 and back.json()["annotations"] == marked["annotations"]
    # Once they are removed, nothing keeps them, not even the imported file.
    assert change(one, back.json(), {"annotations": None}, back.headers["etag"]).status_code == 200
    bare = one.http.get(f"/v1/presets/{back.json()['id']}/xml").text
    assert "annotations" not in bare and "<clinic" in bare
    assert "Here" not in api.psql("SELECT kept_xml FROM presets WHERE id = %s", back.json()["id"])[0][0]
    for broken in (xml.replace("<kind>ARROW</kind>", "<kind>STAR</kind>"), xml.replace("<x>20</x>", "<x>1e300</x>")):
        fields = [each["field"] for each in problem(import_xml(one, scan, broken), 422, "invalid")["errors"]]
        assert len(fields) == 1 and fields[0].startswith("annotations"), fields


def test_an_export_contains_the_marks(api, one, other, scan):  # noqa: F811
    from test_privacy import exported

    author = person(api)
    mine = author.upload(b"x" * 10)["id"]
    make_ready(api, mine)
    save(author, mine, given=content(mark(text="On my own scan")))
    one.http.post(f"/v1/data-sets/{scan}/people", json={"email": author.email, "may": "save"})
    save(author, scan, given=content(mark(text="On the scan of another")))
    one.http.post(f"/v1/data-sets/{scan}/people", json={"email": other.email, "may": "save"})
    save(other, scan, given=content(mark(text="By another")))
    file = exported(api, author)
    of_scan, = json.loads(file.read(f"scans/{mine}/marks.json"))
    assert of_scan["name"] == "Mine" and of_scan["content"]["marks"]["items"][0]["text"] == "On my own scan"
    assert f"scans/{scan}/marks.json" not in file.namelist()
    rows = file.read("records/annotations.author_id.json").decode()
    assert "On my own scan" in rows and "On the scan of another" in rows and "By another" not in rows
    assert b"marks.json" in file.read("README.txt")


def test_marks_are_deleted_with_their_scan_or_their_author(api, one, other, scan):  # noqa: F811
    guest = person(api)
    one.http.post(f"/v1/data-sets/{scan}/people", json={"email": guest.email, "may": "save"})
    assert save(one, scan).status_code == save(guest, scan).status_code == 201
    rows = f"SELECT count(*) FROM annotations WHERE data_set_id = '{scan}'"
    assert api.psql(rows) == [(2,)]
    assert guest.http.post("/v1/me/deletion", json={"password": PASSWORD}).status_code in (200, 202, 204)
    api.wait_until(lambda: api.psql(rows) == [(1,)], what="the deletion of the guest's marks")
    assert one.http.delete(f"/v1/data-sets/{scan}").status_code == 204
    assert api.psql(rows) == [(0,)]
