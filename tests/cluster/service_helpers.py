"""The chart installed on nodes that run its pods, with real stores, folders as claims, and a Service that leads to the edge."""

from __future__ import annotations

import selectors
import socket
import threading
import time
from pathlib import Path

from chart_helpers import CHART, SECRET, stored, values_file
from conftest import wait_for
from node_agent import NodeAgent, Pod
from plane import Plane

from harness import mails_in

NAME = "it-diaphane"


def reach(place: tuple[str, int] | Path) -> socket.socket:
    """Connects to a host and port, or to a Unix socket."""
    if not isinstance(place, Path):
        return socket.create_connection(place, timeout=5)
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    made.settimeout(5)
    try:
        made.connect(str(place))
    except OSError:
        made.close()
        raise
    return made


class Front:
    """A Service in front of its pods, which forwards each connection to a ready one, or the way from pods to a store."""

    def __init__(self, pick, at: tuple[str, int] = ("127.0.0.1", 0)):
        self.pick = pick
        self.listener = socket.create_server(at, backlog=256)
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, name="front", daemon=True).start()

    def _accept(self) -> None:
        while True:
            try:
                one, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self._carry, args=(one,), daemon=True).start()

    def _carry(self, one: socket.socket) -> None:
        try:
            other = reach(self.pick())
        except (OSError, LookupError):
            one.close()
            return
        other.settimeout(None)
        with one, other, selectors.DefaultSelector() as ready:
            ready.register(one, selectors.EVENT_READ, other)
            ready.register(other, selectors.EVENT_READ, one)
            while ready.get_map():
                for key, _ in ready.select():
                    try:
                        data = key.fileobj.recv(1 << 16)
                        if data:
                            key.data.sendall(data)
                            continue
                        key.data.shutdown(socket.SHUT_WR)
                    except OSError:
                        return
                    ready.unregister(key.fileobj)

    def close(self) -> None:
        self.listener.close()


class Service:
    """Offers what tests of a user with a page need of harness.TestStack, for the programs in a cluster."""

    def __init__(self, plane: Plane, namespace: str, agents: list[NodeAgent], stores, folder: Path):
        self.plane, self.namespace, self.agents, self.stores, self.folder = plane, namespace, agents, stores, folder
        self.front = Front(self._edge)
        self.url = f"http://localhost:{self.front.port}"
        self.psql, self.redis, self.wait_until = stores.psql, stores.redis, stores.wait_until
        self.redis_way = Front(lambda: stores.stack.settings.socket("redis"))
        self.dsn, self.redis_address = stores.dsn, f"127.0.0.1:{self.redis_way.port}"
        self.claims = {name: folder / "claims" / name for name in ("volumes", "uploads", "cache")}

    def _edge(self) -> tuple[str, int]:
        pod = next((pod for pod in self.pods("api")), None)
        if pod is None:
            raise LookupError("no pod of the Service is ready")
        return pod.places.address, pod.places.ports[8080]

    def pods(self, component: str) -> list[Pod]:
        return [pod for agent in self.agents for pod in agent.running(component=component, instance="it")]

    def install(self, *parts: dict) -> None:
        for name, place in self.claims.items():
            place.mkdir(parents=True)
            self._own(place)
            self.plane.apply(stored(self.namespace, f"{NAME}-{name}", str(place)))
        self._mail_folder().mkdir()
        self._own(self._mail_folder())
        secret = SECRET | {"postgres": self.dsn, "mail": "file:/data/cache/mail"}
        self.plane.kubectl("create", "-n", self.namespace, "-f", "-", given={
            "apiVersion": "v1", "kind": "Secret", "metadata": {"name": "diaphane"}, "stringData": secret})
        values = {"publicUrl": self.url, "redis": {"address": self.redis_address}, "api": {"replicas": 1}, "operator": {"replicas": 1}}
        self.plane.helm("install", "it", str(CHART), "-n", self.namespace, "-f", values_file(self.folder, values, *parts), "--wait", "--timeout", "180s")

    def _own(self, place: Path) -> None:
        self.plane.run_as.own(place)

    def uninstall(self) -> None:
        self.plane.helm("uninstall", "it", "-n", self.namespace, "--wait", "--timeout", "180s", check=False)
        self.front.close()
        self.redis_way.close()

    def _mail_folder(self) -> Path:
        return self.claims["cache"] / "mail"

    def mails(self, to: str) -> list:
        return mails_in(self._mail_folder(), to)

    # Locations of sessions

    def workers(self, count: int) -> list[Pod]:
        """Returns this many pods once they send heartbeats to Redis."""
        def beating() -> list[Pod] | None:
            pods = [pod for pod in self.pods("renderd") if self.redis.exists(f"diaphane:worker:{pod.name}")]
            return pods if len(pods) == count else None
        return wait_for(beating, f"{count} workers that beat")

    def place_of(self, session: str) -> tuple[str, str]:
        """Returns the worker and the incarnation of its process."""
        worker, incarnation = self.redis.hmget(f"diaphane:session:{session}", "worker", "incarnation")
        return worker, incarnation

    def pod(self, name: str) -> Pod:
        return next(pod for agent in self.agents for pod in agent.pods.values() if pod.name == name and not pod.ended)

    def moved_from(self, session: str, before: tuple[str, str], page) -> float:
        """Waits until another process has the session. Returns the seconds."""
        began = time.monotonic()
        while self.place_of(session) in (before, (None, None)):
            assert time.monotonic() < began + 120, f"the session stays at {before}"
            page.wait_for_timeout(20)
        return time.monotonic() - began
