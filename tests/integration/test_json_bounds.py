"""JSON with deep nesting, floods of values, or growth: refused before any value is built, and nobody else notices."""

from __future__ import annotations

import json
import threading
import uuid

import httpx
import pytest
from api_client import PASSWORD, Person, client, person, problem
from edge_helpers import connect, read_all, resident_mb

LEVELS = 250_000
NESTED = "[" * LEVELS + "]" * LEVELS
#: The limit for a preset is 256 KB.
NESTED_PRESET = NESTED[LEVELS - 120_000:LEVELS + 120_000]
JSON = {"Content-Type": "application/json"}
XML = {"Content-Type": "application/xml"}


@pytest.fixture(scope="module")
def stack(all_stacks):
    opened = all_stacks.open(only=("postgres", "redis", "api", "edge"))
    yield opened
    all_stacks.shut(opened)


@pytest.fixture(scope="module")
def attacker(stack) -> Person:
    somebody = person(stack)
    assert somebody.http.post("/v1/recording-consent").status_code == 204
    return somebody


@pytest.fixture(autouse=True)
def never_restarted(stack):
    """The API is the same process before and after each test."""
    stack.wait_ready("api")
    before = stack.pids["api"]
    yield
    assert stack.pids["api"] == before, stack.log("api")[-2000:]
    assert httpx.get(f"http://127.0.0.1:{stack.ports['api']}/v1/me", timeout=60).status_code == 401


def within(name: str, value: str) -> str:
    return f'{{"{name}":{value}}}'


def routes() -> dict[str, tuple[str, str, str]]:
    """Returns method, path and body of each request that passes a value on to recursive code."""
    some = str(uuid.uuid4())
    return {
        "cut": ("POST", f"/v1/data-sets/{some}/anonymise", within("keep", NESTED)),
        "new preset": ("POST", f"/v1/data-sets/{some}/presets", within("scene", NESTED_PRESET)),
        "changed preset": ("PATCH", f"/v1/presets/{some}", within("scene", NESTED_PRESET)),
        "recording, its viewport": ("POST", "/v1/recordings", within("viewport", NESTED)),
        "recording, its events": ("POST", "/v1/recordings", within("events", NESTED)),
        # Common to all others: an unexpected value.
        "unknown field": ("POST", "/v1/data-sets", within("x", NESTED)),
        "no object at all": ("PATCH", "/v1/me/public-name", NESTED),
    }


@pytest.mark.parametrize("name", routes())
def test_deep_nesting_is_refused_before_it_is_read(attacker, name):
    method, path, body = routes()[name]
    answer = attacker.http.request(method, path, content=body, headers=JSON | {"If-Match": '"1"'})
    assert "64 levels" in problem(answer, 400, "bad-request")["detail"]


def test_deep_nesting_is_refused_without_an_account(stack):
    nobody = client(stack)
    for path in ("/v1/accounts", "/v1/accounts/verify", "/v1/sign-in", "/v1/join", "/v1/follow"):
        # Without a session, a body is limited to 16 KB.
        answer = nobody.post(path, content=within("email", "[" * 8000 + "]" * 8000), headers=JSON)
        assert "64 levels" in problem(answer, 400, "bad-request")["detail"]
        problem(nobody.post(path, content=within("email", NESTED), headers=JSON), 413, "body-too-large")


def test_deep_nesting_in_xml_is_refused(attacker):
    body = '<preset xmlns="urn:diaphane:preset" version="1" name="x">' + "<a>" * 37_000 + "</a>" * 37_000 + "</preset>"
    answer = attacker.http.post(f"/v1/data-sets/{uuid.uuid4()}/presets/xml", content=body[:256 * 1024], headers=XML)
    assert problem(answer, 422, "invalid")["errors"][0]["field"] == "preset"
    shallow = '<preset xmlns="urn:diaphane:preset" version="1" name="x">' + "<a>" * 10_000 + "</a>" * 10_000 + "</preset>"
    answer = attacker.http.post(f"/v1/data-sets/{uuid.uuid4()}/presets/xml", content=shallow, headers=XML)
    assert "nested too deeply" in problem(answer, 422, "invalid")["errors"][0]["message"]


@pytest.mark.parametrize("part", ["0", "[]", "{}", '{"":0}'])
def test_a_flood_of_small_values_is_refused_and_takes_no_memory(stack, attacker, part):
    """1 MB of "[]" would build a tree of 20 MB."""
    count = 1_000_000 // (len(part) + 1)
    body = within("keep", "[" + ",".join([part] * count) + "]")
    before = resident_mb(stack.pids["api"])
    for _ in range(5):
        answer = attacker.http.post(f"/v1/data-sets/{uuid.uuid4()}/anonymise", content=body, headers=JSON)
        assert "JSON values" in problem(answer, 400, "bad-request")["detail"]
    assert resident_mb(stack.pids["api"]) - before < 100


def test_a_recording_that_is_too_large_when_stored_is_refused(attacker):
    body = ('{"format": "diaphane-interaction", "version": 1, "viewport": {"width": 64, "height": 64},'
            ' "events": [{"at_ms": 0, "scene": {"x": [' + ",".join(["1e9"] * 100_000) + ']}}]}')
    assert len(body) < 410_000
    errors = problem(attacker.http.post("/v1/recordings", content=body, headers=JSON), 422, "invalid")["errors"]
    assert [e["field"] for e in errors] == ["events"] and "1 MiB" in errors[0]["message"]


def test_a_flood_of_deeply_nested_json_does_not_slow_other_clients(stack, attacker):
    """As in the attack: the same few bodies repeatedly over four connections, while another user works."""
    ordinary = person(stack)
    over, refused, others = threading.Event(), [], []

    def flood(seed: int) -> None:
        with httpx.Client(base_url=stack.url, timeout=30, cookies=attacker.http.cookies,
                          headers={"X-CSRF-Token": attacker.csrf} | JSON | {"If-Match": '"1"'}) as one:
            requests = list(routes().values())
            for turn in range(seed, seed + 4 * len(requests)):
                method, path, body = requests[turn % len(requests)]
                try:
                    status = one.request(method, path, content=body).status_code
                except httpx.HTTPError as error:
                    status = repr(error)
                (refused if status == 400 else others).append(status)

    def work() -> None:
        while not over.is_set():
            for answer in (ordinary.http.get("/v1/me"), ordinary.http.get("/v1/data-sets"),
                           ordinary.http.post("/v1/data-sets", json={"title": "x", "bytes": 10})):
                done.append(answer.status_code)
            ordinary.http.delete(f"/v1/data-sets/{answer.json()['data_set']['id']}")

    done: list[int] = []
    failed: list[str] = []

    def guarded() -> None:
        try:
            work()
        except Exception as error:  # noqa: BLE001 (also an answer of the edge, which is none of the contract)
            failed.append(repr(error))

    threads = [threading.Thread(target=flood, args=(seed,)) for seed in range(4)]
    beside = threading.Thread(target=guarded)
    beside.start()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    over.set()
    beside.join()
    assert not others and len(refused) == 4 * 4 * len(routes())
    assert not failed and len(done) >= 3 and set(done) <= {200, 201}


def test_each_status_has_its_standard_reason_phrase(stack):
    def status_line(request: str) -> bytes:
        with connect(stack.ports["api"]) as one:
            one.sendall(request.encode())
            return read_all(one).split(b"\r\n", 1)[0]

    def get(method: str, path: str, *headers: str, body: str = "") -> bytes:
        lines = [f"{method} {path} HTTP/1.1", "Host: x", "Connection: close", f"Content-Length: {len(body)}", *headers]
        return status_line("\r\n".join(lines) + "\r\n\r\n" + body)

    as_json = "Content-Type: application/json"
    assert get("GET", "/v1/samples") in (b"HTTP/1.1 200 OK", b"HTTP/1.1 404 Not Found")
    assert get("GET", "/v1/me") == b"HTTP/1.1 401 Unauthorized"
    assert get("GET", "/v1/nothing") == b"HTTP/1.1 404 Not Found"
    assert get("PUT", "/v1/me") == b"HTTP/1.1 405 Method Not Allowed"
    assert get("POST", "/v1/sign-in", as_json, body="{") == b"HTTP/1.1 400 Bad Request"
    assert get("POST", "/v1/sign-in", as_json, body="{}") == b"HTTP/1.1 422 Unprocessable Content"
    assert get("POST", "/v1/sign-in", body="{}") == b"HTTP/1.1 415 Unsupported Media Type"
    wrong = json.dumps({"email": "nobody@example.org", "password": PASSWORD})
    assert get("POST", "/v1/sign-in", as_json, body=wrong) == b"HTTP/1.1 401 Unauthorized"
