"""One whole node: containerd, kubelet and a bridge, in the network and mount namespace that `./diaphane test node` made for the test.

    node = KubeletNode(plane, folder).start();  node.stop()
"""

from __future__ import annotations

import hashlib
import io
import json
import subprocess
import tarfile
from pathlib import Path

from conftest import wait_for
from plane import Plane

from devtool import logfiles, whole_node
from devtool.processes import Identity, end

NAME = "whole"
#: Address of the node besides its loopback, at which pods reach what runs on the node.
ADDRESS = "192.168.177.1"
_PODS = "10.88.0.0/24"
_PAUSE = "localhost/pause:1"


class KubeletNode:
    def __init__(self, plane: Plane, folder: Path, programs: Path, group: str):
        self.plane, self.folder, self.bin = plane, folder, programs
        self.running: list[tuple[Identity, subprocess.Popen]] = []
        self.group = group
        self.socket = folder / "containerd.sock"

    def start(self) -> "KubeletNode":
        self._own_places()
        self._network()
        self._containerd()
        self._kubelet()
        wait_for(self._ready, "a ready node")
        self.plane.kubectl("label", "node", NAME, "pool=real")
        # Sets a device without a plugin at the API. Kubelet keeps it.
        self.plane.api.patch(f"/api/v1/nodes/{NAME}/status", headers={"Content-Type": "application/json-patch+json"}, json=[
            {"op": "add", "path": "/status/capacity/nvidia.com~1gpu", "value": "2"}]).raise_for_status()
        wait_for(lambda: self._status().get("allocatable", {}).get("nvidia.com/gpu") == "2", "GPUs of the node")
        return self

    def stop(self) -> None:
        for task in self._ctr("tasks", "list", "-q", check=False).split():
            self._ctr("tasks", "kill", "-s", "SIGKILL", task, check=False)
        for identity, process in reversed(self.running):
            end(identity, seconds=5)
            process.wait()

    def logs(self) -> dict[str, str]:
        return {path.name: logfiles.tail(path, 40) for path in sorted(self.folder.glob("*.log"))}

    # Internals

    def _own_places(self) -> None:
        """Keeps what these programs write at fixed paths inside this mount namespace."""
        for name in ("run", "var/log"):
            subprocess.run(["mount", "-t", "tmpfs", "tmpfs", f"/{name}"], check=True)
        upper, work = self.folder / "lib", self.folder / "lib-work"
        upper.mkdir()
        work.mkdir()
        subprocess.run(["mount", "-t", "overlay", "overlay", "-o", f"lowerdir=/var/lib,upperdir={upper},workdir={work}", "/var/lib"], check=True)

    def _network(self) -> None:
        for words in (("link", "set", "lo", "up"), ("address", "add", f"{ADDRESS}/32", "dev", "lo"), ("address", "add", "10.96.0.1/32", "dev", "lo")):
            subprocess.run(["ip", *words], check=True)
        Path("/proc/sys/net/ipv4/ip_forward").write_text("1")
        nets = self.folder / "cni"
        nets.mkdir()
        (nets / "10-pods.conflist").write_text(json.dumps({"cniVersion": "1.0.0", "name": "pods", "plugins": [
            {"type": "bridge", "bridge": "pods0", "isGateway": True, "ipMasq": False,
             "ipam": {"type": "host-local", "ranges": [[{"subnet": _PODS}]], "routes": [{"dst": "0.0.0.0/0"}], "dataDir": str(self.folder / "ipam")}},
            {"type": "loopback"}]}), encoding="utf-8")

    def _containerd(self) -> None:
        # Root in a container may be unable to lower a process's OOM score below its own.
        config = self.folder / "containerd.toml"
        config.write_text(f"""version = 2
root = "{self.folder}/containerd"
state = "{self.folder}/state"
disabled_plugins = ["io.containerd.snapshotter.v1.btrfs", "io.containerd.snapshotter.v1.zfs", "io.containerd.snapshotter.v1.devmapper", "io.containerd.internal.v1.opt"]
[grpc]
  address = "{self.socket}"
[plugins."io.containerd.grpc.v1.cri"]
  sandbox_image = "{_PAUSE}"
  restrict_oom_score_adj = true
  [plugins."io.containerd.grpc.v1.cri".cni]
    bin_dir = "{whole_node.CNI}"
    conf_dir = "{self.folder}/cni"
  [plugins."io.containerd.grpc.v1.cri".containerd.runtimes.runc]
    runtime_type = "io.containerd.runc.v2"
    [plugins."io.containerd.grpc.v1.cri".containerd.runtimes.runc.options]
      BinaryName = "{self.bin}/runc"
""", encoding="utf-8")
        self._spawn("containerd", str(self.bin / "containerd"), "--config", str(config))
        wait_for(lambda: self._ctr("version", check=False), "containerd")
        self._ctr("images", "import", str(_pause_image(self.folder)))

    def import_image(self, archive: Path, name: str) -> None:
        self._ctr("images", "import", "--index-name", name, str(archive))
        if name not in self._ctr("images", "list", "-q").split():
            raise AssertionError(f"{archive} holds no {name}")

    def _kubelet(self) -> None:
        config = self.folder / "kubelet.json"
        config.write_text(json.dumps({
            "apiVersion": "kubelet.config.k8s.io/v1beta1", "kind": "KubeletConfiguration", "failCgroupV1": False, "cgroupDriver": "cgroupfs",
            "cgroupRoot": f"/{self.group}", "enforceNodeAllocatable": [], "containerRuntimeEndpoint": f"unix://{self.socket}",
            "authentication": {"anonymous": {"enabled": False}, "webhook": {"enabled": False}}, "authorization": {"mode": "AlwaysAllow"},
            "readOnlyPort": 0, "healthzPort": 0, "address": "127.0.0.1", "failSwapOn": False, "evictionHard": {"nodefs.available": "0%", "imagefs.available": "0%"},
            "imageGCHighThresholdPercent": 100, "resolvConf": "", "podLogsDir": str(self.folder / "pod-logs"), "nodeStatusUpdateFrequency": "4s",
            "shutdownGracePeriod": "0s", "makeIPTablesUtilChains": False, "syncFrequency": "5s"}), encoding="utf-8")
        self._spawn("kubelet", str(self.bin / "kubelet"), f"--config={config}", f"--kubeconfig={self.plane.config_of('agent')}", f"--hostname-override={NAME}",
                    f"--node-ip={ADDRESS}", f"--root-dir={self.folder / 'kubelet'}", f"--cert-dir={self.folder / 'kubelet-pki'}")

    def _spawn(self, name: str, *command: str) -> None:
        with open(self.folder / f"{name}.log", "ab") as log:
            process = subprocess.Popen(command, cwd="/", stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
                                       env={"PATH": f"{self.bin}:/usr/sbin:/usr/bin:/sbin:/bin", "HOME": str(self.folder), "LANG": "C.UTF-8"})
        self.running.append((Identity.of(process.pid), process))

    def _ctr(self, *words: str, check: bool = True) -> str:
        done = subprocess.run([str(self.bin / "ctr"), "--address", str(self.socket), "-n", "k8s.io", *words], capture_output=True, text=True, timeout=300)
        if check and done.returncode != 0:
            raise AssertionError(f"ctr {' '.join(words)}: {done.stderr}")
        return done.stdout if done.returncode == 0 else ""

    def _status(self) -> dict:
        answer = self.plane.api.get(f"/api/v1/nodes/{NAME}")
        return answer.json().get("status", {}) if answer.status_code == 200 else {}

    def _ready(self) -> bool:
        for _, process in self.running:
            assert process.poll() is None, "\n".join(self.logs().values())
        return any(one["type"] == "Ready" and one["status"] == "True" for one in self._status().get("conditions", []))


def _pause_image(folder: Path) -> Path:
    """Creates the pause image, whose process holds a pod's namespaces, as an archive with one layer."""
    source, program, archive = folder / "pause.c", folder / "pause", folder / "pause.tar"
    source.write_text("#include <unistd.h>\nint main(void) { for (;;) pause(); }\n", encoding="ascii")
    subprocess.run(["cc", "-static", "-o", str(program), str(source)], check=True)
    layer = io.BytesIO()
    with tarfile.open(fileobj=layer, mode="w") as tar:
        tar.add(program, "pause")
    blobs: dict[str, bytes] = {}

    def blob(data: bytes, kind: str) -> dict:
        digest = hashlib.sha256(data).hexdigest()
        blobs[f"blobs/sha256/{digest}"] = data
        return {"mediaType": f"application/vnd.oci.image.{kind}", "digest": f"sha256:{digest}", "size": len(data)}

    def text(value: dict) -> bytes:
        return json.dumps(value).encode()

    only = blob(layer.getvalue(), "layer.v1.tar")
    config = blob(text({"architecture": "amd64", "os": "linux", "config": {"Cmd": ["/pause"]}, "rootfs": {"type": "layers", "diff_ids": [only["digest"]]}}), "config.v1+json")
    manifest = blob(text({"schemaVersion": 2, "mediaType": "application/vnd.oci.image.manifest.v1+json", "config": config, "layers": [only]}), "manifest.v1+json")
    index = text({"schemaVersion": 2, "manifests": [{**manifest, "annotations": {"io.containerd.image.name": _PAUSE}}]})
    with tarfile.open(archive, "w") as tar:
        for name, data in {"oci-layout": text({"imageLayoutVersion": "1.0.0"}), "index.json": index, **blobs}.items():
            entry = tarfile.TarInfo(name)
            entry.size = len(data)
            tar.addfile(entry, io.BytesIO(data))
    return archive
