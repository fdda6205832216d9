"""Checks an image: it must be small, contain no compiler, and work for an ordinary user with a read-only root."""

from __future__ import annotations

import json
import os
import re
import stat
from pathlib import Path
from typing import Iterable

from . import bench_volumes, commands, image, paths, plan, ports
from .console import CliError, say

USER = 10001
_COMPILER = re.compile(r"(?:[a-z0-9_]+-linux-gnu-)?(?:gcc|g\+\+|cc|c\+\+|cpp|clang(?:\+\+)?|as|ld|ld\.(?:bfd|gold|lld))(?:-[\d.]+)?"
                       r"|cc1(?:plus)?|collect2|nvcc|ptxas|cicc|cudafe\+\+|make|gmake|ninja|cmake|go|rustc")

#: Runs a command as in a pod: a read-only root, private /tmp and /run/edge, no capabilities, and no
#: way to gain any. $1 is the root, and "$2"... are OUTSIDE INSIDE pairs up to --.
_POD = """set -e
root=$1; shift
mount --bind "$root" "$root"
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount -t tmpfs -o mode=1777 tmpfs "$root/tmp"
mount -t tmpfs -o mode=0755,uid=10001,gid=10001 tmpfs "$root/run/edge"
while [ "$1" != -- ]; do
  touch "$root/$2"; mount --bind "$1" "$root/$2"; mount -o remount,bind,ro "$root/$2"; shift 2
done
shift
mount -o remount,bind,ro "$root"
exec chroot "$root" /usr/bin/setpriv --reuid=10001 --regid=10001 --clear-groups --no-new-privs --inh-caps=-all --bounding-set=-all \
  /usr/bin/env -i "$@"
"""

_EDGE = """/usr/sbin/nginx -e stderr -p /run/edge -c /tmp/nginx.conf & edge=$!
trap 'kill $edge' EXIT
for try in $(seq 100); do
  if exec 3<>/dev/tcp/127.0.0.1/PORT; then break; fi 2>/dev/null
  sleep 0.1
done
printf 'GET / HTTP/1.1\\r\\nHost: diaphane.test\\r\\nConnection: close\\r\\n\\r\\n' >&3
read -r _ status _ <&3
cat <&3 | grep -q '<script' || { echo "the page did not come (status $status)"; exit 1; }
[ "$status" = 200 ]
"""

_RENDER = """set -e
cd /tmp
diaphane-sample --cranium /tmp/Cranium.inv3 --write-dicom /tmp/scan > /dev/null
diaphane-scan /tmp/scan
diaphane-render /tmp/scan --preset bone --size 128x128 --samples 4 --engine cpu --out /tmp/bone.png --quiet
[ "$(head -c 4 /tmp/bone.png | tail -c 3)" = PNG ]
[ "$(stat -c %s /tmp/bone.png)" -gt 4000 ]
"""


def compilers(files: Iterable[str]) -> list[str]:
    """Returns the files that are compilers by their names."""
    return sorted(file for file in files if _COMPILER.fullmatch(file.rpartition("/")[2]) and re.search(r"/(?:s?bin|libexec|lib/gcc)/", file))


def _walk(root: Path) -> tuple[int, list[str]]:
    """Returns the total bytes of all files, counting each once whatever its links, and the paths of executables."""
    total, programs, visited = 0, [], set()
    for where, _, names in os.walk(root):
        for name in names:
            file = Path(where) / name
            status = file.lstat()
            if not stat.S_ISDIR(status.st_mode) and (status.st_dev, status.st_ino) not in visited:
                visited.add((status.st_dev, status.st_ino))
                total += status.st_size
            if status.st_mode & 0o111:
                programs.append("/" + str(file.relative_to(root)))
    return total, programs


def inside(root: Path, env: list[str], script: str, files: dict[str, str] | None = None) -> tuple[int, str]:
    """Returns the exit code and output of `script` (bash) in a pod of the image. `files`: outside -> inside, under /tmp."""
    pairs = [word for pair in (files or {}).items() for word in pair]
    command = ["unshare", "--mount", "--pid", "--fork", "--kill-child", "--propagation", "private", "sh", "-c", _POD, "pod", str(root),
               *pairs, "--", *env, "/bin/bash", "-c", script]
    done = commands.run(command, timeout=300)
    return done.returncode, done.stdout.strip()


def _edge_config() -> tuple[str, int]:
    """Returns nginx's configuration with the chart's paths and a free loopback port."""
    port = ports.random_free()["edge"]
    values = {"LISTEN": f"127.0.0.1:{port}", "API_PORT": "8081", "STREAM_PORT": "8082", "STATIC_DIR": "/opt/diaphane/page", "RUN_DIR": "/run/edge",
              "CACHE_DIR": "/data/cache", "LEGAL_DIR": "/etc/legal", "LOG": "/tmp/access.log", "PUBLIC_HOST": "diaphane.test"}
    return plan.filled((paths.REPO / "api" / "edge" / "nginx.conf.in").read_text(encoding="utf-8"), values), port


def run() -> int:
    container = image.buildah("from", "--pull-never", image.name())
    try:
        faults = _faults(Path(image.buildah("mount", container)), json.loads(image.buildah("inspect", container))["OCIv1"]["config"])
    finally:
        image.buildah("rm", container)
    if faults:
        raise CliError("the image failed its checks:\n" + "\n".join(faults))
    return 0


def _faults(root: Path, config: dict) -> list[str]:
    faults = []

    def held(what: str, right: bool, otherwise: str = "") -> None:
        say(f"{'ok    ' if right else 'FAILED'} {what}")
        if not right:
            faults.append(f"{what}: {otherwise}")

    size, programs = _walk(root)
    held(f"{size / 1e6:.0f} MB, at most {image.LIMIT / 1e6:.0f} MB", size <= image.LIMIT)
    found = compilers(programs)
    held("no compiler, assembler, linker or make", not found, ", ".join(found))
    held("runs as a non-root user", config.get("User") == f"{USER}:{USER}", str(config.get("User")))
    held("no setuid or setgid programs", not [path for path in programs if os.lstat(root / path[1:]).st_mode & 0o6000 and not (root / path[1:]).is_dir()])
    env = config["Env"]

    def works(what: str, script: str, files: dict[str, str] | None = None) -> None:
        code, said = inside(root, env, script, files)
        held(what, code == 0, f"exited with {code}\n{said[-1500:]}")

    works("the root file system is read-only, /tmp is writable", f"[ $(id -u) = {USER} ] && ! touch /x 2>/dev/null && ! touch /opt/diaphane/x 2>/dev/null && touch /tmp/x")
    works("all shared libraries are found", '''shopt -s nullglob
        lost=$(ldd /opt/diaphane/bin/* /opt/diaphane/lib/* /usr/sbin/nginx /usr/lib/nginx/modules/* 2>&1 | grep -E "not found|^/.*error") || true; echo "$lost"; [ -z "$lost" ]''')
    for program in sorted({*image.chart_programs(), *(Path(path).name for path in programs if path.startswith("/opt/diaphane/bin/"))}):
        works(f"{program} --help", f"/opt/diaphane/bin/{program} --help")
    text, port = _edge_config()
    config_file = image.folder() / "nginx.conf"
    config_file.write_text(text, encoding="utf-8")
    works("the edge serves the web page", _EDGE.replace("PORT", str(port)), {str(config_file): "/tmp/nginx.conf"})
    if (root / "opt/diaphane/lib").exists():
        works("NVRTC loads", 'said=$(LD_PRELOAD="/opt/diaphane/lib/libnvrtc.so.13 $(echo /opt/diaphane/lib/libnvrtc-builtins.so.*)" /bin/true 2>&1); '
                             'echo "$said"; [ -z "$said" ]')
        test = paths.build_dir() / "bin" / "render_cuda_unit_test"
        if test.exists():
            works("NVRTC compiles", 'said=$(/tmp/cuda_test --gtest_filter=NvrtcTest.CompileErrorNamesTheFile); echo "$said"; [[ $said == *"PASSED  ] 1 test"* ]]',
                  {str(test): "/tmp/cuda_test"})
    works("the migrations and the bill of materials are present", "ls /opt/diaphane/migrations/0001_*.up.sql && [ -s /opt/diaphane/sbom.json ]")
    if bench_volumes.CRANIUM.exists():
        works("the sample can be written, scanned and rendered on the CPU", _RENDER, {str(bench_volumes.CRANIUM): "/tmp/Cranium.inv3"})
    return faults
