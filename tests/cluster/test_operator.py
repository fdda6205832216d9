"""The operator's program against the real API server, scheduler and controller manager, with kwok's nodes and workers that send
heartbeats like renderd."""

from __future__ import annotations

import time

import pytest
from conftest import wait_for
from operator_helpers import GROUP


@pytest.mark.chosen
def test_a_fleet_creates_one_worker_and_pod_per_gpu(cluster):
    nodes = cluster.nodes(2, gpus=2)
    operator = cluster.operator()
    cluster.fleet(replicas=4)
    cluster.settled(4)
    assert sorted(one["spec"]["nodeName"] for one in cluster.pods()) == sorted(nodes * 2)
    for pod in cluster.pods():
        worker = next(one for one in cluster.workers() if one["metadata"]["name"] == pod["metadata"]["name"])
        assert pod["spec"]["nodeName"] == worker["spec"]["nodeName"]
        assert pod["metadata"]["ownerReferences"][0]["uid"] == worker["metadata"]["uid"]
        assert pod["spec"]["containers"][0]["resources"]["limits"]["nvidia.com/gpu"] == "1"
    assert operator.ready()["ready"] and operator.ready()["leader"]
    status = cluster.status()
    assert status["slotsTotal"] == 16 and status["observedGeneration"] == 1
    assert cluster.condition("Available")["status"] == "True"
    assert {one["reason"] for one in cluster.events() if one["involvedObject"]["kind"] == "RenderFleet"} == {"Placed"}
    assert "diaphane_operator_leader 1" in operator.metrics()


def test_scaling_and_deleting_a_fleet_leaves_nothing_behind(cluster):
    cluster.nodes(1, gpus=4)
    cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=3", "-n", cluster.namespace)
    cluster.settled(3)
    cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=1", "-n", cluster.namespace)
    cluster.settled(1)
    cluster.plane.kubectl("delete", "renderfleet/skull", "-n", cluster.namespace, "--wait=false")
    wait_for(lambda: not cluster.pods() and not cluster.workers(), "the end of all that was made")
    wait_for(lambda: cluster.plane.api.get(f"{GROUP}/namespaces/{cluster.namespace}/renderfleets/skull").status_code == 404, "the fleet's end")


def test_missing_capacity_is_reported_and_gpus_are_never_overcommitted(cluster):
    cluster.nodes(2, gpus=1)
    cluster.operator()
    cluster.fleet(replicas=5)
    wait_for(lambda: cluster.condition("CapacityLimited").get("status") == "True" and len(cluster.running()) == 2, "CapacityLimited")
    assert "Missing workers: 3." in cluster.condition("CapacityLimited")["message"]
    assert cluster.over_committed() == [] and len(cluster.workers()) == 2


def test_a_cordoned_node_is_drained_without_ending_sessions(cluster):
    first, second = cluster.nodes(2, gpus=1)
    cluster.operator()
    cluster.fleet(replicas=1, drainTimeout="10m")
    cluster.settled(1)
    pod = cluster.running()[0]
    on, name = pod["spec"]["nodeName"], pod["metadata"]["name"]
    cluster.beats.sessions[name] = ["11111111-1111-4111-8111-111111111111"]
    wait_for(lambda: cluster.status().get("slotsUsed") == 1, "the session in the status")
    cluster.plane.kubectl("cordon", on)
    wait_for(lambda: pod["metadata"]["uid"] in cluster.beats.told, "the worker that is told to drain")
    wait_for(lambda: any(one["spec"]["nodeName"] != on for one in cluster.running()), "the other in its place")
    time.sleep(6)  # longer than anything but its grace period would let it live
    assert any(one["metadata"]["uid"] == pod["metadata"]["uid"] for one in cluster.running())
    cluster.beats.sessions[name] = []
    wait_for(lambda: all(one["metadata"]["uid"] != pod["metadata"]["uid"] for one in cluster.pods()), "the end of the drained pod")
    cluster.settled(1)
    assert cluster.running()[0]["spec"]["nodeName"] == (second if on == first else first)


def test_manually_deleted_or_edited_objects_are_restored(cluster):
    cluster.nodes(1, gpus=2)
    cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    pod, worker = cluster.running()[0], cluster.workers()[0]
    name, ns = pod["metadata"]["name"], cluster.namespace
    cluster.plane.kubectl("label", "pod", name, "diaphane.dev/worker-", "-n", ns)
    cluster.plane.kubectl("label", "renderworker", name, "diaphane.dev/fleet=other", "--overwrite", "-n", ns)
    cluster.plane.kubectl("patch", "renderworker", name, "-n", ns, "--type=merge", "-p", '{"metadata":{"finalizers":null,"ownerReferences":null}}')

    def is_put_back() -> bool:
        now, owner = cluster.workers()[0]["metadata"], worker["metadata"]["ownerReferences"]
        return (cluster.running()[0]["metadata"]["labels"].get("diaphane.dev/worker") == name and now["labels"]["diaphane.dev/fleet"] == "skull"
                and now.get("finalizers") == ["diaphane.dev/drain"] and now.get("ownerReferences", [{}])[0].get("uid") == owner[0]["uid"])
    wait_for(is_put_back, "labels, finalizer and owner")
    cluster.plane.kubectl("delete", "pod", name, "-n", ns, "--wait=false")
    wait_for(lambda: any(one["metadata"]["uid"] != pod["metadata"]["uid"] for one in cluster.running()), "another pod")
    cluster.settled(1)
    assert cluster.workers()[0]["metadata"]["uid"] == worker["metadata"]["uid"]
    assert cluster.running()[0]["metadata"]["annotations"]["diaphane.dev/epoch"] == "2"


def test_a_manually_edited_worker_template_is_not_used(cluster):
    cluster.nodes(1, gpus=1)
    cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    pod, ns = cluster.running()[0]["metadata"], cluster.namespace
    template = cluster.workers()[0]["spec"]["template"]
    template["spec"]["containers"][0]["image"] = "evil"
    cluster.plane.api.patch(f"{GROUP}/namespaces/{ns}/renderworkers/{pod['name']}", headers={"Content-Type": "application/merge-patch+json"},
                            json={"spec": {"template": template}}).raise_for_status()
    cluster.plane.kubectl("delete", "pod", pod["name"], "-n", ns, "--wait=false")
    cluster.settled(1)
    now = cluster.running()[0]
    assert now["metadata"]["uid"] != pod["uid"] and now["spec"]["containers"][0]["image"] == "diaphane:test"


def test_a_foreign_pod_with_our_label_and_name_is_left_alone(cluster):
    node, = cluster.nodes(1, gpus=2)
    foreign = cluster.fleet_object()["spec"]["template"]["spec"]
    foreign["containers"][0]["resources"] = {"limits": {"nvidia.com/gpu": "1"}}
    cluster.plane.apply({"apiVersion": "v1", "kind": "Pod", "metadata": {
        "name": "skull-0", "namespace": cluster.namespace, "labels": {"diaphane.dev/fleet": "skull", "diaphane.dev/worker": "skull-0"}},
        "spec": {**foreign, "nodeSelector": {"pool": cluster.namespace}}})
    wait_for(cluster.running, "their pod")
    theirs = cluster.pods()[0]["metadata"]
    cluster.operator()
    cluster.fleet(replicas=2)
    wait_for(lambda: len(cluster.running()) == 2 and cluster.condition("CapacityLimited").get("status") == "True", "the one GPU that is left")
    assert [one["metadata"]["name"] for one in cluster.workers()] == ["skull-1"]
    still = next(one["metadata"] for one in cluster.pods() if one["metadata"]["name"] == "skull-0")
    assert still["uid"] == theirs["uid"] and "ownerReferences" not in still and "deletionTimestamp" not in still


def test_a_leader_suspended_past_its_lease_exits_without_acting(cluster):
    cluster.nodes(2, gpus=4)
    first = cluster.operator()
    wait_for(lambda: first.ready().get("leader"), "a leader")
    second = cluster.operator()
    wait_for(lambda: second.ready().get("ready"), "the other")
    assert not second.ready()["leader"]
    cluster.fleet(replicas=3)
    cluster.settled(3)
    before = {one["metadata"]["uid"] for one in cluster.pods()}
    first.pause()
    wait_for(lambda: second.ready().get("leader"), "the other leader", timeout=60)
    cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=5", "-n", cluster.namespace)
    first.pause(on=False)
    wait_for(lambda: not first.alive(), "the end of the first")
    assert first.process.returncode == 75
    cluster.settled(5)
    assert before <= {one["metadata"]["uid"] for one in cluster.pods()} and cluster.over_committed() == []


def test_the_next_leader_continues_after_the_leader_is_killed(cluster):
    cluster.nodes(2, gpus=4)
    first = cluster.operator()
    cluster.fleet(replicas=8)
    wait_for(cluster.workers, "the first worker")
    first.kill()
    second = cluster.operator()
    cluster.settled(8)
    assert cluster.over_committed() == []
    assert second.stop() == 0
    third = cluster.operator()
    # The lease was released, so there is no wait for its expiry.
    wait_for(lambda: third.ready().get("leader"), "the third leader", timeout=13)


def test_missed_events_are_recovered_by_a_new_list_after_a_compaction(cluster):
    """Its watches are interrupted while it is suspended, and the revision at which they would resume is compacted away (410)."""
    cluster.nodes(1, gpus=4)
    leader = cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    # A process that does not lead may be suspended for any time.
    standby = cluster.operator()
    wait_for(lambda: standby.ready().get("ready"), "the standby")
    leader.kill()
    standby.pause()
    for number in range(10):
        cluster.plane.kubectl("annotate", "renderfleet/skull", f"note={number}", "--overwrite", "-n", cluster.namespace)
    cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=3", "-n", cluster.namespace)
    cluster.plane.compact()
    cluster.plane.kill("kube-apiserver")
    cluster.plane.start_program("kube-apiserver")
    standby.pause(on=False)
    cluster.settled(3)
    assert '"relist"' in standby.log.read_text(encoding="utf-8")


def test_the_operator_survives_and_reports_an_outage_of_the_api_server(cluster):
    cluster.nodes(1, gpus=4)
    operator = cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    pod = cluster.running()[0]["metadata"]["uid"]
    standby = cluster.operator()
    wait_for(lambda: standby.ready().get("ready"), "the standby")
    cluster.plane.kill("kube-apiserver")
    try:
        wait_for(lambda: not standby.ready()["checks"]["kubernetes"], "not ready")
        assert standby.alive()
        wait_for(lambda: not operator.alive(), "the leader's end, who cannot renew", timeout=40)
    finally:
        cluster.plane.start_program("kube-apiserver")
    wait_for(lambda: standby.ready().get("leader"), "the standby's lead")
    cluster.plane.kubectl("scale", "renderfleet/skull", "--replicas=2", "-n", cluster.namespace)
    cluster.settled(2)
    assert pod in {one["metadata"]["uid"] for one in cluster.running()}


def test_demand_adds_a_worker_when_the_last_slot_is_taken(cluster):
    cluster.nodes(1, gpus=4)
    cluster.operator()
    cluster.fleet(sessionsPerWorker=2, maxReplicas=4)
    cluster.settled(1)
    cluster.beats.sessions["skull-0"] = ["11111111-1111-4111-8111-111111111111", "22222222-2222-4222-8222-222222222222"]
    cluster.settled(2)
    assert cluster.status()["slotsUsed"] == 2
