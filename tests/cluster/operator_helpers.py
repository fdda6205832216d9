"""The operator's program against the real control plane, and workers that send heartbeats with renderd's own scripts."""

from __future__ import annotations

import itertools
import os
import secrets
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path

import httpx
import redis as redis_client
from chart_helpers import rendered
from conftest import wait_for
from plane import Plane

from devtool import paths, ports
from devtool.processes import Identity, end
from devtool.stack import WITHOUT_CORE_FILES

GROUP = "/apis/diaphane.dev/v1alpha1"
#: The only lease that the chart permits.
LEASE = "it-diaphane-operator"
BUILD = Path(os.environ.get("DIAPHANE_BUILD", paths.REPO / "build" / "release"))
_SCRIPTS = BUILD / "directory" / "scripts"
_numbers = itertools.count(1)

_rights: dict[bool, dict[str, list[dict]]] = {}


def chart_rights(plane: Plane, all_pods: bool = False) -> dict[str, list[dict]]:
    """Returns the rights that the chart gives the operator: `here`, in its namespace, and `everywhere`."""
    if all_pods not in _rights:
        with tempfile.TemporaryDirectory() as folder:
            roles = rendered(plane, Path(folder), {"operator": {"watchAllPods": all_pods}}, hooks=False)
        named = {"Role": "here", "ClusterRole": "everywhere"}
        _rights[all_pods] = {named[one["kind"]]: one["rules"] for one in roles if one["kind"] in named}
    return _rights[all_pods]


class Redis:
    """A Redis for one test."""

    def __init__(self, folder: Path, run_as):
        self.folder, self.run_as = folder, run_as
        self.port = next(iter(ports.random_free().values()))
        self.client = redis_client.Redis(port=self.port, decode_responses=True)
        self.start()

    def start(self) -> None:
        """Starts it empty, also after stop()."""
        self.process = subprocess.Popen([*WITHOUT_CORE_FILES, "/usr/bin/redis-server", "--port", str(self.port), "--bind", "127.0.0.1",
                                         "--save", "", "--appendonly", "no", "--dir", str(self.folder)],
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True, **self.run_as.popen())
        wait_for(self._answers, "Redis")

    def _answers(self) -> bool:
        try:
            return self.client.ping()
        except redis_client.ConnectionError:
            return False

    def stop(self) -> None:
        self.process.kill()
        self.process.wait()


class Beats:
    """Sends heartbeats for each running pod, as its renderd would."""

    def __init__(self, cluster: Cluster):
        self.cluster = cluster
        self.sessions: dict[str, list[str]] = {}
        self.silent: set[str] = set()
        self.told: dict[str, float] = {}
        self.stopping = threading.Event()
        self.heartbeat = cluster.redis.client.register_script((_SCRIPTS / "heartbeat.lua").read_text(encoding="utf-8"))
        self.report = cluster.redis.client.register_script((_SCRIPTS / "update_telemetry.lua").read_text(encoding="utf-8"))
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self) -> None:
        while not self.stopping.wait(0.5):
            try:
                for pod in self.cluster.pods():
                    if pod["status"].get("phase") == "Running" and pod["metadata"]["name"] not in self.silent:
                        self._beat(pod)
            except (httpx.HTTPError, redis_client.RedisError):
                pass

    def _beat(self, pod: dict) -> None:
        containers = [one for one in pod["spec"]["containers"] if one["name"] == "renderd"]
        env = {one["name"]: one.get("value", "") for container in containers for one in container.get("env", [])}
        owner = env.get("DIAPHANE_OWNER")
        if not owner:
            return
        name = env["DIAPHANE_WORKER_ID"]
        live = self.sessions.get(name, [])
        uid = pod["metadata"]["uid"]
        draining = "1" if uid in self.told else "0"
        sessions = [word for one in live for word in (one, "1", "0")]
        self.heartbeat(args=[name, uid, f"{uid}:1", "cpu", "test", env["DIAPHANE_SLOTS"], draining, str(0.1 * len(live)), str(0.1 * len(live)), "",
                             pod["spec"]["nodeName"], *sessions])
        room = self.report(args=[name, uid, owner, "0.1", "0.2"])
        if int(room) >= 0:
            self.told.setdefault(uid, time.monotonic())

    def stop(self) -> None:
        self.stopping.set()
        self.thread.join()


class Operator:
    """One diaphane-operator process."""

    def __init__(self, cluster: Cluster, number: int, server: str = "", **settings: str):
        self.cluster = cluster
        self.name = f"operator-{number}"
        self.admin = next(iter(ports.random_free().values()))
        self.log = cluster.folder / f"{cluster.namespace}-{self.name}.log"
        plane = cluster.plane
        env = {"PATH": "/usr/bin:/bin", "LANG": "C.UTF-8", "DIAPHANE_NAMESPACE": cluster.namespace, "DIAPHANE_KUBE_SERVER": server or plane.server,
               "DIAPHANE_KUBE_TOKEN_FILE": str(cluster.token_file), "DIAPHANE_KUBE_CA_FILE": str(plane.folder / "ca.crt"),
               "DIAPHANE_REDIS": f"127.0.0.1:{cluster.redis.port}", "DIAPHANE_ADMIN_PORT": str(self.admin), "DIAPHANE_IDENTITY": self.name,
               "DIAPHANE_LEASE": LEASE, **settings}
        with open(self.log, "ab") as out:
            self.process = subprocess.Popen([*WITHOUT_CORE_FILES, str(BUILD / "bin" / "diaphane-operator")], env=env, cwd="/", stdin=subprocess.DEVNULL,
                                            stdout=out, stderr=out, start_new_session=True)
        self.identity = Identity.of(self.process.pid)

    def ready(self) -> dict:
        try:
            return httpx.get(f"http://127.0.0.1:{self.admin}/readyz", timeout=5, trust_env=False).json()
        except (httpx.HTTPError, ValueError):
            return {}

    def alive(self) -> bool:
        return self.process.poll() is None

    def metrics(self) -> str:
        return httpx.get(f"http://127.0.0.1:{self.admin}/metrics", timeout=5, trust_env=False).text

    def pause(self, on: bool = True) -> None:
        self.identity.send(signal.SIGSTOP if on else signal.SIGCONT)

    def kill(self) -> None:
        self.identity.send(signal.SIGKILL)
        self.process.wait()

    def stop(self) -> int:
        if self.alive():
            self.pause(on=False)
            end(self.identity, seconds=10)
        return self.process.wait()


class Cluster:
    """A namespace with its own nodes, an account for the operator, and a Redis."""

    def __init__(self, plane: Plane, namespace: str, folder: Path):
        self.plane, self.namespace, self.folder = plane, namespace, folder
        self.redis = Redis(folder, plane.run_as)
        self.operators: list[Operator] = []
        self.allow(**chart_rights(plane))
        self.token_file = folder / f"{namespace}.token"
        self.token_file.write_text(plane.service_account_token(namespace, "operator"), encoding="utf-8")
        self.beats = Beats(self)

    def allow(self, here: list[dict], everywhere: list[dict]) -> None:
        space = {"namespace": self.namespace}
        api = "rbac.authorization.k8s.io"
        subject = {"kind": "ServiceAccount", "name": "operator", **space}
        wide = f"{self.namespace}-operator"
        self.plane.apply(
            {"apiVersion": "v1", "kind": "ServiceAccount", "metadata": {"name": "operator", **space}},
            {"apiVersion": f"{api}/v1", "kind": "Role", "metadata": {"name": "operator", **space}, "rules": here},
            {"apiVersion": f"{api}/v1", "kind": "RoleBinding", "metadata": {"name": "operator", **space},
             "roleRef": {"apiGroup": api, "kind": "Role", "name": "operator"}, "subjects": [subject]},
            {"apiVersion": f"{api}/v1", "kind": "ClusterRole", "metadata": {"name": wide}, "rules": everywhere},
            {"apiVersion": f"{api}/v1", "kind": "ClusterRoleBinding", "metadata": {"name": wide},
             "roleRef": {"apiGroup": api, "kind": "ClusterRole", "name": wide}, "subjects": [subject]})

    def operator(self, **how: str) -> Operator:
        """`server`: another address of the API server. Other arguments are settings."""
        self.operators.append(Operator(self, next(_numbers), **how))
        return self.operators[-1]

    def nodes(self, count: int, gpus: int = 8) -> list[str]:
        return self.plane.add_nodes(count, gpus, prefix=f"{self.namespace}-{secrets.token_hex(2)}", labels={"pool": self.namespace})

    def fleet(self, name: str = "skull", **spec) -> None:
        self.plane.apply(self.fleet_object(name, **spec))

    def fleet_object(self, name: str = "skull", **spec) -> dict:
        container = {"name": "renderd", "image": "diaphane:test", "securityContext": {
            "allowPrivilegeEscalation": False, "capabilities": {"drop": ["ALL"]}, "runAsNonRoot": True, "seccompProfile": {"type": "RuntimeDefault"}}}
        return {"apiVersion": "diaphane.dev/v1alpha1", "kind": "RenderFleet", "metadata": {"name": name, "namespace": self.namespace},
                "spec": {"sessionsPerWorker": 4, "nodeSelector": {"pool": self.namespace},
                         "template": {"spec": {"containers": [container]}}, **spec}}

    def _get(self, path: str) -> dict:
        """A starting API server responds with 429 until it has read its store."""
        answer = wait_for(lambda: (got := self.plane.api.get(path)).status_code not in (429, 503) and got, "an answer")
        answer.raise_for_status()
        return answer.json()

    def _list(self, path: str) -> list[dict]:
        return self._get(path)["items"]

    def pods(self) -> list[dict]:
        return self._list(f"/api/v1/namespaces/{self.namespace}/pods")

    def workers(self) -> list[dict]:
        return self._list(f"{GROUP}/namespaces/{self.namespace}/renderworkers")

    def status(self, name: str = "skull") -> dict:
        return self._get(f"{GROUP}/namespaces/{self.namespace}/renderfleets/{name}").get("status", {})

    def condition(self, kind: str, name: str = "skull") -> dict:
        return next((one for one in self.status(name).get("conditions", []) if one["type"] == kind), {})

    def events(self) -> list[dict]:
        return self._list(f"/api/v1/namespaces/{self.namespace}/events")

    def running(self) -> list[dict]:
        return [one for one in self.pods() if one["status"].get("phase") == "Running" and "deletionTimestamp" not in one["metadata"]]

    def settled(self, count: int):
        """Waits until exactly this many workers exist and are ready, each with a running pod."""
        def is_so() -> bool:
            workers, pods = self.workers(), self.pods()
            return len(workers) == len(pods) == len(self.running()) == count and self.status().get("readyReplicas", 0) == count
        return wait_for(is_so, f"{count} ready workers")

    def over_committed(self) -> list[str]:
        """Returns nodes of the test with more reservations than GPUs."""
        gpus = {one["metadata"]["name"]: int(one["status"]["allocatable"]["nvidia.com/gpu"]) for one in self._list("/api/v1/nodes")}
        taken: dict[str, int] = {}
        for worker in self.workers():
            taken[worker["spec"]["nodeName"]] = taken.get(worker["spec"]["nodeName"], 0) + 1
        return [node for node, count in taken.items() if count > gpus.get(node, count)]

    def close(self) -> None:
        for one in self.operators:
            one.stop()
        self.beats.stop()
        self.redis.stop()
        # No operator is left to remove the finalizers.
        for kind in ("renderworkers", "renderfleets"):
            for one in self._list(f"{GROUP}/namespaces/{self.namespace}/{kind}"):
                self.plane.api.patch(f"{GROUP}/namespaces/{self.namespace}/{kind}/{one['metadata']['name']}", json={"metadata": {"finalizers": None}},
                                     headers={"Content-Type": "application/merge-patch+json"})
        self.plane.api.delete("/api/v1/nodes", params={"labelSelector": f"pool={self.namespace}"})
