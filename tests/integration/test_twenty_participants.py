"""A live session with twenty followers, each behind a slow line: everything that the presenter shows reaches all of them within
a second."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field

import pytest

from slow_network import SlowNetwork
from stream_helpers import ClientMessage, Viewer
from test_guest_slices import set_guest_slices
from test_live_sessions import Guest, link_of

FOLLOWERS = 20
ROUND_TRIP_S, BITS_PER_S, BUFFER = 0.1, 2e6, 32 << 10
AXIAL, FOUR, TEXT = 1, 1, 3
SECONDS, PER_SECOND = 8, 8


@dataclass
class Follower:
    viewer: Viewer
    sent: dict[int, float]
    #: By kind: how old the newest state was when it came, in seconds.
    ages: dict[str, list[float]] = field(default_factory=lambda: {"view": [], "pointer": [], "marks": [], "slice": []})
    last: dict[str, int] = field(default_factory=dict)
    asked: dict[int, int] = field(default_factory=dict)
    taken: int = 0

    def note(self, kind: str, number: int) -> None:
        if number in self.sent:
            self.ages[kind].append(time.monotonic() - self.sent[number])
            self.last[kind] = number

    def follow(self, end: threading.Event) -> None:
        while not end.is_set():
            try:
                message = self.viewer.receive(0.2)
            except TimeoutError:
                continue
            if message.WhichOneof("body") == "shared":
                self.take(message.shared)
            elif message.WhichOneof("body") == "slice" and message.slice.index in self.asked:
                self.note("slice", self.asked[message.slice.index])
                self.ask(message.slice.seq, None)

    def take(self, shared) -> None:
        answer = ClientMessage()
        answer.shared_taken.seq = shared.seq
        self.viewer.send(answer)
        if shared.HasField("slice_view"):
            number = round(shared.slice_view.window_width)
            self.note("view", number)
            self.ask(0, number)
        for pointer in shared.pointers:
            self.note("pointer", round(pointer.x * 10))
        for of in shared.marks:
            self.note("marks", int(of.marks.items[0].text))

    def ask(self, taken: int, number: int | None) -> None:
        """Asks for the slice that the presenter sees now, or only acknowledges one."""
        message = ClientMessage()
        message.slices.taken = self.taken = max(taken, self.taken)
        if number is not None:
            self.asked[number % 48] = number
            message.slices.slices.add(plane=AXIAL, index=number % 48)
        self.viewer.send(message)


def show(owner: Viewer, number: int) -> None:
    """Moves the slices, the pointer and a mark. Each carries the number."""
    view, pointer, marks = ClientMessage(), ClientMessage(), ClientMessage()
    view.slice_view.layout, view.slice_view.window_width = FOUR, number
    view.slice_view.crosshair.z = (number % 48 - 23.5) * 2  # mm
    pointer.pointer.slice.plane, pointer.pointer.slice.place.x = AXIAL, number / 10
    marks.marks.items.add(id=1, kind=TEXT, text=str(number)).place.x = number / 10
    for message in (view, pointer, marks):
        owner.send(message)


@pytest.mark.nightly
def test_twenty_followers_behind_slow_lines_see_everything_within_a_second(running, one, session):
    owner = Viewer(running.url, session[1])
    set_guest_slices(owner, True)
    token = link_of(one, session[0])
    sent: dict[int, float] = {}
    end = threading.Event()
    with SlowNetwork(running.ports["edge"], ROUND_TRIP_S, BITS_PER_S, BUFFER) as network:
        followers = []
        for i in range(FOLLOWERS):
            answer = Guest(running, token, f"Follower {i}").ask()
            assert answer.status_code == 201, answer.text
            followers.append(Follower(Viewer(running.url, answer.json()["stream_url"], port=network.port), sent))
        owner.until("audience", condition=lambda who: len(who.participants) == FOLLOWERS + 1)
        threads = [threading.Thread(target=each.follow, args=(end,)) for each in followers]
        for thread in threads:
            thread.start()
        reading = threading.Thread(target=Follower(owner, {}).follow, args=(end,))
        reading.start()
        for number in range(1, SECONDS * PER_SECOND + 1):
            sent[number] = time.monotonic()
            show(owner, number)
            time.sleep(1 / PER_SECOND)
        last = SECONDS * PER_SECOND
        running.wait_until(lambda: all(each.last.get(kind) == last for each in followers for kind in each.ages), what="the last state at every follower")
        end.set()
        for thread in [*threads, reading]:
            thread.join()
        for each in followers:
            each.viewer.leave()
    owner.leave()
    ages = {kind: sorted(age for each in followers for age in each.ages[kind]) for kind in followers[0].ages}
    for kind, of in ages.items():
        print(f"{kind}: {len(of)} states, p50 {1e3 * of[len(of) // 2]:.0f} ms, p95 {1e3 * of[int(0.95 * len(of))]:.0f} ms, the oldest {1e3 * of[-1]:.0f} ms")
    assert all(of[-1] < 1 for of in ages.values()), {kind: of[-1] for kind, of in ages.items()}
