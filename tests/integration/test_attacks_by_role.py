"""The attacks of edge_attacks.py on every route in every role, with authorised requests: none exceeds the role's rights. These
tests send some in each cell. All of them: `./diaphane bench edge-attacks`."""

from __future__ import annotations

from collections import Counter

import pytest
from api_client import person
from attack_plan import Cell, Tally, all_of_them, cells, fault_of, printed, routes, some_of, table
from attack_run import Sent, changes, run, state_of
from edge_attacks import Attack, Request, attacks_on
from edge_helpers import Undisturbed, talk
from access_matrix import OPERATIONS
from access_matrix_fixture import ROLES

#: Attacks per cell, besides the request itself, and headers and a body at one byte per second.
EACH = 4
#: Routes that get the whole list: with and without a body, a page, the stream.
WHOLE = ("getMe", "describeDataSet", "/", "stream")


@pytest.fixture(scope="module")
def attacked(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "gateway", "edge"))
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def somebody(attacked):
    return person(attacked)


@pytest.fixture
def ordinary(attacked, somebody):
    """A user who works meanwhile. Afterwards, every response was right, and the programs are the same and no larger."""
    watched = Undisturbed(attacked, somebody)
    yield
    assert watched.faults() == []
    one = watched.ordinary
    print(f"ordinary client: {3 * len(one.seconds)} answers, p99 {one.p99() * 1000:.1f} ms; api {watched.grown_mb:+.1f} MB, edge {watched.edge_mb:.1f} MB")


@pytest.mark.nightly
def test_every_route_and_role_withstands_a_sample_of_each_attack(attacked, ordinary):
    chosen = cells(routes())
    found = run(attacked, chosen, some_of(EACH), renew=False)
    print(printed(table(found.tallies)))
    assert found.misses == []
    assert set(found.tallies) == set(chosen)
    # Attacks got as far as permitted requests.
    answered = Counter(cell.role for cell, tally in found.tallies.items() if tally.answered)
    assert all(answered[role] > 20 for role in ("other", "view", "edit", "owner", "administrator")), answered


def test_selected_routes_withstand_every_attack(attacked, ordinary):
    chosen = [one for one in routes() if one.name in WHOLE]
    found = run(attacked, cells(chosen, ("nobody", "owner")), all_of_them, drip_seconds=0, renew=False)
    print(printed(table(found.tallies)))
    assert found.misses == []


@pytest.mark.parametrize("path", [b"/v1/sessions", b"/v1/none"])
def test_a_request_that_bypasses_the_edge_is_detected(attacked, path):
    sent = Sent(attacked)
    assert sent.smuggled() == []
    talk(attacked.ports["api"], b"GET " + path + b" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
    assert len(sent.smuggled()) == 1


def test_changes_by_an_attack_are_detected(attacked, somebody):
    before = state_of(attacked)
    made = somebody.data_set(10)["data_set"]["id"]
    found = changes(before, state_of(attacked))
    assert any(made in one and one.startswith("new: data_sets") for one in found)
    somebody.http.delete(f"/v1/data-sets/{made}")


# The plan itself

def test_the_attack_plan_covers_all_operations_the_stream_and_the_pages():
    assert {one.name for one in routes()} > {*OPERATIONS, "stream", "/", "/scans"}
    assert {one.role for one in cells(routes())} == set(ROLES)


def test_the_samples_cover_every_attack_together():
    """Over all cells, every attack occurs, and in every role every kind does."""
    one = Request(b"PATCH", b"/v1/x", ((b"Cookie", b"a" * 64), (b"X-CSRF-Token", b"b" * 64)), b"{}")
    listed = attacks_on(one)
    assert len({(attack.kind, attack.name) for attack in listed}) == len(listed), "names tell them apart"
    chosen = cells(routes())
    seen: set[str] = set()
    kinds: dict[str, set[str]] = {}
    for number, cell in enumerate(chosen):
        for attack in some_of(EACH)(number, listed):
            seen.add(attack.name)
            kinds.setdefault(cell.role, set()).add(attack.kind)
    assert seen == {attack.name for attack in listed}
    assert all(kinds[role] == {attack.kind for attack in listed} for role in ROLES)


ROUTE = next(one for one in routes() if one.name == "deleteDataSet")
BAD, ODD = Attack("", "", b"", refused=True), Attack("", "", b"")


@pytest.mark.parametrize(("role", "attack", "statuses", "well"), [
    ("owner", BAD, [400], True), ("owner", BAD, [204], False), ("owner", BAD, [404], False), ("owner", BAD, [], False),
    ("owner", ODD, [204], True), ("view", ODD, [204], False), ("view", ODD, [403], True), ("view", ODD, [500], False),
    ("owner", ODD, [204, 401], False), ("owner", ODD, [502], False),
])
def test_responses_are_judged_by_role_and_attack(role, attack, statuses, well):
    assert (fault_of(Cell(ROUTE, role), attack, statuses) == "") == well


def test_the_result_table_adds_up():
    tallies = {Cell(ROUTE, "owner"): Tally(5, 3, 2, 0, ["x"])}
    assert table(tallies) == [{"group": "data-sets", "routes": 1, "role": "owner", "sent": 5, "refused": 3, "answered": 2, "closed": 0, "misses": 1}]
