"""What the participants of a live session show each other: the presenter's slices and measurements, and pointers."""

from __future__ import annotations

import math

from stream_helpers import ClientMessage, Viewer, open_session
from test_guest_slices import SHOWN, set_guest_slices
from test_live_sessions import Guest, hand_over, link_of

AXIAL, FOUR, ELLIPSE = 1, 1, 3
RADIUS = 0.35 * 48 * 2.0  # mm, of the stored ball


def show_slices(viewer: Viewer, width: float) -> None:
    message = ClientMessage()
    message.slice_view.layout = FOUR
    message.slice_view.crosshair.z = 12.5
    message.slice_view.window_centre, message.slice_view.window_width = 40, width
    viewer.send(message)


def measure(viewer: Viewer) -> None:
    message = ClientMessage()
    item = message.measurements.items.add(kind=ELLIPSE, plane=AXIAL, slice=7)
    item.points.add(x=1)
    item.points.add(y=2)
    viewer.send(message)


def point(viewer: Viewer, x: float = 0.5, y: float = 0.5) -> None:
    message = ClientMessage()
    message.pointer.picture.x, message.pointer.picture.y = x, y
    viewer.send(message)


def shared(viewer: Viewer, condition=lambda _: True):
    """The next state that passes `condition`, acknowledged like every one before it."""

    def passes(state) -> bool:
        message = ClientMessage()
        message.shared_taken.seq = state.seq
        viewer.send(message)
        return condition(state)

    return viewer.until("shared", condition=passes)


def pointer_of(viewer: Viewer, number: int):
    return next(one for one in shared(viewer, lambda state: any(one.number == number for one in state.pointers)).pointers if one.number == number)


def test_followers_with_slices_see_those_of_the_presenter(running, one, session):
    owner = Viewer(running.url, session[1])
    guest = Guest(running, link_of(one, session[0]))
    follower = guest.join()
    owner.until("audience", condition=lambda who: len(who.participants) == 2)
    show_slices(owner, 400)
    measure(owner)
    point(owner)
    # A guest without slices gets the pointer in the picture, and nothing of the slices.
    first = shared(follower)
    assert first.pointers and not first.HasField("slice_view") and not first.HasField("measurements")
    set_guest_slices(owner, True)
    follower.until("audience", condition=lambda who: who.slices == SHOWN)
    seen = shared(follower, lambda state: state.HasField("slice_view"))
    assert (seen.slice_view.layout, seen.slice_view.crosshair.z, seen.slice_view.window_width) == (FOUR, 12.5, 400)
    assert (seen.measurements.items[0].kind, seen.measurements.items[0].slice) == (ELLIPSE, 7)
    # Only the presenter shows slices. After the handover, the owner follows.
    show_slices(follower, 100)
    assert follower.until("problem").field == "slice_view"
    hand_over(owner, guest.id)
    follower.until("audience", condition=lambda who: who.presenter == guest.id)
    show_slices(follower, 100)
    assert shared(owner, lambda state: state.slice_view.window_width == 100)
    follower.leave()
    owner.leave()


def test_a_follower_who_reads_slowly_gets_only_the_newest_slices(running, one, session):
    owner = Viewer(running.url, session[1])
    follower = Guest(running, link_of(one, session[0])).join()
    set_guest_slices(owner, True)
    for width in range(1, 201):
        show_slices(owner, width)
    two = [follower.until("shared") for _ in range(2)]
    assert [state.seq for state in two] == [1, 2] and two[0].slice_view.window_width == 1
    # Nothing more is under way until the follower acknowledges.
    seq = owner.turn(10)
    while (message := follower.receive()).WhichOneof("body") != "frame" or message.frame.input_seq < seq:
        assert message.WhichOneof("body") != "shared"
    message = ClientMessage()
    message.shared_taken.seq = 2
    follower.send(message)
    assert follower.until("shared").slice_view.window_width == 200
    follower.leave()
    owner.leave()


def test_pointers_lie_on_the_surface_for_every_camera(running, one, session):
    owner = Viewer(running.url, session[1])
    guest = Guest(running, link_of(one, session[0]), "Ann")
    follower = guest.join()
    numbers = {one.id: one.number for one in owner.until("audience", condition=lambda who: len(who.participants) == 2).participants}
    owner.frame(), follower.frame()
    point(follower)
    seen = pointer_of(owner, numbers[guest.id])
    assert seen.shown and abs(math.hypot(seen.x, seen.y, seen.z) - RADIUS) < 4
    eye = owner.config.scene.camera.eye
    towards = (seen.x * eye.x + seen.y * eye.y + seen.z * eye.z) / math.hypot(eye.x, eye.y, eye.z)
    assert towards > RADIUS - 4, "the side that faces the presenter's camera"
    # Beside the ball there is no surface, and the pointer disappears.
    point(follower, 0.01, 0.01)
    assert not pointer_of(owner, numbers[guest.id]).shown

    # A follower with a camera of their own points at what they see.
    on = ClientMessage()
    on.free_camera.on = True
    follower.send(on)
    follower.config = follower.until("config", condition=lambda config: not config.follower)
    camera = follower.config.scene.camera
    camera.eye.x, camera.eye.y, camera.eye.z = -eye.x, -eye.y, -eye.z
    follower.input_seq = 1000
    seq = follower.turn(0)
    follower.frame(condition=lambda frame: frame.input_seq >= seq)
    point(follower)
    seen = pointer_of(owner, numbers[guest.id])
    towards = (seen.x * eye.x + seen.y * eye.y + seen.z * eye.z) / math.hypot(eye.x, eye.y, eye.z)
    assert seen.shown and towards < 4 - RADIUS

    # The presenter turns the pointers of guests off.
    off = ClientMessage()
    off.guest_pointers.on = False
    owner.send(off)
    follower.until("audience", condition=lambda who: not who.guest_pointers)
    point(follower)
    assert follower.until("problem").field == "pointer"
    point(owner)
    assert pointer_of(follower, numbers["owner"]).shown
    follower.leave()
    owner.leave()


def test_a_lone_viewer_gets_nothing(running, one, ball):
    session, url = open_session(one, ball)
    owner = Viewer(running.url, url)
    owner.frame()
    show_slices(owner, 400)
    point(owner)
    seq = owner.turn(10)
    while (message := owner.receive()).WhichOneof("body") != "frame" or message.frame.input_seq < seq:
        assert message.WhichOneof("body") not in ("shared", "problem")
    owner.leave()
    one.http.delete(f"/v1/sessions/{session}")
