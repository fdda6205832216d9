"""The operator with thousands of GPUs: filled, idle and restarted, sessions placed among them, and a worker created when the last
slot is taken. Used by `./diaphane bench cluster`. Nodes and pods are kwok's. renderd's own scripts send a heartbeat per pod to a
real Redis."""

from __future__ import annotations

import json
import os
import random
import shutil
import socket
import statistics
import tempfile
import threading
import time
import uuid
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx
import redis as redis_client
from conftest import wait_for
from operator_helpers import BUILD, GROUP, Cluster, Redis
from plane import ORDER, Plane

from devtool import paths, users
from devtool.bench import percentile
from devtool.benches.soak import held

_SCRIPTS = BUILD / "directory" / "scripts"
PLACE = _SCRIPTS / "place.lua"
HEARTBEAT = _SCRIPTS / "heartbeat.lua"
REPORT = _SCRIPTS / "update_telemetry.lua"
FLEETS = _SCRIPTS / "fleets.lua"
#: Overrides defaults for small clusters: 50 bindings per second, a node lease every 10 s.
_FLAGS = {
    "kube-scheduler": ["--kube-api-qps=2000", "--kube-api-burst=4000"],
    "kube-controller-manager": ["--kube-api-qps=2000", "--kube-api-burst=4000", "--node-monitor-grace-period=900s"],
    "kwok": ["--node-lease-duration-seconds=600"],
    "kube-apiserver": ["--max-requests-inflight=2000", "--max-mutating-requests-inflight=1000"],
}


def _resp(*words: object) -> bytes:
    parts = [str(word).encode() for word in words]
    return b"*%d\r\n" % len(parts) + b"".join(b"$%d\r\n%s\r\n" % (len(one), one) for one in parts)


class ManyBeats:
    """Heartbeats of thousands of workers per second as prepared bytes, so that the measured cost is that of Redis and not of
    Python."""

    def __init__(self, port: int):
        self.client = redis_client.Redis(port=port, decode_responses=True)
        self.heartbeat, self.report = (self.client.script_load(path.read_text(encoding="utf-8")) for path in (HEARTBEAT, REPORT))
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.words: dict[str, bytes] = {}
        self.rounds: list[float] = []
        self.stopping = threading.Event()
        self.thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> "ManyBeats":
        self.thread.start()
        return self

    def put(self, name: str, incarnation: str, owner: str = "", slots: int = 16) -> None:
        words = _resp("EVALSHA", self.heartbeat, 0, name, incarnation, f"{name}:1", "cpu", "test", slots, "0", "0.1", "0.1", "", "")
        if owner:
            words += _resp("EVALSHA", self.report, 0, name, incarnation, owner, "0.1", "0.2")
        self.words[name] = words

    def remove(self, name: str) -> None:
        self.words.pop(name, None)

    def _run(self) -> None:
        while not self.stopping.is_set():
            began = time.monotonic()
            words = list(self.words.values())
            for i in range(0, len(words), 100):     # in small batches, so that other commands can run in between
                self.socket.sendall(b"".join(words[i:i + 100]))
                self._drain(sum(one.count(b"EVALSHA") for one in words[i:i + 100]))
            if words:
                self.rounds.append(time.monotonic() - began)
            self.stopping.wait(max(0.01, 1 - (time.monotonic() - began)))

    def _drain(self, answers: int) -> None:
        """Reads this many answers: a list of three for a heartbeat, and a number for a report."""
        data = b""
        while data.count(b":") + data.count(b"*3\r\n") < answers:
            piece = self.socket.recv(1 << 16)
            if not piece or b"-ERR" in piece or b"-NOSCRIPT" in piece:
                raise RuntimeError(piece[:200])
            data += piece

    def stop(self) -> None:
        self.stopping.set()
        self.thread.join()


def asked(session: str) -> list:
    """Returns the arguments of place.lua for one session of a new user."""
    return [session, str(uuid.uuid4()), str(uuid.uuid4()), uuid.uuid4().hex * 2, "1", 15000, 30, 86400, 8, 64, "", "", "", "", "skull",
            "", "owner", "1", "", 25, ""]


# Sessions on warm workers, without Kubernetes

def place(workers: int, rate: float, seconds: float, slots: int = 16, filled: float = 0.5) -> dict:
    """Requests new sessions at `rate`, on schedule whatever the response times, while all workers send heartbeats and the
    operator polls every second."""
    folder, run_as = Path(tempfile.mkdtemp(prefix="diaphane-place-")), users.ordinary_user()
    run_as.own(folder)
    redis = Redis(folder, run_as)
    beats = ManyBeats(redis.port)
    try:
        names = [f"skull-{number}" for number in range(workers)]
        for name in names:
            beats.put(name, "i", f"skull/{name}/1", slots)
        beats.start()
        wait_for(lambda: redis.client.scard("diaphane:workers") == workers and len(beats.rounds) > 2, "all workers")
        # Existing sessions hold their slots for longer than the measurement.
        until = int(time.time() * 1000) + 3_600_000
        pipe = redis.client.pipeline(transaction=False)
        dice = random.Random(1)
        for name in names:
            held = {str(uuid.UUID(int=dice.getrandbits(128))): until for _ in range(min(slots - 1, max(0, round(dice.gauss(filled * slots, 1)))))}
            if held:
                pipe.zadd(f"diaphane:worker:{name}:sessions", held)
        pipe.execute()
        script = redis.client.register_script(PLACE.read_text(encoding="utf-8"))
        look = redis.client.register_script(FLEETS.read_text(encoding="utf-8"))
        looks: list[float] = []
        over = threading.Event()

        def operator() -> None:
            while not over.wait(1):
                began, cursor = time.monotonic(), "0"
                while (cursor := look(args=[cursor, "1", "skull"])[0]) != "0":
                    pass
                looks.append(time.monotonic() - began)
        looker = threading.Thread(target=operator, daemon=True)
        looker.start()
        times: list[float] = []
        refused: list[str] = []

        def ask(due: float) -> None:
            session = str(uuid.uuid4())
            answer = script(args=asked(session))
            times.append(time.monotonic() - due)
            if answer[0] == "placed":
                redis.client.zadd(f"diaphane:worker:{answer[1]}:sessions", {session: until})
            else:
                refused.append(answer[0])
        due = time.monotonic()
        end = due + seconds
        with ThreadPoolExecutor(8) as asking:       # about as many as an api has connections
            while due < end:
                due += dice.expovariate(rate)
                time.sleep(max(0, due - time.monotonic()))
                asking.submit(ask, due)
        over.set()
        looker.join()
        pipe = redis.client.pipeline(transaction=False)
        for name in names:
            pipe.zcard(f"diaphane:worker:{name}:sessions")
        counts = pipe.execute()
        return {"workers": workers, "asked": len(times), "p50_ms": 1e3 * percentile(times, 50), "p99_ms": 1e3 * percentile(times, 99),
                "refused": len(refused), "over_committed": sum(count > slots for count in counts), "sessions": sum(counts),
                "most": max(counts), "least": min(counts), "spread": statistics.pstdev(counts) / statistics.mean(counts),
                "beats_s": statistics.median(beats.rounds), "look_p50_ms": 1e3 * percentile(looks, 50)}
    finally:
        beats.stop()
        redis.stop()
        shutil.rmtree(folder, ignore_errors=True)


# With the control plane

class ScaleCluster(Cluster):
    """Replaces the slow heartbeats of the tests: a watch of the pods' metadata determines which workers send them."""

    def __init__(self, plane: Plane, namespace: str, folder: Path):
        super().__init__(plane, namespace, folder)
        self.beats.stop()
        self.slots = 16
        self.many = ManyBeats(self.redis.port).start()
        self.closing = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        path = f"/api/v1/namespaces/{self.namespace}/pods"
        accept = {"Accept": "application/json;as=PartialObjectMetadata;g=meta.k8s.io;v=v1"}
        while not self.closing.is_set():
            try:
                with self.plane.client() as api, api.stream("GET", path, params={"watch": "1"}, headers=accept, timeout=None) as answer:
                    for line in answer.iter_lines():
                        self._pod(json.loads(line))
            except httpx.HTTPError:
                time.sleep(0.2)

    def _pod(self, event: dict) -> None:
        about = event["object"]["metadata"]
        if not (owners := about.get("ownerReferences")):
            return
        if event["type"] == "DELETED":
            return self.many.remove(about["name"])
        fleet = about["labels"]["diaphane.dev/fleet"]
        self.many.put(about["name"], about["uid"], f"{fleet}/{owners[0]['uid']}/{about['annotations']['diaphane.dev/epoch']}", self.slots)

    def close(self) -> None:
        self.closing.set()
        self.many.stop()
        for one in self.operators:
            one.stop()
        self.redis.stop()


def say_ready(plane: Plane, names: list[str]) -> None:
    """Does what a kubelet and then the controller manager would do. The API server creates each node with a taint."""
    patch = {"Content-Type": "application/merge-patch+json"}
    for name in names:
        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        ready = {"type": "Ready", "status": "True", "reason": "Said", "lastHeartbeatTime": now, "lastTransitionTime": now}
        for path, words in (("/status", {"status": {"conditions": [ready]}}), ("", {"spec": {"taints": None}})):
            plane.api.patch(f"/api/v1/nodes/{name}{path}", headers=patch, json=words).raise_for_status()


@contextmanager
def cluster(nodes: int, gpus: int = 8, only: tuple[str, ...] = ORDER):
    folder, run_as = Path(tempfile.mkdtemp(prefix="diaphane-scale-")), users.ordinary_user()
    run_as.own(folder)
    plane = Plane(folder, run_as, flags=_FLAGS, only=only).start()
    made = None
    try:
        plane.define_resources()
        plane.apply({"apiVersion": "v1", "kind": "Namespace", "metadata": {"name": "scale"}})
        own = folder / "operator"
        own.mkdir()
        run_as.own(own)
        made = ScaleCluster(plane, "scale", own)
        names = made.nodes(nodes, gpus)
        if "kwok" not in only:
            say_ready(plane, names)
        yield made
    finally:
        if made:
            made.close()
        plane.stop()
        shutil.rmtree(folder, ignore_errors=True)


def cpu_s(pid: int) -> float:
    words = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def _written(operator) -> float:
    """Returns the number of actions that the operator executed."""
    lines = [line for line in operator.metrics().splitlines() if line.startswith("diaphane_operator_actions_total{")]
    return sum(float(line.rpartition(" ")[2]) for line in lines)


def settle(operator, most_s: float = 300, quiet_s: float = 10) -> float:
    """Returns the seconds until the operator wrote nothing for `quiet_s`. Counting ready workers by heartbeats would end before
    each worker's status reports it."""
    began, last, since = time.monotonic(), -1.0, time.monotonic()
    while time.monotonic() - began < most_s and time.monotonic() - since < quiet_s:
        time.sleep(0.5)
        if (now := _written(operator)) != last:
            last, since = now, time.monotonic()
    return since - began


def fill(nodes: int, most_s: float, idle_s: float) -> dict:
    """Measures a fleet that needs every GPU, then idles. Afterwards, the operator restarts and must act immediately."""
    with cluster(nodes) as made:
        wanted = nodes * 8
        operator = made.operator()
        wait_for(lambda: operator.ready().get("leader"), "a leader")
        began = time.monotonic()
        made.fleet(replicas=wanted, sessionsPerWorker=16)
        steps = []
        while (now := time.monotonic() - began) < most_s:
            ready = made.status().get("readyReplicas", 0)
            steps.append((round(now, 1), ready, len(made.many.words)))
            if ready == wanted:
                break
            time.sleep(2)
        reached, took = steps[-1][1], time.monotonic() - began
        pids = {"operator": operator.process.pid, **{name: one.pid for name, one in made.plane.processes.items()}}
        spent = {name: cpu_s(pid) for name, pid in pids.items()}
        over = made.over_committed()
        out = {"nodes": nodes, "wanted": wanted, "ready": reached, "fill_s": took, "over_committed_nodes": len(over), "steps": steps[::10],
               "cpu_filling_s": {name: round(value, 1) for name, value in spent.items()}, "rss_filled_mb": held(pids["operator"])["memory"]}
        if reached < wanted:
            # Fixes the number of workers at the current one.
            made.plane.kubectl("scale", "rf/skull", f"--replicas={len(made.many.words)}", "-n", made.namespace)
        out["settled_s"] = settle(operator)
        out["actions"] = _written(operator)
        before, at = cpu_s(pids["operator"]), time.monotonic()
        time.sleep(idle_s)
        out["idle_cpu_share"] = (cpu_s(pids["operator"]) - before) / (time.monotonic() - at)
        out["actions_while_idle"] = _written(operator) - out["actions"]
        out["rss_idle_mb"] = held(pids["operator"])["memory"]
        out["beats_s"] = statistics.median(made.many.rounds[-20:])
        out |= restart(made, operator)
        out["over_committed_nodes"] = max(out["over_committed_nodes"], len(made.over_committed()))
        return out


def restart(made: ScaleCluster, operator) -> dict:
    assert operator.stop() == 0
    name = sorted(made.many.words)[0]
    made.plane.kubectl("delete", "pod", name, "-n", made.namespace, "--wait=true", "--grace-period=0", "--force")
    began = time.monotonic()
    second = made.operator()
    wait_for(lambda: second.ready().get("checks", {}).get("listed"), "all listed", timeout=300)
    listed = time.monotonic() - began
    path = f"/api/v1/namespaces/{made.namespace}/pods/{name}"
    wait_for(lambda: made.plane.api.get(path).status_code == 200, "the pod that is missing", timeout=300)
    return {"listed_s": listed, "acting_s": time.monotonic() - began, "rss_restarted_mb": held(second.process.pid)["memory"]}


def left_behind(made: ScaleCluster, count: int) -> float:
    """Creates this many RenderWorkers as an operator would, without pods. Returns the seconds. One is the operator's own, and the
    others are copies of it."""
    first = made.operator()
    made.fleet(replicas=1, sessionsPerWorker=16)
    own = wait_for(made.workers, "the operator's own worker")[0]
    assert first.stop() == 0
    about, path = own["metadata"], f"{GROUP}/namespaces/{made.namespace}/renderworkers"
    gpus = [one["metadata"]["name"] for one in made.plane.api.get("/api/v1/nodes").json()["items"] for _ in range(8)]
    gpus.remove(own["spec"]["nodeName"])
    names = [f"skull-{number}" for number in range(count) if f"skull-{number}" != about["name"]]
    began, share = time.monotonic(), threading.local()

    def make(name: str, node: str) -> None:
        if not hasattr(share, "api"):
            share.api = made.plane.client()
        share.api.post(path, json={"apiVersion": own["apiVersion"], "kind": own["kind"], "spec": {**own["spec"], "nodeName": node}, "metadata": {
            "name": name, "labels": {**about["labels"], "diaphane.dev/worker": name}, "finalizers": about["finalizers"],
            "ownerReferences": about["ownerReferences"]}}).raise_for_status()
    with ThreadPoolExecutor(8) as making:
        list(making.map(make, names, gpus))
    made.plane.kubectl("scale", "rf/skull", f"--replicas={count}", "-n", made.namespace)
    return time.monotonic() - began


def listed(workers: int) -> dict:
    """An operator starts among RenderWorkers of a previous one. Measures until it has read them, and until the first missing pod
    exists. Only etcd and the API server run, so pods are never bound."""
    with cluster(-(-workers // 8), only=("etcd", "kube-apiserver")) as made:
        made.plane.apply({"apiVersion": "v1", "kind": "ServiceAccount", "metadata": {"name": "default", "namespace": made.namespace}})
        made_s = left_behind(made, workers)
        pods, before = f"/api/v1/namespaces/{made.namespace}/pods", len(made.pods())
        began = time.monotonic()
        operator = made.operator()
        wait_for(lambda: operator.ready().get("checks", {}).get("listed"), "all listed", timeout=300)
        seen = time.monotonic() - began
        wait_for(lambda: len(made.plane.api.get(pods, params={"limit": before + 1}).json()["items"]) > before, "the first pod", timeout=300)
        acting = time.monotonic() - began
        time.sleep(20)
        return {"workers": workers, "made_s": made_s, "listed_s": seen, "acting_s": acting, "pods_after_20_s": len(made.pods()) - before,
                "memory_mb": held(operator.process.pid)["memory"], "over_committed_nodes": len(made.over_committed())}


def cold(times: int) -> dict:
    """The last slot is taken, and a user arrives. Measures until a worker accepts them. Its pod starts at once (kwok), so the
    start of a GPU is not included."""
    with cluster(max(1, times // 8 + 1)) as made:
        operator = made.operator()
        wait_for(lambda: operator.ready().get("leader"), "a leader")
        made.slots = 1
        made.fleet(sessionsPerWorker=made.slots, maxReplicas=times + 4)
        client, took = made.redis.client, []
        script = client.register_script(PLACE.read_text(encoding="utf-8"))
        until = int(time.time() * 1000) + 3_600_000

        def ask(session: str) -> str:
            answer = script(args=asked(session))
            return answer[1] if answer[0] == "placed" else ""
        for _ in range(times):
            session = str(uuid.uuid4())
            while worker := ask(session):       # fills the workers with free slots first
                client.zadd(f"diaphane:worker:{worker}:sessions", {session: until})
                session = str(uuid.uuid4())
            began = time.monotonic()
            worker = wait_for(lambda: ask(session), "a place", timeout=120)
            took.append(time.monotonic() - began)
            client.zadd(f"diaphane:worker:{worker}:sessions", {session: until})
        return {"times": times, "p50_s": percentile(took, 50), "p99_s": percentile(took, 99), "over_committed_nodes": len(made.over_committed())}
