"""How the API server validates, defaults and explains RenderFleet and RenderWorker."""

import copy
import json

import pytest

pytestmark = pytest.mark.chosen
SINCE = "2026-11-22T12:00:00.000000Z"


def fleet(**spec) -> dict:
    return {"apiVersion": "diaphane.dev/v1alpha1", "kind": "RenderFleet", "metadata": {"name": "gpus"}, "spec": {
        "template": {"metadata": {"labels": {"a": "b"}}, "spec": {"containers": [{"name": "renderd", "image": "diaphane"}]}}, **spec}}


def worker(**spec) -> dict:
    return {"apiVersion": "diaphane.dev/v1alpha1", "kind": "RenderWorker", "metadata": {"name": "gpus-0"}, "spec": {
        "fleetName": "gpus", "fleetUid": "u", "nodeName": "node-0", "templateHash": "h", "template": {"spec": {"x": 1}}, **spec}}


def pods(**spec) -> dict:
    return {"template": {"spec": {"containers": [{"name": "renderd", "image": "diaphane"}], **spec}}}


def create(plane, namespace, what, check=True):
    return plane.kubectl("create", "-n", namespace, "-f", "-", "-o", "json", given=what, check=check)


def patch(plane, namespace, kind, name, spec, check=False):
    return plane.kubectl("patch", kind, name, "-n", namespace, "--type=merge", "-p", json.dumps({"spec": spec}), check=check)


REFUSED = [
    ({"sessionsPerWorker": 0}, "should be greater than or equal to 1"),
    ({"sessionsPerWorker": 5000}, "should be less than or equal to 4096"),
    ({"gpusPerWorker": 0}, "should be greater than or equal to 1"),
    ({"strategy": "Random"}, 'supported values: "LeastLoaded", "Packed"'),
    ({"minReplicas": -1}, "should be greater than or equal to 0"),
    ({"minReplicas": 3, "maxReplicas": 2}, "minReplicas must not be larger than maxReplicas"),
    ({"replicas": 3, "maxReplicas": 2}, "replicas must not be larger than maxReplicas"),
    ({"replicas": -1}, "should be greater than or equal to 0"),
    ({"scaleToZeroAfter": "10m", "minReplicas": 1}, "scaleToZeroAfter requires minReplicas 0"),
    ({"scaleToZeroAfter": "0s"}, "from 1s to 720h"),
    ({"scaleToZeroAfter": "soon"}, "should match"),
    ({"drainTimeout": "25h"}, "at most 24h"),
    ({"drainTimeout": "-5m"}, "should match"),
    ({"drainTimeout": 300}, "must be of type string"),
    ({"warm": {"minIdleSlots": -1}}, "should be greater than or equal to 0"),
    ({"warm": {"maxRefillPerSecond": -0.5}}, "should be greater than or equal to 0"),
    ({"template": {}}, "spec.template.spec: Required value"),
    ({"template": {"spec": {"containers": []}}}, "should have at least 1 items"),
    ({"template": {"spec": {"containers": [{"name": "other", "image": "x"}]}}}, 'exactly one container must be named "renderd"'),
    ({"template": {"spec": {"containers": [{"name": "renderd"}]}}}, "image: Required value"),
    (pods(nodeName="node-0"), "the operator chooses the node"),
    (pods(nodeSelector={"a": "b"}), "use spec.nodeSelector of the fleet"),
    (pods(affinity={"nodeAffinity": {}}), "the operator uses it to place pods"),
    ({"template": {**pods()["template"], "metadata": {"labels": {"diaphane.dev/fleet": "x"}}}}, "the label prefix diaphane.dev/ is reserved"),
    ({"template": {**pods()["template"], "metadata": {"annotations": {"diaphane.dev/epoch": "x"}}}}, "the annotation prefix diaphane.dev/ is reserved"),
    ({"sessionPerWorker": 3}, 'unknown field "spec.sessionPerWorker"'),
]


@pytest.mark.parametrize("spec, words", REFUSED, ids=[words for _, words in REFUSED])
def test_an_invalid_fleet_is_refused_with_the_reason(plane, namespace, spec, words):
    said = create(plane, namespace, fleet(**spec), check=False)
    assert said.code != 0 and words in said.text, said.text


def test_a_name_too_long_for_its_pods_is_refused(plane, namespace):
    named = fleet()
    named["metadata"]["name"] = "f" * 53
    assert "at most 52 characters" in create(plane, namespace, named, check=False).text
    named["metadata"]["name"] = "f" * 52
    create(plane, namespace, named)


def test_omitted_fields_get_defaults(plane, namespace):
    made = create(plane, namespace, fleet()).json["spec"]
    made.pop("template")
    assert made == {"sessionsPerWorker": 16, "gpusPerWorker": 1, "strategy": "LeastLoaded", "minReplicas": 0, "drainTimeout": "5m",
                    "warm": {"minIdleSlots": 0, "maxRefillPerSecond": 0}}


def test_the_template_keeps_every_pod_field(plane, namespace):
    spec = {"template": {"metadata": {"labels": {"app": "x"}, "annotations": {"note": "y"}}, "spec": {
        "containers": [{"name": "renderd", "image": "diaphane", "env": [{"name": "A", "value": "b"}], "ports": [{"containerPort": 8085}]}],
        "affinity": {"podAntiAffinity": {"x": []}}, "tolerations": [{"operator": "Exists"}], "volumes": [{"name": "v", "emptyDir": {}}]}}}
    assert create(plane, namespace, fleet(**copy.deepcopy(spec))).json["spec"]["template"] == spec["template"]


def test_kubectl_scale_changes_a_fleet_up_to_its_maximum(plane, namespace):
    create(plane, namespace, fleet(maxReplicas=5))
    scale = f"/apis/diaphane.dev/v1alpha1/namespaces/{namespace}/renderfleets/gpus"
    plane.api.patch(f"{scale}/status", json={"status": {"replicas": 2, "selector": "diaphane.dev/fleet=gpus"}},
                    headers={"Content-Type": "application/merge-patch+json"}).raise_for_status()
    plane.kubectl("scale", "rf/gpus", "-n", namespace, "--replicas=4")
    seen = plane.api.get(f"{scale}/scale").json()
    assert seen["spec"] == {"replicas": 4} and seen["status"] == {"replicas": 2, "selector": "diaphane.dev/fleet=gpus"}
    said = plane.kubectl("scale", "rf/gpus", "-n", namespace, "--replicas=6", check=False)
    assert said.code != 0 and "larger than maxReplicas" in said.text


def test_spec_and_status_are_changed_separately(plane, namespace):
    create(plane, namespace, {**fleet(), "status": {"replicas": 7}})
    url = f"/apis/diaphane.dev/v1alpha1/namespaces/{namespace}/renderfleets/gpus"
    assert "status" not in plane.api.get(url).json()
    merge = {"Content-Type": "application/merge-patch+json"}
    plane.api.patch(f"{url}/status", json={"status": {"replicas": 1}, "spec": {"sessionsPerWorker": 3}}, headers=merge).raise_for_status()
    plane.api.patch(url, json={"status": {"replicas": 9}}, headers=merge).raise_for_status()
    seen = plane.api.get(url).json()
    assert seen["status"]["replicas"] == 1 and seen["spec"]["sessionsPerWorker"] == 16 and seen["metadata"]["generation"] == 1


def test_kubectl_get_shows_the_main_columns(plane, namespace):
    create(plane, namespace, fleet())
    url = f"/apis/diaphane.dev/v1alpha1/namespaces/{namespace}/renderfleets/gpus/status"
    conditions = [{"type": "Available", "status": "True", "reason": "R", "message": "m", "lastTransitionTime": SINCE},
                  {"type": "CapacityLimited", "status": "True", "reason": "InsufficientNodeCapacity", "message": "m", "lastTransitionTime": SINCE}]
    plane.api.patch(url, json={"status": {"replicas": 3, "readyReplicas": 2, "slotsTotal": 32, "slotsUsed": 5, "conditions": conditions}},
                    headers={"Content-Type": "application/merge-patch+json"}).raise_for_status()
    heads, row = plane.kubectl("get", "rf", "-n", namespace).out.splitlines()
    assert heads.split() == ["NAME", "WORKERS", "READY", "SLOTS", "USED", "AVAILABLE", "LIMITED", "AGE"]
    assert row.split()[:-1] == ["gpus", "3", "2", "32", "5", "True", "InsufficientNodeCapacity"]
    create(plane, namespace, worker(drain={"reason": "Cordoned", "since": SINCE}))
    heads, row = plane.kubectl("get", "rw", "-n", namespace).out.splitlines()
    assert heads.split() == ["NAME", "FLEET", "NODE", "READY", "DRAIN", "EPOCH", "AGE"]
    assert row.split()[:4] == ["gpus-0", "gpus", "node-0", "Cordoned"]
    assert plane.kubectl("get", "diaphane", "-n", namespace, "-o", "name").out.split() == [
        "renderfleet.diaphane.dev/gpus", "renderworker.diaphane.dev/gpus-0"]


FOR_GOOD = [
    ({"nodeName": "node-1"}, "nodeName cannot change, because it reserves GPUs"),
    ({"fleetName": "x"}, "a worker cannot move to another fleet"),
    ({"fleetUid": "x"}, "a worker cannot move to another fleet"),
    ({"fleetUid": None}, "fleetUid and template cannot change; delete the worker, and the operator creates a new one"),
    ({"templateHash": "x"}, "templateHash cannot change"),
    ({"template": None}, "fleetUid and template cannot change; delete the worker, and the operator creates a new one"),
    ({"nodeName": None}, "nodeName: Required value"),
    ({"drain": None}, "a drain cannot be undone"),
    ({"drain": {"reason": "Idle"}}, "a drain cannot change"),
    ({"drain": {"since": "2026-11-22T13:00:00.000000Z"}}, "a drain cannot change"),
]


@pytest.mark.parametrize("change, words", FOR_GOOD, ids=[str(change) for change, _ in FOR_GOOD])
def test_only_the_drain_request_of_a_worker_can_change(plane, namespace, change, words):
    create(plane, namespace, worker())
    patch(plane, namespace, "rw", "gpus-0", {"drain": {"reason": "Upgrade", "since": SINCE}}, check=True)
    said = patch(plane, namespace, "rw", "gpus-0", change)
    assert said.code != 0 and words in said.text, said.text


@pytest.mark.parametrize("spec, words", [
    ({"drain": {"reason": "Whim", "since": SINCE}}, "supported values"),
    ({"drain": {"reason": "Idle"}}, "since: Required value"),
    ({"drain": {"reason": "Idle", "since": "yesterday"}}, "date-time"),
    ({"nodeName": ""}, "should be at least 1 chars long"),
])
def test_an_invalid_worker_is_refused(plane, namespace, spec, words):
    said = create(plane, namespace, worker(**spec), check=False)
    assert said.code != 0 and words in said.text, said.text


@pytest.mark.parametrize("path, words", [
    ("renderfleet", "scales with the number of viewing sessions"),
    ("renderfleet.spec.drainTimeout", "before they are moved"),
    ("renderfleet.spec.warm.minIdleSlots", "free slots to keep at any time"),
    ("renderfleet.spec.template.spec.nodeName", "Must not be set"),
    ("renderfleet.status.refusals", "not tried again for a while"),
    ("renderworker.spec.nodeName", "Node whose GPU this worker reserves"),
    ("renderworker.spec.drain.reason", "ENUM: Cordoned Upgrade Deleted Idle"),
])
def test_kubectl_explain_describes_the_fields(plane, path, words):
    assert words in " ".join(plane.kubectl("explain", path).out.split())


def test_every_crd_field_has_a_description(plane):
    """Except fields of every Kubernetes object, and self-explanatory names."""
    plain = {"apiVersion", "kind", "metadata", "conditions", "name", "image", "labels", "annotations", "node", "type", "status", "observedGeneration",
             "failedAt", "nodeSelector"}
    silent = []

    def walk(schema, path):
        for name, inner in schema.get("properties", {}).items():
            if "description" not in inner and name not in plain:
                silent.append(f"{path}.{name}")
            walk(inner, f"{path}.{name}")
        if "items" in schema:
            walk(schema["items"], path + "[]")

    for kind in ("renderfleets", "renderworkers"):
        crd = plane.api.get(f"/apis/apiextensions.k8s.io/v1/customresourcedefinitions/{kind}.diaphane.dev").json()
        walk(crd["spec"]["versions"][0]["schema"]["openAPIV3Schema"], kind)
        assert not [c for c in crd["status"]["conditions"] if c["type"] == "NonStructuralSchema" and c["status"] == "True"]
    assert silent == []


def test_deleting_a_fleet_deletes_its_workers(plane, namespace):
    owner = create(plane, namespace, fleet()).json["metadata"]
    owned = worker()
    owned["metadata"]["ownerReferences"] = [{"apiVersion": "diaphane.dev/v1alpha1", "kind": "RenderFleet", "name": "gpus", "uid": owner["uid"],
                                             "controller": True, "blockOwnerDeletion": True}]
    create(plane, namespace, owned)
    plane.kubectl("delete", "rf/gpus", "-n", namespace)
    plane.kubectl("wait", "--for=delete", "rw/gpus-0", "-n", namespace, "--timeout=120s")
