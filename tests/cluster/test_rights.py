"""The rights of the chart's accounts: without each right of the operator, something fails, and everything else is refused."""

from __future__ import annotations

import copy
import itertools
import shutil
import tempfile
from pathlib import Path

import pytest
from conftest import wait_for
from operator_helpers import GROUP, LEASE, Cluster, Operator, chart_rights
from blackhole_proxy import BlackholeProxy

_numbers = itertools.count()


@pytest.fixture(scope="module")
def world(plane):
    """A namespace, and an operator that starts when a case needs a leader."""
    name = "rights"
    plane.apply({"apiVersion": "v1", "kind": "Namespace", "metadata": {"name": name, "labels": {"pod-security.kubernetes.io/enforce": "restricted"}}})
    folder = Path(tempfile.mkdtemp(prefix="diaphane-rights-"))
    plane.run_as.own(folder)
    made = World(plane, name, folder)
    made.nodes(4, gpus=8)     # each case keeps a fleet
    yield made
    made.close()
    plane.kubectl("delete", "namespace", name, "--wait=false", check=False)
    shutil.rmtree(folder, ignore_errors=True)


class World(Cluster):
    _leader: Operator | None = None

    def leader(self) -> Operator:
        if self._leader is None or not self._leader.alive():
            self._leader = self.fresh()
            wait_for(lambda: self._leader.ready().get("leader"), "a leader")
        return self._leader

    def fresh(self, **how: str) -> Operator:
        """Starts the only operator."""
        self._stop()
        return self.operator(**how)

    def nobody_leads(self) -> None:
        self._stop()
        self.plane.kubectl("delete", "lease", LEASE, "-n", self.namespace, "--ignore-not-found")

    def _stop(self) -> None:
        for one in self.operators:
            one.stop()
        self._leader = None

    def new_fleet(self, replicas: int = 1) -> str:
        name = f"f{next(_numbers)}"
        self.fleet(name, replicas=replicas)
        return name

    def pod(self, name: str) -> dict:
        return next((one for one in self.running() if one["metadata"]["name"] == name), {})

    def ready_fleet(self) -> str:
        self.leader()
        name = self.new_fleet()
        wait_for(lambda: self.status(name).get("readyReplicas") == 1, "its worker")
        return name

    def delete(self, fleet: str) -> None:
        self.plane.kubectl("delete", "renderfleet", fleet, "-n", self.namespace, "--wait=false")

    def has_gone(self, fleet: str) -> bool:
        return self.plane.api.get(f"{GROUP}/namespaces/{self.namespace}/renderfleets/{fleet}").status_code == 404

    def without(self, resource: str, verb: str) -> None:
        """Grants the chart's rights except one, and waits until the API server applies that."""
        self.allow(**{where: _without(rules, resource, verb) for where, rules in chart_rights(self.plane, all_pods=self.all_pods).items()})
        self._known(resource, verb, False)

    def with_all(self, resource: str, verb: str) -> None:
        self.allow(**chart_rights(self.plane, all_pods=self.all_pods))
        self._known(resource, verb, True)

    all_pods = False

    def _known(self, resource: str, verb: str, allowed: bool) -> None:
        wait_for(lambda: may(self, verb, resource) is allowed, f"{verb} {resource}: {allowed}")


GROUPS = {"renderfleets": "diaphane.dev", "renderworkers": "diaphane.dev", "leases": "coordination.k8s.io"}


def may(world: Cluster, verb: str, resource: str) -> bool:
    """Whether a lease may be changed in that way, on one that exists."""
    kind, _, sub = resource.partition("/")
    asked = {"verb": verb, "resource": kind, "subresource": sub, "group": GROUPS.get(kind, "")}
    if kind != "nodes" and not getattr(world, "all_pods", False):
        asked["namespace"] = world.namespace
    if kind == "leases" and verb != "create":
        asked["name"] = LEASE
    answer = world.plane.client(token=world.token_file.read_text(encoding="utf-8")).post(
        "/apis/authorization.k8s.io/v1/selfsubjectaccessreviews",
        json={"apiVersion": "authorization.k8s.io/v1", "kind": "SelfSubjectAccessReview", "spec": {"resourceAttributes": asked}})
    return answer.json()["status"]["allowed"]


def _without(rules: list[dict], resource: str, verb: str) -> list[dict]:
    out = []
    for rule in copy.deepcopy(rules):
        if resource in rule["resources"] and verb in rule["verbs"]:
            if rest := [one for one in rule["resources"] if one != resource]:
                out.append({**rule, "resources": rest})
            rule = {**rule, "resources": [resource], "verbs": [one for one in rule["verbs"] if one != verb]}
            if not rule["verbs"]:
                continue
        out.append(rule)
    return out


class Log:
    """New log lines of an operator."""

    def __init__(self, operator: Operator):
        self.operator, self.begin = operator, operator.log.stat().st_size

    def has(self, words: str) -> bool:
        return words in self.operator.log.read_bytes()[self.begin:].decode()

    def refused(self, verb: str, resource: str) -> None:
        wait_for(lambda: self.has(f'cannot {verb} resource \\"{resource}\\"'), f"that it may not {verb} {resource}")


# For each right: what the operator does without it, and what then fails. Each case restores the right and checks that it
# succeeds.

def starts(world, resource, verb):
    """An operator that may not list or watch reports it and does nothing."""
    world.without(resource, verb)
    operator = world.fresh(**({"DIAPHANE_WATCH_ALL_PODS": "1"} if world.all_pods else {}))
    Log(operator).refused(verb, resource)
    wait_for(lambda: not (operator.ready()["checks"]["listed"] and operator.ready()["checks"]["kubernetes"]), "that it is not ready")
    world.with_all(resource, verb)
    wait_for(lambda: operator.ready().get("ready"), "that it is ready")


def takes_the_lease(world, resource, verb):
    world.nobody_leads()
    world.without(resource, verb)
    operator = world.fresh()
    Log(operator).refused(verb, resource)
    assert not operator.ready()["leader"]
    world.with_all(resource, verb)
    wait_for(lambda: operator.ready()["leader"], "that it leads")


def renews_the_lease(world, resource, verb):
    """It may create one. It works correctly until the lease expires, and then exits."""
    world.nobody_leads()
    world.without(resource, verb)
    operator = world.fresh()
    Log(operator).refused(verb, resource)
    wait_for(lambda: not operator.alive(), "its end")
    assert operator.process.returncode == 75
    world.with_all(resource, verb)


def makes_a_fleet(world, resource, verb):
    log = Log(world.leader())
    world.without(resource, verb)
    fleet = world.new_fleet()
    log.refused(verb, resource)
    assert world.status(fleet).get("readyReplicas", 0) == 0
    world.with_all(resource, verb)
    wait_for(lambda: world.status(fleet).get("readyReplicas") == 1, "its worker")


def takes_in_a_fleet(world, resource, verb):
    """Its finalizer, without which a fleet would be deleted before its workers."""
    log = Log(world.leader())
    world.without(resource, verb)
    fleet = world.new_fleet(replicas=0)
    log.refused(verb, resource)
    url = f"{GROUP}/namespaces/{world.namespace}/renderfleets/{fleet}"
    assert "finalizers" not in world.plane.api.get(url).json()["metadata"]
    world.with_all(resource, verb)
    wait_for(lambda: world.plane.api.get(url).json()["metadata"].get("finalizers"), "its finalizer")


def blocks_the_owner(world, resource, verb):
    """blockOwnerDeletion: admission refuses it with its own message."""
    log = Log(world.leader())
    world.without(resource, verb)
    fleet = world.new_fleet()
    wait_for(lambda: log.has("cannot set blockOwnerDeletion"), "the refusal")
    assert world.status(fleet).get("readyReplicas", 0) == 0
    world.with_all(resource, verb)
    wait_for(lambda: world.status(fleet).get("readyReplicas") == 1, "its worker")


def lets_a_fleet_go(world, resource, verb):
    fleet = world.ready_fleet()
    log = Log(world.leader())
    world.without(resource, verb)
    world.delete(fleet)
    log.refused(verb, resource)
    assert not world.has_gone(fleet)
    world.with_all(resource, verb)
    wait_for(lambda: world.has_gone(fleet), "its end")


def tells_an_event(world, resource, verb):
    log = Log(world.leader())
    world.without(resource, verb)
    fleet = world.new_fleet()
    log.refused(verb, resource)
    wait_for(lambda: world.status(fleet).get("readyReplicas") == 1, "its worker nevertheless")
    assert not [one for one in world.events() if one["involvedObject"]["name"] == fleet]
    world.with_all(resource, verb)


def puts_a_label_back(world, resource, verb):
    fleet = world.ready_fleet()
    log = Log(world.leader())
    world.without(resource, verb)
    world.plane.kubectl("label", "pod", f"{fleet}-0", "diaphane.dev/worker-", "-n", world.namespace)
    log.refused(verb, resource)
    assert "diaphane.dev/worker" not in world.pod(f"{fleet}-0")["metadata"]["labels"]
    world.with_all(resource, verb)
    wait_for(lambda: world.pod(f"{fleet}-0")["metadata"]["labels"].get("diaphane.dev/worker"), "the label")


def tells_an_event_again(world, resource, verb):
    """A repetition of the event ten seconds later increases its count."""
    fleet = world.ready_fleet()
    log = Log(world.leader())
    world.without(resource, verb)

    def again() -> bool:
        world.plane.kubectl("label", "pod", f"{fleet}-0", "diaphane.dev/worker-", "-n", world.namespace)
        wait_for(lambda: world.pod(f"{fleet}-0")["metadata"]["labels"].get("diaphane.dev/worker"), "the label")
        return log.has(f'cannot {verb} resource \\"{resource}\\"')
    wait_for(again, "the refusal")
    world.with_all(resource, verb)


def reads_what_is_there_already(world, resource, verb):
    """Its watches are stuck, so it learns of another creator's pod only from the refusal of its own write."""
    wire = BlackholeProxy(world.plane.server)
    try:
        operator = world.fresh(server=wire.url)
        wait_for(lambda: operator.ready().get("leader"), "a leader")
        fleet = f"f{next(_numbers)}"
        world.fleet(fleet, sessionsPerWorker=1, maxReplicas=3)
        wait_for(lambda: world.status(fleet).get("readyReplicas") == 1, "its worker")
        world.without(resource, verb)
        assert wire.stick() >= 4, "four watches"
        foreign = world.fleet_object()["spec"]["template"]["spec"]
        world.plane.apply({"apiVersion": "v1", "kind": "Pod", "metadata": {"name": f"{fleet}-1", "namespace": world.namespace},
                           "spec": {**foreign, "nodeSelector": {"pool": world.namespace}}})
        log = Log(operator)
        world.beats.sessions[f"{fleet}-0"] = ["11111111-1111-4111-8111-111111111111"]
        log.refused(verb, resource)
        world.with_all(resource, verb)
        world.beats.sessions.clear()
    finally:
        world.fresh()   # the next case may need it
        wire.close()


#: Each right of the operator, and what needs it.
NEEDED = {
    ("renderfleets", "patch"): takes_in_a_fleet,
    ("renderworkers", "create"): makes_a_fleet,
    ("renderworkers/status", "patch"): makes_a_fleet,
    ("renderfleets/status", "patch"): makes_a_fleet,
    ("pods", "create"): makes_a_fleet,
    ("renderfleets/finalizers", "update"): blocks_the_owner,
    ("renderworkers/finalizers", "update"): blocks_the_owner,
    ("renderworkers", "patch"): lets_a_fleet_go,
    ("pods", "delete"): lets_a_fleet_go,
    ("renderworkers", "delete"): lets_a_fleet_go,
    ("renderworkers", "get"): lets_a_fleet_go,
    ("renderworkers", "update"): lets_a_fleet_go,
    ("renderfleets", "get"): lets_a_fleet_go,
    ("renderfleets", "update"): lets_a_fleet_go,
    ("events", "create"): tells_an_event,
    ("pods", "patch"): puts_a_label_back,
    ("events", "patch"): tells_an_event_again,
    ("pods", "get"): reads_what_is_there_already,
    ("renderfleets", "list"): starts,
    ("renderfleets", "watch"): starts,
    ("renderworkers", "list"): starts,
    ("renderworkers", "watch"): starts,
    ("pods", "list"): starts,
    ("pods", "watch"): starts,
    ("nodes", "list"): starts,
    ("nodes", "watch"): starts,
    ("leases", "create"): takes_the_lease,
    ("leases", "get"): takes_the_lease,
    ("leases", "update"): renews_the_lease,
}


def pairs(rules: list[dict]) -> set[tuple[str, str]]:
    return {(resource, verb) for rule in rules for resource in rule["resources"] for verb in rule["verbs"]}


def test_every_operator_permission_has_a_test_case(plane):
    here, everywhere = chart_rights(plane)["here"], chart_rights(plane)["everywhere"]
    assert pairs(here) | pairs(everywhere) == set(NEEDED)
    assert pairs(everywhere) == {("nodes", "list"), ("nodes", "watch")}
    assert pairs(chart_rights(plane, all_pods=True)["everywhere"]) - pairs(everywhere) == {("pods", "list"), ("pods", "watch")}


@pytest.mark.parametrize("resource, verb", NEEDED)
def test_each_operator_permission_is_needed(world, resource, verb):
    world.with_all(resource, verb)
    NEEDED[resource, verb](world, resource, verb)


@pytest.mark.parametrize("verb", ["list", "watch"])
def test_each_permission_on_all_pods_is_needed_when_enabled(world, verb):
    world.all_pods = True
    try:
        starts(world, "pods", verb)
    finally:
        world.all_pods = False
        world.with_all("pods", verb)


# Rights that are not granted

VERBS = {"get": "GET", "list": "GET", "create": "POST", "update": "PUT", "patch": "PATCH", "delete": "DELETE"}


def served(plane) -> list[tuple[str, str, bool, list[str]]]:
    """Returns everything that this API server serves: path of the group, resource, whether it is namespaced, verbs."""
    paths = ["/api/v1", *(f"/apis/{one['preferredVersion']['groupVersion']}" for one in plane.api.get("/apis").json()["groups"])]
    return [(path, one["name"], one["namespaced"], one["verbs"]) for path in paths for one in plane.api.get(path).json()["resources"]]


def tries(plane, token: str, space: str, given: set[tuple[str, str]]) -> tuple[int, list[str]]:
    """Tries each verb of each resource except the given ones. Returns the number, and those that were not refused. An account may
    query its own rights."""
    harmless = ("selfsubjectreviews", "selfsubjectaccessreviews", "selfsubjectrulesreviews")
    count, let_in = 0, []
    with plane.client(token=token) as who:
        for path, resource, namespaced, verbs in served(plane):
            name, _, sub = resource.partition("/")
            if name in harmless:
                continue
            for verb in sorted(set(verbs) & set(VERBS)):
                if (resource, verb) in given:
                    continue
                url = f"{path}/namespaces/{space}/{name}" if namespaced else f"{path}/{name}"
                if sub or verb in ("get", "update", "patch", "delete"):
                    url += "/nobody" + (f"/{sub}" if sub else "")
                kind = "application/merge-patch+json" if verb == "patch" else "application/json"
                answer = who.request(VERBS[verb], url, content=b"" if verb in ("get", "list") else b"{}", headers={"Content-Type": kind})
                count += 1
                if answer.status_code != 403:
                    let_in.append(f"{verb} {path} {resource}: {answer.status_code}")
    return count, let_in


def test_operator_is_refused_everything_else(world):
    world.with_all("pods", "get")
    given = {(resource, verb) for resource, verb in NEEDED if resource != "leases" or verb == "create"}
    token = world.token_file.read_text(encoding="utf-8")
    # Tries all other rights in its namespace, and in another namespace all rights on namespaced resources.
    count, let_in = tries(world.plane, token, world.namespace, given)
    assert let_in == [] and count > 300
    count, let_in = tries(world.plane, token, "default", {one for one in given if one[0] == "nodes"})
    assert let_in == [] and count > 300


def test_the_default_service_account_has_no_permissions(world):
    """api, ingest, renderers and hooks have neither their own account nor a token. With a token, they would have no rights."""
    count, let_in = tries(world.plane, world.plane.service_account_token(world.namespace, "default"), world.namespace, set())
    assert let_in == [] and count > 300
