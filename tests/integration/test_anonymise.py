"""Anonymising a data set: only by its owner, permanently, and without a trace of anything made from the old one."""

from __future__ import annotations

import uuid

import numpy
import pytest
from api_client import person, problem
from cut_helpers import KEEP, expected_left, hash_of, holders_of_mark, marked_scan
from jpeg_pixels import jpeg_pixels
from stream_helpers import open_session

CONFIRMATION = "this cannot be undone"
CAMERA = {"camera": {"eye": {"y": -300, "z": 4}, "target": {"z": 4}, "up": {"z": 1}, "verticalFovDegrees": 30},
          "clip": {"boxLow": {"x": -9, "y": -9, "z": -9}, "boxHigh": {"x": 9, "y": 9, "z": 9}}}


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "gateway", "edge", "ingestd", "renderd"))
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def owner(running):
    return person(running)


@pytest.fixture
def scan(running, owner) -> tuple[str, str]:
    """Returns a ready data set with the mark in it, and the hash of its volume."""
    return marked_scan(running, owner)


def ask(owner, data_set: str, content: str, keep: dict = KEEP, confirm: str = CONFIRMATION):
    return owner.http.post(f"/v1/data-sets/{data_set}/anonymise",
                           json={"keep": keep, "volume_hash": content, "confirm": confirm})


def wait_cut(running, owner, data_set: str) -> dict:
    def done():
        view = owner.http.get(f"/v1/data-sets/{data_set}/anonymise").json()
        return view if view["state"] == "ready" else None
    return running.wait_until(done, what="the cut")


def loaded(running) -> str:
    redis = running.redis
    return ",".join(redis.hget(f"diaphane:worker:{name}", "volumes") or "" for name in redis.smembers("diaphane:workers"))


def loads(running, data_set: str) -> int:
    return running.log("renderd").count(f'"event":"volume_loaded","volume":"{data_set}"')


def picture(running, owner, data_set: str):
    """Returns the thumbnail, rendered if necessary."""
    def made():
        answer = owner.http.get(f"/v1/data-sets/{data_set}/thumbnails/bone")
        return answer if answer.status_code == 200 else None
    return running.wait_until(made, 60, "a picture")


def test_nothing_remains_of_the_removed_parts(running, owner, scan):
    data_set, content = scan
    made = owner.http.post(f"/v1/data-sets/{data_set}/presets", json={
        "name": "mine", "scene": SCENE(owner, data_set), "annotations": {"marks": {"items": [{"id": 1, "kind": "TEXT", "text": "A name"}]}}})
    assert made.status_code == 201, made.text
    preset = made.json()
    old_picture = picture(running, owner, data_set)
    session, _ = open_session(owner, data_set)
    running.wait_until(lambda: data_set in loaded(running), what="the worker's copy")
    assert len(holders_of_mark(running.data_dir)) == 1, "the search would find nothing anyway"
    problem(owner.http.post(f"/v1/data-sets/{data_set}/visibility", json={"visibility": "public"}), 409, "not-anonymised")

    answer = ask(owner, data_set, content)
    assert answer.status_code == 202 and answer.json()["state"] in ("queued", "building", "ready")
    view = wait_cut(running, owner, data_set)

    voxels = (running.data_dir / "volumes" / data_set / "voxels.i16").read_bytes()
    assert voxels == expected_left() and view["volume_hash"] == hash_of(voxels)
    assert view["anonymised_at"] and view["problem"] is None and view["head"]["found"] is False
    assert owner.http.get(f"/v1/data-sets/{data_set}").json()["volume"]["size"] == [32, 32, 16]
    problem(owner.http.post(f"/v1/sessions/{session}/tickets"), 404, "not-found")
    # The new picture of the preset may have had the worker load what is left.
    running.wait_until(lambda: data_set not in loaded(running) or loads(running, data_set) > 1, what="the worker's copy is let go")
    running.wait_until(lambda: running.psql("SELECT count(*) FROM disposals WHERE id = %s", data_set) == [(0,)], what=
                       "what was noted is disposed of")
    assert holders_of_mark(running.data_dir) == []

    new_picture = picture(running, owner, data_set)
    assert new_picture.content != old_picture.content and "no-cache" in new_picture.headers["cache-control"]
    # The cut removes 32 mm at the top, so the centre is 16 mm lower, and coordinates are 16 mm higher.
    moved = owner.http.get(f"/v1/presets/{preset['id']}").json()
    assert preset["annotations"]["marks"]["items"][0]["text"] == "A name" and moved["annotations"] is None
    old, new = preset["scene"]["camera"]["eye"], moved["scene"]["camera"]["eye"]
    assert new.get("z", 0) - old.get("z", 0) == pytest.approx(16) and new["y"] == pytest.approx(old["y"])
    actions = running.psql("SELECT action, actor FROM audit_log WHERE subject_id = %s ORDER BY id", data_set)
    assert [row for row in actions if "anonymise" in row[0]] == [("data-set.anonymise-ordered", "person"),
                                                                 ("data-set.anonymised", "person")]
    published = owner.http.post(f"/v1/data-sets/{data_set}/visibility", json={"visibility": "public"})
    assert published.status_code == 200 and published.json()["is_public"]


#: A camera beside the centre, a box that keeps only the slab of the lower half, and a lamp, all with positions.
SLAB_XML = """<preset xmlns="urn:diaphane:preset" version="1" name="Slab">
  <note where="62 mm behind the nose">of what is cut away</note>
  <transferFunction>
    <channels><name>slab</name><opacity><value>20</value></opacity><opacity><value>45</value><opacity>1</opacity></opacity>
      <opacity><value>100</value><opacity>1</opacity></opacity><diffuse><r>0.9</r><g>0.5</g><b>0.3</b></diffuse></channels>
    <extinctionPerMm>1</extinctionPerMm>
  </transferFunction>
  <lights><environment><radiance><r>0.4</r><g>0.4</g><b>0.4</b></radiance></environment></lights>
  <lights><sphere><centre><x>-60</x><y>-90</y><z>40</z></centre><radius>15</radius><radiance><r>12</r><g>12</g><b>12</b></radiance></sphere></lights>
  <camera><eye><x>20</x><y>-190</y><z>60</z></eye><target><x>4</x><z>-15</z></target><up><z>1</z></up>
    <verticalFovDegrees>22</verticalFovDegrees></camera>
  <clip><boxLow><x>-30</x><y>-30</y><z>-30</z></boxLow><boxHigh><x>16</x><y>30</y><z>-4</z></boxHigh><cutsLight>true</cutsLight></clip>
</preset>"""


def preset_picture(running, owner, preset: dict) -> numpy.ndarray:
    """Of the preset as it is now; made if it has to be."""
    def made():
        answer = owner.http.get(f"/v1/data-sets/{preset['data_set_id']}/presets/{preset['id']}/thumbnail")
        return answer.content if answer.status_code == 200 else None
    return jpeg_pixels(running.wait_until(made, 120, "the preset's picture")).astype(float)


def difference(one: numpy.ndarray, other: numpy.ndarray) -> float:
    """Root of the mean square, of 255."""
    return float(numpy.sqrt(numpy.mean((one - other) ** 2)))


@pytest.mark.nightly
def test_a_preset_keeps_its_view_after_a_cut_without_removed_parts(running, owner, scan):
    data_set, content = scan
    path = f"/v1/data-sets/{data_set}/presets"
    imported = owner.http.post(f"{path}/xml", content=SLAB_XML, headers={"Content-Type": "application/xml"})
    assert imported.status_code == 201, imported.text
    preset = imported.json()
    assert "behind the nose" in owner.http.get(f"/v1/presets/{preset['id']}/xml").text
    # What could not be moved, as a later program may have written it.
    running.psql("""INSERT INTO presets (id, data_set_id, author_id, name, scene, created_at, updated_at)
                    VALUES (%s, %s, %s, 'of tomorrow', '{"holograms": [{"x": 62}]}', now(), now())""",
                 str(uuid.uuid4()), data_set, owner.id)
    before = preset_picture(running, owner, preset)
    assert before.std() > 20, "there is something in the picture"
    file = running.data_dir / "cache" / "presets" / preset["id"] / "picture.jpg"
    old_jpeg = file.read_bytes()

    assert ask(owner, data_set, content).status_code == 202
    wait_cut(running, owner, data_set)
    moved = owner.http.get(f"/v1/presets/{preset['id']}").json()
    # The centre is 16 mm lower now, so every coordinate is 16 mm higher.
    assert moved["scene"]["camera"]["eye"] == pytest.approx({"x": 20, "y": -190, "z": 76})
    assert moved["scene"]["camera"]["target"] == pytest.approx({"x": 4, "z": 1})
    assert moved["scene"]["clip"]["boxLow"] == pytest.approx({"x": -30, "y": -30, "z": -14})
    assert moved["scene"]["clip"]["boxHigh"] == pytest.approx({"x": 16, "y": 30, "z": 12})
    assert moved["scene"]["lights"][1]["sphere"]["centre"] == pytest.approx({"x": -60, "y": -90, "z": 56})
    xml = owner.http.get(f"/v1/presets/{preset['id']}/xml").text
    assert "<z>76</z>" in xml and "<z>-14</z>" in xml and "nose" not in xml and "cut away" not in xml
    assert running.psql("SELECT kept_xml, name FROM presets WHERE data_set_id = %s", data_set) == [(None, "Slab")]

    after = preset_picture(running, owner, moved)
    assert file.read_bytes() != old_jpeg, "it was rendered again"
    stayed = owner.http.post(path, json={"name": "Where it was", "scene": preset["scene"]}).json()
    elsewhere = preset_picture(running, owner, stayed)
    assert difference(before, after) < 6 < 18 < difference(before, elsewhere)


def SCENE(owner, data_set: str) -> dict:  # noqa: N802
    return {"transferFunction": {"channels": [{"name": "bone", "opacity": [{"value": 100}, {"value": 900, "opacity": 1}],
                                               "diffuse": {"r": 0.8, "g": 0.8, "b": 0.8}}], "extinctionPerMm": 1},
            "lights": [{"environment": {"radiance": {"r": 1, "g": 1, "b": 1}}}], **CAMERA}


def test_a_cut_needs_the_reviewed_volume_and_a_confirmation(running, owner, scan):
    data_set, content = scan
    problem(ask(owner, data_set, "blake2b:" + "0" * 64), 412, "precondition")
    problem(ask(owner, data_set, content, confirm="yes"), 422, "invalid")
    assert problem(ask(owner, data_set, content, keep={"box": {"low": [0, 0, 0], "high": [1, 1]}}), 422, "invalid")[
        "errors"][0]["field"] == "keep.box.high"
    assert owner.http.get(f"/v1/data-sets/{data_set}/anonymise").json()["anonymised_at"] is None
    # Of two simultaneous requests, one is accepted.
    answers = sorted(ask(owner, data_set, content).status_code for _ in range(2))
    assert answers in ([202, 409], [202, 412])
    wait_cut(running, owner, data_set)
    problem(ask(owner, data_set, content), 412, "precondition")


def test_a_cut_that_would_leave_nothing_is_refused(running, owner, scan):
    data_set, content = scan
    assert ask(owner, data_set, content, keep={"box": {"low": [500, 0, 0], "high": [600, 10, 10]}}).status_code == 202
    view = wait_cut(running, owner, data_set)
    assert "Too little" in view["problem"] and view["anonymised_at"] is None and view["volume_hash"] == content


def test_only_the_owner_can_anonymise_a_scan(running, owner, scan):
    data_set, content = scan
    stranger = person(running)
    problem(stranger.http.get(f"/v1/data-sets/{data_set}/anonymise"), 404, "not-found")
    problem(ask(stranger, data_set, content), 404, "not-found")
    problem(owner.http.get(f"/v1/data-sets/{uuid.uuid4()}/anonymise"), 404, "not-found")


def test_the_worker_releases_a_deleted_data_set(running, owner, scan):
    data_set, _ = scan
    picture(running, owner, data_set)
    running.wait_until(lambda: data_set in loaded(running), what="the worker's copy")
    assert owner.http.delete(f"/v1/data-sets/{data_set}").status_code == 204
    running.wait_until(lambda: data_set not in loaded(running), what="the worker's copy is let go")
    # The worker does not wait for the disposal of the files.
    running.wait_until(lambda: not (running.data_dir / "volumes" / data_set).exists(), what="the disposal of the volume")
