"""The control plane itself, on which the other tests rely."""

import httpx
from conftest import wait_for


def a_pod(name: str, **spec) -> dict:
    container = {"name": "it", "image": "none", "resources": {"limits": {"nvidia.com/gpu": "1"}}, "securityContext": {
        "allowPrivilegeEscalation": False, "capabilities": {"drop": ["ALL"]}}}
    return {"apiVersion": "v1", "kind": "Pod", "metadata": {"name": name}, "spec": {
        "containers": [container], "securityContext": {"runAsNonRoot": True, "seccompProfile": {"type": "RuntimeDefault"}}, **spec}}


def test_a_pod_with_a_gpu_is_scheduled_and_runs(plane, namespace):
    plane.kubectl("create", "-n", namespace, "-f", "-", given=a_pod("one"))
    plane.kubectl("wait", "-n", namespace, "pod/one", "--for=condition=Ready", "--timeout=60s")
    assert plane.kubectl("get", "pod", "one", "-n", namespace, "-o", "jsonpath={.spec.nodeName}").out


def test_a_pod_beyond_the_gpu_capacity_is_not_scheduled(plane, namespace):
    pod = a_pod("greedy")
    pod["spec"]["containers"][0]["resources"]["limits"]["nvidia.com/gpu"] = "9"
    plane.kubectl("create", "-n", namespace, "-f", "-", given=pod)
    said = wait_for(lambda: plane.kubectl("get", "pod", "greedy", "-n", namespace, "-o",
                                          'jsonpath={.status.conditions[?(@.type=="PodScheduled")].message}').out, "the scheduler's word")
    assert "Insufficient nvidia.com/gpu" in said


def test_a_pod_that_violates_the_restricted_standard_is_refused(plane, namespace):
    pod = a_pod("root")
    pod["spec"]["securityContext"] = {}
    said = plane.kubectl("create", "-n", namespace, "-f", "-", given=pod, check=False)
    assert said.code != 0 and 'violates PodSecurity "restricted' in said.text


def test_a_watch_from_a_compacted_revision_gets_410(plane, namespace):
    url = f"/api/v1/namespaces/{namespace}/configmaps"
    first = plane.api.get(url).json()["metadata"]["resourceVersion"]
    for number in range(3):
        plane.api.post(url, json={"metadata": {"name": f"c-{number}"}}).raise_for_status()
    plane.compact()
    plane.kill("kube-apiserver")      # its memory would still answer
    plane.start_program("kube-apiserver")
    answer = plane.api.get(url, params={"watch": "1", "resourceVersion": first, "timeoutSeconds": "5"})
    assert answer.status_code == 410 or '"code":410' in answer.text


def test_a_deployment_waits_for_a_stopped_controller_manager(plane, namespace):
    plane.stop_program("kube-controller-manager")
    pod = a_pod("x")
    deployment = {"apiVersion": "apps/v1", "kind": "Deployment", "metadata": {"name": "d"}, "spec": {
        "selector": {"matchLabels": {"a": "b"}}, "template": {"metadata": {"labels": {"a": "b"}}, "spec": pod["spec"]}}}
    plane.kubectl("create", "-n", namespace, "-f", "-", given=deployment)
    assert plane.kubectl("get", "pods", "-n", namespace, "-o", "name").out == ""
    plane.start_program("kube-controller-manager")
    plane.kubectl("rollout", "status", "-n", namespace, "deployment/d", "--timeout=120s")


def test_an_unauthenticated_request_is_refused(plane):
    assert plane.client(token="nobody").get("/api/v1/nodes").status_code == 401
    assert httpx.get(f"{plane.server}/api/v1/nodes", verify=False, trust_env=False).status_code == 403
