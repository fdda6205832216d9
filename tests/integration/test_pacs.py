"""The hospital's archives: a real Orthanc is searched, and series are fetched from it, by DICOMweb and by DIMSE."""

from __future__ import annotations

import time

import httpx
import phantom
import pytest
from api_client import person, problem
from archives import dimse_archive, open_stack, web_archive
from canaries import Search
from pacs_helpers import audit, fetched, give_token, radiologist, wait_ready

STUDY, SERIES = "1.2", "1.2.3"
#: The ways to the same Orthanc: DICOMweb, C-GET and C-MOVE.
WAYS = ("radiology", "legacy", "moving")


@pytest.fixture(scope="module")
def stack(all_stacks, orthanc):
    archives = [web_archive(orthanc), dimse_archive(orthanc),
                web_archive(orthanc, name="locked", password_file="secrets/wrong-password"),
                dimse_archive(orthanc, name="stranger", ae_title="NOBODY"), dimse_archive(orthanc, name="moving", retrieve="move")]
    running = open_stack(all_stacks, archives, port=orthanc.receiver_port)
    yield running
    all_stacks.shut(running)


@pytest.fixture(scope="module")
def doctor(stack):
    return radiologist(stack)


def search(who, archive, **fields):
    return who.http.post(f"/v1/archives/{archive}/studies", json=fields)


def test_archives_are_listed_by_name_without_addresses_or_secrets(doctor):
    answer = doctor.http.get("/v1/archives")
    assert answer.json() == {"items": [{"name": "radiology", "title": "Radiology"}, {"name": "legacy", "title": "Old archive"},
                                       {"name": "locked", "title": "Radiology"}, {"name": "stranger", "title": "Old archive"},
                                       {"name": "moving", "title": "Old archive"}]}
    assert "127.0.0.1" not in answer.text


@pytest.mark.parametrize("archive", WAYS)
def test_a_study_is_found_by_each_field(doctor, archive):
    for fields in ({"patient_name": "phanta"}, {"patient_name": "Phantasia Can"}, {"patient_id": phantom.NAME.replace("^", "?")}, {"from": "2019-12-31", "until": "2020-01-02"},
                   {"patient_name": "Phantasia", "modality": "CT"}):
        answer = search(doctor, archive, **fields)
        assert answer.status_code == 200, answer.text
        [study] = answer.json()["items"]
        assert (study["study"], study["patient_name"], study["date"], study["modalities"]) == (STUDY, "Phantasia Canary", "2020-01-01", ["CT"]), fields
    for fields in ({"patient_name": "Nobody"}, {"patient_name": "Canary"}, {"from": "2020-01-02"}, {"patient_name": "Phantasia", "modality": "MR"}):
        assert search(doctor, archive, **fields).json() == {"items": [], "more": False}, fields


@pytest.mark.parametrize("archive", WAYS)
def test_the_series_of_a_study_are_listed(doctor, archive):
    [series] = doctor.http.post(f"/v1/archives/{archive}/series", json={"study": STUDY}).json()["items"]
    assert (series["series"], series["modality"], series["images"], series["suitable"]) == (SERIES, "CT", phantom.SLICES, True)


@pytest.mark.parametrize("archive", WAYS)
def test_a_fetched_series_becomes_a_scan_without_patient_data(stack, doctor, archive):
    begun = time.time()
    end = fetched(doctor, archive, STUDY, SERIES, title="Head")
    assert (end["state"], end["problem"], end["images"], end["total"]) == ("done", None, phantom.SLICES, phantom.SLICES)
    wait_ready(stack, end["data_set_id"])
    scan = doctor.http.get(f"/v1/data-sets/{end['data_set_id']}").json()
    assert (scan["state"], scan["title"]) == ("ready", "Head")
    assert Search(["Phantasia", "Canary"], begun).in_stack(stack) == []


def test_an_archive_may_send_only_what_is_fetched(stack, doctor, orthanc):
    before = doctor.http.get("/v1/data-sets").json()["items"]
    [study] = orthanc.http.get("/studies").json()
    refused = orthanc.http.post("/modalities/diaphane/store", content=study)
    assert not refused.is_success, refused.text
    assert doctor.http.get("/v1/data-sets").json()["items"] == before
    assert "an image was refused: no fetch waits for the image" in stack.log("pacs")


def test_an_archive_that_does_not_know_the_receiver_is_reported(all_stacks, stack, doctor, orthanc):
    orthanc.http.request("DELETE", "/modalities/diaphane").raise_for_status()
    try:
        end = fetched(doctor, "moving", STUDY, SERIES)
        assert (end["state"], end["problem"], end["data_set_id"]) == ("failed", "faulty", None)
    finally:
        orthanc.http.put("/modalities/diaphane", json=["DIAPHANE", "127.0.0.1", orthanc.receiver_port]).raise_for_status()


def test_searches_and_fetches_are_in_the_audit_log_with_hashed_studies(stack):
    who = radiologist(stack)
    before = {action: len(audit(stack, action)) for action in ("archive.searched", "archive.study-opened", "archive.fetch-started")}
    search(who, "radiology", patient_name="Phantasia")
    search(who, "locked", patient_name="Phantasia")
    who.http.post("/v1/archives/radiology/series", json={"study": STUDY})
    fetched(who, "radiology", STUDY, SERIES)
    new = {action: audit(stack, action)[count:] for action, count in before.items()}
    assert new["archive.searched"] == [{"archive": "radiology", "results": 1}, {"archive": "locked", "failed": 1}]
    [opened], [started] = new["archive.study-opened"], new["archive.fetch-started"]
    assert opened["study"] == started["study"] and len(started["study"]) == 32 and started["study"] != started["series"]


def test_only_users_with_access_may_use_the_archives(stack, doctor):
    stranger = person(stack)
    requests = [("GET", "/v1/archives", None), ("POST", "/v1/archives/radiology/studies", {"patient_name": "P"}),
                ("POST", "/v1/archives/radiology/series", {"study": STUDY}), ("POST", "/v1/archives/radiology/fetches", {"study": STUDY, "series": SERIES}),
                ("POST", "/v1/archive-receipts", {"via": "stow", "study": STUDY})]
    for method, path, body in requests:
        problem(stranger.http.request(method, path, json=body), 403, "forbidden")
    boss = person(stack).becomes_administrator()
    stranger_id = stranger.http.get("/v1/me").json()["id"]
    assert boss.http.patch(f"/v1/admin/users/{stranger_id}", json={"archive_access": True}).json()["archive_access"] is True
    assert stranger.http.get("/v1/me").json()["archive_access"] is True
    assert search(stranger, "radiology", patient_name="Phantasia").status_code == 200
    boss.http.patch(f"/v1/admin/users/{stranger_id}", json={"archive_access": False})
    problem(stranger.http.get("/v1/archives"), 403, "forbidden")
    assert audit(stack, "archive-access.granted") and audit(stack, "archive-access.revoked")


def test_a_token_needs_the_scope_and_its_user_the_access(stack, doctor):
    def listed(token):
        return httpx.get(f"{stack.url}/v1/archives", headers={"Authorization": f"Bearer {token}"}, trust_env=False)

    assert listed(give_token(stack, doctor, "archive")).status_code == 200
    problem(listed(give_token(stack, doctor, "read write share")), 403, "forbidden")
    problem(listed(give_token(stack, person(stack), "archive")), 403, "forbidden")


def test_the_token_of_a_fetch_only_uploads_and_ends_with_the_access(stack):
    who = radiologist(stack)
    token = give_token(stack, who, "write")
    stack.psql("UPDATE api_tokens SET for_fetch = true WHERE user_id = %s", who.http.get("/v1/me").json()["id"])
    headers = {"Authorization": f"Bearer {token}"}

    def create():
        return httpx.post(f"{stack.url}/v1/data-sets", json={"title": "", "bytes": 1024}, headers=headers, trust_env=False)

    made = create()
    assert made.status_code == 201
    problem(httpx.delete(f"{stack.url}/v1/data-sets/{made.json()['data_set']['id']}", headers=headers, trust_env=False), 403, "forbidden")
    assert who.http.get("/v1/me/tokens").json()["items"] == [], "nobody made it, so it is not listed"
    stack.psql("UPDATE users SET archive_access = false WHERE email = %s", who.email)
    problem(create(), 401, "unauthenticated")


def test_a_fetch_belongs_to_its_user(stack, doctor):
    answer = doctor.http.post("/v1/archives/radiology/fetches", json={"study": STUDY, "series": SERIES}).json()
    other = radiologist(stack)
    path = f"/v1/archives/radiology/fetches/{answer['id']}"
    problem(other.http.get(path), 404, "not-found")
    problem(other.http.delete(path), 404, "not-found")
    problem(doctor.http.get(path.replace("radiology", "legacy")), 404, "not-found")
    assert doctor.http.get(path).status_code == 200


def test_unknown_archives_studies_and_series_are_not_found(doctor):
    problem(search(doctor, "nowhere", patient_name="P"), 404, "not-found")
    problem(doctor.http.post("/v1/archives/nowhere/fetches", json={"study": STUDY, "series": SERIES}), 404, "not-found")
    for archive in WAYS:
        end = fetched(doctor, archive, STUDY, "9.9.9")
        assert (end["state"], end["problem"]) == ("failed", "not-found")


def test_searches_without_a_field_or_with_invalid_ones_are_refused(doctor):
    for fields in ({}, {"modality": "CT"}, {"patient_name": ""}, {"until": "2020-01-01"}):
        problem(search(doctor, "radiology", **fields), 422, "invalid")
    for fields in ({"from": "yesterday"}, {"patient_name": "x" * 65}, {"patient_name": "P", "modality": "US"}, {"patient_name": "P", "level": "PATIENT"}):
        problem(search(doctor, "radiology", **fields), 422, "invalid")
    problem(doctor.http.post("/v1/archives/radiology/series", json={"study": "../1"}), 422, "invalid")


def test_wrong_credentials_are_reported(doctor):
    for archive in ("locked", "stranger"):
        problem(search(doctor, archive, patient_name="P"), 502, "archive-refused")
        end = fetched(doctor, archive, STUDY, SERIES)
        assert (end["state"], end["problem"]) == ("failed", "unauthorised")


def test_a_full_quota_ends_the_fetch_and_keeps_nothing(stack):
    who = radiologist(stack)
    stack.psql("UPDATE users SET quota_bytes = 1000 WHERE email = %s", who.email)
    end = fetched(who, "radiology", STUDY, SERIES)
    assert (end["state"], end["problem"], end["data_set_id"]) == ("failed", "over-quota", None)
    assert who.http.get("/v1/me").json()["quota"]["used_bytes"] == 0
    assert [one for one in who.http.get("/v1/data-sets").json()["items"] if one["role"] == "owner"] == []


def test_the_gateway_answers_only_api(stack):
    url = f"http://127.0.0.1:{stack.ports['pacs']}"
    for headers in ({}, {"Authorization": "Bearer " + "0" * 64}):
        assert httpx.post(f"{url}/archives", json={}, headers=headers, trust_env=False).status_code == 401
    metrics = httpx.get(f"{url}/metrics", trust_env=False).text
    assert 'diaphane_pacs_requests_total{archive="radiology",operation="search"}' in metrics
    assert 'diaphane_pacs_failures_total{archive="locked",operation="search",reason="unauthorised"}' in metrics


def test_without_the_gateway_the_archives_are_unavailable(stack, doctor):
    stack.stop("pacs")
    try:
        problem(search(doctor, "radiology", patient_name="P"), 503, "unavailable")
    finally:
        stack.start("pacs")
        stack.wait_ready("pacs")
    # Fetches are kept in memory, so one from before is unknown.
    assert search(doctor, "radiology", patient_name="Phantasia").status_code == 200
