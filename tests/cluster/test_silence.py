"""Connections that die silently."""

from __future__ import annotations

import time

from conftest import wait_for
from blackhole_proxy import BlackholeProxy


def test_a_silently_dead_watch_is_detected_and_restarted(cluster, record_property):
    """The API server sends a bookmark every minute. Without one for a minute and a quarter, the operator watches again from the
    last revision."""
    wire = BlackholeProxy(cluster.plane.server)
    try:
        cluster.nodes(2, gpus=1)
        operator = cluster.operator(server=wire.url)
        cluster.fleet(replicas=1)
        cluster.settled(1)
        assert wire.stick() >= 4, "four watches"
        # Only the watch reports a node's cordon. No write and no heartbeat does.
        cluster.plane.kubectl("cordon", cluster.running()[0]["spec"]["nodeName"])
        began = time.monotonic()
        wait_for(lambda: any(one["spec"].get("drain", {}).get("reason") == "Cordoned" for one in cluster.workers()), "the change that no event announced", timeout=150)
        record_property("noticed_s", time.monotonic() - began)
        print(f"noticed after {time.monotonic() - began:.0f} s")
        cluster.settled(1)
        assert operator.alive() and operator.ready()["leader"]
        assert '{kind="nodes",what="silent"} 1' in operator.metrics()
        assert '"relist"' not in operator.log.read_text(encoding="utf-8")
        assert operator.metrics().count('what="failures"} 0') == 4, "nothing failed: it was noticed"
    finally:
        for one in cluster.operators:
            one.stop()
        wire.close()
