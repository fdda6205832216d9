"""What guests, visitors and others receive of a scan: the clipped picture, and slices and files only if the owner allows them."""

from __future__ import annotations

import hashlib
import json
import secrets
import time

import numpy as np
import pytest
from api_client import client, forget_attempts, person
from stream_helpers import ClientMessage, Viewer, open_session, store_ball
from test_live_sessions import Guest, hand_over, link_of
from test_slices import AXIAL, CORONAL, SAGITTAL, stored, values, wish
from websockets.exceptions import ConnectionClosed

BLANK = -32768
NONE, CLIPPED, WHOLE, SHOWN = 0, 1, 2, 3
FOUR = 1  # SliceView.Layout
SIZE, SPACING = 48, 2.0


def textured(running, data_set: str) -> np.ndarray:
    """Returns the scan's voxels, each with a value that identifies its position (z, y, x)."""
    folder = running.data_dir / "volumes" / data_set
    return stored(folder)


@pytest.fixture(scope="module")
def scan(running, one) -> str:
    """A scan whose voxels are distinguishable, so that leaked ones are recognised."""
    data_set = store_ball(running, one)
    folder = running.data_dir / "volumes" / data_set
    z, y, x = np.mgrid[:SIZE, :SIZE, :SIZE]
    ball = np.hypot(np.hypot(x - 23.5, y - 23.5), z - 23.5) < 0.35 * SIZE
    voxels = np.where(ball, 1000, -900) + (x * 7 + y * 13 + z * 31) % 97
    (folder / "voxels.i16").write_bytes(voxels.astype("<i2").tobytes())

    header = json.loads((folder / "volume.json").read_text())
    header["minimum"], header["maximum"] = int(voxels.min()), int(voxels.max())
    header["contentHash"] = "blake2b:" + hashlib.blake2b(voxels.astype("<i2").tobytes(), digest_size=32).hexdigest()
    (folder / "volume.json").write_text(json.dumps(header))
    return data_set


def clip_to_box(viewer: Viewer, low: float = -3, high: float = 3, plane: tuple | None = None) -> int:
    """The presenter clips everything but a box of 6 mm."""
    message = ClientMessage()
    viewer.input_seq += 1
    message.scene.input_seq = viewer.input_seq
    message.scene.scene.CopyFrom(viewer.config.scene)
    clip = message.scene.scene.clip
    clip.Clear()
    for axis in "xyz":
        setattr(clip.box_low, axis, low)
        setattr(clip.box_high, axis, high)
    if plane:
        cut = clip.planes.add()
        cut.point.x, cut.point.y, cut.point.z = plane[0]
        cut.normal.x, cut.normal.y, cut.normal.z = plane[1]
    viewer.config.scene.CopyFrom(message.scene.scene)
    viewer.send(message)
    viewer.frame(condition=lambda frame: frame.input_seq >= viewer.input_seq)
    return viewer.input_seq


def inside(low: float = -3, high: float = 3, plane: tuple | None = None) -> np.ndarray:
    """Returns which voxels' centres lie inside the clip (z, y, x), as scene.proto defines it."""
    mm = (np.arange(SIZE) - (SIZE - 1) / 2) * SPACING
    z, y, x = np.meshgrid(mm, mm, mm, indexing="ij")
    kept = np.ones((SIZE,) * 3, bool)
    for axis in (x, y, z):
        kept &= (axis >= low) & (axis <= high)
    if plane:
        (px, py, pz), (nx, ny, nz) = plane
        kept &= (x - px) * nx + (y - py) * ny + (z - pz) * nz <= 0
    return kept


def of_slice(voxels: np.ndarray, piece) -> np.ndarray:
    """Returns the voxels of a slice in radiological orientation."""
    if piece.plane == AXIAL:
        return voxels[piece.index]
    return voxels[::-1, piece.index, :] if piece.plane == CORONAL else voxels[::-1, :, piece.index]


def ask_for_all(viewer: Viewer, plane: int = AXIAL, count: int = 40) -> list:
    """Requests slice after slice, as in the attack. Returns slices and refusals."""
    got, taken = [], 0
    for index in range(count):
        wish(viewer, (plane, index), taken=taken)
        while True:
            message = viewer.receive()
            kind = message.WhichOneof("body")
            if kind == "slice":
                got.append(message.slice)
                taken = message.slice.seq
                break
            if kind == "problem":
                got.append(message.problem)
                break
    return got


def is_refused(got: list) -> bool:
    return bool(got) and all(not hasattr(one, "data") and one.code == "forbidden" and one.field == "slices" and not one.fatal for one in got)


def set_guest_slices(viewer: Viewer, on: bool) -> None:
    message = ClientMessage()
    message.guest_slices.on = on
    viewer.send(message)


def show_slices(viewer: Viewer, on: bool = True, axial: int = 24) -> None:
    message = ClientMessage()
    message.slice_view.layout = FOUR if on else 0
    message.slice_view.crosshair.x = message.slice_view.crosshair.y = 0.5 * SPACING
    message.slice_view.crosshair.z = (axial - (SIZE - 1) / 2) * SPACING
    viewer.send(message)


def asks_for_file(viewer: Viewer) -> bool:
    """Requests a small picture as a file. Returns whether the viewer gets it."""
    view, order = ClientMessage(), ClientMessage()
    view.key_view.scene.CopyFrom(viewer.config.scene)
    order.file.picture.width = order.file.picture.height = 64
    order.file.picture.error = 1
    for message in (view, order):
        viewer.send(message)
    refused = 0
    while refused < 2:
        answer = viewer.receive()
        if answer.WhichOneof("body") in ("file_progress", "file_part"):
            return True
        if answer.WhichOneof("body") == "problem":
            assert (answer.problem.code, answer.problem.field, answer.problem.fatal) == ("forbidden", "file", False)
            refused += 1
    return False


def visitor(running, **what: str) -> Viewer:
    """A visitor keeps a slot for a while after leaving. This one comes back, like a page."""
    key = secrets.token_hex(32)

    def look() -> Viewer | None:
        forget_attempts(running)    # each refusal for lack of a place counts as one more attempt of this address
        answer = client(running).post("/v1/visits", json={"key": key, **what})
        assert answer.status_code in (201, 503), answer.text
        try:
            return Viewer(running.url, answer.json()["stream_url"]) if answer.status_code == 201 else None
        except ConnectionClosed:
            return None

    return running.wait_until(look, timeout=60, what="a place for a visitor")


def audience(viewer: Viewer):
    return viewer.until("audience")


def test_a_guest_gets_no_voxel_unless_the_owner_allows_it(running, one, scan):
    session, url = open_session(one, scan)
    owner = Viewer(running.url, url)
    assert audience(owner).slices == WHOLE
    clip_to_box(owner)
    guest = Guest(running, link_of(one, session)).join()
    assert audience(guest).slices == NONE
    for plane in (AXIAL, CORONAL, SAGITTAL):
        assert is_refused(ask_for_all(guest, plane))
    # Nothing else reveals what is clipped.
    config = guest.config
    assert config.volume.content_hash == "" and not config.volume.percentiles and not config.HasField("histogram")
    values_of_points = [point.value for channel in config.scene.transfer_function.channels for point in channel.opacity]
    assert (config.volume.minimum, config.volume.maximum) == (round(min(values_of_points)), round(max(values_of_points)))
    assert owner.config.volume.content_hash and owner.config.HasField("histogram")
    # The owner's own slices are still complete, whatever is clipped in the picture.
    wish(owner, (AXIAL, 7))
    assert np.array_equal(values(owner.until("slice")), textured(running, scan)[7])
    for viewer in (guest, owner):
        viewer.leave()
    one.http.delete(f"/v1/sessions/{session}")


@pytest.mark.parametrize("plane", [None, ((0.3, 0, -0.5), (0.5, -0.8, 0.33))], ids=["box", "box-and-rotated-plane"])
def test_allowed_slices_contain_only_the_inside_of_the_clip(running, one, scan, plane):
    session, url = open_session(one, scan)
    owner = Viewer(running.url, url)
    clip_to_box(owner, plane=plane)
    # A session can have several links. Each has its own permission.
    guest = Guest(running, link_of(one, session)).join()
    wide = Guest(running, link_of(one, session, slices=True)).join()
    assert audience(guest).slices == NONE and is_refused(ask_for_all(guest, AXIAL, 3))
    assert audience(wide).slices == CLIPPED, "at any time, also while the presenter shows none"
    voxels, kept = textured(running, scan), inside(plane=plane)
    assert 0 < kept.sum() <= 27 * 8
    shown = 0
    for across in (AXIAL, CORONAL, SAGITTAL):
        for piece in ask_for_all(wide, across, SIZE):
            expected = np.where(of_slice(kept, piece), of_slice(voxels, piece), BLANK)
            assert np.array_equal(values(piece), expected)
            shown += int((values(piece) != BLANK).sum())
    assert shown == 3 * kept.sum(), "all of what is inside, in each of the three directions"
    wide.leave()
    # By default, guests get only what the presenter shows.
    set_guest_slices(owner, True)
    guest.until("audience", condition=lambda who: who.guest_slices and who.slices == NONE)
    assert is_refused(ask_for_all(guest, AXIAL, 3)), "the presenter shows none"
    show_slices(owner)
    there = guest.until("audience", condition=lambda who: who.slices == SHOWN)
    assert there.guest_slices and not there.sets_guest_slices
    for across in (AXIAL, CORONAL, SAGITTAL):
        for index in [*range(24), *range(25, SIZE), 24]:
            wish(guest, (across, index))
        piece = guest.until("slice")
        assert (piece.plane, piece.index) == (across, 24), "the others are left out"
        assert np.array_equal(values(piece), np.where(of_slice(kept, piece), of_slice(voxels, piece), BLANK))
        wish(guest, taken=piece.seq)
    # When more is visible, the guest is notified and asks again.
    clip_to_box(owner, -10, 10)
    guest.until("slices_stale")
    wish(guest, (AXIAL, 24), taken=2**62)
    piece = guest.until("slice")
    assert np.array_equal(values(piece), np.where(inside(-10, 10)[24], voxels[24], BLANK))
    # They end when the presenter closes them, and when they are switched off.
    show_slices(owner, False)
    guest.until("audience", condition=lambda who: who.slices == NONE)
    assert is_refused(ask_for_all(guest, AXIAL, 3))
    show_slices(owner)
    guest.until("audience", condition=lambda who: who.slices == SHOWN)
    set_guest_slices(owner, False)
    guest.until("audience", condition=lambda who: who.slices == NONE)
    assert is_refused(ask_for_all(guest, AXIAL, 3))
    guest.leave()
    owner.leave()
    one.http.delete(f"/v1/sessions/{session}")


def test_presenting_guests_and_free_cameras_cannot_undo_the_clip(running, one, scan):
    session, url = open_session(one, scan)
    owner = Viewer(running.url, url)
    clip_to_box(owner)
    guest = Guest(running, link_of(one, session))
    follower = guest.join()
    clip = owner.config.scene.clip.SerializeToString(deterministic=True)
    on = ClientMessage()
    on.free_camera.on = True
    follower.send(on)
    mine = follower.until("config", condition=lambda config: not config.follower)
    assert mine.volume.content_hash == "" and not mine.HasField("histogram")
    assert mine.scene.clip.SerializeToString(deterministic=True) == clip
    off = ClientMessage()
    off.free_camera.on = False
    follower.send(off)
    follower.config = follower.until("config", condition=lambda config: config.follower)
    # A presenting guest can change the picture, but not the clip.
    hand_over(owner, guest.id)
    follower.until("audience", condition=lambda who: who.presenter == guest.id)
    follower.config.scene.clip.Clear()
    follower.config.scene.slices.axial.shown = True
    follower.config.scene.slices.window_width = 1
    follower.input_seq = 1000
    seq = follower.turn(20)
    look = owner.until("look", condition=lambda one: one.input_seq == seq)
    assert look.scene.clip.SerializeToString(deterministic=True) == clip
    assert not look.scene.slices.axial.shown
    assert look.scene.camera.eye.x == pytest.approx(follower.config.scene.camera.eye.x)
    assert is_refused(ask_for_all(follower, AXIAL, 3))
    # Nor can they permit slices or make files.
    set_guest_slices(follower, True)
    assert follower.until("problem").field == "guest_slices"
    assert not asks_for_file(follower)
    follower.leave()
    owner.leave()
    one.http.delete(f"/v1/sessions/{session}")


@pytest.mark.parametrize("allowed", [False, True])
def test_link_visitors_get_slices_only_if_the_link_allows_them(running, one, scan, allowed):
    body = {"hours": 1, "slices": True} if allowed else {"hours": 1}
    link = one.http.post(f"/v1/data-sets/{scan}/links", json=body).json()
    assert link["slices"] is allowed
    assert [known["slices"] for known in one.http.get(f"/v1/data-sets/{scan}/links").json()["items"] if known["id"] == link["id"]] == [allowed]
    viewer = visitor(running, token=link["token"])
    assert audience(viewer).slices == (CLIPPED if allowed else NONE)
    assert viewer.config.volume.content_hash == ""
    clip_to_box(viewer)
    got = ask_for_all(viewer)
    if allowed:
        voxels, kept = textured(running, scan), inside()
        for piece in got:
            assert np.array_equal(values(piece), np.where(kept[piece.index], voxels[piece.index], BLANK))
    else:
        assert is_refused(got)
        # Nor as cross-sections in the picture.
        viewer.config.scene.slices.axial.shown = True
        viewer.config.scene.slices.window_width = 1
        viewer.turn(1)
        viewer.leave()
        viewer = visitor(running, token=link["token"])
        assert not viewer.config.scene.slices.axial.shown
    viewer.leave()
    one.http.delete(f"/v1/data-sets/{scan}/links/{link['id']}")


@pytest.mark.parametrize("allowed", [False, True])
def test_link_visitors_get_files_only_if_the_link_allows_them(running, one, scan, allowed):
    link = one.http.post(f"/v1/data-sets/{scan}/links", json={"hours": 1, "downloads": allowed}).json()
    assert (link["slices"], link["downloads"]) == (False, allowed)
    assert [known["downloads"] for known in one.http.get(f"/v1/data-sets/{scan}/links").json()["items"] if known["id"] == link["id"]] == [allowed]
    viewer = visitor(running, token=link["token"])
    rights = audience(viewer)
    assert (rights.slices, rights.downloads) == (NONE, allowed)
    assert asks_for_file(viewer) is allowed
    viewer.leave()
    one.http.delete(f"/v1/data-sets/{scan}/links/{link['id']}")


def test_the_owner_chooses_slices_and_files_for_each_person(running, one, scan):
    friend, other = person(running), person(running)
    path = f"/v1/data-sets/{scan}/people"
    for who, allowed in ((friend, {}), (other, {"slices": False, "downloads": False})):
        assert one.http.post(path, json={"email": who.email, "may": "view", **allowed}).status_code == 204
    people = {each["email"]: each for each in one.http.get(path).json()["items"]}
    assert [(people[who.email]["slices"], people[who.email]["downloads"]) for who in (friend, other)] == [(True, True), (False, False)]

    def viewing(who, slices: int, downloads: bool) -> tuple[Viewer, str]:
        session, url = open_session(who, scan)
        viewer = Viewer(running.url, url)
        rights = audience(viewer)
        assert (rights.slices, rights.downloads) == (slices, downloads)
        assert asks_for_file(viewer) is downloads
        if slices == NONE:
            assert is_refused(ask_for_all(viewer, AXIAL, 3))
        else:
            wish(viewer, (AXIAL, 7))
            assert np.array_equal(values(viewer.until("slice")), textured(running, scan)[7])
        return viewer, session

    first, first_session = viewing(friend, WHOLE, True)
    second, second_session = viewing(other, NONE, False)
    # Removing a permission ends the sessions of this person, and of nobody else.
    of_friend = f"{path}/{people[friend.email]['id']}"
    assert one.http.patch(of_friend, json={"may": "save"}).status_code == 204
    assert friend.http.get(f"/v1/sessions/{first_session}").status_code == 200
    assert one.http.patch(of_friend, json={"slices": False}).status_code == 204
    assert friend.http.get(f"/v1/sessions/{first_session}").status_code == 404
    assert first.close_code() not in (1000, 1006)
    assert other.http.get(f"/v1/sessions/{second_session}").status_code == 200
    third, third_session = viewing(friend, NONE, True)
    # More is allowed from the next visit on.
    assert one.http.patch(f"{path}/{people[other.email]['id']}", json={"downloads": True}).status_code == 204
    second.leave()
    other.http.delete(f"/v1/sessions/{second_session}")
    fourth, fourth_session = viewing(other, NONE, True)
    assert one.http.post(path, json={"email": friend.email, "may": "view", "slices": True, "downloads": False}).status_code == 204
    assert friend.http.get(f"/v1/sessions/{third_session}").status_code == 404
    fifth, fifth_session = viewing(friend, WHOLE, False)
    for viewer in (third, fourth, fifth):
        viewer.leave()
    other.http.delete(f"/v1/sessions/{fourth_session}")
    friend.http.delete(f"/v1/sessions/{fifth_session}")
    for each in people.values():
        assert one.http.delete(f"{path}/{each['id']}").status_code == 204


def test_visitors_of_a_sample_get_slices_inside_the_clip(running, one, scan):
    running.psql("UPDATE data_sets SET is_sample = true, visibility = 'public', published_at = now(), anonymised_at = now() WHERE id = %s", scan)
    try:
        viewer = visitor(running, data_set_id=scan)
        assert audience(viewer).slices == CLIPPED
        assert not asks_for_file(viewer), "only with an account"
        clip_to_box(viewer)
        voxels, kept = textured(running, scan), inside()
        for piece in ask_for_all(viewer):
            assert np.array_equal(values(piece), np.where(kept[piece.index], voxels[piece.index], BLANK))
        viewer.leave()
    finally:
        running.psql("UPDATE data_sets SET is_sample = false, visibility = 'private', published_at = NULL WHERE id = %s", scan)


def test_viewers_of_a_public_scan_get_slices_and_files_while_the_owner_allows_them(running, one, scan):
    running.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", scan)
    path = f"/v1/data-sets/{scan}/visibility"
    assert one.http.post(path, json={"visibility": "public"}).json()["public_slices"] is False
    assert one.http.get(f"/v1/data-sets/{scan}").json()["public_downloads"] is False
    other = person(running)
    session, url = open_session(other, scan)
    viewer = Viewer(running.url, url)
    assert audience(viewer).slices == NONE and is_refused(ask_for_all(viewer, AXIAL, 3))
    assert not asks_for_file(viewer)
    viewer.leave()
    other.http.delete(f"/v1/sessions/{session}")
    # Files without slices, and the other way round.
    assert one.http.post(path, json={"visibility": "public", "downloads": True}).json()["public_downloads"] is True
    session, url = open_session(other, scan)
    viewer = Viewer(running.url, url)
    rights = audience(viewer)
    assert (rights.slices, rights.downloads) == (NONE, True) and asks_for_file(viewer)
    assert one.http.post(path, json={"visibility": "public", "slices": True}).json()["public_slices"] is True
    assert other.http.get(f"/v1/sessions/{session}").status_code == 404, "the files are withdrawn"
    viewer.leave()
    session, url = open_session(other, scan)
    mine, mine_url = open_session(one, scan)
    viewer = Viewer(running.url, url)
    assert audience(viewer).slices == WHOLE
    wish(viewer, (AXIAL, 7))
    assert np.array_equal(values(viewer.until("slice")), textured(running, scan)[7])
    # When this is revoked, only sessions of users who had slices end.
    assert one.http.post(path, json={"visibility": "public"}).json()["public_slices"] is False
    assert other.http.get(f"/v1/sessions/{session}").status_code == 404
    assert one.http.get(f"/v1/sessions/{mine}").status_code == 200
    assert viewer.close_code() not in (1000, 1006)
    one.http.post(path, json={"visibility": "private"})
    one.http.delete(f"/v1/sessions/{mine}")


def test_slices_per_second_are_limited(running, one, scan):
    session, url = open_session(one, scan)
    viewer = Viewer(running.url, url)

    begun, got, taken = time.monotonic(), 0, 0
    while (seconds := time.monotonic() - begun) < 4:
        wish(viewer, (AXIAL, got % SIZE), taken=taken)
        piece = viewer.until("slice")
        taken, got = piece.seq, got + 1
    assert got <= 120 + 120 * (seconds + 1), "a burst of 120, and 120 per second"
    viewer.leave()
    one.http.delete(f"/v1/sessions/{session}")
