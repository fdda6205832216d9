"""How the Python client talks to the REST API. The server is a function here."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

import httpx
import pytest
from diaphane import (AuthenticationError, BusyError, ConnectionLost, Diaphane, ForbiddenError, InvalidError, NotFoundError, QuotaError, Scan, ScanError,
                      UploadInterrupted, WaitedTooLong)
from diaphane import _upload
from diaphane._generated.operations import OPERATIONS

PACKAGE = Path(__file__).resolve().parents[2] / "clients" / "python"
SCAN = {"id": "7", "title": "Head", "state": "ready", "refusal": None}


def client(answer) -> Diaphane:
    return Diaphane("https://see.example/", "diaphane_x", http=httpx.Client(transport=httpx.MockTransport(answer)))


def problem(status: int, kind: str, headers: dict | None = None, **more) -> httpx.Response:
    return httpx.Response(status, json={"type": f"urn:diaphane:problem:{kind}", "title": "T", "status": status, "request_id": "r", **more},
                          headers={"content-type": "application/problem+json", **(headers or {})})


def test_a_token_is_required(monkeypatch):
    monkeypatch.delenv("DIAPHANE_TOKEN", raising=False)
    with pytest.raises(ValueError, match="token"):
        Diaphane("https://see.example")
    monkeypatch.setenv("DIAPHANE_TOKEN", "diaphane_x")
    Diaphane("https://see.example").close()
    with pytest.raises(ValueError, match="https"):
        Diaphane("see.example")


def test_lists_all_pages_with_the_token():
    def answer(request: httpx.Request) -> httpx.Response:
        assert request.headers["authorization"] == "Bearer diaphane_x"
        second = request.url.params.get("cursor") == "next"
        return httpx.Response(200, json={"items": [{**SCAN, "id": "b" if second else "a"}], "next_cursor": None if second else "next"})

    assert [scan.id for scan in client(answer).scans()] == ["a", "b"]


@pytest.mark.parametrize("status, kind, error", [
    (401, "unauthenticated", AuthenticationError), (403, "forbidden", ForbiddenError), (404, "not-found", NotFoundError),
    (409, "over-quota", QuotaError), (422, "invalid", InvalidError), (429, "too-many", BusyError), (503, "unavailable", BusyError)])
def test_each_problem_has_its_exception(status, kind, error):
    with pytest.raises(error, match="In words.*title: too long") as caught:
        Scan(client(lambda _: problem(status, kind, detail="In words", errors=[{"field": "title", "message": "too long"}])).api, SCAN).rename("x")
    assert (caught.value.kind, caught.value.status, caught.value.request_id) == (kind, status, "r")


def test_an_answer_without_a_problem_document_is_an_error_too():
    with pytest.raises(Exception, match="502"):
        client(lambda _: httpx.Response(502, text="<html>")).scan("7")


def test_a_busy_server_is_asked_again_but_a_change_is_not_repeated(monkeypatch):
    monkeypatch.setattr("time.sleep", lambda _: None)
    asked = []

    def answer(request: httpx.Request) -> httpx.Response:
        asked.append(request.method)
        return problem(503, "unavailable", {"retry-after": "1"}) if len(asked) < 3 else httpx.Response(200, json=SCAN)

    scan = client(answer).scan("7")
    assert scan.title == "Head" and asked == ["GET"] * 3
    asked.clear()
    with pytest.raises(BusyError):
        scan.delete()
    assert asked == ["DELETE"]


def test_waiting_ends_when_the_scan_is_ready_or_refused():
    states = iter(["queued", "building", "ready"])
    assert Scan(client(lambda _: httpx.Response(200, json={**SCAN, "state": next(states)})).api, SCAN).wait(interval=0).state == "ready"
    refused = {**SCAN, "state": "refused", "refusal": {"code": "too_few_slices", "text": "It has one slice."}}
    with pytest.raises(ScanError, match="one slice") as caught:
        Scan(client(lambda _: httpx.Response(200, json=refused)).api, SCAN).wait()
    assert caught.value.code == "too_few_slices"
    with pytest.raises(WaitedTooLong, match="queued"):
        Scan(client(lambda _: httpx.Response(200, json={**SCAN, "state": "queued"})).api, SCAN).wait(timeout=0)


class Uploads:
    """Takes uploads like the server. Loses the responses to some parts, and whole requests with others, by their numbers."""

    def __init__(self, lose_response: tuple[int, ...] = (), lose_request: tuple[int, ...] = ()):
        self.received, self.parts, self.announced = b"", 0, 0
        self.lose_response, self.lose_request = lose_response, lose_request

    def __call__(self, request: httpx.Request) -> httpx.Response:
        if request.url.path == "/v1/data-sets":
            assert request.headers["idempotency-key"]
            self.announced = json.loads(request.content)["bytes"]
            return httpx.Response(201, json={"data_set": SCAN, "upload_url": "/v1/uploads/7"})
        if request.method == "GET":
            return httpx.Response(200, json=SCAN)
        assert request.headers["tus-resumable"] == "1.0.0"
        if request.method == "HEAD":
            return httpx.Response(200, headers={"upload-offset": str(len(self.received))})
        self.parts += 1
        if self.parts in self.lose_request:
            raise httpx.ConnectError("lost")
        if int(request.headers["upload-offset"]) != len(self.received):
            return problem(409, "offset-mismatch")
        assert request.headers["upload-checksum"].startswith("sha256 ")
        self.received += request.content
        if self.parts in self.lose_response:
            raise httpx.ReadError("lost")
        return httpx.Response(204, headers={"upload-offset": str(len(self.received))})


@pytest.fixture
def small_parts(monkeypatch):
    monkeypatch.setattr(_upload, "PART", 1000)
    monkeypatch.setattr("time.sleep", lambda _: None)
    monkeypatch.setattr("diaphane.client.clean_files", lambda path, series, phases: [hashlib.sha256(str(path).encode()).digest() * 60])


def test_an_upload_continues_where_the_server_is(small_parts):
    server = Uploads(lose_response=(1,), lose_request=(3,))
    shares: list[float] = []
    assert client(server).upload("folder", progress=shares.append).id == "7"
    assert len(server.received) == server.announced == len(_upload.bundle([hashlib.sha256(b"folder").digest() * 60]))
    assert shares == sorted(shares) and shares[-1] == 1


def test_an_interrupted_upload_can_be_resumed_later(small_parts):
    server = Uploads(lose_request=(2, 3, 4))
    with pytest.raises(UploadInterrupted) as caught:
        client(server).upload("folder", patience=0)
    assert 0 < len(server.received) < server.announced
    server.announced = 0
    client(server).upload("folder", resume=caught.value.scan_id)
    assert server.announced == 0, "nothing new was announced"
    assert len(server.received) == len(_upload.bundle([hashlib.sha256(b"folder").digest() * 60]))


def test_a_server_that_cannot_be_reached_is_named():
    def answer(_):
        raise httpx.ConnectError("refused")

    with pytest.raises(ConnectionLost, match="https://see.example"):
        next(client(answer).api.json("deleteDataSet", data_set_id="7"))


def test_the_code_uses_only_operations_that_tokens_can_use():
    used = {name for path in (PACKAGE / "src" / "diaphane").glob("*.py")
            for name in re.findall(r'\.(?:call|json)\(\s*"(\w+)"', path.read_text(encoding="utf-8"))}
    assert len(used) > 8 and used <= set(OPERATIONS)
