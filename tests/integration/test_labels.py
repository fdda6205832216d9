"""Labels of a scan, from their upload to the worker: who may add them, what they cost, and where they are afterwards."""

from __future__ import annotations

import gzip
import io
import json
import struct
import tarfile

import numpy
import pytest
from api_client import Person, person, problem
from cut_helpers import SIDE, marked_scan
from stream_helpers import ClientMessage, Viewer, open_session
from test_live_sessions import Guest, link_of

SPACING = 2.0


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "gateway", "edge", "ingestd", "renderd"))
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def owner(running):
    return person(running)


@pytest.fixture
def scan(running, owner) -> str:
    """Returns a ready scan that says where it lies: its first voxel is at the origin."""
    data_set, _ = marked_scan(running, owner)
    file = running.data_dir / "volumes" / data_set / "volume.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"origin": [0.0, 0.0, 0.0]}))
    # As large as it is stored, because labels count in addition.
    running.psql("UPDATE data_sets SET volume_bytes = %s, size_x = %s, size_y = %s, size_z = %s WHERE id = %s",
                 2 * SIDE**3, SIDE, SIDE, SIDE, data_set)
    return data_set


def nifti(numbers: tuple[int, ...] = (5,), origin: float = 0.0) -> bytes:
    """Layers of labels with these numbers over the whole scan."""
    values = numpy.zeros((SIDE, SIDE, SIDE), numpy.uint8)
    for i, number in enumerate(numbers):
        values[:, :, 4 * i:4 * i + 4] = number
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, SIDE, SIDE, SIDE, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 2, 8)
    struct.pack_into("<4f", header, 76, 1, SPACING, SPACING, SPACING)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, -SPACING, 0, 0, origin, 0, -SPACING, 0, origin, 0, 0, SPACING, origin)
    header[344:347] = b"n+1"
    return gzip.compress(bytes(header) + values.tobytes(order="F"))


def bundle(file: bytes) -> bytes:
    """The archive that a page uploads."""
    archive = io.BytesIO()
    with tarfile.open(fileobj=archive, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        entry = tarfile.TarInfo("00001.dcm")
        entry.size = len(file)
        tar.addfile(entry, io.BytesIO(file))
    return archive.getvalue()


def announce(owner: Person, scan: str, size: int):
    return owner.http.post(f"/v1/data-sets/{scan}/labels", json={"bytes": size})


def add(owner: Person, scan: str, file: bytes) -> dict:
    """Uploads a file of labels and returns the labels of the scan after the server has read it."""
    data = bundle(file)
    made = announce(owner, scan, len(data))
    assert made.status_code == 201, made.text
    assert owner.patch(made.json()["upload_url"], 0, data).status_code == 204
    return owner.stack.wait_until(lambda: read(owner, scan), what="the labels")


def read(owner: Person, scan: str) -> dict | None:
    """Returns the labels of a scan unless the server still reads them. The scan is ready all the time."""
    data_set = owner.http.get(f"/v1/data-sets/{scan}").json()
    assert data_set["state"] == "ready"
    labels = data_set["labels"]
    return None if labels["placing"] or labels["upload"] else labels


def used(owner: Person) -> int:
    return owner.http.get("/v1/me").json()["quota"]["used_bytes"]


def files(running, scan: str) -> set[str]:
    return {file.name for file in (running.data_dir / "volumes" / scan).iterdir()}


def test_labels_are_stored_counted_replaced_and_removed(running, owner, scan):
    before = used(owner)
    labels = add(owner, scan, nifti((5, 7)))
    assert (labels["count"], labels["refusal"]) == (2, None)
    stored = running.data_dir / "volumes" / scan / "label_set"
    assert labels["bytes"] == stored.stat().st_size == used(owner) - before
    assert add(owner, scan, nifti((9,)))["count"] == 1
    assert stored.stat().st_size == used(owner) - before
    assert owner.http.delete(f"/v1/data-sets/{scan}/labels").status_code == 204
    assert read(owner, scan) == {"count": 0, "bytes": 0, "placing": False, "upload": None, "refusal": None}
    assert "label_set" not in files(running, scan) and used(owner) == before
    running.wait_until(lambda: not list((running.data_dir / "uploads").iterdir()), what="the uploads to go")
    actions = [row[0] for row in running.psql("SELECT action FROM audit_log WHERE subject_id = %s ORDER BY id", scan)]
    assert actions.count("data-set.labels-added") == 2 and actions[-1] == "data-set.labels-removed"


def test_refused_labels_leave_earlier_ones(running, owner, scan):
    add(owner, scan, nifti((5,)))
    for file, code in ((nifti((5,), origin=5000.0), "labels_other_scan"), (b"no labels at all", "labels_unsupported"),
                       (nifti()[:60], "labels_damaged")):
        labels = add(owner, scan, file)
        assert (labels["count"], labels["refusal"]["code"]) == (1, code)
    assert add(owner, scan, nifti((5,)))["refusal"] is None


def test_a_scan_that_does_not_say_where_it_lies_takes_labels_on_its_own_grid(running, owner, scan):
    file = running.data_dir / "volumes" / scan / "volume.json"
    header = json.loads(file.read_text())
    del header["origin"]
    file.write_text(json.dumps(header))
    assert add(owner, scan, nifti((5,), origin=5000.0))["count"] == 1


def test_only_the_owner_adds_and_sees_labels(running, owner, scan):
    add(owner, scan, nifti((5,)))
    friend, stranger = person(running), person(running)
    shared = owner.http.post(f"/v1/data-sets/{scan}/people", json={"email": friend.email, "may": "save"})
    assert shared.status_code == 204
    assert friend.http.get(f"/v1/data-sets/{scan}").json()["labels"] is None
    for who, status, kind in ((friend, 403, "forbidden"), (stranger, 404, "not-found")):
        problem(announce(who, scan, 10), status, kind)
        problem(who.http.delete(f"/v1/data-sets/{scan}/labels"), status, kind)
    upload = announce(owner, scan, 10).json()["upload_url"]
    for who in (friend, stranger):
        problem(who.patch(upload, 0, b"0123456789"), 404, "not-found")
    assert read(owner, scan) is None


def test_an_upload_of_labels_counts_and_can_be_given_up(running, owner, scan):
    before = used(owner)
    upload = announce(owner, scan, 1000).json()["upload_url"]
    assert owner.patch(upload, 0, b"x" * 600).status_code == 204
    assert owner.offset(upload) == 600 and used(owner) == before + 1000
    again = announce(owner, scan, 500).json()["upload_url"]
    assert again != upload and used(owner) == before + 500
    problem(owner.patch(upload, 600, b"x"), 404, "not-found")
    assert owner.http.delete(again, headers={"Tus-Resumable": "1.0.0"}).status_code == 204
    assert read(owner, scan)["count"] == 0 and used(owner) == before
    problem(announce(owner, scan, 2 << 30), 413, "upload-too-large")
    quota = owner.http.get("/v1/me").json()["quota"]["bytes"]
    running.psql("UPDATE users SET quota_bytes = %s WHERE email = %s", before + 500, owner.email)
    problem(announce(owner, scan, 501), 413, "over-quota")
    running.psql("UPDATE users SET quota_bytes = %s WHERE email = %s", quota, owner.email)
    running.wait_until(lambda: not list((running.data_dir / "uploads").iterdir()), what="the uploads to go")


def test_a_complete_upload_of_labels_cannot_be_given_up(running, owner, scan):
    upload = announce(owner, scan, 1000).json()["upload_url"]
    remove = {"url": upload, "headers": {"Tus-Resumable": "1.0.0"}}
    running.psql("UPDATE uploads SET received = length WHERE data_set_id = %s", scan)
    problem(owner.http.delete(**remove), 409, "upload-complete")
    running.psql("UPDATE uploads SET received = 0 WHERE data_set_id = %s", scan)
    assert owner.http.delete(**remove).status_code == 204


def test_an_upload_of_labels_that_is_abandoned_expires_alone(running, owner, scan):
    announce(owner, scan, 1000)
    running.psql("UPDATE uploads SET expires_at = now() - interval '1 second' WHERE data_set_id = %s", scan)
    running.wait_until(lambda: read(owner, scan), what="the end of the upload")
    assert owner.http.get(f"/v1/data-sets/{scan}").json()["state"] == "ready"


def test_labels_go_with_their_scan(running, owner, scan):
    add(owner, scan, nifti((5,)))
    announce(owner, scan, 1000)
    assert owner.http.delete(f"/v1/data-sets/{scan}").status_code == 204
    folder = running.data_dir / "volumes" / scan
    running.wait_until(lambda: not folder.exists() and not list((running.data_dir / "uploads").iterdir()), what="the files to go")


def test_the_worker_reports_labels_as_soon_as_they_are_there(running, owner, scan):
    friend = person(running)
    owner.http.post(f"/v1/data-sets/{scan}/people", json={"email": friend.email, "may": "view"})
    _, url = open_session(owner, scan)
    viewer = Viewer(running.url, url)
    add(owner, scan, nifti((5, 7)))
    labels = viewer.until("labels").labels
    # Layers of four voxels of 8 mm3.
    assert [(one.number, one.volume) for one in labels] == [(5, 4 * 8 * SIDE**2), (7, 4 * 8 * SIDE**2)]
    viewer.frame()
    _, of_friend = open_session(friend, scan)
    theirs = Viewer(running.url, of_friend)
    assert len(theirs.until("labels").labels) == 2, "the scan is shared with them"
    theirs.leave()
    owner.http.delete(f"/v1/data-sets/{scan}/labels")
    assert len(viewer.until("labels").labels) == 0
    viewer.leave()


def kinds_with_depth(viewer: Viewer) -> tuple[set[str], int]:
    """Asks what is above the middle of the picture, where there is bone. Returns the kinds of messages up to the answer, and the label in it."""
    viewer.frame()
    message = ClientMessage()
    message.depth_query.id, message.depth_query.x, message.depth_query.y = 1, 0.5, 0.35
    viewer.send(message)
    kinds = set()
    while "depth" not in kinds:
        answer = viewer.receive()
        kinds.add(answer.WhichOneof("body"))
    return kinds, answer.depth.label


def test_guests_learn_neither_labels_nor_the_place_of_a_scan(running, owner, scan):
    add(owner, scan, nifti((5, 5, 5, 5, 5, 5, 5, 5)))
    session, url = open_session(owner, scan)
    viewer = Viewer(running.url, url)
    assert len(viewer.until("labels").labels) == 1
    assert kinds_with_depth(viewer)[1] == 5, "a positive control"
    guest = Guest(running, link_of(owner, session)).join()
    assert not guest.config.volume.origin and not guest.config.volume.label_hash
    received = {guest.receive().WhichOneof("body") for _ in range(4)}
    kinds, label = kinds_with_depth(guest)
    assert "labels" not in received | kinds and label == 0
    guest.leave()
    viewer.leave()
