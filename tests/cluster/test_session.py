"""A browser's session through the real chart, operator and scheduler, with pods that a node agent runs, and their pictures."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from node_agent import NodeAgent
from plane import ORDER, Plane
from playwright.sync_api import expect, sync_playwright
from service_helpers import NAME, Service

from harness import REPO
from devtool import chromium, logfiles, users

sys.path.insert(0, str(REPO / "tests" / "e2e"))

from person import PATIENCE_MS, Person  # noqa: E402
from picture import difference, drag, facts, pixels, spread, wait_for_samples  # noqa: E402

ENOUGH = 8
NAMESPACE = "scans"
SESSION = "JSON.parse(Object.entries(sessionStorage).find(([k]) => k.startsWith('diaphane.view.'))[1]).session_id"
POOL = {"nodeSelector": {"pool": "real"}}


@pytest.fixture
def service(all_stacks, stack_factory, request):
    """The chart on two nodes of its own control plane, which run every pod."""
    if os.geteuid() != 0:
        pytest.skip("a pod's processes get mount namespaces of their own, which root alone may make")
    folder = Path(tempfile.mkdtemp(prefix="diaphane-cluster-"))
    folder.chmod(0o755)
    run_as = users.ordinary_user()
    (folder / "plane").mkdir()
    run_as.own(folder / "plane")
    plane = Plane(folder / "plane", run_as, only=tuple(name for name in ORDER if name != "kwok")).start()
    agents: list[NodeAgent] = []
    made = None
    try:
        plane.define_resources()
        plane.apply({"apiVersion": "v1", "kind": "Namespace", "metadata": {"name": NAMESPACE, "labels": {"pod-security.kubernetes.io/enforce": "restricted"}}})
        for name in ("node-a", "node-b"):
            agents.append(NodeAgent(plane, name, folder / name, all_stacks.layout(), gpus=2, labels={"pool": "real"}).start())
        made = Service(plane, NAMESPACE, agents, stack_factory(only=("postgres", "redis")), folder)
        made.install({"fleet": {"replicas": 2, "sessionsPerWorker": 4, "engine": "cpu", "drainTimeout": "1s", **POOL}, "api": POOL, "ingest": POOL, "operator": POOL})
        yield made
    finally:
        for agent in agents:
            for pod in agent.pods.values():
                for log in sorted(pod.folder.glob("*.log")):
                    request.node.add_report_section("teardown", f"{pod.name} {log.name}", logfiles.tail(log, 30))
        if made:
            made.uninstall()
        for agent in agents:
            agent.stop()
        plane.stop()
        if not os.environ.get("DIAPHANE_KEEP"):
            shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def page():
    expect.set_options(timeout=PATIENCE_MS)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium.path(), args=chromium.ARGS)
        page = browser.new_page(viewport={"width": 480, "height": 320})
        page.set_default_timeout(PATIENCE_MS)
        yield page
        browser.close()


def test_a_session_survives_the_loss_of_its_pod_process_and_node(service: Service, page, tmp_path):
    pictures = Path(os.environ.get("DIAPHANE_PICTURES") or tmp_path)
    pictures.mkdir(parents=True, exist_ok=True)
    disc = tmp_path / "disc"
    subprocess.run([Path(os.environ.get("DIAPHANE_BUILD", REPO / "build" / "release")) / "bin" / "diaphane-sample", "--write-dicom", disc], check=True, capture_output=True)
    assert {pod.object["spec"]["nodeName"] for pod in service.workers(2)} == {"node-a", "node-b"}
    for pod in service.workers(2):
        assert pod.object["spec"]["containers"][0]["resources"]["limits"]["nvidia.com/gpu"] == "1"

    person = Person.arrives(service, page, "anna")
    person.has_scan(disc, "My head")
    person.open_scan("My head")
    wait_for_samples(service, page, ENOUGH)
    first = pixels(page)
    assert spread(first) > 5
    before = facts(page)
    drag(page, 110, 30)
    wait_for_samples(service, page, 2 * ENOUGH, input_seq=before.input_seq + 1)
    turned = pixels(page)
    assert difference(first, turned) > 2
    page.screenshot(path=pictures / "pod.png")
    session = page.evaluate(SESSION)

    def goes_on(what: str, act) -> None:
        """Checks for the same session and picture in another process."""
        was, shown = service.place_of(session), wait_for_samples(service, page, 2 * ENOUGH)
        began = time.monotonic()
        act(service.pod(was[0]))
        service.moved_from(session, was, page)
        moved = time.monotonic() - began
        # The film is new, so it starts again with few samples.
        service.wait_until(lambda: page.wait_for_timeout(10) or facts(page).samples < shown.samples, timeout=120, what="a picture of the other process")
        seen = time.monotonic() - began
        wait_for_samples(service, page, ENOUGH)
        again = pixels(page)
        print(f"{what}: session at {was[0]} is at {service.place_of(session)[0]} after {moved:.2f} s, its first picture is seen after {seen:.2f} s")
        assert page.evaluate(SESSION) == session
        assert difference(turned, again) < 0.4 * difference(first, turned), f"{what}: another picture"
        page.screenshot(path=pictures / f"{what}.png")
        service.workers(2)

    goes_on("deleted", lambda pod: service.plane.kubectl("delete", "pod", pod.name, "-n", NAMESPACE, "--wait=false"))
    goes_on("killed", lambda pod: pod.runs["renderd"].signal(signal.SIGKILL))
    goes_on("cordoned", lambda pod: service.plane.kubectl("cordon", pod.object["spec"]["nodeName"]))

    fleet = service.plane.kubectl("get", f"rf/{NAME}", "-n", NAMESPACE, "-o", "json").json
    assert fleet["status"]["readyReplicas"] == 2

    # Uninstalled, with its hook run like any other pod, it leaves nothing behind.
    page.close()
    service.plane.helm("uninstall", "it", "-n", NAMESPACE, "--wait", "--timeout", "180s")
    assert service.plane.kubectl("get", "rf,rw,deploy", "-n", NAMESPACE, "-o", "name").out == ""
    service.wait_until(lambda: not service.plane.kubectl("get", "pods", "-n", NAMESPACE, "-o", "name").out, what="the last pod's end")
