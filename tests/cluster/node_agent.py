"""A node of the real control plane: pods that the scheduler binds to it run as processes of this machine.

    agent = NodeAgent(plane, "node-a", folder, programs, gpus=8).start()
    agent.stop()

It does what a kubelet does for pods like ours, through the API server alone: it keeps the node and its lease alive, watches the pods bound to
it, makes their volumes, starts their containers, asks their own probes, says phase, conditions, address and restarts, starts again what ended
(at once, then after 10 s, doubled), and ends what is deleted: preStop, SIGTERM, the grace, SIGKILL, and only then the object goes.
"""

from __future__ import annotations

import datetime
import itertools
import json
import os
import shutil
import signal
import socket
import threading
import time
from pathlib import Path

import httpx
from plane import Plane, node
from pod_contents import Places, chosen, data_of, environment, field_of, mapped, phase_of, ports_named, probe_port
from pod_process import Container, Mount, image_mounts

from devtool import layout, ports

_MERGE = {"Content-Type": "application/merge-patch+json"}
_addresses = itertools.count(1)


def now() -> str:
    return datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


class NodeAgent:
    def __init__(self, plane: Plane, name: str, folder: Path, programs: layout.Layout, gpus: int = 8, labels: dict | None = None):
        self.plane, self.name, self.folder, self.programs = plane, name, folder, programs
        self.api = plane.client("agent")
        self.node = node(name, gpus, labels, kwok=False)
        self.pods: dict[str, Pod] = {}
        self.stopping = threading.Event()
        self.threads: list[threading.Thread] = []

    def start(self) -> "NodeAgent":
        self.folder.mkdir(parents=True, exist_ok=True)
        self.plane.run_as.own(self.folder)
        self.api.post("/api/v1/nodes", json=self.node).raise_for_status()
        for work in (self._live, self._watch):
            self.threads.append(threading.Thread(target=work, name=f"{self.name} {work.__name__}", daemon=True))
            self.threads[-1].start()
        return self

    def stop(self) -> None:
        """Ends every process like a node that loses power. The objects stay."""
        self.stopping.set()
        for pod in list(self.pods.values()):
            pod.kill()
        for thread in [*self.threads, *(pod.thread for pod in self.pods.values())]:
            thread.join(timeout=20)

    # The node

    def _live(self) -> None:
        lease = "/apis/coordination.k8s.io/v1/namespaces/kube-node-lease/leases"
        while True:
            ready = {"type": "Ready", "status": "True", "reason": "AgentReady", "message": "", "lastHeartbeatTime": now(), "lastTransitionTime": now()}
            try:
                self.api.patch(f"/api/v1/nodes/{self.name}/status", json={"status": {"conditions": [ready]}}, headers=_MERGE)
                spec = {"holderIdentity": self.name, "leaseDurationSeconds": 40,
                        "renewTime": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%S.%fZ")}
                if self.api.patch(f"{lease}/{self.name}", json={"spec": spec}, headers=_MERGE).status_code == 404:
                    self.api.post(lease, json={"metadata": {"name": self.name, "namespace": "kube-node-lease"}, "spec": spec})
            except httpx.HTTPError:
                pass
            if self.stopping.wait(5):
                return

    def _watch(self) -> None:
        where = {"fieldSelector": f"spec.nodeName={self.name}"}
        while not self.stopping.is_set():
            try:
                listed = self.api.get("/api/v1/pods", params=where).raise_for_status().json()
                here = {one["metadata"]["uid"] for one in listed["items"]}
                for one in listed["items"]:
                    self._see(one)
                for uid, pod in list(self.pods.items()):
                    if uid not in here:
                        pod.kill()
                more = {**where, "watch": "1", "resourceVersion": listed["metadata"]["resourceVersion"], "timeoutSeconds": "5"}
                with self.api.stream("GET", "/api/v1/pods", params=more, timeout=httpx.Timeout(5, read=15)) as stream:
                    for line in stream.iter_lines():
                        event = json.loads(line)
                        if self.stopping.is_set() or event["type"] == "ERROR":
                            break
                        if event["type"] == "DELETED" and event["object"]["metadata"]["uid"] in self.pods:
                            self.pods[event["object"]["metadata"]["uid"]].kill()
                        elif event["type"] in ("ADDED", "MODIFIED"):
                            self._see(event["object"])
            except (httpx.HTTPError, ValueError):
                self.stopping.wait(0.5)

    def _see(self, pod: dict) -> None:
        uid = pod["metadata"]["uid"]
        if uid not in self.pods:
            if pod.get("status", {}).get("phase") in ("Succeeded", "Failed"):
                return
            self.pods[uid] = Pod(self, pod)
        self.pods[uid].see(pod)

    # For tests

    def running(self, **labels: str) -> list["Pod"]:
        """Returns ready pods that are not being deleted, as a Service would choose them."""
        wanted = {f"app.kubernetes.io/{key}": value for key, value in labels.items()}
        return [pod for pod in self.pods.values() if pod.is_ready and not pod.ended and not pod.terminating.is_set()
                and wanted.items() <= pod.object["metadata"].get("labels", {}).items()]


class Pod:
    """One pod of the node, which has its own thread."""

    def __init__(self, agent: NodeAgent, pod: dict):
        self.agent, self.object = agent, pod
        meta = pod["metadata"]
        self.name, self.namespace = meta["name"], meta["namespace"]
        self.path = f"/api/v1/namespaces/{self.namespace}/pods/{self.name}"
        self.folder = agent.folder / "pods" / meta["uid"]
        number = next(_addresses)
        self.claimed = ports.random_free()
        free = list(self.claimed.values())
        # Differs between test runs, so that parallel runs use different addresses.
        self.places = Places(f"127.{64 + os.getpid() % 128}.{number // 250}.{number % 250 + 1}", dict(zip(ports_named(pod["spec"]), free)))
        self.terminating, self.killed = threading.Event(), threading.Event()
        self.is_ready = self.ended = False
        self.said: dict = {}
        self.runs: dict[str, Run] = {}
        self.thread = threading.Thread(target=self._run, name=f"pod {self.name}", daemon=True)
        self.thread.start()

    def see(self, pod: dict) -> None:
        self.object = pod
        if "deletionTimestamp" in pod["metadata"]:
            self.terminating.set()

    def kill(self) -> None:
        self.killed.set()
        self.terminating.set()

    # Internals

    def _run(self) -> None:
        try:
            self._prepare()
            while not self.terminating.is_set() and self._turn():
                time.sleep(0.1)
            self._end()
        except Exception as wrong:     # noqa: BLE001 - said where somebody looks
            (self.folder / "agent.log").write_text(repr(wrong), encoding="utf-8")
            self._say("Failed", [], str(wrong))
        finally:
            for run in self.runs.values():
                run.signal(signal.SIGKILL)
            self.ended = True
            ports.give_back(self.claimed.values())

    def _prepare(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        self.agent.plane.run_as.own(self.folder)
        sources = {one["name"]: self._volume(one) for one in self.object["spec"].get("volumes", [])}
        for one in self.object["spec"]["containers"]:
            mounts = [Mount(sources[mount["name"]], mount["mountPath"], mount.get("readOnly", False)) for mount in one.get("volumeMounts", [])]
            env = environment(self.object, one, self.places, lambda name: self._data("secrets", name), lambda name: self._data("configmaps", name))
            server = httpx.URL(self.agent.plane.server)
            env |= {"KUBERNETES_SERVICE_HOST": server.host, "KUBERNETES_SERVICE_PORT": str(server.port)}
            self.runs[one["name"]] = Run(self, one, env, mounts)

    def _turn(self) -> bool:
        """Returns False when everything has ended for good."""
        policy = self.object["spec"].get("restartPolicy", "Always")
        for run in self.runs.values():
            run.turn(policy)
        runs = list(self.runs.values())
        phase = phase_of(policy, [run.ended for run in runs], [run.restarts > 0 or run.began for run in runs])
        self.is_ready = phase == "Running" and all(run.ready for run in runs)
        self._say(phase, [run.status() for run in runs])
        return phase in ("Running", "Pending")

    def _end(self) -> None:
        meta = self.object["metadata"]
        grace = 0 if self.killed.is_set() else meta.get("deletionGracePeriodSeconds", 30)
        if "deletionTimestamp" not in meta and not self.killed.is_set():
            return     # it ended on its own, and its object stays
        self.is_ready = False
        deadline = time.monotonic() + grace
        self._say("Running", [run.status(ready=False) for run in self.runs.values()])
        pause = max((run.container.get("lifecycle", {}).get("preStop", {}).get("sleep", {}).get("seconds", 0) for run in self.runs.values()), default=0)
        self.killed.wait(min(pause, grace))
        for run in self.runs.values():
            run.signal(signal.SIGTERM)
        while any(run.alive() for run in self.runs.values()) and time.monotonic() < deadline and not self.killed.is_set():
            time.sleep(0.05)
        for run in self.runs.values():
            run.signal(signal.SIGKILL)
        while any(run.alive() for run in self.runs.values()):
            time.sleep(0.02)
        if not self.agent.stopping.is_set():
            self.agent.api.request("DELETE", self.path, json={"gracePeriodSeconds": 0, "preconditions": {"uid": meta["uid"]}})
        shutil.rmtree(self.folder, ignore_errors=True)

    def _say(self, phase: str, containers: list[dict], message: str = "") -> None:
        """Updates the status only after a change. The transition time is that of the condition."""
        before = {one["type"]: one for one in self.said.get("conditions", self.object.get("status", {}).get("conditions", []))}
        truth = {"Initialized": True, "ContainersReady": self.is_ready, "Ready": self.is_ready}
        conditions = [one for kind, one in before.items() if kind not in truth]
        for kind, value in truth.items():
            same = before.get(kind, {}).get("status") == str(value)
            conditions.append({"type": kind, "status": str(value), "lastTransitionTime": before[kind]["lastTransitionTime"] if same else now()})
        status = {"phase": phase, "conditions": conditions, "podIP": self.places.address, "podIPs": [{"ip": self.places.address}], "hostIP": "127.0.0.1",
                  "containerStatuses": containers, "message": message, "startTime": self.said.get("startTime", now())}
        if status != self.said:
            answer = self.agent.api.patch(f"{self.path}/status", json={"metadata": {"uid": self.object["metadata"]["uid"]}, "status": status}, headers=_MERGE)
            if answer.status_code in (404, 409):
                self.kill()
            elif answer.status_code == 200:
                self.said = status
            else:
                raise RuntimeError(answer.text)

    def _data(self, kind: str, name: str) -> dict[str, bytes]:
        """Waits for the object, like a kubelet."""
        while True:
            answer = self.agent.api.get(f"/api/v1/namespaces/{self.namespace}/{kind}/{name}")
            if answer.status_code == 200:
                return data_of(answer.json())
            if self.terminating.wait(0.5):
                raise RuntimeError(f"{kind}/{name}: {answer.status_code}")

    def _volume(self, volume: dict) -> Path:
        if claim := volume.get("persistentVolumeClaim"):
            return self._claim(claim["claimName"])
        place = self.folder / "volumes" / volume["name"]
        place.mkdir(parents=True)
        files: dict[str, bytes] = {}
        if "hostPath" in volume:
            return Path(volume["hostPath"]["path"])
        if secret := volume.get("secret"):
            files = chosen(self._data("secrets", secret["secretName"]), secret.get("items"))
        if config := volume.get("configMap"):
            files = {path: mapped(data.decode(), self.places).encode() for path, data in chosen(self._data("configmaps", config["name"]), config.get("items")).items()}
        for source in volume.get("projected", {}).get("sources", []):
            files |= self._projected(source)
        for path, data in files.items():
            (place / path).write_bytes(data)
            (place / path).chmod(0o440)
            self.agent.plane.run_as.own(place / path)
        self.agent.plane.run_as.own(place)
        return place

    def _projected(self, source: dict) -> dict[str, bytes]:
        if token := source.get("serviceAccountToken"):
            account = self.object["spec"]["serviceAccountName"]
            bound = {"kind": "Pod", "apiVersion": "v1", "name": self.name, "uid": self.object["metadata"]["uid"]}
            answer = self.agent.api.post(f"/api/v1/namespaces/{self.namespace}/serviceaccounts/{account}/token", json={
                "apiVersion": "authentication.k8s.io/v1", "kind": "TokenRequest", "spec": {"expirationSeconds": 3607, "boundObjectRef": bound}})
            return {token["path"]: answer.raise_for_status().json()["status"]["token"].encode()}
        if config := source.get("configMap"):
            return chosen(self._data("configmaps", config["name"]), config.get("items"))
        items = source.get("downwardAPI", {}).get("items", [])
        return {one["path"]: field_of(self.object, one["fieldRef"]["fieldPath"], self.places).encode() for one in items}

    def _claim(self, name: str) -> Path:
        """Returns the folder on this machine behind a bound claim."""
        while True:
            claim = self.agent.api.get(f"/api/v1/namespaces/{self.namespace}/persistentvolumeclaims/{name}").json()
            if claim.get("status", {}).get("phase") == "Bound":
                volume = self.agent.api.get(f"/api/v1/persistentvolumes/{claim['spec']['volumeName']}").json()
                return Path(volume["spec"]["hostPath"]["path"])
            if self.terminating.wait(0.5):
                raise RuntimeError(f"the claim {name} is not bound")


class Run:
    """A container of a pod: its current process, restarts, and results of its probes."""

    def __init__(self, pod: Pod, container: dict, env: dict[str, str], mounts: list[Mount]):
        self.pod, self.container, self.env = pod, container, env
        self.mounts = [*image_mounts(pod.agent.programs), *mounts]
        self.process: Container | None = None
        self.restarts, self.failures, self.again_at = 0, 0, 0.0
        self.began = self.ready = self.up = False
        self.since = ""
        self.ended: int | None = None
        self.asked: dict[str, float] = {}
        self.failed: dict[str, int] = {}

    def alive(self) -> bool:
        return self.process is not None and self.process.exit_code() is None

    def signal(self, number: int) -> None:
        if self.process:
            self.process.signal(number)

    def turn(self, policy: str) -> None:
        if self.process is None:
            if self.ended is None or (policy != "Never" and time.monotonic() >= self.again_at):
                self._begin()
            return
        code = self.process.exit_code()
        if code is None:
            self._ask()
            return
        self.process, self.ended, self.ready, self.up = None, code, False, False
        if policy == "OnFailure" and code == 0:
            self.again_at = float("inf")
            return
        # The first restart is immediate.
        self.again_at = time.monotonic() + (0 if self.failures == 0 else min(300, 10 * 2 ** (self.failures - 1)))
        self.failures += 1

    def _begin(self) -> None:
        command = [*self.container.get("command", []), *self.container.get("args", [])]
        root = self.pod.folder / "root" / self.container["name"]
        if self.began:
            self.restarts += 1
        self.process = Container(command, self.env, self.mounts, root, self.pod.folder / f"{self.container['name']}.log", self.pod.agent.plane.run_as)
        self.began, self.ended, self.since = True, None, now()
        self.asked, self.failed = {}, {}

    def _ask(self) -> None:
        """The other probes start after the startup probe has succeeded."""
        if not self.up and "startupProbe" in self.container:
            self.up = self._probe("startupProbe") is True
        else:
            self.up = True
        if not self.up:
            return
        if "readinessProbe" not in self.container:
            self.ready = True
        elif (answer := self._probe("readinessProbe")) is not None:
            self.ready = answer
        if "livenessProbe" in self.container and self._probe("livenessProbe") is False:
            self.signal(signal.SIGKILL)

    def _probe(self, kind: str) -> bool | None:
        """Returns True for success, False after the allowed number of failures, and None without a new result. Probes at most
        every half second until it succeeds."""
        probe = self.container[kind]
        period = probe.get("periodSeconds", 10)
        wait = min(period, 0.5) if kind == "startupProbe" or (kind == "readinessProbe" and not self.ready) else period
        if time.monotonic() < self.asked.get(kind, 0) + wait:
            return None
        self.asked[kind] = time.monotonic()
        if self._answers(probe):
            self.failed[kind] = 0
            return True
        self.failed[kind] = self.failed.get(kind, 0) + 1
        return False if self.failed[kind] >= probe.get("failureThreshold", 3) else None

    def _answers(self, probe: dict) -> bool:
        limit = probe.get("timeoutSeconds", 1)
        at = (self.pod.places.address, probe_port(self.container, probe, self.pod.places))
        try:
            if "tcpSocket" in probe:
                socket.create_connection(at, limit).close()
                return True
            return 200 <= httpx.get(f"http://{at[0]}:{at[1]}{probe['httpGet']['path']}", timeout=limit, trust_env=False).status_code < 400
        except (OSError, httpx.HTTPError):
            return False

    def status(self, ready: bool | None = None) -> dict:
        if self.process:
            state: dict = {"running": {"startedAt": self.since}}
        elif self.ended is not None:
            state = {"terminated": {"exitCode": self.ended, "reason": "Completed" if self.ended == 0 else "Error", "startedAt": self.since, "finishedAt": self.since}}
        else:
            state = {"waiting": {"reason": "ContainerCreating"}}
        return {"name": self.container["name"], "image": self.container["image"], "imageID": "", "ready": self.ready if ready is None else ready,
                "restartCount": self.restarts, "started": self.up, "state": state}
