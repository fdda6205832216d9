"""The real control plane of Kubernetes on free ports of the loopback, as an ordinary user, in a directory of its own.

    plane = Plane(factory.folder(), factory.run_as).start()
    plane.kubectl("get", "nodes");  plane.api.get("/apis/diaphane.dev/v1alpha1/renderfleets")
    plane.add_nodes(8, gpus=8);     plane.stop()

By hand: `.tools/venv/bin/python tests/cluster/plane.py [--nodes N]` starts one, says where its kubeconfig is, and ends it with Ctrl-C.
"""

from __future__ import annotations

import json
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

import httpx  # noqa: E402
from devtool import kubernetes, logfiles, paths, ports, users  # noqa: E402
from devtool.processes import Identity, end  # noqa: E402
from devtool.stack import WITHOUT_CORE_FILES  # noqa: E402

#: Users with a token: name and groups. Everyone else uses the token of a service account.
_USERS = {
    "admin": ("admin", "system:masters"),
    "kube-controller-manager": ("system:kube-controller-manager", ""),
    "kube-scheduler": ("system:kube-scheduler", ""),
    "kwok": ("kwok", "system:masters"),
    "agent": ("agent", "system:masters"),
}
ORDER = ("etcd", "kube-apiserver", "kube-controller-manager", "kube-scheduler", "kwok")


class PlaneError(RuntimeError):
    pass


@dataclass
class Said:
    """The output of a command."""

    code: int
    out: str
    err: str

    @property
    def text(self) -> str:
        return self.out + self.err

    @property
    def json(self):
        return json.loads(self.out)


@dataclass
class Plane:
    folder: Path
    run_as: users.RunAs = field(default_factory=users.RunAs)
    #: Additional flags of a program: {"kube-controller-manager": ["--node-monitor-grace-period=8s"]}
    flags: dict[str, list[str]] = field(default_factory=dict)
    only: tuple[str, ...] = ORDER

    def __post_init__(self) -> None:
        self.bin = kubernetes.reachable(self.run_as)
        given = list(ports.random_free().values())
        names = ("etcd", "etcd-peer", "kube-apiserver", "kube-controller-manager", "kube-scheduler", "kwok")
        self.ports = dict(zip(names, given))
        ports.give_back(given[len(names):])
        self.tokens = {name: secrets.token_hex(16) for name in _USERS}
        self.running: dict[str, Identity] = {}
        self.resources: dict[tuple[str, str], tuple[str, bool]] = {}
        self.processes: dict[str, subprocess.Popen] = {}
        self.server = f"https://127.0.0.1:{self.ports['kube-apiserver']}"

    # Start and stop

    def start(self) -> "Plane":
        try:
            self._make_files()
            for name in self.only:
                self.start_program(name)
            self.api = self.client("admin")
            if "kube-controller-manager" in self.only:
                self._wait_first()
        except BaseException:
            self.stop()
            raise
        return self

    def stop(self) -> None:
        for name in reversed(ORDER):
            self.stop_program(name)
        ports.give_back(self.ports.values())

    def start_program(self, name: str) -> None:
        """Starts it and waits until it responds."""
        log = open(self.log_path(name), "ab")
        process = subprocess.Popen([*WITHOUT_CORE_FILES, str(self.bin / name), *self._flags(name), *self.flags.get(name, [])],
                                   cwd=self.folder, env={"PATH": "/usr/bin:/bin", "HOME": str(self.folder), "LANG": "C.UTF-8"},
                                   stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True, **self.run_as.popen())
        log.close()
        self.processes[name] = process
        self.running[name] = Identity.of(process.pid)
        self._wait(name)

    def stop_program(self, name: str) -> None:
        if identity := self.running.pop(name, None):
            end(identity, seconds=5)
            self.processes.pop(name).wait()

    def kill(self, name: str) -> None:
        """Sends SIGKILL. The program stays down until start_program(name)."""
        self.running.pop(name).send(signal.SIGKILL)
        self.processes.pop(name).wait()

    def pause(self, name: str, on: bool = True) -> None:
        self.running[name].send(signal.SIGSTOP if on else signal.SIGCONT)

    def log_path(self, name: str) -> Path:
        return self.folder / f"{name}.log"

    def log_tails(self) -> dict[str, str]:
        return {name: logfiles.tail(self.log_path(name), 8) for name in ORDER if self.log_path(name).exists()}

    # Access

    @property
    def kubeconfig(self) -> Path:
        """Returns the administrator's kubeconfig."""
        return self.config_of("admin")

    def config_of(self, who: str) -> Path:
        return self.folder / f"{who}.kubeconfig"

    def write_config(self, who: str, token: str, namespace: str = "default") -> Path:
        path = self.config_of(who)
        self._write(path, json.dumps({
            "apiVersion": "v1", "kind": "Config", "current-context": "plane",
            "clusters": [{"name": "plane", "cluster": {"server": self.server, "certificate-authority": str(self.folder / "ca.crt")}}],
            "users": [{"name": who, "user": {"token": token}}],
            "contexts": [{"name": "plane", "context": {"cluster": "plane", "user": who, "namespace": namespace}}]}))
        return path

    def client(self, who: str = "admin", token: str = "") -> httpx.Client:
        """Returns a client of the API server with a user's token or with `token`."""
        import ssl

        trust = ssl.create_default_context(cafile=str(self.folder / "ca.crt"))
        headers = {"Authorization": f"Bearer {token or self.tokens[who]}"}
        return httpx.Client(base_url=self.server, headers=headers, verify=trust, timeout=30, trust_env=False)

    def kubectl(self, *words: str, given: object = None, who: str = "admin", check: bool = True, timeout: float = 120) -> Said:
        """`given` is passed to standard input: text, or an object (or a list of them) as JSON."""
        return self._run("kubectl", words, given, who, check, timeout)

    def helm(self, *words: str, given: object = None, who: str = "admin", check: bool = True, timeout: float = 240) -> Said:
        return self._run("helm", words, given, who, check, timeout)

    def apply(self, *objects: dict) -> None:
        """Works like `kubectl apply --server-side`, without starting a program per object."""
        for one in objects:
            version, kind, about = one["apiVersion"], one["kind"], one["metadata"]
            path = f"/apis/{version}" if "/" in version else f"/api/{version}"
            resource, namespaced = self._resource(path, kind)
            if namespaced:
                path += f"/namespaces/{about.get('namespace', 'default')}"
            deadline = time.monotonic() + 60
            # A starting server responds with 429 until it has read its store.
            while (answer := self.api.patch(f"{path}/{resource}/{about['name']}", params={"fieldManager": "kubectl", "fieldValidation": "Strict"},
                                            headers={"Content-Type": "application/apply-patch+yaml"}, content=json.dumps(one))
                   ).status_code in (429, 503) and time.monotonic() < deadline:
                time.sleep(0.2)
            if answer.is_error:
                raise PlaneError(f"{kind} {about['name']}: {answer.status_code} {answer.text}")

    def service_account_token(self, namespace: str, name: str) -> str:
        asked = {"apiVersion": "authentication.k8s.io/v1", "kind": "TokenRequest", "spec": {"expirationSeconds": 7200}}
        answer = self.api.post(f"/api/v1/namespaces/{namespace}/serviceaccounts/{name}/token", json=asked)
        return answer.raise_for_status().json()["status"]["token"]

    def compact(self) -> int:
        """Discards all earlier revisions, so that a watch from one of them gets 410. Returns the revision."""
        url = f"http://127.0.0.1:{self.ports['etcd']}/v3/kv"
        revision = int(httpx.post(f"{url}/range", json={"key": "AA=="}, trust_env=False).json()["header"]["revision"])
        httpx.post(f"{url}/compaction", json={"revision": revision, "physical": True}, trust_env=False).raise_for_status()
        return revision

    def add_nodes(self, count: int, gpus: int = 8, prefix: str = "node", labels: dict | None = None, kwok: bool = True) -> list[str]:
        """Adds nodes with GPUs. With `kwok`, they become ready and their pods run. Otherwise, the caller must do that."""
        names = [f"{prefix}-{number}" for number in range(count)]
        for name in names:
            self.api.post("/api/v1/nodes", json=node(name, gpus, labels, kwok)).raise_for_status()
        return names

    def define_resources(self) -> None:
        """Installs the chart's custom resources and waits until they are served."""
        self.kubectl("apply", "--server-side", "-f", str(paths.REPO / "helm" / "diaphane" / "crds"))
        self.kubectl("wait", "--for=condition=Established", "crd", "-l", "app.kubernetes.io/part-of=diaphane", "--timeout=60s")

    # Internals

    def _resource(self, path: str, kind: str) -> tuple[str, bool]:
        """Returns the kind's name in a path, and whether it is namespaced."""
        if (path, kind) not in self.resources:
            for one in self.api.get(path).raise_for_status().json()["resources"]:
                if "/" not in one["name"]:
                    self.resources[path, one["kind"]] = (one["name"], one["namespaced"])
        return self.resources[path, kind]

    def _run(self, program: str, words, given: object, who: str, check: bool, timeout: float) -> Said:
        if isinstance(given, list):
            given = {"apiVersion": "v1", "kind": "List", "items": given}
        if given is not None and not isinstance(given, str):
            given = json.dumps(given)
        done = subprocess.run([str(self.bin / program), *words], input=given, capture_output=True, text=True, timeout=timeout,
                              cwd=self.folder, env=self.environment(who))
        if check and done.returncode != 0:
            raise PlaneError(f"{program} {' '.join(words)}: {done.returncode}\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
        return Said(done.returncode, done.stdout, done.stderr)

    def environment(self, who: str = "admin") -> dict[str, str]:
        home = self.folder / "client"
        home.mkdir(exist_ok=True)
        return {"PATH": "/usr/bin:/bin", "HOME": str(home), "KUBECONFIG": str(self.config_of(who)), "LANG": "C.UTF-8"}

    def _write(self, path: Path, text: str) -> None:
        path.write_text(text, encoding="utf-8")
        path.chmod(0o600)
        self.run_as.own(path)

    def _make_files(self) -> None:
        rows = [f'{self.tokens[name]},{user},{name},"{groups}"' for name, (user, groups) in _USERS.items()]
        self._write(self.folder / "tokens.csv", "\n".join(rows) + "\n")
        for name in _USERS:
            self.write_config(name, self.tokens[name])
        names = ("DNS:localhost,DNS:kubernetes,DNS:kubernetes.default,DNS:kubernetes.default.svc,IP:127.0.0.1,IP:10.96.0.1")
        self._openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", "ca.key", "-out",
                      "ca.crt", "-days", "2", "-subj", "/CN=plane-ca", "-addext", "keyUsage=critical,keyCertSign,cRLSign")
        self._openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", "server.key", "-out",
                      "server.crt", "-days", "2", "-subj", "/CN=kube-apiserver", "-addext", f"subjectAltName={names}", "-addext",
                      "basicConstraints=critical,CA:FALSE", "-CA", "ca.crt", "-CAkey", "ca.key")
        self._openssl("genrsa", "-out", "accounts.key", "2048")

    def _openssl(self, *words: str) -> None:
        done = subprocess.run(["openssl", *words], cwd=self.folder, capture_output=True, text=True, **self.run_as.popen())
        if done.returncode != 0:
            raise PlaneError(f"openssl {words[0]}: {done.stderr}")

    def _flags(self, name: str) -> list[str]:
        at = {key: f"http://127.0.0.1:{port}" for key, port in self.ports.items()}
        config, accounts = f"--kubeconfig={self.config_of(name)}", self.folder / "accounts.key"
        serving = ["--bind-address=127.0.0.1", f"--secure-port={self.ports[name]}" if name in self.ports else ""]
        asks = [f"--authentication-kubeconfig={self.config_of(name)}", f"--authorization-kubeconfig={self.config_of(name)}"]
        return {
            "etcd": [f"--data-dir={self.folder / 'etcd'}", f"--listen-client-urls={at['etcd']}", f"--advertise-client-urls={at['etcd']}",
                     f"--listen-peer-urls={at['etcd-peer']}", f"--initial-advertise-peer-urls={at['etcd-peer']}",
                     f"--initial-cluster=default={at['etcd-peer']}", "--unsafe-no-fsync", "--log-level=warn"],
            "kube-apiserver": [
                f"--etcd-servers={at['etcd']}", *serving, "--advertise-address=127.0.0.1", "--endpoint-reconciler-type=none",
                "--service-cluster-ip-range=10.96.0.0/16", "--authorization-mode=Node,RBAC",
                f"--token-auth-file={self.folder / 'tokens.csv'}", "--service-account-issuer=https://kubernetes.default.svc",
                f"--service-account-key-file={accounts}", f"--service-account-signing-key-file={accounts}",
                f"--tls-cert-file={self.folder / 'server.crt'}", f"--tls-private-key-file={self.folder / 'server.key'}",
                f"--cert-dir={self.folder / 'certificates'}", "--shutdown-delay-duration=0s",
                # As on OpenShift: setting blockOwnerDeletion requires permission.
                "--enable-admission-plugins=OwnerReferencesPermissionEnforcement"],
            "kube-controller-manager": [
                config, *asks, *serving, "--leader-elect=false", "--use-service-account-credentials", f"--root-ca-file={self.folder / 'ca.crt'}",
                f"--service-account-private-key-file={accounts}", f"--cert-dir={self.folder / 'certificates'}"],
            "kube-scheduler": [config, *asks, *serving, "--leader-elect=false", f"--cert-dir={self.folder / 'certificates'}"],
            "kwok": [config, f"--config={self.bin / 'kwok.yaml'}", "--manage-all-nodes=false", "--manage-nodes-with-annotation-selector=kwok.x-k8s.io/node=fake",
                     "--node-lease-duration-seconds=40", f"--node-port={self.ports['kwok']}", "--node-ip=127.0.0.1"],
        }[name]

    def _wait(self, name: str) -> None:
        path = {"etcd": "http://{}/health", "kube-apiserver": "https://{}/readyz", "kwok": "http://{}/healthz"}.get(name, "https://{}/healthz")
        url = path.format(f"127.0.0.1:{self.ports[name]}")
        deadline = time.monotonic() + 120
        while True:
            if self.processes[name].poll() is not None:
                raise PlaneError(f"{name} ended with {self.processes[name].returncode}:\n{logfiles.tail(self.log_path(name), 30)}")
            try:
                # The certificate does not matter, only whether the port responds.
                if httpx.get(url, verify=False, timeout=5, trust_env=False,
                             headers={"Authorization": f"Bearer {self.tokens['admin']}"}).status_code == 200:
                    return
            except httpx.HTTPError:
                pass
            if time.monotonic() > deadline:
                raise PlaneError(f"{name} is not ready after two minutes:\n{logfiles.tail(self.log_path(name), 30)}")
            time.sleep(0.05)

    def _wait_first(self) -> None:
        """Waits until pods can be created, because the controller manager first creates each namespace's service account."""
        deadline = time.monotonic() + 60
        while self.api.get("/api/v1/namespaces/default/serviceaccounts/default").status_code != 200:
            if time.monotonic() > deadline:
                raise PlaneError("no service account in the namespace default after a minute")
            time.sleep(0.05)


def node(name: str, gpus: int = 8, labels: dict | None = None, kwok: bool = True) -> dict:
    room = {"cpu": "64", "memory": "512Gi", "pods": "250", "ephemeral-storage": "1Ti", "nvidia.com/gpu": str(gpus)}
    marks = {"kwok.x-k8s.io/node": "fake"} if kwok else {}
    return {"apiVersion": "v1", "kind": "Node",
            "metadata": {"name": name, "annotations": marks,
                         "labels": {"kubernetes.io/hostname": name, "kubernetes.io/os": "linux", "kubernetes.io/arch": "amd64", **(labels or {})}},
            "status": {"capacity": room, "allocatable": room}}


def main() -> int:
    import argparse

    parser = argparse.ArgumentParser(description="A control plane of Kubernetes by hand; Ctrl-C ends it.")
    parser.add_argument("--nodes", type=int, default=2, help="nodes of kwok with 8 GPUs each (default 2)")
    parser.add_argument("--only", default=",".join(ORDER), help="comma-separated programs (default: all)")
    parser.add_argument("--folder", type=Path, help="an empty directory (default: one in /tmp, removed at the end)")
    options = parser.parse_args()
    if set(options.only.split(",")) & set(kubernetes.missing()):
        kubernetes.ensure()
    run_as = users.ordinary_user()
    folder = options.folder or Path(tempfile.mkdtemp(prefix="diaphane-plane-"))
    folder.mkdir(exist_ok=True)
    run_as.own(folder)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: sys.exit(0))     # runs the cleanup that ends its programs
    began = time.monotonic()
    plane = Plane(folder, run_as, only=tuple(options.only.split(","))).start()
    try:
        plane.add_nodes(options.nodes)
        print(f"ready after {time.monotonic() - began:.1f} s\nexport KUBECONFIG={plane.kubeconfig}\nexport PATH={plane.bin}:$PATH", flush=True)
        while True:
            signal.pause()
    finally:
        plane.stop()
        if options.folder is None:
            shutil.rmtree(folder, ignore_errors=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
