"""Archives that are unreachable, slow or lying. Whatever they do, the user learns what is wrong, and nothing is kept."""

from __future__ import annotations

import time

import pytest
from api_client import problem
from archives import open_stack, phantom_folder
from canaries import Search
from harness import free_port
from lying_archive import SERIES, STUDY, LyingArchive
from pacs_helpers import fetch_end, fetched, radiologist

#: What a search says, by the lie.
SEARCHES = {"html": "archive-faulty", "broken": "archive-faulty", "object": "archive-faulty", "deep": "archive-faulty", "endless": "archive-faulty",
            "gzip": "archive-faulty", "redirect": "archive-faulty", "error": "archive-faulty", "stall": "archive-unreachable",
            "nowhere": "archive-unreachable", "silent": "archive-unreachable"}
#: Why a fetch fails, by the lie.
FETCHES = {"html": "faulty", "other-series": "faulty", "pictures": "faulty", "noise": "faulty", "bomb": "faulty", "missing": "not-found"}
OTHERS = ("honest", "huge-values", "other-study", "cut-off", "trickle")


@pytest.fixture(scope="module")
def liar(all_stacks):
    with LyingArchive(phantom_folder(all_stacks)) as running:
        yield running


@pytest.fixture(scope="module")
def stack(all_stacks, liar):
    def archive(name: str) -> dict:
        return {"name": name, "title": name, "url": liar.url(name), **({"timeout_seconds": 2} if name == "stall" else {})}

    known = [archive(name) for name in {*SEARCHES, *FETCHES, *OTHERS} - {"nowhere", "silent"}]
    known.append({"name": "nowhere", "title": "-", "url": f"http://127.0.0.1:{free_port()}"})
    known.append({"name": "silent", "title": "-", "host": "127.0.0.1", "port": free_port(), "ae_title": "X"})
    running = open_stack(all_stacks, known)
    yield running
    all_stacks.shut(running)


@pytest.fixture(scope="module")
def doctor(stack):
    return radiologist(stack)


def search(who, archive):
    return who.http.post(f"/v1/archives/{archive}/studies", json={"patient_name": "Phantasia"})


@pytest.mark.parametrize("lie", SEARCHES)
def test_a_search_reports_what_is_wrong(doctor, lie):
    assert "Phantasia" not in str(problem(search(doctor, lie), 502, SEARCHES[lie]))


@pytest.mark.parametrize("lie", FETCHES)
def test_a_fetch_reports_what_is_wrong_and_keeps_nothing(doctor, lie):
    end = fetched(doctor, lie, STUDY, SERIES)
    assert (end["state"], end["problem"], end["data_set_id"]) == ("failed", FETCHES[lie], None)
    assert doctor.http.get("/v1/me").json()["quota"]["used_bytes"] == 0


def test_redirects_are_not_followed(doctor, liar):
    problem(search(doctor, "redirect"), 502, "archive-faulty")
    assert liar.elsewhere == []


def test_a_series_of_another_study_is_not_shown(doctor):
    problem(doctor.http.post("/v1/archives/other-study/series", json={"study": STUDY}), 502, "archive-faulty")


def test_huge_and_strange_values_are_cut_off_and_wrong_uids_left_out(doctor):
    [study] = search(doctor, "huge-values").json()["items"]
    assert (study["study"], study["patient_name"], study["description"], study["series"]) == (STUDY, "x" * 128, "", None)


def test_a_fetch_that_was_cut_off_gets_only_the_missing_images_again(stack, liar):
    who = radiologist(stack)
    before = len(liar.requests)
    end = fetched(who, "cut-off", STUDY, SERIES)
    assert (end["state"], end["images"]) == ("done", 40), end
    singles = [path for path in liar.requests[before:] if "/instances/" in path]
    assert 15 <= len(singles) <= 25, ("the first half had arrived", liar.requests[before:])


def test_a_fetch_can_be_cancelled_while_the_archive_sends(stack):
    who = radiologist(stack)
    job = who.http.post("/v1/archives/trickle/fetches", json={"study": STUDY, "series": SERIES}).json()
    path = f"/v1/archives/trickle/fetches/{job['id']}"
    stack.wait_until(lambda: who.http.get(path).json()["images"] > 0, what="the first images")
    begun = time.monotonic()
    assert who.http.delete(path).status_code == 204
    assert fetch_end(who, "trickle", job["id"])["state"] == "cancelled"
    assert time.monotonic() - begun < 60
    assert who.http.get("/v1/me").json()["quota"]["used_bytes"] == 0


def test_an_account_has_two_fetches_at_once(stack):
    who = radiologist(stack)
    order = {"study": STUDY, "series": SERIES}
    jobs = [who.http.post("/v1/archives/trickle/fetches", json=order).json()["id"] for _ in range(2)]
    problem(who.http.post("/v1/archives/trickle/fetches", json=order), 429, "too-many")
    for job in jobs:
        who.http.delete(f"/v1/archives/trickle/fetches/{job}")
        fetch_end(who, "trickle", job)
    assert fetched(who, "honest", STUDY, SERIES)["state"] == "done"


def test_an_unknown_study_of_a_lying_archive_leaves_no_trace(stack, doctor):
    begun = time.time()
    search(doctor, "error")
    search(doctor, "honest")
    fetched(doctor, "noise", STUDY, SERIES)
    fetched(doctor, "other-series", STUDY, SERIES)
    assert Search(["Phantasia", "Canary"], begun).in_stack(stack) == []
