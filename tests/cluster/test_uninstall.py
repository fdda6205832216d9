"""`helm uninstall` completes with an operator that drains, with one that does not finish in time, and with none. Its hook has
only the rights that this needs."""

from __future__ import annotations

import subprocess

import pytest
from chart_helpers import CHART, rendered, values_file
from conftest import wait_for
from hooks_helpers import Hooks
from operator_helpers import BUILD, GROUP
from test_chart import prepare

RELEASE = "it-diaphane"


class Retires(Hooks):
    component = "retire"

    def further(self, pod: dict) -> dict[str, str]:
        """Adds what a kubelet puts into its pod: the address of the API server, and the token of its account."""
        token = self.plane.folder / f"{self.namespace}.retire.token"
        token.write_text(self.plane.service_account_token(self.namespace, pod["spec"]["serviceAccountName"]), encoding="utf-8")
        return {"DIAPHANE_KUBE_SERVER": self.plane.server, "DIAPHANE_KUBE_TOKEN_FILE": str(token), "DIAPHANE_KUBE_CA_FILE": str(self.plane.folder / "ca.crt")}


@pytest.fixture
def hooks(plane, namespace):
    made = Retires(plane, namespace)
    yield made
    made.close()


def left(plane, namespace: str) -> list[str]:
    """Returns what is left of a release, except users' scans and their secret."""
    return plane.kubectl("get", "rf,rw,pods,deploy,jobs,svc,roles,rolebindings,sa,netpol,pdb", "-n", namespace, "-l", "app.kubernetes.io/instance=it",
                         "-o", "name").out.split()


@pytest.mark.parametrize("operator, grace, watched", [("there", 100, False), ("there", 3, True), ("killed", 3, False)],
                         ids=["drained in time", "somebody looks on for longer", "no operator"])
def test_uninstall_finishes_and_leaves_only_the_scans(plane, namespace, cluster, hooks, tmp_path, operator, grace, watched):
    prepare(plane, namespace)
    cluster.nodes(1, gpus=2)
    fleet = {"minReplicas": 2, "nodeSelector": {"pool": namespace}, "drainTimeout": "10m", "retire": {"graceSeconds": grace}}
    plane.helm("install", "it", str(CHART), "-n", namespace, "-f", values_file(tmp_path, {"fleet": fleet}), "--wait", "--timeout", "180s")
    cluster.token_file.write_text(plane.service_account_token(namespace, f"{RELEASE}-operator"), encoding="utf-8")
    leader = cluster.operator()
    wait_for(lambda: cluster.status(RELEASE).get("readyReplicas") == 2, "two workers")
    assert all(one["metadata"]["finalizers"] == ["diaphane.dev/drain"] for one in cluster.workers())
    if watched:
        cluster.beats.sessions[f"{RELEASE}-0"] = ["11111111-1111-4111-8111-111111111111"]
        wait_for(lambda: cluster.status(RELEASE).get("slotsUsed") == 1, "the session")
    if operator == "killed":
        leader.kill()

    hooks.while_helm("uninstall", "it", "-n", namespace)
    assert ('"finalizers_removed"' in hooks.ran[0][1]) is (watched or operator == "killed"), hooks.ran[0][1]
    assert cluster.workers() == [] and plane.api.get(f"{GROUP}/namespaces/{namespace}/renderfleets/{RELEASE}").status_code == 404
    wait_for(lambda: left(plane, namespace) == [], "the end of the pods")
    assert len(plane.kubectl("get", "pvc", "-n", namespace, "-o", "name").out.split()) == 3


def test_the_uninstall_hook_needs_each_of_its_permissions(plane, namespace, cluster, tmp_path):
    """Rights are granted one by one, and each time the next one is missing. It may not touch another fleet."""
    rules = next(one for one in rendered(plane, tmp_path, namespace=namespace) if one["kind"] == "Role" and one["metadata"]["name"] == f"{RELEASE}-retire")["rules"]
    granted = {(rule["resources"][0], verb) for rule in rules for verb in rule["verbs"]}
    in_turn = [("renderfleets", "get"), ("renderworkers", "list"), ("renderworkers", "delete"), ("renderfleets", "delete"), ("renderworkers", "update"),
               ("renderfleets", "update")]
    assert granted == set(in_turn)

    cluster.nodes(1, gpus=2)
    operator = cluster.operator()
    for name in (RELEASE, "other"):
        cluster.fleet(name, replicas=1)
        wait_for(lambda name=name: cluster.status(name).get("readyReplicas") == 1, "its worker")
    operator.kill()
    account = {"kind": "ServiceAccount", "name": "retire", "namespace": namespace}
    api = "rbac.authorization.k8s.io"
    plane.apply({"apiVersion": "v1", "kind": "ServiceAccount", "metadata": {"name": "retire", "namespace": namespace}})
    token = tmp_path / "token"
    token.write_text(plane.service_account_token(namespace, "retire"), encoding="utf-8")

    def retire() -> subprocess.CompletedProcess:
        return subprocess.run([str(BUILD / "bin" / "diaphane-operator"), "retire"], capture_output=True, text=True, timeout=60, env={
            "DIAPHANE_NAMESPACE": namespace, "DIAPHANE_FLEET": RELEASE, "DIAPHANE_GRACE_S": "0", "DIAPHANE_KUBE_SERVER": plane.server,
            "DIAPHANE_KUBE_TOKEN_FILE": str(token), "DIAPHANE_KUBE_CA_FILE": str(plane.folder / "ca.crt")})

    for count in range(len(in_turn) + 1):
        given = [{**rule, "verbs": verbs} for rule in rules
                 if (verbs := [verb for verb in rule["verbs"] if (rule["resources"][0], verb) in in_turn[:count]])]
        plane.apply({"apiVersion": f"{api}/v1", "kind": "Role", "metadata": {"name": "retire", "namespace": namespace}, "rules": given},
                    {"apiVersion": f"{api}/v1", "kind": "RoleBinding", "metadata": {"name": "retire", "namespace": namespace},
                     "roleRef": {"apiGroup": api, "kind": "Role", "name": "retire"}, "subjects": [account]})
        if count == len(in_turn):
            break
        resource, verb = in_turn[count]

        def refused(words: str = f'cannot {verb} resource \\"{resource}\\"') -> bool:
            done = retire()
            return done.returncode == 77 and words in done.stdout + done.stderr
        wait_for(refused, f"that it may not {verb} {resource}")
    wait_for(lambda: retire().returncode == 0, "the end of the fleet")
    assert {one["spec"]["fleetName"] for one in cluster.workers()} == {"other"}
    other = plane.api.get(f"{GROUP}/namespaces/{namespace}/renderfleets/other").json()["metadata"]
    assert "deletionTimestamp" not in other
