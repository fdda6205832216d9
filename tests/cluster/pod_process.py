"""Runs a container as a process of an ordinary user in a private mount namespace: this machine's programs are read-only,
Diaphane's programs are where the image has them, the pod's volumes are at their mount paths, and the root is read-only."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

from devtool import layout, users
from devtool.processes import Identity
from devtool.stack import WITHOUT_CORE_FILES

#: The parts of this machine's /etc that programs need to run.
_ETC = ("passwd", "group", "nsswitch.conf", "hosts", "resolv.conf", "ld.so.cache", "ssl", "localtime", "nginx")
_ROOT = r"""
set -eu
root=$1; shift; owner=$1; shift
mount -t tmpfs -o mode=755 tmpfs "$root"
for name in usr proc dev sys; do mkdir "$root/$name"; mount --rbind "/$name" "$root/$name"; done
mount -o remount,bind,ro "$root/usr"
for name in bin sbin lib lib64; do if [ -L "/$name" ]; then cp -P "/$name" "$root/$name"; else mkdir "$root/$name"; mount --rbind "/$name" "$root/$name"; fi; done
mkdir "$root/etc" "$root/run" "$root/tmp"
for name in __ETC__; do if [ -e "/etc/$name" ]; then cp -a "/etc/$name" "$root/etc/$name"; fi; done
while [ "$1" != -- ]; do
  mkdir -p "$root$2"
  mount --bind "$1" "$root$2"
  if [ "$3" = ro ]; then mount -o remount,bind,ro "$root$2"; fi
  shift 3
done
shift
mount -o remount,ro "$root"
exec chroot --userspec="$owner" --groups= "$root" "$@"
""".replace("__ETC__", " ".join(_ETC))


@dataclass(frozen=True)
class Mount:
    source: Path
    path: str
    read_only: bool = False


def image_mounts(programs: layout.Layout) -> list[Mount]:
    """Returns the mounts that correspond to the Containerfile."""
    return [Mount(programs.bin, "/opt/diaphane/bin", True), Mount(programs.static, "/opt/diaphane/page", True),
            Mount(programs.migrations, "/opt/diaphane/migrations", True)]


class Container:
    """One run of one container."""

    def __init__(self, command: list[str], env: dict[str, str], mounts: list[Mount], root: Path, log: Path, run_as: users.RunAs):
        root.mkdir(parents=True, exist_ok=True)
        words: list[str] = []
        for one in sorted(mounts, key=lambda mount: mount.path.count("/")):
            words += [str(one.source), one.path, "ro" if one.read_only else "rw"]
        with open(log, "ab") as out:
            run_as.own(log)     # nginx reopens its standard output by name
            self.process = subprocess.Popen(
                ["unshare", "--mount", "--propagation", "private", "--", "/bin/sh", "-c", _ROOT, "sh", str(root), f"{run_as.uid}:{run_as.gid}", *words,
                 "--", *WITHOUT_CORE_FILES, *command],
                env={"PATH": "/opt/diaphane/bin:/usr/sbin:/usr/bin:/sbin:/bin", "LANG": "C.UTF-8", **env}, cwd="/",
                stdin=subprocess.DEVNULL, stdout=out, stderr=out, start_new_session=True)
        self.identity = Identity.of(self.process.pid)

    def exit_code(self) -> int | None:
        return self.process.poll()

    def signal(self, number: int) -> None:
        if self.identity and self.process.poll() is None:
            self.identity.send(number, group=True)
