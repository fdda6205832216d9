"""The same on one complete node: containerd runs the real image in containers that kubelet starts (`./diaphane test node`; not
part of `test cluster`)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import wait_for
from kubelet_node import ADDRESS, KubeletNode
from plane import ORDER, Plane
from service_helpers import Front, Service
from test_session import ENOUGH, NAMESPACE, POOL, SESSION, page  # noqa: F401

from harness import REPO
from devtool import image, users, whole_node

sys.path.insert(0, str(REPO / "tests" / "e2e"))

from person import Person  # noqa: E402
from picture import difference, facts, pixels, spread, wait_for_samples  # noqa: E402

#: The user of the image.
_OWNER = 10001


class WholeNode(Service):
    """The pods are kubelet's. The stores are reached at the node's address."""

    def __init__(self, plane: Plane, stores, folder: Path):
        self.ways = {"postgres": Front(lambda: ("127.0.0.1", stores.ports["postgres"]), (ADDRESS, 0)),
                     "redis": Front(lambda: stores.stack.settings.socket("redis"), (ADDRESS, 0))}
        super().__init__(plane, NAMESPACE, [], stores, folder)
        self.dsn = stores.dsn.replace(f"127.0.0.1:{stores.ports['postgres']}", f"{ADDRESS}:{self.ways['postgres'].port}")
        self.redis_address = f"{ADDRESS}:{self.ways['redis'].port}"

    def _own(self, place: Path) -> None:
        os.chown(place, _OWNER, _OWNER)

    def listed(self, component: str) -> list[dict]:
        """Returns ready pods."""
        said = self.plane.api.get(f"/api/v1/namespaces/{NAMESPACE}/pods", params={"labelSelector": f"app.kubernetes.io/component={component}"}).json()
        return [one for one in said["items"] if "deletionTimestamp" not in one["metadata"]
                and any(two["type"] == "Ready" and two["status"] == "True" for two in one["status"].get("conditions", []))]

    def _edge(self) -> tuple[str, int]:
        pods = self.listed("api")
        if not pods:
            raise LookupError("no pod of the Service is ready")
        return pods[0]["status"]["podIP"], 8080


@pytest.fixture
def node(stack_factory, request):
    assert os.environ.get("DIAPHANE_WHOLE_NODE"), "./diaphane test node makes the namespaces that this wants"
    folder = Path(os.environ["DIAPHANE_WHOLE_NODE"])
    run_as = users.ordinary_user()
    (folder / "plane").mkdir()
    (folder / "node").mkdir()
    run_as.own(folder / "plane")
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    plane = Plane(folder / "plane", run_as, only=tuple(name for name in ORDER if name != "kwok")).start()
    kubelet = KubeletNode(plane, folder / "node", whole_node.folder(), folder.name)
    made = None
    try:
        plane.define_resources()
        plane.apply({"apiVersion": "v1", "kind": "Namespace", "metadata": {"name": NAMESPACE, "labels": {"pod-security.kubernetes.io/enforce": "restricted"}}})
        kubelet.start()
        # what a Service's address becomes with kube-proxy
        Front(lambda: ("127.0.0.1", plane.ports["kube-apiserver"]), ("10.96.0.1", 443))
        kubelet.import_image(Path(os.environ["DIAPHANE_IMAGE"]), image.name())
        made = WholeNode(plane, stack_factory(only=("postgres", "redis")), folder)
        little = {"resources": {"requests": {"cpu": "10m", "memory": "64Mi"}}}
        made.install({"image": {"repository": image.name().rpartition(":")[0]}, "redis": {"address": made.redis_address},
                      "fleet": {"replicas": 2, "sessionsPerWorker": 4, "engine": "cpu", **POOL, **little}, "api": {**POOL, **little},
                      "ingest": {**POOL, **little}, "operator": {**POOL, **little}, "edge": little})
        yield made
    finally:
        said = plane.kubectl("get", "pods,events", "-A", "-o", "wide", check=False).text
        request.node.add_report_section("teardown", "pods and events", said[-6000:])
        for name, text in kubelet.logs().items():
            request.node.add_report_section("teardown", name, text)
        kubelet.stop()
        plane.stop()


def test_a_session_runs_in_real_containers(node: WholeNode, page, tmp_path):  # noqa: F811
    disc = tmp_path / "disc"
    subprocess.run([Path(os.environ.get("DIAPHANE_BUILD", REPO / "build" / "release")) / "bin" / "diaphane-sample", "--write-dicom", disc], check=True, capture_output=True)
    wait_for(lambda: len(node.listed("renderd")) == 2, "two workers", timeout=300)
    person = Person.arrives(node, page, "anna")
    person.has_scan(disc, "My head")
    person.open_scan("My head")
    shown = wait_for_samples(node, page, ENOUGH)
    first = pixels(page)
    assert spread(first) > 5
    session = page.evaluate(SESSION)
    was = node.place_of(session)
    node.plane.kubectl("delete", "pod", was[0], "-n", NAMESPACE, "--wait=false")
    seconds = node.moved_from(session, was, page)
    node.wait_until(lambda: page.wait_for_timeout(10) or facts(page).samples < shown.samples, timeout=120, what="a picture of the other process")
    wait_for_samples(node, page, ENOUGH)
    print(f"deleted: the session at {was[0]} is at {node.place_of(session)[0]} after {seconds:.2f} s")
    assert difference(first, pixels(page)) < 3
