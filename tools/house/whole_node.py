"""A whole node for `./diaphane test node`: containerd and runc as Debian has them (taken out of their packages: nothing is installed, no
service starts), kubelet from Kubernetes' sources, Debian's CNI plugins. It lives in a network and a mount namespace of its own."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from . import kubernetes, packages
from .says import HouseError, say, step

#: Everything of the test runs below this.
NAMESPACES = ("unshare", "--net", "--mount", "--propagation", "private", "--")
CNI = Path("/usr/lib/cni")
_DEBIAN = ("containerd", "runc")
_PROGRAMS = ("containerd", "containerd-shim-runc-v2", "ctr", "runc", "kubelet")
_INSTALLED = ("containernetworking-plugins", "iproute2")
_CONTROLLERS = ("cpu", "cpuset", "memory")


def absence() -> str:
    """What this machine lacks for a node, in words; empty when nothing."""
    if os.geteuid() != 0:
        return "a node is run by root, and this is not root"
    if why := _no_cgroups():
        return why
    if "overlay" not in Path("/proc/filesystems").read_text(encoding="ascii"):
        return "the kernel has no overlay file system, in which containerd lays images"
    if not Path("/dev/kmsg").exists():
        return "/dev/kmsg is not there, where kubelet hears of processes killed for memory"
    script = "ip link set lo up && ip link add probe0 type bridge && ip link add a0 type veth peer name b0 && mount -t tmpfs probe /mnt"
    tried = subprocess.run([*NAMESPACES, "/bin/sh", "-c", script], capture_output=True, text=True)
    if tried.returncode != 0:
        return f"no network and mount namespace with a bridge in it: {tried.stderr.strip()}"
    return ""


def cgroup_folders() -> list[Path]:
    """Where a node's own cgroup is made: in each hierarchy of version 1, or in the one of version 2."""
    root = Path("/sys/fs/cgroup")
    if (root / "cgroup.controllers").exists():
        return [root]
    found = []
    for line in Path("/proc/self/mounts").read_text(encoding="utf-8").splitlines():
        _, where, kind, options, *_ = line.split()
        if kind == "cgroup":
            found.append(Path(where))
    return found


def _no_cgroups() -> str:
    root = Path("/sys/fs/cgroup")
    if (root / "cgroup.controllers").exists():
        has = set((root / "cgroup.controllers").read_text(encoding="ascii").split())
    else:
        has = {name for folder in cgroup_folders() for name in folder.name.split(",")}
    if lacking := [name for name in _CONTROLLERS if name not in has]:
        return f"control groups: no {', '.join(lacking)} below /sys/fs/cgroup"
    for folder in cgroup_folders():
        probe = folder / f"diaphane-probe-{os.getpid()}"
        try:
            probe.mkdir()
            probe.rmdir()
        except OSError as error:
            return f"control groups: {folder} cannot be written ({error.strerror})"
    return ""


def folder() -> Path:
    return kubernetes.folder() / "node"


def ensure() -> Path:
    """Takes and builds what is not there."""
    if absent := packages.missing(list(_INSTALLED)):
        packages.install(absent)
    folder().mkdir(parents=True, exist_ok=True)
    if any(not (folder() / name).exists() for name in _PROGRAMS if name != "kubelet"):
        _take()
    if not (folder() / "kubelet").exists():
        step("Building kubelet (minutes)")
        _build_kubelet()
    return folder()


def _take() -> None:
    with tempfile.TemporaryDirectory(dir=folder(), prefix=".new-") as beside:
        done = subprocess.run(["apt-get", "-qq", "-o", "APT::Sandbox::User=", "download", *_DEBIAN], cwd=beside, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        found = sorted(Path(beside).glob("*.deb"))
        if done.returncode != 0 or len(found) != len(_DEBIAN):
            raise HouseError(f"apt-get download {' '.join(_DEBIAN)} failed (apt-get update first?):\n{done.stdout}")
        for package in found:
            subprocess.run(["dpkg", "-x", str(package), beside], check=True)
        for name in _PROGRAMS[:-1]:
            place = next(path for path in (Path(beside) / "usr/bin" / name, Path(beside) / "usr/sbin" / name) if path.is_file() and not path.is_symlink())
            shutil.move(place, folder() / name)
        say(f"containerd and runc of Debian: {folder()}")


def _build_kubelet() -> None:
    """By the control plane's module, and the few sums that only kubelet needs: with them in it all the rest would be built again."""
    with tempfile.TemporaryDirectory(dir=folder(), prefix=".new-") as beside:
        shutil.copy(kubernetes.MODULE / "go.mod", Path(beside) / "go.mod")
        sums = "".join((kubernetes.MODULE / name).read_text(encoding="ascii") for name in ("go.sum", "kubelet.sum"))
        (Path(beside) / "go.sum").write_text(sums, encoding="ascii")
        kubernetes.build_go(["build", "-ldflags", kubernetes.version_flags(), "-o", f"{beside}/kubelet", "k8s.io/kubernetes/cmd/kubelet"], Path(beside))
        os.replace(Path(beside) / "kubelet", folder() / "kubelet")


def image_archive() -> Path:
    """The image of `./diaphane image`, built when it is not there, as an archive that containerd takes."""
    from . import image

    out = folder() / f"image-{re.sub(r'[^A-Za-z0-9.]', '-', image.version())}.tar"
    if not out.exists():
        image.run(out, False, None, False, None)
    return out
