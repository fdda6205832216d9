"""Saved marks and measurements: what is checked and cleaned, who sees them, and when they are deleted."""

from __future__ import annotations

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
