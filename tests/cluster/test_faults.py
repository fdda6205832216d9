"""What fails around the operator, on the real control plane: Redis, a node, each of Kubernetes' own programs."""

from __future__ import annotations

import pytest
from conftest import wait_for


def uids(cluster) -> set[str]:
    return {one["metadata"]["uid"] for one in cluster.running()}


def test_while_redis_is_away_nobody_is_added_or_taken_away(cluster):
    cluster.nodes(1, gpus=4)
    operator = cluster.operator()
    cluster.fleet(replicas=2)
    cluster.settled(2)
    wait_for(lambda: cluster.condition("MetricsFresh").get("status") == "True", "that load is known")
    pods = uids(cluster)
    cluster.redis.stop()
    wait_for(lambda: cluster.condition("MetricsFresh").get("status") == "False", "that load is not known")
    assert operator.alive() and not operator.ready()["checks"]["redis"] and operator.ready()["leader"]
    assert uids(cluster) == pods and len(cluster.workers()) == 2
    # Empty, it is filled by heartbeats.
    cluster.redis.start()
    wait_for(lambda: cluster.condition("MetricsFresh").get("status") == "True", "that load is known again")
    cluster.settled(2)
    assert uids(cluster) == pods and cluster.over_committed() == []


def test_a_node_that_is_lost_and_deleted_gives_its_worker_to_another(cluster):
    first, second = cluster.nodes(2, gpus=1)
    cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    pod = cluster.running()[0]
    lost = pod["spec"]["nodeName"]
    cluster.beats.silent.add(pod["metadata"]["name"])
    cluster.plane.kubectl("delete", "node", lost, "--wait=false")
    wait_for(lambda: pod["metadata"]["uid"] not in {one["metadata"]["uid"] for one in cluster.pods()}, "the end of its pod")
    cluster.beats.silent.clear()
    cluster.settled(1)
    assert cluster.running()[0]["spec"]["nodeName"] == (second if lost == first else first)
    assert [one["spec"]["nodeName"] for one in cluster.workers()] == [cluster.running()[0]["spec"]["nodeName"]]


@pytest.mark.parametrize("program", ["etcd", "kube-scheduler", "kube-controller-manager"])
def test_a_program_of_the_control_plane_that_was_killed_holds_up_and_breaks_nothing(cluster, program):
    cluster.nodes(1, gpus=4)
    cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    pods = uids(cluster)
    cluster.plane.kill(program)
    try:
        if program != "etcd":       # without it nothing can be asked for
            cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=3", "-n", cluster.namespace)
            wait_for(lambda: len(cluster.workers()) == 3, "the workers, for which neither is needed")
    finally:
        cluster.plane.start_program(program)
    if program == "etcd":
        def scaled() -> bool:
            return cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=3", "-n", cluster.namespace, check=False).code == 0
        wait_for(scaled, "an API server that answers")
        if not cluster.operators[-1].alive():       # it could not renew its lease, and ended as it should
            assert cluster.operators[-1].process.returncode == 75
            cluster.operator()
    cluster.settled(3)
    assert pods <= uids(cluster) and cluster.over_committed() == []
