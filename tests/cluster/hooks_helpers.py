"""Runs the pods of a chart's hooks for real while helm waits for them, with the programs of this checkout."""

from __future__ import annotations

import subprocess
import threading

from conftest import wait_for
from operator_helpers import BUILD
from plane import node
from pod_contents import Places, data_of, environment


class Hooks:
    """Runs the pods of a component's hooks."""

    component = ""

    def __init__(self, plane, namespace: str):
        self.plane, self.namespace = plane, namespace
        self.ran: list[tuple[str, str]] = []
        self.node = f"{namespace}-hooks"
        # Unschedulable, so that it runs only pods that are bound to it by name.
        plane.api.post("/api/v1/nodes", json={**node(self.node, gpus=0, kwok=False), "spec": {"unschedulable": True}}).raise_for_status()

    def words(self, container: dict) -> list[str]:
        return [word.replace("/opt/diaphane/bin", str(BUILD / "bin")) for word in container["command"]]

    def further(self, pod: dict) -> dict[str, str]:
        """Returns additions to the environment in the pod's spec."""
        return {}

    def while_helm(self, *words: str) -> None:
        """Stops the scheduler until the hook's pod has been bound here, so that it gets no kwok node."""
        before = len(self.ran)
        said: list = []
        self.plane.pause("kube-scheduler")
        try:
            helm = threading.Thread(target=lambda: said.append(self.plane.helm(*words, "--wait", "--timeout", "180s", check=False)))
            helm.start()
            wait_for(lambda: self._run_one() or not helm.is_alive(), "the hook's pod")
        finally:
            self.plane.pause("kube-scheduler", on=False)
        helm.join()
        assert said[0].code == 0, said[0].text
        assert len(self.ran) == before + 1, "no hook was run"

    def _run_one(self) -> bool:
        path = f"/api/v1/namespaces/{self.namespace}/pods"
        pods = self.plane.api.get(path, params={"labelSelector": f"app.kubernetes.io/component={self.component}"}).json()["items"]
        waiting = [one for one in pods if not one["spec"].get("nodeName") and one["status"].get("phase") == "Pending"]
        if not waiting:
            return False
        name = waiting[0]["metadata"]["name"]
        self.plane.api.post(f"{path}/{name}/binding", json={"apiVersion": "v1", "kind": "Binding", "metadata": {"name": name},
                                                            "target": {"apiVersion": "v1", "kind": "Node", "name": self.node}}).raise_for_status()
        container = waiting[0]["spec"]["containers"][0]
        done = self._run(waiting[0], container)
        phase = "Succeeded" if done.returncode == 0 else "Failed"
        self.plane.api.patch(f"{path}/{name}/status", json={"status": {"phase": phase}},
                             headers={"Content-Type": "application/merge-patch+json"}).raise_for_status()
        assert done.returncode == 0, done.stdout + done.stderr
        self.ran.append((container["image"], done.stdout + done.stderr))
        return True

    def _data(self, kind: str, name: str) -> dict[str, bytes]:
        return data_of(self.plane.api.get(f"/api/v1/namespaces/{self.namespace}/{kind}/{name}").raise_for_status().json())

    def _run(self, pod: dict, container: dict) -> subprocess.CompletedProcess:
        env = environment(pod, container, Places("127.0.0.1"), lambda name: self._data("secrets", name), lambda name: self._data("configmaps", name))
        return subprocess.run(self.words(container), env={**env, **self.further(pod)}, capture_output=True, text=True, timeout=120)

    def close(self) -> None:
        self.plane.api.delete(f"/api/v1/nodes/{self.node}")
