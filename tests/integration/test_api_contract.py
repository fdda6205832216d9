"""api/openapi.yaml against the running server: every operation is there, and what the contract refuses is refused in
its form. (All other API tests hold every answer against it too: api_client.client.)"""

from __future__ import annotations

import random
import re
import uuid

import pytest
from api_client import CONTRACT, add_worker, api, client, forget_attempts, make_ready, person, problem, remove_worker  # noqa: F401

OPERATIONS = list(CONTRACT.operations())
WITH_BODY = [o for o in OPERATIONS if "application/json" in str(CONTRACT.resolve(o[2].get("requestBody", {})))]
names = {"ids": lambda o: o[2]["operationId"]}


def address(path: str, **ids: str) -> str:
    return re.sub(r"\{(\w+)\}", lambda m: ids.get(m[1], "bone" if m[1] == "preset" else str(uuid.uuid4())), path)


@pytest.fixture(scope="module")
def one(api):  # noqa: F811
    return person(api)


@pytest.mark.parametrize("operation", [o for o in OPERATIONS if o[2].get("security") != []], **names)
def test_who_is_not_signed_in_gets_nowhere(api, operation):  # noqa: F811
    path, method, _ = operation
    answer = client(api).request(method, address(path), headers={"Tus-Resumable": "1.0.0"})
    assert answer.status_code == 401
    if method != "HEAD":
        problem(answer, 401, "unauthenticated")


@pytest.mark.parametrize("operation", [o for o in OPERATIONS if "{" in o[0]], **names)
def test_what_does_not_exist_is_not_found(api, one, operation):  # noqa: F811
    path, method, _ = operation
    for other in (None, "x", "0" * 36):
        given = {} if other is None else {"data_set_id": other, "upload_id": other, "session_id": other, "recording_id": other}
        answer = one.http.request(method, address(path, **given), headers={
            "Tus-Resumable": "1.0.0", "Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"})
        assert answer.status_code == 404


@pytest.mark.parametrize("operation", OPERATIONS, **names)
def test_a_method_that_is_not_in_the_contract_is_said_to_be_none(api, one, operation):  # noqa: F811
    path, _, _ = operation
    known = {method for p, method, _ in OPERATIONS if p == path}
    for method in {"GET", "POST", "PATCH", "DELETE"} - known:
        answer = one.http.request(method, address(path))
        problem(answer, 405, "method-not-allowed")
        assert set(answer.headers["allow"].replace(" ", "").split(",")) - {"HEAD", "OPTIONS"} == known - {"HEAD", "OPTIONS"}


def wrong_bodies(schema: dict, rng: random.Random):
    """(a body that the schema refuses, the field that is wrong or None)."""
    good = {name: valid(CONTRACT.resolve(part)) for name, part in schema["properties"].items()}
    for name in schema["required"]:
        yield {k: v for k, v in good.items() if k != name}, name
    for name, part in schema["properties"].items():
        part = CONTRACT.resolve(part)
        wrong = [None, [], {}, True, rng.random(), {"a": [1]}, -1 if part["type"] == "integer" else "\x00",
                 "x" * 10_000, 2**63, -(2**63), 1e300, "\ud7ff\u0007"]
        for value in wrong:
            if not (part["type"] == "string" and name == "password" and isinstance(value, str) and len(value) < 800):
                if not (isinstance(value, int) and not isinstance(value, bool) and part["type"] == "integer"
                        and part["minimum"] <= value <= part.get("maximum", 2**63 - 1)):
                    yield {**good, name: value}, name
    yield {**good, "surprise": 1}, "surprise"


def valid(part: dict):
    if part["type"] == "integer":
        return 1000
    return "0" * 64 if "64" in part.get("pattern", "") else "somebody@example.org"


@pytest.mark.parametrize("operation", WITH_BODY, **names)
def test_a_body_that_the_schema_refuses_is_refused_by_field(api, one, operation):  # noqa: F811
    path, method, spec = operation
    body = CONTRACT.resolve(CONTRACT.resolve(spec["requestBody"])["content"]["application/json"]["schema"])
    for wrong, field in wrong_bodies(body, random.Random(1)):
        document = problem(one.http.request(method, address(path), json=wrong), 422, "invalid")
        assert field in [e["field"] for e in document["errors"]], (wrong, document)


@pytest.mark.parametrize("operation", WITH_BODY, **names)
def test_a_body_that_is_no_json_object_is_refused(api, one, operation):  # noqa: F811
    path, method, _ = operation
    json_type = {"Content-Type": "application/json"}
    for raw in (b"", b"{", b"\xff\xfe", b'{"a":1}}', b"[" * 100_000, b'{"email":"\xc3\x28"}'):
        problem(one.http.request(method, address(path), content=raw, headers=json_type), 400, "bad-request")
    for raw in (b"[]", b"null", b"1", b'"text"'):
        problem(one.http.request(method, address(path), content=raw, headers=json_type), 422, "invalid")
    for media in ("text/plain", "application/x-www-form-urlencoded", "application/jsonp"):
        answer = one.http.request(method, address(path), content=b"{}", headers={"Content-Type": media})
        problem(answer, 415, "media-type")
    answer = one.http.request(method, address(path), content=b" " * (2**20 + 1), headers=json_type)
    problem(answer, 413, "body-too-large")


def test_head_is_answered_like_get_but_without_a_body(api, one):  # noqa: F811
    for path in ("/v1/me", "/v1/data-sets", "/v1/sessions"):
        answer = one.http.head(path)
        assert answer.status_code == 200 and answer.content == b""
    assert one.http.head("/v1/nothing").status_code == 404


def test_options_says_what_a_route_allows(api):  # noqa: F811
    answer = client(api).options("/v1/me")
    assert answer.status_code == 204 and answer.headers["allow"] == "GET, HEAD, OPTIONS"


def test_every_operation_of_the_contract_succeeds_somewhere(api, one):  # noqa: F811
    """Runs the shortest good way through all of them, so that this holds for this file alone too."""
    made = one.upload(b"x" * 10)["id"]
    make_ready(api, made)
    folder = api.data_dir / "cache" / "thumbnails" / made
    folder.mkdir(parents=True)
    (folder / "bone.jpg").write_bytes(b"\xff\xd8\xff")
    for path in (folder / "bone.jpg", folder, folder.parent):
        api.stack.run_as.own(path)
    add_worker(api, "contract-test")
    one.http.get(f"/v1/data-sets/{made}/thumbnails/bone")
    session = one.http.post("/v1/sessions", json={"data_set_id": made}).json()["session_id"]
    one.http.post(f"/v1/sessions/{session}/tickets")
    one.http.get(f"/v1/sessions/{session}")
    token = one.http.post(f"/v1/sessions/{session}/links").json()["token"]
    client(api).post("/v1/join", json={"token": token, "key": "0" * 64})
    one.http.delete(f"/v1/sessions/{session}/links")
    one.http.post("/v1/recording-consent")
    recording = {"format": "diaphane-interaction", "version": 1, "viewport": {"width": 64, "height": 64},
                 "events": [{"at_ms": 0, "scene": {}}]}
    recording = one.http.post("/v1/recordings", json=recording).json()["id"]
    one.http.get(f"/v1/recordings/{recording}")
    one.http.get("/v1/recordings")
    one.http.delete(f"/v1/recordings/{recording}")
    one.http.delete("/v1/recording-consent")
    for path in ("/v1/sessions", "/v1/data-sets", "/v1/me"):
        one.http.get(path)
    one.http.delete(f"/v1/sessions/{session}")
    one.http.get(f"/v1/data-sets/{made}")
    one.http.delete(f"/v1/data-sets/{made}")
    unwanted = one.data_set(100)["upload_url"]
    one.offset(unwanted)
    one.http.delete(unwanted, headers={"Tus-Resumable": "1.0.0"})
    remove_worker(api, "contract-test")
    client(api).options("/v1/uploads")
    forget_attempts(api)
    person(api).http.post("/v1/sign-out")
    succeeded = {name for name, status in CONTRACT.seen if status < 300}
    assert succeeded == {spec["operationId"] for _, _, spec in OPERATIONS}
