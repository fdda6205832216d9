"""api/openapi.yaml compared with the running server: every operation exists, and what the contract forbids is refused in its
form. (All other API tests validate every response against it: api_client.client.)"""

from __future__ import annotations

import json
import random
import re
import uuid

import answering_worker
import pytest
from api_client import (CONTRACT, PASSWORD, add_worker, api, client, forget_attempts, link_token, make_ready, one, person,  # noqa: F401
                        problem, put_thumbnail, remove_worker, signed_up)
from cut_helpers import KEEP, store
from access_matrix_fixture import put_export_file, put_picture
from pacs_helpers import archive_ways
from panoramas import hdr
from seeds import PRIVACY_NOTICE
from study_helpers import study_result_ways, study_ways

OPERATIONS = list(CONTRACT.operations())
WITH_BODY = [o for o in OPERATIONS if "application/json" in str(CONTRACT.resolve(o[2].get("requestBody", {})))]
names = {"ids": lambda o: o[2]["operationId"]}


def address(path: str, **ids: str) -> str:
    return re.sub(r"\{(\w+)\}", lambda m: ids.get(m[1], "bone" if m[1] == "preset" else str(uuid.uuid4())), path)


@pytest.mark.parametrize("operation", [o for o in OPERATIONS if o[2].get("security", [0]) and {} not in o[2].get("security", [0])], **names)
def test_unauthenticated_requests_are_refused(api, operation):  # noqa: F811
    path, method, _ = operation
    answer = client(api).request(method, address(path), headers={"Tus-Resumable": "1.0.0"})
    assert answer.status_code == 401
    if method != "HEAD":
        problem(answer, 401, "unauthenticated")


@pytest.fixture(scope="module")
def boss(api):  # noqa: F811
    """An administrator, for operations that only they may call."""
    made = person(api).becomes_administrator()
    yield made
    made.is_no_administrator()


FOR_ADMINISTRATORS = {"listUsers", "getUser", "changeUser", "listAudit", "getFleet", "takeDownDataSet", "restoreDataSet", "takeDownPreset",
                      "restorePreset", "listReports", "countReports", "listTakeDowns", "dismissReport", "adoptStudyResults", "resetComfort"}


@pytest.fixture(scope="module", autouse=True)
def role(api, one):  # noqa: F811
    """Makes the user a researcher with access to the archives, for the operations of both."""
    api.psql("UPDATE users SET is_researcher = true, archive_access = true WHERE id = %s", one.id)


def caller(one, boss, operation):
    return boss if operation[2]["operationId"] in FOR_ADMINISTRATORS else one


@pytest.mark.parametrize("operation", [o for o in OPERATIONS if "{" in o[0]], **names)
def test_missing_objects_give_404(api, one, boss, operation):  # noqa: F811
    path, method, spec = operation
    one = caller(one, boss, operation)
    xml = CONTRACT.resolve(spec.get("requestBody", {})).get("content", {}).get("application/xml")
    schema = body_schema(operation)
    for other in (None, "x", "0" * 36):
        given = {} if other is None else {name: other for name in re.findall(r"\{(\w+)\}", path)}
        media = "application/offset+octet-stream" if schema is None else "application/json"
        answer = one.http.request(method, address(path, **given), headers={
            "Tus-Resumable": "1.0.0", "Upload-Offset": "0", "Content-Type": "application/xml" if xml else media},
            content=xml["example"] if xml else None if schema is None else json.dumps(good_body(schema)))
        assert answer.status_code == 404


@pytest.mark.parametrize("operation", OPERATIONS, **names)
def test_a_method_that_is_not_in_the_contract_is_refused(api, one, operation):  # noqa: F811
    path, _, _ = operation
    known = {method for p, method, _ in OPERATIONS if p == path}
    for method in {"GET", "POST", "PATCH", "DELETE"} - known:
        answer = one.http.request(method, address(path))
        problem(answer, 405, "method-not-allowed")
        assert set(answer.headers["allow"].replace(" ", "").split(",")) - {"HEAD", "OPTIONS"} == known - {"HEAD", "OPTIONS"}


def body_schema(operation) -> dict | None:
    """Returns the schema of a JSON body, or None without a body."""
    content = CONTRACT.resolve(operation[2].get("requestBody", {})).get("content", {})
    return CONTRACT.resolve(content["application/json"]["schema"]) if "application/json" in content else None


def good_body(schema: dict) -> dict:
    return {name: valid(CONTRACT.resolve(schema["properties"][name])) for name in schema.get("required", [])}


def property_schema(part: dict) -> dict:
    """Returns the schema of a property. That of an object or null becomes one schema with both types."""
    if "oneOf" not in part:
        return CONTRACT.resolve(part)
    one, null = part["oneOf"]
    assert null == {"type": "null"}
    given = CONTRACT.resolve(one)
    return {**given, "type": [given["type"], "null"]}


def wrong_bodies(schema: dict, rng: random.Random):
    """Yields (a body that the schema refuses, the wrong field or None)."""
    good = {**{name: valid(property_schema(part)) for name, part in schema["properties"].items()}, **good_body(schema)}
    for name in schema.get("required", []):
        yield {k: v for k, v in good.items() if k != name}, name
    for name, part in schema["properties"].items():
        part = {"type": "string", **property_schema(part)}  # a const has no type
        wrong = [None, [], {}, True, rng.random(), {"a": [1]}, -1 if part["type"] == "integer" else "\x00",
                 "x" * 10_000, 2**63, -(2**63), 1e300, "\ud7ff\u0007"]
        for value in wrong:
            if value is None and "null" in part["type"]:
                continue
            if value == {} and "object" in part["type"] and "minProperties" not in part:
                continue
            # The contract does not say what is in this object.
            if isinstance(value, dict) and part["type"] == "object" and not {"properties", "minProperties"} & part.keys():
                continue
            if not (part["type"] == "string" and name in ("password", "current") and isinstance(value, str) and len(value) < 800):
                if part["type"] == "boolean" and isinstance(value, bool):
                    continue
                if not (isinstance(value, int) and not isinstance(value, bool) and part["type"] == "integer"
                        and part["minimum"] <= value <= part.get("maximum", 2**63 - 1)):
                    yield {**good, name: value}, name
    yield {**good, "surprise": 1}, "surprise"


def valid(part: dict):
    if "const" in part:
        return part["const"]
    if "enum" in part:
        return part["enum"][0]
    if part["type"] == "integer":
        return min(1000, part.get("maximum", 1000))
    if "object" in part["type"]:
        return part.get("example", {})
    if part["type"] == "boolean":
        return True
    if part.get("pattern") == "^[0-9.]+$":
        return "1.2"
    return "0" * 64 if "64" in part.get("pattern", "") else "somebody@example.org"


@pytest.mark.parametrize("operation", WITH_BODY, **names)
def test_a_body_that_violates_the_schema_is_refused_by_field(api, one, boss, operation):  # noqa: F811
    path, method, spec = operation
    one = caller(one, boss, operation)
    body = body_schema(operation)
    for wrong, field in wrong_bodies(body, random.Random(1)):
        document = problem(one.http.request(method, address(path), json=wrong), 422, "invalid")
        named = [e["field"] for e in document["errors"]]
        assert any(name == field or name.startswith(f"{field}.") for name in named), (wrong, document)


@pytest.mark.parametrize("operation", WITH_BODY, **names)
def test_a_body_that_is_not_a_json_object_is_refused(api, one, boss, operation):  # noqa: F811
    path, method, _ = operation
    one = caller(one, boss, operation)
    json_type = {"Content-Type": "application/json"}
    for raw in (b"", b"{", b"\xff\xfe", b'{"a":1}}', b"[" * 10_000, b'{"email":"\xc3\x28"}'):
        problem(one.http.request(method, address(path), content=raw, headers=json_type), 400, "bad-request")
    for raw in (b"[]", b"null", b"1", b'"text"'):
        problem(one.http.request(method, address(path), content=raw, headers=json_type), 422, "invalid")
    for media in ("text/plain", "application/x-www-form-urlencoded", "application/jsonp"):
        answer = one.http.request(method, address(path), content=b"{}", headers={"Content-Type": media})
        problem(answer, 415, "media-type")
    answer = one.http.request(method, address(path), content=b" " * (2**20 + 1), headers=json_type)
    problem(answer, 413, "body-too-large")


def test_head_gives_the_response_of_get_without_the_body(api, one):  # noqa: F811
    for path in ("/v1/me", "/v1/data-sets", "/v1/sessions"):
        answer = one.http.head(path)
        assert answer.status_code == 200 and answer.content == b""
    assert one.http.head("/v1/nothing").status_code == 404


def test_options_lists_the_allowed_methods(api):  # noqa: F811
    answer = client(api).options("/v1/me")
    assert answer.status_code == 204 and answer.headers["allow"] == "GET, HEAD, OPTIONS"


def account_ways(stack) -> None:
    """Calls each operation of an account once, each as a new user."""
    other = person(stack)
    other.http.post("/v1/password-reset", json={"email": other.email})
    other.http.post("/v1/password-reset/confirm",
                    json={"token": link_token(stack, other.email, "reset"), "password": PASSWORD + " two"})
    other = person(stack)
    other.http.get("/v1/me/second-factor")
    factor, given = "/v1/me/second-factor", {"password": PASSWORD, "code": other.sets_up_second_factor()[0]}
    given["code"] = other.http.post(f"{factor}/recovery-codes", json=given).json()["recovery_codes"][0]
    other.http.post(f"{factor}/removal", json=given)
    other = person(stack)
    other.http.post("/v1/me/password", json={"current": PASSWORD, "password": PASSWORD + " two"})
    other.http.post("/v1/me/email", json={"email": "x-" + other.email, "password": PASSWORD + " two"})
    other.http.post("/v1/email-change/confirm", json={"token": link_token(stack, "x-" + other.email, "confirm-email")})
    other.http.post("/v1/me/tokens", json={"name": "a", "scopes": ["read"], "days": 1, "password": PASSWORD + " two"})
    [token] = other.http.get("/v1/me/tokens").json()["items"]
    other.http.delete(f"/v1/me/tokens/{token['id']}")
    [browser] = other.http.get("/v1/me/browser-sessions").json()["items"]
    other.http.delete(f"/v1/me/browser-sessions/{browser['id']}")
    person(stack).http.delete("/v1/me/browser-sessions")
    other = person(stack)
    other.http.post("/v1/me/export")
    stack.wait_until(lambda: other.http.get("/v1/me/export").json()["state"] == "ready", what="the export")
    other.http.get("/v1/me/export/file")
    other.http.delete("/v1/me/export")
    other.http.post("/v1/me/deletion", json={"password": PASSWORD})


def administrators_ways(one) -> None:
    for path in ("/v1/admin/users", "/v1/admin/audit", "/v1/admin/fleet", f"/v1/admin/users/{one.id}"):
        one.http.get(path)
    one.http.patch(f"/v1/admin/users/{one.id}", json={"quota_bytes": 10**9})


def annotation_ways(one, data_set: str) -> None:
    path = f"/v1/data-sets/{data_set}/annotations"
    saved = one.http.post(path, json={"name": "a", "content": CONTRACT.spec["components"]["schemas"]["Annotations"]["example"]}).json()
    one.http.get(path)
    one.http.patch(f"{path}/{saved['id']}", json={"name": "b", "shared": True})
    one.http.delete(f"{path}/{saved['id']}")


def export_ways(one, data_set: str) -> None:
    """Without ingestd, so the file is put there."""
    path = f"/v1/data-sets/{data_set}/export"
    one.http.post(path, json={"format": "nifti"})
    one.http.get(path)
    [(name,)] = one.stack.psql("UPDATE scan_exports SET state = 'ready', bytes = 3 WHERE user_id = %s RETURNING id::text", one.id)
    put_export_file(one.stack, f"{name}.scan", b"nii")
    one.http.get(f"{path}/file")
    one.http.delete(path)


def alignment_ways(one, data_set: str) -> None:
    second = one.data_set(10)["data_set"]["id"]
    make_ready(one.stack, second)
    path = f"/v1/data-sets/{data_set}/alignments/{second}"
    for method in (one.http.get, one.http.put, one.http.put, one.http.delete):
        method(path)


def preset_ways(stack, one, data_set: str) -> None:
    presets = f"/v1/data-sets/{data_set}/presets"
    saved = one.http.post(presets, json={"name": "a", "scene": CONTRACT.spec["components"]["schemas"]["Scene"]["example"]})
    preset = f"/v1/presets/{saved.json()['id']}"
    xml = one.http.get(f"{preset}/xml").content
    one.http.post(f"{presets}/xml", content=xml, headers={"Content-Type": "application/xml"})
    put_picture(stack, saved.json()["id"])
    for path in (presets, preset, f"{presets}/{saved.json()['id']}/thumbnail"):
        one.http.get(path)
    one.http.post(f"/v1/data-sets/{data_set}/default-preset", json={"preset_id": saved.json()["id"]})
    one.http.post(f"{preset}/vote", json={"value": 1})
    changed = one.http.patch(preset, json={"name": "b"}, headers={"If-Match": saved.headers["etag"]})
    one.http.delete(preset, headers={"If-Match": changed.headers["etag"]})


def report_ways(stack, data_set: str) -> None:
    """The data set is public before. Afterwards, the administrator who took it down has restored it."""
    boss, other = person(stack).becomes_administrator(), person(stack)
    boss.http.post(f"/v1/data-sets/{data_set}/reports", json={"reason": "other", "words": "twice"})
    other.http.post(f"/v1/data-sets/{data_set}/reports", json={"reason": "identifies"})
    theirs = other.http.post(f"/v1/data-sets/{data_set}/presets", json={
        "name": "theirs", "scene": CONTRACT.spec["components"]["schemas"]["Scene"]["example"]}).json()["id"]
    boss.http.post(f"/v1/presets/{theirs}/reports", json={"reason": "offensive"})
    boss.http.post(f"/v1/presets/{theirs}/take-down", json={"reason": "A slur."})
    boss.http.delete(f"/v1/presets/{theirs}/take-down")
    boss.http.get("/v1/report-count")
    reports = boss.http.get("/v1/reports").json()["items"]
    boss.http.delete(f"/v1/reports/{reports[0]['id']}")
    boss.http.post(f"/v1/data-sets/{data_set}/take-down", json={"reason": "A name is on it."})
    boss.http.get("/v1/take-downs")
    boss.http.delete(f"/v1/data-sets/{data_set}/take-down")
    boss.is_no_administrator()


def test_every_operation_of_the_contract_succeeds_in_some_test(api, one, boss, all_stacks):  # noqa: F811
    """Runs the shortest valid sequence through all operations, so that this also holds for this file alone."""
    signed_up(api)
    one.sign_in()
    made = one.upload(b"x" * 10)["id"]
    make_ready(api, made)
    put_thumbnail(api, made)
    add_worker(api, "contract-test", address=answering_worker.address())
    one.http.get(f"/v1/data-sets/{made}/thumbnails/bone")
    session = one.http.post("/v1/sessions", json={"data_set_id": made}).json()["session_id"]
    one.http.post(f"/v1/sessions/{session}/tickets")
    one.http.get(f"/v1/sessions/{session}")
    one.http.get(f"/v1/sessions/{session}/error-curve")
    one.http.patch(f"/v1/data-sets/{made}", json={"title": "a", "body_part": "head"})
    api.psql("UPDATE data_sets SET anonymised_at = now() WHERE id = %s", made)
    one.http.post(f"/v1/data-sets/{made}/visibility", json={"visibility": "public"})
    one.http.get("/v1/gallery")
    one.http.post(f"/v1/data-sets/{made}/people", json={"email": "friend@example.org", "may": "view"})
    people = one.http.get(f"/v1/data-sets/{made}/people").json()["items"]
    one.http.get(f"/v1/data-sets/{made}/views")
    one.http.patch(f"/v1/data-sets/{made}/people/{people[0]['id']}", json={"slices": False})
    one.http.delete(f"/v1/data-sets/{made}/people/{people[0]['id']}")
    one.http.post(f"/v1/data-sets/{made}/labels", json={"bytes": 100})
    one.http.delete(f"/v1/data-sets/{made}/labels")
    preset_ways(api, one, made)
    annotation_ways(one, made)
    export_ways(one, made)
    alignment_ways(one, made)
    one.http.get(f"/v1/data-sets/{made}/anonymise")
    to_cut = one.data_set(100)["data_set"]["id"]
    make_ready(api, to_cut)
    one.http.post(f"/v1/data-sets/{to_cut}/anonymise",
                  json={"keep": KEEP, "volume_hash": store(api, to_cut), "confirm": "this cannot be undone"})
    report_ways(api, made)
    link = one.http.post(f"/v1/data-sets/{made}/links", json={"hours": 1}).json()
    one.http.get(f"/v1/data-sets/{made}/links")
    for path in ("/v1/follow", "/v1/follow/annotations"):
        client(api).post(path, json={"token": link["token"]})
    put_thumbnail(api, made)    # The first one is older than the anonymisation.
    client(api).post("/v1/follow/thumbnails/bone", json={"token": link["token"]})
    client(api).post("/v1/follow/tour", json={"token": link["token"]})
    client(api).post("/v1/visits", json={"token": link["token"], "key": "0" * 64})
    one.http.delete(f"/v1/data-sets/{made}/links/{link['id']}")
    one.http.patch("/v1/me/public-name", json={"public_name": "One"})
    one.http.get("/v1/me/public-name")
    one.http.post("/v1/me/consent", json={"version": PRIVACY_NOTICE})
    token = one.http.post(f"/v1/sessions/{session}/links").json()["token"]
    client(api).post("/v1/join", json={"token": token, "key": "0" * 64})
    one.http.delete(f"/v1/sessions/{session}/links")
    study_ways(api, one, made)
    environment = one.http.post("/v1/environments", params={"name": "Sky"}, content=hdr(4, 2, lambda x, y: (1, 1, 1))).json()["id"]
    one.http.get("/v1/environments")
    one.http.get(f"/v1/environments/{environment}")
    one.http.patch(f"/v1/environments/{environment}", json={"name": "Park"})
    one.http.delete(f"/v1/environments/{environment}")
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
    unwanted = one.http.post("/v1/uploads", headers={"Tus-Resumable": "1.0.0", "Upload-Length": "100"}).headers["location"]
    one.offset(unwanted)
    one.http.delete(unwanted, headers={"Tus-Resumable": "1.0.0"})
    remove_worker(api, "contract-test")
    client(api).options("/v1/uploads")
    forget_attempts(api)
    account_ways(api)
    administrators_ways(boss)
    study_result_ways(all_stacks)
    archive_ways(all_stacks)
    person(api).http.post("/v1/sign-out")
    succeeded = {name for name, status in CONTRACT.seen if status < 300}
    assert succeeded == {spec["operationId"] for _, _, spec in OPERATIONS}
