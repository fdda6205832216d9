"""Every query of the chart's dashboard finds its metric and labels in the output of the real programs."""

from __future__ import annotations

import shutil
import time
import uuid

import httpx
import pytest
from api_client import person
from dashboard_helpers import asked, unanswered
from stream_helpers import Viewer, open_session, store_ball
from websockets.exceptions import ConnectionClosed

from harness import TestStack

#: Programs that are queried here. tests/cluster queries the operator.
PROGRAMS = ("api", "gateway", "renderd", "ingestd")
PREFIXES = ("diaphane_api_", "diaphane_stream_", "diaphane_renderd_", "diaphane_ingest_", "diaphane_start_")


def metrics(stack: TestStack) -> str:
    return "".join(stack.metrics(one) for one in PROGRAMS)


def test_every_dashboard_query_has_data(stack):
    somebody = person(stack)
    ball = store_ball(stack, somebody)
    session, url = open_session(somebody, ball)
    viewer = Viewer(stack.url, url)
    viewer.frame()
    # A refused ticket and an invalid upload, because counters by kind appear with the first event.
    httpx.get(f"{stack.url}/stream?ticket={'0' * 64}", headers={"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
                                                                "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==", "Origin": stack.url,
                                                                "Sec-WebSocket-Protocol": "diaphane.v1"}, timeout=60)
    viewer.leave()
    # A worker without that volume ends its call with an error.
    gone = store_ball(stack, somebody)
    shutil.rmtree(stack.data_dir / "volumes" / gone)
    lost, url = open_session(somebody, gone)
    with pytest.raises((AssertionError, ConnectionClosed, TimeoutError)):
        Viewer(stack.url, url).frame()
    for one in (session, lost):
        somebody.http.delete(f"/v1/sessions/{one}")
    somebody.upload(uuid.uuid4().bytes * 40)
    deadline = time.monotonic() + 60
    while unanswered(PREFIXES, metrics(stack)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert unanswered(PREFIXES, metrics(stack)) == []
    assert {metric for _, metric, _ in asked() if not metric.startswith((*PREFIXES, "diaphane_operator_"))} == set()
