"""From one version of the chart to the next and back: users' sessions, their rows, and the workers that they use."""

from __future__ import annotations

import json
import shutil
import time
import uuid
from pathlib import Path

import pytest
import yaml
from chart_helpers import CHART, SECRET, values_file
from conftest import wait_for
from hooks_helpers import Hooks
from operator_helpers import GROUP
from test_chart import prepare

from devtool import paths

RELEASE = "it-diaphane"
OLD = "0.0.9"
MIGRATIONS = paths.REPO / "migrations"


def older_chart(folder: Path) -> Path:
    """Writes the previous version: another number and image, and a worker without one of its settings."""
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


class Migrates(Hooks):
    """Runs the migration with the schema of its image's version."""

    component = "migrate"

    def __init__(self, plane, namespace: str, folder: Path):
        super().__init__(plane, namespace)
        older = folder / "migrations"
        shutil.copytree(MIGRATIONS, older)
        for file in older.glob(sorted(MIGRATIONS.glob("*.up.sql"))[-1].name[:4] + "*"):
            file.unlink()
        self.migrations = {OLD: older}

    def words(self, container: dict) -> list[str]:
        migrations = self.migrations.get(container["image"].partition(":")[2], MIGRATIONS)
        return [word.replace("/opt/diaphane/migrations", str(migrations)) for word in super().words(container)]


@pytest.fixture
def hooks(plane, namespace, tmp_path):
    made = Migrates(plane, namespace, tmp_path)
    yield made
    made.close()


def schema(stack) -> list[str]:
    return [name for name, in stack.psql("SELECT name FROM schema_migrations ORDER BY name")]


#: The columns that every version has.
USERS = "SELECT id, email, email_key, password_hash, created_at FROM users"


def test_upgrade_and_rollback_keep_sessions_and_rows(plane, namespace, hooks, cluster, stack_factory, tmp_path):
    stores = stack_factory(only=("postgres",))
    prepare(plane, namespace)
    plane.kubectl("patch", "secret", "diaphane", "-n", namespace, "-p", json.dumps({"stringData": {**SECRET, "postgres": stores.dsn}}))
    cluster.nodes(2, gpus=4)
    values = {"fleet": {"minReplicas": 2, "nodeSelector": {"pool": namespace}, "drainTimeout": "10m", "sessionsPerWorker": 4}, "networkPolicy": {"enabled": False}}
    given = ("-n", namespace, "-f", values_file(tmp_path, values))
    hooks.while_helm("install", "it", str(older_chart(tmp_path)), *given)
    everything = sorted(one.name.removesuffix(".up.sql") for one in MIGRATIONS.glob("*.up.sql"))
    assert hooks.ran[-1][0] == f"diaphane:{OLD}" and schema(stores) == everything[:-1]

    # Uses the account of the chart, before its fleet exists.
    cluster.token_file.write_text(plane.service_account_token(namespace, f"{RELEASE}-operator"), encoding="utf-8")
    operator = cluster.operator()
    wait_for(lambda: cluster.status(RELEASE).get("readyReplicas") == 2, "two workers")

    # Users: rows, and sessions that they view.
    person = str(uuid.uuid4())
    stores.psql("INSERT INTO users (id, email, email_key, password_hash) VALUES (%s, %s, %s, %s)", person, "a@example.org", "a@example.org", "x")
    rows = stores.psql(USERS)
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
        """Checks that all workers with live sessions keep running."""
        until = time.monotonic() + span
        while time.monotonic() < until:
            now = worker_pods()
            assert all(now.get(name) == uid for name, uid in pods.items()), "a worker with live sessions has gone"
            assert {session: cluster.redis.client.hgetall(f"diaphane:session:{session}") for session in sessions} == stored
            assert stores.psql(USERS) == rows
            time.sleep(0.5)

    def exchanged(image: str) -> dict[str, str]:
        """Replaces the workers by ones with that image. The sessions move to them, and the old ones end."""
        def of(wanted: bool) -> dict[str, str]:
            renderers = [one for one in cluster.running() if one["spec"]["containers"][0]["name"] == "renderd"]
            return {one["metadata"]["name"]: one["metadata"]["uid"] for one in renderers if (one["spec"]["containers"][0]["image"] == image) is wanted}
        new = wait_for(lambda: of(True), f"a worker of {image}")
        old = of(False)
        kept({name: uid for name, uid in old.items() if cluster.beats.sessions.get(name)}, 8)
        to = next(iter(new))
        for name in list(cluster.beats.sessions):
            cluster.beats.sessions[name] = []
        for session in sessions:      # moves a session as the gateway and place.lua do
            cluster.redis.client.hset(f"diaphane:session:{session}", mapping={"worker": to, "placement": "2"})
        stored.update({session: cluster.redis.client.hgetall(f"diaphane:session:{session}") for session in sessions})
        cluster.beats.sessions[to] = list(sessions)
        wait_for(lambda: not of(False), "the end of the workers without viewers", timeout=180)
        return {to: new[to]}

    fleet = plane.api.get(f"{GROUP}/namespaces/{namespace}/renderfleets/{RELEASE}").json()["metadata"]["uid"]
    hooks.while_helm("upgrade", "it", str(CHART), *given)
    now = yaml.safe_load((CHART / "Chart.yaml").read_text(encoding="utf-8"))["appVersion"]
    assert hooks.ran[-1][0] == f"diaphane:{now}" and schema(stores) == everything
    holder = exchanged(f"diaphane:{now}")
    assert stores.psql(USERS) == rows

    plane.helm("rollback", "it", "1", "-n", namespace, "--wait", "--timeout", "180s")
    kept(holder, 2)
    exchanged(f"diaphane:{OLD}")
    assert schema(stores) == everything, "what was written since needs the schema that it was written in"
    assert plane.api.get(f"{GROUP}/namespaces/{namespace}/renderfleets/{RELEASE}").json()["metadata"]["uid"] == fleet
    assert operator.alive() and cluster.over_committed() == []
    plane.helm("uninstall", "it", "-n", namespace, "--timeout", "120s", check=False)
