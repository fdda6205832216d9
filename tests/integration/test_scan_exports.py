"""Exports of scans, from the request to the file: what is in it, who gets it, its limits, and when it ends."""

from __future__ import annotations

import gzip
from pathlib import Path

import nibabel
import numpy as np
import pytest
import trimesh
from api_client import PASSWORD, Person, client, person, problem
from cut_helpers import KEEP, MARK, SIDE, marked_scan, marked_volume
from test_api_sharing import share
from test_api_tokens import create, program
from test_labels import SPACING, add, nifti, owner, scan  # noqa: F401


@pytest.fixture(scope="module")
def running(all_stacks):
    # ingestd looks for work only when it is notified, so every test here also shows that api notifies it.
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge", "ingestd"), extra_env={"DIAPHANE_POLL_MS": "3600000"})
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(autouse=True)
def no_exports(running):
    running.psql("DELETE FROM scan_exports")
    running.wait_until(lambda: files(running) == [], what="the deletion of earlier exports")


def route(scan: str) -> str:  # noqa: F811
    return f"/v1/data-sets/{scan}/export"


def request(who: Person, scan: str, **order: object) -> dict:  # noqa: F811
    """Requests an export and returns it once it is ready or has failed."""
    asked = who.http.post(route(scan), json=order)
    assert asked.status_code == 202, asked.text
    assert asked.json()["state"] == "queued"
    return who.stack.wait_until(lambda: ended(who, scan), what="the export")


def ended(who: Person, scan: str) -> dict | None:  # noqa: F811
    state = who.http.get(route(scan)).json()
    return None if state["state"] == "queued" else state


def download(who: Person, scan: str, name: str, into: Path) -> Path:  # noqa: F811
    answer = who.http.get(route(scan) + "/file")
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-disposition"] == f'attachment; filename="{name}"'
    assert answer.headers["cache-control"] == "no-store"
    file = into / name
    file.write_bytes(answer.content)
    return file


def files(stack) -> list[str]:
    folder = stack.data_dir / "cache" / "exports"
    return sorted(file.name for file in folder.iterdir()) if folder.exists() else []


def test_nifti_has_every_voxel_and_its_place(running, owner, scan, tmp_path):  # noqa: F811
    made = request(owner, scan, format="nifti")
    assert (made["state"], made["problem"], made["label"], made["above"]) == ("ready", None, None, None)
    file = download(owner, scan, "scan.nii.gz", tmp_path)
    assert file.stat().st_size == made["bytes"]
    image = nibabel.load(file)
    voxels, _ = marked_volume()
    assert np.asarray(image.dataobj).astype("<i2").tobytes(order="F") == voxels.tobytes()
    assert np.array_equal(image.affine, np.diag([-SPACING, -SPACING, SPACING, 1]))
    # What names a scan is not in the file: the title, the IDs, or a date.
    header = gzip.decompress(file.read_bytes())[:352]
    assert scan.encode() not in header and header[148:228] == bytes(80) and header[228:252] == bytes(24)
    actions = [row[0] for row in running.psql("SELECT action FROM audit_log WHERE subject_id = %s AND actor_id = %s ORDER BY id", scan, owner.id)]
    assert actions[-2:] == ["data-set.export-asked", "data-set.export-downloaded"]


@pytest.mark.parametrize("kind", ["stl", "glb"])
def test_a_surface_of_a_label_is_closed(running, owner, scan, tmp_path, kind):  # noqa: F811
    add(owner, scan, nifti((5, 7)))
    assert request(owner, scan, format=kind, label=7)["state"] == "ready"
    mesh = trimesh.load(download(owner, scan, f"surface.{kind}", tmp_path), force="mesh")
    assert mesh.is_watertight
    # The label is a layer of 4 slices. Smoothing rounds its edges by less than half a voxel.
    unit = 1 if kind == "stl" else 0.001
    sides = np.sort(mesh.extents) / unit / SPACING
    assert np.abs(sides - (4, SIDE, SIDE)).max() < 0.5


def test_a_surface_of_a_threshold_is_closed_and_in_its_place(running, owner, scan, tmp_path):  # noqa: F811
    assert request(owner, scan, format="stl", above=1000)["state"] == "ready"
    mesh = trimesh.load(download(owner, scan, "surface.stl", tmp_path), force="mesh")
    assert mesh.is_watertight
    # The values from 1000 are in the voxels 8 to 23 along x and y, and 20 to 27 along z. The surface passes between two centres.
    low, high = np.array((7, 7, 19)) * SPACING, np.array((24, 24, 28)) * SPACING
    assert (mesh.bounds[0] > low).all() and (mesh.bounds[0] < low + SPACING).all()
    assert (mesh.bounds[1] < high).all() and (mesh.bounds[1] > high - SPACING).all()


def test_an_impossible_export_gives_its_reason(running, owner, scan):  # noqa: F811
    for order, code in (({"label": 77}, "nothing_inside"), ({"above": 32767}, "nothing_inside")):
        made = request(owner, scan, format="stl", **order)
        assert (made["state"], made["problem"]["code"], made["bytes"]) == ("failed", code, None)
        problem(owner.http.get(route(scan) + "/file"), 409, "not-ready")
    # A failed export makes room for the next one at once.
    assert request(owner, scan, format="nifti")["state"] == "ready"


def test_invalid_orders_are_refused(running, owner, scan):  # noqa: F811
    for order, field in (({"format": "obj"}, "format"), ({}, "format"), ({"format": "stl"}, "label"),
                         ({"format": "stl", "label": 1, "above": 1}, "label"), ({"format": "nifti", "label": 1}, "label"),
                         ({"format": "nifti", "above": 1}, "above"), ({"format": "stl", "above": 40000}, "above"),
                         ({"format": "stl", "label": 0}, "label"), ({"format": "stl", "above": 1, "deep": 1}, "deep")):
        answer = owner.http.post(route(scan), json=order)
        problem(answer, 422, "invalid")
        assert field in {wrong["field"] for wrong in answer.json()["errors"]}, order
    problem(owner.http.get(route(scan)), 404, "not-found")


def test_ingestd_is_notified_of_an_alignment(running, owner, scan):  # noqa: F811
    second, _ = marked_scan(running, owner)
    assert owner.http.put(f"/v1/data-sets/{scan}/alignments/{second}").status_code in (200, 201, 202)
    running.wait_until(lambda: running.psql("SELECT 1 FROM alignments WHERE state IN ('ready', 'failed')"), what="the end of the alignment")


def test_only_the_owner_gets_exports(running, owner, scan):  # noqa: F811
    """Not even with every permission, because that is for slices and videos."""
    friend, stranger = person(running), person(running)
    share(owner, scan, friend.email)
    [shared] = owner.http.get(f"/v1/data-sets/{scan}/people").json()["items"]
    assert owner.http.patch(f"/v1/data-sets/{scan}/people/{shared['id']}", json={"slices": True, "downloads": True}).status_code == 204
    assert request(owner, scan, format="nifti")["state"] == "ready"
    for who, status, kind in ((friend, 403, "forbidden"), (stranger, 404, "not-found"), (client(running), 401, "unauthenticated")):
        http = getattr(who, "http", who)
        problem(http.post(route(scan), json={"format": "nifti"}), status, kind)
        problem(http.get(route(scan)), status, kind)
        problem(http.get(route(scan) + "/file"), status, kind)
        problem(http.delete(route(scan)), status, kind)
    [name] = files(running)
    for who in (friend, owner, stranger):
        assert who.http.get(f"/_cache/exports/{name}").status_code == 404, "nobody gets at it but by the route"


def test_the_audit_log_has_each_format(running, owner, scan, tmp_path):  # noqa: F811
    request(owner, scan, format="nifti")
    download(owner, scan, "scan.nii.gz", tmp_path)
    request(owner, scan, format="stl", above=1000)
    download(owner, scan, "surface.stl", tmp_path)
    noted = running.psql("SELECT details->>'format' FROM audit_log WHERE subject_id = %s AND action = 'data-set.export-downloaded' ORDER BY id", scan)
    assert noted[-2:] == [("nifti",), ("stl",)]


def test_an_export_without_room_keeps_the_old_one(running, owner, scan):  # noqa: F811
    request(owner, scan, format="nifti")
    before = files(running)
    # Room is reserved for one surface, which together with these exceeds the limit of 20 GiB by a byte.
    running.psql("""INSERT INTO scan_exports (id, user_id, data_set_id, format, state, bytes, created_at, expires_at)
                    SELECT gen_random_uuid(), %s, id, 'nifti', 'ready', %s - COALESCE(volume_bytes, 0), now(), now() + interval '1 day'
                      FROM data_sets WHERE id = %s""", person(running).id, (20480 - 64) * 2**20 + 1, scan)
    problem(owner.http.post(route(scan), json={"format": "stl", "above": 1000}), 507, "storage-full")
    assert owner.http.get(route(scan)).json()["state"] == "ready" and files(running) == before
    running.psql("UPDATE scan_exports SET bytes = bytes - 1 WHERE user_id <> %s", owner.id)
    assert request(owner, scan, format="stl", above=1000)["state"] == "ready"


def test_any_change_of_the_scan_ends_its_export(running, owner):  # noqa: F811
    """Even one by an api that does not know of exports, and while the export is being made."""
    data_set, _ = marked_scan(running, owner)
    assert owner.http.post(route(data_set), json={"format": "nifti"}).status_code == 202
    running.psql("UPDATE data_sets SET state = 'queued' WHERE id = %s", data_set)
    assert running.psql("SELECT count(*) FROM scan_exports WHERE data_set_id = %s", data_set) == [(0,)]
    running.psql("UPDATE data_sets SET state = 'ready' WHERE id = %s", data_set)
    problem(owner.http.get(route(data_set)), 404, "not-found")
    running.wait_until(lambda: files(running) == [], what="the deletion")


def test_a_guest_with_a_link_cannot_export(running, owner, scan):  # noqa: F811
    """A guest has no account that could hold a file, even if the link allows downloads."""
    link = owner.http.post(f"/v1/data-sets/{scan}/links", json={"hours": 1, "slices": True, "downloads": True}).json()
    guest = client(running)
    assert guest.post("/v1/follow", json={"token": link["token"]}).status_code == 200
    problem(guest.post(route(scan), json={"format": "nifti"}), 401, "unauthenticated")
    problem(guest.get(route(scan) + "/file"), 401, "unauthenticated")


def test_a_token_needs_the_scope_read(running, owner, scan):  # noqa: F811
    reader = program(running, create(owner, "read")["token"])
    assert reader.post(route(scan), json={"format": "nifti"}).status_code == 202
    running.wait_until(lambda: reader.get(route(scan)).json()["state"] == "ready", what="the export")
    assert len(reader.get(route(scan) + "/file").content) == reader.get(route(scan)).json()["bytes"]
    other = program(running, create(owner, "write", "share")["token"])
    problem(other.post(route(scan), json={"format": "nifti"}), 403, "forbidden")
    problem(other.get(route(scan) + "/file"), 403, "forbidden")
    assert reader.delete(route(scan)).status_code == 204


def test_a_person_has_one_export_at_a_time(running, owner, scan):  # noqa: F811
    first = request(owner, scan, format="nifti")
    assert first["state"] == "ready"
    [before] = files(running)
    assert request(owner, scan, format="stl", above=1000)["state"] == "ready"
    running.wait_until(lambda: before not in files(running), what="the deletion of the replaced file")
    running.psql("UPDATE scan_exports SET state = 'queued', not_before = now() + interval '1 hour' WHERE data_set_id = %s", scan)
    problem(owner.http.post(route(scan), json={"format": "nifti"}), 429, "too-many")
    assert owner.http.delete(route(scan)).status_code == 204
    problem(owner.http.delete(route(scan)), 404, "not-found")
    running.wait_until(lambda: files(running) == [], what="the deletion")


def test_an_export_ends_with_its_day_its_scan_and_its_account(running, tmp_path):
    one = person(running)
    for end in ("expiry", "scan", "account"):
        data_set, _ = marked_scan(running, one)
        assert request(one, data_set, format="nifti")["state"] == "ready"
        [name] = files(running)
        if end == "expiry":
            running.psql("UPDATE scan_exports SET expires_at = now() - interval '1 second' WHERE user_id = %s", one.id)
            problem(one.http.get(route(data_set) + "/file"), 404, "not-found")
        elif end == "scan":
            assert one.http.delete(f"/v1/data-sets/{data_set}").status_code == 204
        else:
            assert one.http.post("/v1/me/deletion", json={"password": PASSWORD}).status_code == 204
        running.wait_until(lambda: name not in files(running), what=f"the deletion after the end by {end}")
    assert running.psql("SELECT count(*) FROM scan_exports") == [(0,)]


def test_an_export_never_has_what_anonymising_removed(running, owner, tmp_path):  # noqa: F811
    data_set, content = marked_scan(running, owner)
    assert request(owner, data_set, format="nifti")["state"] == "ready"
    assert MARK.tobytes() in gzip.decompress(download(owner, data_set, "scan.nii.gz", tmp_path).read_bytes())
    [name] = files(running)
    cut = owner.http.post(f"/v1/data-sets/{data_set}/anonymise", json={"keep": KEEP, "volume_hash": content, "confirm": "this cannot be undone"})
    assert cut.status_code == 202, cut.text
    problem(owner.http.get(route(data_set)), 404, "not-found")
    running.wait_until(lambda: name not in files(running), what="the deletion")
    running.wait_until(lambda: owner.http.get(f"/v1/data-sets/{data_set}").json()["state"] == "ready", what="the cut")
    assert request(owner, data_set, format="nifti")["state"] == "ready"
    assert MARK.tobytes() not in gzip.decompress(download(owner, data_set, "scan.nii.gz", tmp_path).read_bytes())


def test_an_export_of_a_worker_that_ended_is_made_by_the_next(running, owner, scan):  # noqa: F811
    """A worker that ends while it makes an export leaves it to the next one."""
    assert owner.http.post(route(scan), json={"format": "nifti"}).status_code == 202
    running.psql("UPDATE scan_exports SET state = 'queued', leased_by = 'a worker that ended', leased_until = now() - interval '1 s' WHERE user_id = %s", owner.id)
    made = running.wait_until(lambda: ended(owner, scan), what="the export")
    assert made["state"] == "ready"
