"""The service of the analysis, as a process of its own."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time

import httpx
import numpy as np
import pytest

from devtool import study
from diaphane_studies import serve, simulate


@pytest.fixture(scope="module")
def url(tmp_path_factory):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    env = {**os.environ, **study.environment(study.libraries(), study.PACKAGE), "DIAPHANE_PORT": str(port)}
    log = tmp_path_factory.mktemp("analysis") / "log"
    with log.open("wb") as out, subprocess.Popen([sys.executable, "-m", "diaphane_studies.serve"], env=env, stdout=out, stderr=out) as process:
        address = f"http://127.0.0.1:{port}"
        while process.poll() is None:
            try:
                httpx.get(address + "/readyz")
                break
            except httpx.TransportError:
                time.sleep(0.05)
        yield address
        process.terminate()
        assert process.wait(20) == 0
    assert log.read_text().splitlines() == [f"listening on 127.0.0.1:{port}"]    # nothing of any request


def test_an_export_is_analysed_in_the_language_that_is_asked_for(url):
    document = simulate.sus(np.random.default_rng(1))
    found = {language: httpx.post(url + "/analyse", params={"language": language}, json=document, timeout=60) for language in ("en", "de")}
    assert {one.status_code for one in found.values()} == {200}
    assert [one.json()["sections"][0]["title"] for one in found.values()] == ["Participants", "Teilnehmende"]
    assert set(found["en"].json()["adoptable"]) == {"comfort", "tours"}


@pytest.mark.parametrize("path, body, status", [("/analyse", b"{}", 422), ("/analyse?language=fr", b"{}", 400), ("/other", b"{}", 404)])
def test_a_bad_request_is_refused_with_a_reason(url, path, body, status):
    answer = httpx.post(url + path, content=body, timeout=60)
    assert answer.status_code == status and answer.json()["error"]


def test_a_body_that_is_too_large_is_refused_before_it_is_read(url):
    host, port = url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), 10) as connection:
        connection.sendall(b"POST /analyse HTTP/1.1\r\nHost: a\r\nContent-Length: 33554433\r\n\r\n")
        assert connection.recv(100).startswith(b"HTTP/1.1 413")


def test_an_analysis_ends_at_its_time_limit(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", study.environment(study.libraries(), study.PACKAGE)["PYTHONPATH"])
    status, answer = serve.analysed(json.dumps(simulate.comfort(np.random.default_rng(1))).encode(), "en", seconds=0.05)
    assert status == 503 and "longer" in answer["error"]
