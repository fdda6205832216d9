"""The results of studies: the analysis service behind the API, and adopting what it finds."""

from __future__ import annotations

import pytest
from analysis_double import AnalysisDouble
from api_client import client, person, problem
from study_helpers import BOTH, definition, joined, opened, researcher, scan_of, step, tour_of, view

#: Of 255, as the analysis and the page count (thesis, Table 1).
COMFORT = {"bone": [-30.0, 7.0, 6.0], "blood": [34.0, 21.0, 32.0]}


@pytest.fixture(scope="module")
def analysis():
    double = AnalysisDouble()
    yield double
    double.close()


@pytest.fixture(scope="module")
def stack(all_stacks, analysis):
    running = all_stacks.open(only=("postgres", "redis", "api", "edge"), extra_env={"DIAPHANE_STUDY_ANALYSIS_URL": analysis.url})
    yield running
    all_stacks.shut(running)


@pytest.fixture(scope="module")
def lab(stack):
    return researcher(stack)


def found(analysis, comfort) -> None:
    analysis.status, analysis.answer = 200, {"sections": [], "adoptable": {"comfort": comfort, "tours": []}}


def test_the_analysis_gets_the_export_and_its_answer_reaches_the_researcher(stack, lab, analysis):
    study, token = opened(lab, definition())
    joined(stack, token).answer("rating", {"rating": 4})
    analysis.answer = {"sections": [{"id": "a" * 2_000_000}], "adoptable": {"comfort": None, "tours": []}}
    answer = lab.http.get(f"/v1/studies/{study}/analysis", params={"language": "de"})
    assert answer.status_code == 200 and answer.json() == analysis.answer, "also an answer above the 1 MB of the API itself"
    path, sent = analysis.seen[-1]
    assert path == "/analyse?language=de" and sent["participants"][0]["answers"][0]["value"] == {"rating": 4}


def test_a_failing_analysis_is_unavailable(lab, analysis):
    study, _ = opened(lab, definition())
    for analysis.status, analysis.answer in ((500, {}), (200, b"x" * (8 * 1024 * 1024 + 1))):
        problem(lab.http.get(f"/v1/studies/{study}/analysis"), 503, "unavailable")
    assert lab.http.get(f"/v1/studies/{study}/analysis", params={"language": "fr"}).status_code == 422


def test_an_administrator_adopts_the_comfort_of_a_study_and_undoes_it(stack, lab, analysis):
    study, token = opened(lab, definition())
    joined(stack, token)
    boss = person(stack).becomes_administrator()
    path = f"/v1/studies/{study}/adoption"
    for analysis.answer in ({"adoptable": {"comfort": None}}, b"no JSON", {"adoptable": {"comfort": {"bone": [1, 2], "blood": [1, 2, 3]}}},
                            {"adoptable": {"comfort": {**COMFORT, "bone": [256, 7, 6]}}}, []):
        problem(boss.http.post(path, json={"comfort": True}), 409, "conflict")
    found(analysis, COMFORT)
    assert boss.http.post(path, json={"comfort": False}).status_code == 422
    problem(lab.http.post(path, json={"comfort": True}), 403, "forbidden")
    assert boss.http.post(path, json={"comfort": True}).status_code == 204
    assert client(stack).get("/v1/perception").json() == {"comfort": {**COMFORT, "participants": 1, "title": BOTH}}
    assert boss.http.delete("/v1/perception/comfort").status_code == 204
    assert client(stack).get("/v1/perception").json() == {"comfort": None}
    actions = [entry["action"] for entry in boss.http.get("/v1/admin/audit", params={"action": "comfort."}).json()["items"]]
    assert actions == ["comfort.reset", "comfort.adopted"]


@pytest.fixture
def toured(stack, lab):
    """Returns a scan, and a study whose participants choose views of it."""
    scan = scan_of(stack, lab)
    study, token = opened(lab, definition(step("viewpoint", view=view(scan))))
    joined(stack, token)
    return scan, study


def gives_tours(analysis, *tours) -> None:
    analysis.status, analysis.answer = 200, {"sections": [], "adoptable": {"comfort": None, "tours": [*tours]}}


def adopt(who, scan: str, study: str):
    return who.http.put(f"/v1/data-sets/{scan}/tour", json={"study_id": study, "step": "viewpoint"})


def test_the_tour_of_a_study_reaches_everyone_who_may_see_the_scan(stack, lab, analysis, toured):
    scan, study = toured
    path = f"/v1/data-sets/{scan}/tour"
    assert lab.http.get(path).json() == {"tour": None}
    gives_tours(analysis, tour_of("another", scan, 3), tour_of("viewpoint", scan))
    assert adopt(lab, scan, study).status_code == 204
    found = {"views": tour_of("viewpoint", scan)["views"], "participants": 1, "title": BOTH}
    tour = {"tour": {**found, "removable": False}}
    assert lab.http.get(path).json() == {"tour": {**found, "removable": True}}
    friend, stranger = person(stack), person(stack)
    problem(friend.http.get(path), 404, "not-found")
    assert lab.http.post(f"/v1/data-sets/{scan}/people", json={"email": friend.email, "may": "view"}).status_code == 204
    assert friend.http.get(path).json() == tour
    problem(friend.http.delete(path), 403, "forbidden")
    token = lab.http.post(f"/v1/data-sets/{scan}/links", json={"hours": 1}).json()["token"]
    assert client(stack).post("/v1/follow/tour", json={"token": token}).json() == tour
    problem(client(stack).get(path), 404, "not-found")
    problem(stranger.http.get(path), 404, "not-found")
    lab.http.delete(f"/v1/studies/{study}")
    assert friend.http.get(path).json() == tour, "the tour names nobody, so it stays without its study"
    assert lab.http.delete(path).status_code == 204
    assert friend.http.get(path).json() == {"tour": None}
    actions = stack.psql("SELECT action FROM audit_log WHERE subject_id = %s AND action LIKE '%%.tour-%%' ORDER BY id", scan)
    assert actions == [("data-set.tour-adopted",), ("data-set.tour-removed",)]


def test_a_tour_needs_clear_results(lab, analysis, toured):
    scan, study = toured
    good = tour_of("viewpoint", scan)
    crooked = {**good, "views": [*good["views"], {"eye": [0, 0, 0], "target": [0, 0, 0], "up": [0, 0, 1]}]}
    far = {**good, "views": [*good["views"], {"eye": [1e6, 0, 0], "target": [0, 0, 0], "up": [0, 0, 1]}]}
    for wrong in (tour_of("another", scan), tour_of("viewpoint", study), tour_of("viewpoint", scan, 1), tour_of("viewpoint", scan, 65), crooked, far,
                  {**good, "views": "none"}):
        gives_tours(analysis, wrong)
        problem(adopt(lab, scan, study), 409, "conflict")
    analysis.answer = b"no JSON"
    problem(adopt(lab, scan, study), 409, "conflict")
    gives_tours(analysis, tour_of("viewpoint", scan, 64))
    assert adopt(lab, scan, study).status_code == 204


def test_a_tour_needs_a_study_and_a_scan_of_ones_own(stack, lab, analysis, toured):
    scan, study = toured
    gives_tours(analysis, tour_of("viewpoint", scan))
    other = researcher(stack)
    problem(adopt(other, scan, study), 404, "not-found")
    theirs = scan_of(stack, other)
    problem(adopt(other, theirs, study), 404, "not-found")
    stack.psql("UPDATE data_sets SET visibility = 'public', published_at = now(), anonymised_at = now() - interval '1 hour' WHERE id = %s", scan)
    problem(adopt(other, scan, study), 403, "forbidden")
    stack.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", scan)
    problem(adopt(lab, scan, study), 409, "conflict")


def test_files_of_exports_do_not_stay(stack, lab):
    study, token = opened(lab, definition())
    joined(stack, token)
    lab.http.get(f"/v1/studies/{study}/export")
    folder = stack.data_dir / "cache" / "studies"
    old = 3 * 60
    import os
    import time
    for file in folder.iterdir():
        os.utime(file, (time.time() - old, time.time() - old))
    stack.wait_until(lambda: not list(folder.iterdir()), what="the files to be deleted")
