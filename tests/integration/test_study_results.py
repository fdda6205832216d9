"""The results of studies: the analysis service behind the API, and adopting what it finds."""

from __future__ import annotations

import pytest
from analysis_double import AnalysisDouble
from api_client import client, person, problem
from study_helpers import BOTH, definition, joined, opened, researcher

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
