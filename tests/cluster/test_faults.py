"""Faults around the operator on the real control plane: Redis, a node, and each of Kubernetes' own programs."""

from __future__ import annotations

import threading

import pytest
from conftest import wait_for
from operator_helpers import GROUP


def uids(cluster) -> set[str]:
    return {one["metadata"]["uid"] for one in cluster.running()}


def test_workers_are_not_scaled_during_a_redis_outage(cluster):
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
    # It starts empty, and heartbeats fill it.
    cluster.redis.start()
    wait_for(lambda: cluster.condition("MetricsFresh").get("status") == "True", "that load is known again")
    cluster.settled(2)
    assert uids(cluster) == pods and cluster.over_committed() == []


def test_the_worker_of_a_lost_and_deleted_node_moves_to_another(cluster):
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


def test_an_unreachable_node_keeps_its_slots_until_it_is_out_of_service(cluster):
    first, second = cluster.nodes(2, gpus=1)
    cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    worker = cluster.workers()[0]
    name, lost = worker["metadata"]["name"], worker["spec"]["nodeName"]

    def is_lost() -> bool:
        said = next(one for one in cluster.workers() if one["metadata"]["name"] == name).get("status", {}).get("conditions", [])
        return any(one["type"] == "NodeLost" and one["status"] == "True" for one in said)
    cluster.beats.silent.add(name)
    cluster.plane.stop_program("kwok")       # which simulates all nodes
    try:
        wait_for(is_lost, "NodeLost")
        # Another worker may have replaced it by now, but its reservation goes to no other worker.
        assert [one["metadata"]["uid"] for one in cluster.workers() if one["spec"]["nodeName"] == lost] == [worker["metadata"]["uid"]]
        cluster.plane.kubectl("taint", "node", lost, "node.kubernetes.io/out-of-service=gone:NoExecute")
        wait_for(lambda: worker["metadata"]["uid"] not in {one["metadata"]["uid"] for one in cluster.workers()}, "the end of its reservation")
    finally:
        cluster.beats.silent.clear()
        cluster.plane.start_program("kwok")
    cluster.settled(1)
    assert cluster.running()[0]["spec"]["nodeName"] == (second if lost == first else first)


def test_a_write_of_an_outdated_object_is_refused_and_retried(cluster):
    """A worker changes constantly, so that the operator's copy of it is never current."""
    first, second = cluster.nodes(2, gpus=1)
    operator = cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    worker = cluster.workers()[0]
    path = f"{GROUP}/namespaces/{cluster.namespace}/renderworkers/{worker['metadata']['name']}"
    over = threading.Event()

    def write(who: int) -> None:
        number = 0
        with cluster.plane.client() as api:
            while not over.is_set():
                number += 1
                api.patch(path, headers={"Content-Type": "application/merge-patch+json"}, json={"metadata": {"annotations": {f"note-{who}": str(number)}}})
    writers = [threading.Thread(target=write, args=(who,)) for who in range(2)]
    for one in writers:
        one.start()
    try:
        cluster.plane.kubectl("cordon", worker["spec"]["nodeName"])
        wait_for(lambda: '"reason":"Conflict"' in operator.log.read_text(encoding="utf-8"), "a write that was overtaken")
    finally:
        over.set()
        for one in writers:
            one.join()
    wait_for(lambda: worker["metadata"]["uid"] not in {one["metadata"]["uid"] for one in cluster.workers()}, "the drained worker's end")
    cluster.settled(1)
    assert cluster.running()[0]["spec"]["nodeName"] == (second if worker["spec"]["nodeName"] == first else first)


@pytest.mark.parametrize("program", ["etcd", "kube-scheduler", "kube-controller-manager"])
def test_killing_a_control_plane_program_breaks_nothing(cluster, program):
    cluster.nodes(1, gpus=4)
    cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    pods = uids(cluster)
    cluster.plane.kill(program)
    try:
        if program != "etcd":       # nothing can be queried without it
            cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=3", "-n", cluster.namespace)
            wait_for(lambda: len(cluster.workers()) == 3, "the workers, for which neither is needed")
    finally:
        cluster.plane.start_program(program)
    if program == "etcd":
        def scaled() -> bool:
            return cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=3", "-n", cluster.namespace, check=False).code == 0
        wait_for(scaled, "an API server that answers")
        if not cluster.operators[-1].alive():       # it could not renew its lease, and exited as it should
            assert cluster.operators[-1].process.returncode == 75
            cluster.operator()
    cluster.settled(3)
    assert pods <= uids(cluster) and cluster.over_committed() == []
