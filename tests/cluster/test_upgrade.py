"""From one version of the chart to the next and back: people's sessions, their rows, the workers that they look through."""

from __future__ import annotations

import json
import shutil
import subprocess
import threading
import time
import uuid
from pathlib import Path

import pytest
import yaml
from chart_help import CHART, SECRET, values_file
from conftest import wait_for
from operator_help import BUILD, GROUP
from plane import node
from pod_contents import Places, data_of, environment
from test_chart import prepare

from house import paths

RELEASE = "it-diaphane"
OLD = "0.0.9"
MIGRATIONS = paths.REPO / "migrations"


def older_chart(folder: Path) -> Path:
    """The version before: another number and image, and a worker without one of its settings."""
    chart = folder / "older"
    shutil.copytree(CHART, chart, symlinks=False)
    about = yaml.safe_load((chart / "Chart.yaml").read_text(encoding="utf-8"))
    (chart / "Chart.yaml").write_text(yaml.safe_dump({**about, "version": OLD, "appVersion": OLD}), encoding="utf-8")
    template = chart / "templates" / "fleet.yaml"
    lines = template.read_text(encoding="utf-8").splitlines()
    without = [line for line in lines if "DIAPHANE_KERNEL_CACHE" not in line]
    assert len(without) == len(lines) - 1
    template.write_text("\n".join(without) + "\n", encoding="utf-8")
    return chart


class Hooks:
    """Runs what a hook's pod says, really: with the programs of this checkout and the schema of its image's version."""

    def __init__(self, plane, namespace: str, folder: Path):
        self.plane, self.namespace, self.folder = plane, namespace, folder
        self.ran: list[tuple[str, str]] = []
        self.node = f"{namespace}-hooks"
        # Nothing is scheduled to it: what is bound there by hand is run here.
        plane.api.post("/api/v1/nodes", json={**node(self.node, gpus=0, kwok=False), "spec": {"unschedulable": True}}).raise_for_status()
        older = folder / "migrations"
        shutil.copytree(MIGRATIONS, older)
        for file in older.glob(sorted(MIGRATIONS.glob("*.up.sql"))[-1].name[:4] + "*"):
            file.unlink()
        self.migrations = {OLD: older}

    def while_helm(self, *words: str) -> None:
        """The scheduler waits until the hook's pod is here, so that it is bound to no node of kwok's."""
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
        pods = self.plane.api.get(path, params={"labelSelector": "app.kubernetes.io/component=migrate"}).json()["items"]
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
        assert done.returncode == 0, done.stderr
        self.ran.append((container["image"], done.stdout))
        return True

    def _data(self, kind: str, name: str) -> dict[str, bytes]:
        return data_of(self.plane.api.get(f"/api/v1/namespaces/{self.namespace}/{kind}/{name}").raise_for_status().json())

    def _run(self, pod: dict, container: dict) -> subprocess.CompletedProcess:
        env = environment(pod, container, Places("127.0.0.1"), lambda name: self._data("secrets", name), lambda name: self._data("configmaps", name))
        migrations = self.migrations.get(container["image"].partition(":")[2], MIGRATIONS)
        words = [word.replace("/opt/diaphane/bin", str(BUILD / "bin")).replace("/opt/diaphane/migrations", str(migrations)) for word in container["command"]]
        return subprocess.run(words, env=env, capture_output=True, text=True, timeout=60)

    def close(self) -> None:
        self.plane.api.delete(f"/api/v1/nodes/{self.node}")


@pytest.fixture
def hooks(plane, namespace, tmp_path):
    made = Hooks(plane, namespace, tmp_path)
    yield made
    made.close()


def schema(stack) -> list[str]:
    return [name for name, in stack.psql("SELECT name FROM schema_migrations ORDER BY name")]


def test_upgraded_and_rolled_back_with_sessions_and_rows_kept(plane, namespace, hooks, cluster, stack_factory, tmp_path):
    stores = stack_factory(only=("postgres",))
    prepare(plane, namespace)
    plane.kubectl("patch", "secret", "diaphane", "-n", namespace, "-p", json.dumps({"stringData": {**SECRET, "postgres": stores.dsn}}))
    cluster.nodes(2, gpus=4)
    values = {"fleet": {"minReplicas": 2, "nodeSelector": {"pool": namespace}, "drainTimeout": "10m", "sessionsPerWorker": 4}, "networkPolicy": {"enabled": False}}
    given = ("-n", namespace, "-f", values_file(tmp_path, values))
    hooks.while_helm("install", "it", str(older_chart(tmp_path)), *given)
    everything = sorted(one.name.removesuffix(".up.sql") for one in MIGRATIONS.glob("*.up.sql"))
    assert hooks.ran[-1][0] == f"diaphane:{OLD}" and schema(stores) == everything[:-1]

    # The chart's own account, before its own fleet.
    cluster.token_file.write_text(plane.service_account_token(namespace, f"{RELEASE}-operator"), encoding="utf-8")
    operator = cluster.operator()
    wait_for(lambda: cluster.status(RELEASE).get("readyReplicas") == 2, "two workers")

    # People: rows, and sessions that they look at.
    person = str(uuid.uuid4())
    stores.psql("INSERT INTO users (id, email, email_key, password_hash) VALUES (%s, %s, %s, %s)", person, "a@example.org", "a@example.org", "x")
    rows = stores.psql("SELECT * FROM users")
    sessions = [str(uuid.uuid4()) for _ in range(3)]
    first, second = sorted(one["metadata"]["name"] for one in cluster.running() if "diaphane.dev/worker" in one["metadata"]["labels"])
    for session, worker in zip(sessions, (first, first, second)):
        cluster.redis.client.hset(f"diaphane:session:{session}", mapping={"user": person, "data_set": str(uuid.uuid4()), "worker": worker, "placement": "1"})
    cluster.beats.sessions.update({first: sessions[:2], second: sessions[2:]})
    wait_for(lambda: cluster.status(RELEASE).get("slotsUsed") == 3, "the sessions")
    stored = {session: cluster.redis.client.hgetall(f"diaphane:session:{session}") for session in sessions}

    def worker_pods() -> dict[str, str]:
        return {one["metadata"]["name"]: one["metadata"]["uid"] for one in cluster.running() if "diaphane.dev/worker" in one["metadata"]["labels"]}

    def kept(pods: dict[str, str], span: float) -> None:
        """Whoever has live sessions is there, the same, all the time."""
        until = time.monotonic() + span
        while time.monotonic() < until:
            now = worker_pods()
            assert all(now.get(name) == uid for name, uid in pods.items()), "a worker with live sessions has gone"
            assert {session: cluster.redis.client.hgetall(f"diaphane:session:{session}") for session in sessions} == stored
            assert stores.psql("SELECT * FROM users") == rows
            time.sleep(0.5)

    def exchanged(image: str) -> dict[str, str]:
        """Others came, of that image; the sessions move to them, and the old ones go."""
        def of(wanted: bool) -> dict[str, str]:
            renderers = [one for one in cluster.running() if one["spec"]["containers"][0]["name"] == "renderd"]
            return {one["metadata"]["name"]: one["metadata"]["uid"] for one in renderers if (one["spec"]["containers"][0]["image"] == image) is wanted}
        new = wait_for(lambda: of(True), f"a worker of {image}")
        old = of(False)
        kept({name: uid for name, uid in old.items() if cluster.beats.sessions.get(name)}, 8)
        to = next(iter(new))
        for name in list(cluster.beats.sessions):
            cluster.beats.sessions[name] = []
        for session in sessions:      # as the gateway and place.lua move one
            cluster.redis.client.hset(f"diaphane:session:{session}", mapping={"worker": to, "placement": "2"})
        stored.update({session: cluster.redis.client.hgetall(f"diaphane:session:{session}") for session in sessions})
        cluster.beats.sessions[to] = list(sessions)
        wait_for(lambda: not of(False), "the end of those that nobody looks through", timeout=180)
        return {to: new[to]}

    fleet = plane.api.get(f"{GROUP}/namespaces/{namespace}/renderfleets/{RELEASE}").json()["metadata"]["uid"]
    hooks.while_helm("upgrade", "it", str(CHART), *given)
    now = yaml.safe_load((CHART / "Chart.yaml").read_text(encoding="utf-8"))["appVersion"]
    assert hooks.ran[-1][0] == f"diaphane:{now}" and schema(stores) == everything
    holder = exchanged(f"diaphane:{now}")
    assert stores.psql("SELECT * FROM users") == rows

    plane.helm("rollback", "it", "1", "-n", namespace, "--wait", "--timeout", "180s")
    kept(holder, 2)
    exchanged(f"diaphane:{OLD}")
    assert schema(stores) == everything, "what was written since needs the schema that it was written in"
    assert plane.api.get(f"{GROUP}/namespaces/{namespace}/renderfleets/{RELEASE}").json()["metadata"]["uid"] == fleet
    assert operator.alive() and cluster.over_committed() == []
    plane.helm("uninstall", "it", "-n", namespace, "--timeout", "120s", check=False)
