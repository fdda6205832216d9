"""A complete node for `./diaphane test node`: containerd and runc from Debian's packages (unpacked, not installed, so that no
service starts), kubelet built from Kubernetes' sources, and Debian's CNI plugins. It runs in its own namespaces, and everything
in them ends with them."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from . import kubernetes, packages
from .console import say, step

#: The prefix of all processes of the test. The shell is the first process of the namespace, reaps orphans, and ends all others
#: when it exits.
NAMESPACES = ("unshare", "--net", "--mount", "--propagation", "private", "--pid", "--fork", "--kill-child", "--mount-proc", "--",
              "/bin/sh", "-c", '"$@"; exit $?', "sh")
CNI = Path("/usr/lib/cni")
CONTROL_GROUPS = Path("/sys/fs/cgroup")
_DEBIAN = ("containerd", "runc")
_PROGRAMS = ("containerd", "containerd-shim-runc-v2", "ctr", "runc", "kubelet")
_INSTALLED = ("containernetworking-plugins", "iproute2")
_CONTROLLERS = ("cpu", "cpuset", "memory")
#: Settings that kubelet changes for the whole machine.
_TUNED = ("vm/overcommit_memory", "vm/panic_on_oom", "kernel/panic", "kernel/panic_on_oops", "kernel/keys/root_maxkeys", "kernel/keys/root_maxbytes")


def absence() -> str:
    """Returns what this machine lacks for a node, or an empty text."""
    if os.geteuid() != 0:
        return "running a node requires root"
    if why := _no_cgroups():
        return why
    if "overlay" not in Path("/proc/filesystems").read_text(encoding="ascii"):
        return "the kernel does not support overlayfs, which containerd requires"
    if not Path("/dev/kmsg").exists():
        return "/dev/kmsg is missing, which kubelet reads to detect out-of-memory kills"
    script = "ip link set lo up && ip link add probe0 type bridge && ip link add a0 type veth peer name b0 && mount -t tmpfs probe /mnt"
    tried = subprocess.run([*NAMESPACES, "/bin/sh", "-c", script], capture_output=True, text=True)
    if tried.returncode != 0:
        return f"cannot create network, mount and PID namespaces with a bridge: {tried.stderr.strip()}"
    return ""


def cgroup_folders() -> list[Path]:
    """Returns the parent folders of a node's cgroup: one per hierarchy in version 1, or the one of version 2."""
    if (CONTROL_GROUPS / "cgroup.controllers").exists():
        return [CONTROL_GROUPS]
    found = []
    for line in Path("/proc/self/mounts").read_text(encoding="utf-8").splitlines():
        _, where, kind, options, *_ = line.split()
        if kind in ("cgroup", "cgroup2"):
            found.append(Path(where))
    return found


def _no_cgroups() -> str:
    if (CONTROL_GROUPS / "cgroup.controllers").exists():
        has = set((CONTROL_GROUPS / "cgroup.controllers").read_text(encoding="ascii").split())
    else:
        has = {name for folder in cgroup_folders() for name in folder.name.split(",")}
    if lacking := [name for name in _CONTROLLERS if name not in has]:
        return f"cgroup controllers are missing below {CONTROL_GROUPS}: {', '.join(lacking)}"
    for folder in cgroup_folders():
        probe = folder / f"diaphane-probe-{os.getpid()}"
        try:
            probe.mkdir()
            probe.rmdir()
        except OSError as error:
            return f"cannot write to the cgroup folder {folder}: {error.strerror}"
    return ""


def folder() -> Path:
    return kubernetes.folder() / "node"


def ensure() -> Path:
    """Fetches and builds the missing parts."""
    if absent := packages.missing(list(_INSTALLED)):
        packages.install(absent)
    folder().mkdir(parents=True, exist_ok=True)
    if any(not (folder() / name).exists() for name in _PROGRAMS if name != "kubelet"):
        _take()
    if not (folder() / "kubelet").exists():
        step("Building kubelet (takes several minutes)")
        _build_kubelet()
    return folder()


def _take() -> None:
    with tempfile.TemporaryDirectory(dir=folder(), prefix=".new-") as beside:
        packages.unpack(_DEBIAN, Path(beside))
        for name in _PROGRAMS[:-1]:
            place = next(path for path in (Path(beside) / "usr/bin" / name, Path(beside) / "usr/sbin" / name) if path.is_file() and not path.is_symlink())
            shutil.move(place, folder() / name)
        say(f"Unpacked Debian's containerd and runc to {folder()}")


def _build_kubelet() -> None:
    """Builds kubelet with the control plane's module and the few checksums that only kubelet needs.
    Adding them to the module would rebuild everything else."""
    with tempfile.TemporaryDirectory(dir=folder(), prefix=".new-") as beside:
        shutil.copy(kubernetes.MODULE / "go.mod", Path(beside) / "go.mod")
        sums = "".join((kubernetes.MODULE / name).read_text(encoding="ascii") for name in ("go.sum", "kubelet.sum"))
        (Path(beside) / "go.sum").write_text(sums, encoding="ascii")
        kubernetes.build_go(["build", "-ldflags", kubernetes.version_flags(), "-o", f"{beside}/kubelet", "k8s.io/kubernetes/cmd/kubelet"], Path(beside))
        os.replace(Path(beside) / "kubelet", folder() / "kubelet")


def image_archive() -> Path:
    """Returns the current image of `./diaphane image` as an archive for containerd."""
    from . import image

    out = image.folder() / "image.tar"
    image.run(out, False, None, False, None)
    return out


@contextmanager
def place() -> Iterator[Path]:
    """Yields a folder whose name is also that of a control group. Both are removed once nothing runs in NAMESPACES,
    however the run ended."""
    settings = {name: (Path("/proc/sys") / name).read_text() for name in _TUNED if (Path("/proc/sys") / name).exists()}
    made = Path(tempfile.mkdtemp(prefix="diaphane-node-", dir="/var/tmp"))
    made.chmod(0o755)
    try:
        for group in (one / made.name for one in cgroup_folders()):
            group.mkdir()
            for name in ("cpuset.cpus", "cpuset.mems"):     # version 1 starts with empty values
                if (group / name).exists() and not (group / name).read_text().strip():
                    (group / name).write_text((group.parent / name).read_text())
        yield made
    finally:
        for one in cgroup_folders():
            _remove_group(one / made.name)
        for name, value in settings.items():
            (Path("/proc/sys") / name).write_text(value)
        if not os.environ.get("DIAPHANE_KEEP"):
            shutil.rmtree(made, ignore_errors=True)


def _remove_group(root: Path) -> None:
    """Removes the groups from the leaves. The last process may still be exiting."""
    for _ in range(100):
        if not root.exists():
            return
        for one in [*sorted((path for path in root.rglob("*") if path.is_dir()), key=lambda path: -len(path.parts)), root]:
            try:
                one.rmdir()
            except OSError:
                pass
        time.sleep(0.1)
