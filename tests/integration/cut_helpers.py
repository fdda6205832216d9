"""Shared helpers of the anonymisation tests: a stored volume with a mark outside the kept region, orders, and a program that
kills ingestd."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import uuid
from pathlib import Path

import numpy
from api_client import ready_without_upload
from harness import contents_below

SIDE = 32
# Eight voxels in a row in the removed part, with values that occur nowhere else.
MARK = numpy.array([20011, -3257, 17389, -2111, 30103, -4999, 28657, -1597], "<i2")
KEEP = {"box": {"low": [-40, -40, -40], "high": [40, 40, 0]}, "planes": []}  # the lower half, of 2 mm voxels


def marked_volume() -> tuple[numpy.ndarray, dict]:
    voxels = numpy.full((SIDE, SIDE, SIDE), -1000, "<i2")  # z, y, x
    voxels[4:12, 4:28, 4:28] = 40 + numpy.arange(24, dtype="<i2")
    voxels[20:28, 8:24, 8:24] = 1200
    for z in (22, 25):
        voxels[z, 10, 12:20] = MARK
    header = {
        "format": 1, "size": [SIDE] * 3, "spacing": [2.0] * 3, "direction": [1, 0, 0, 0, 1, 0, 0, 0, 1], "modality": "CT",
        "minimum": int(voxels.min()), "maximum": int(voxels.max()), "percentiles": [-1000.0] * 5 + [1200.0] * 3,
        "contentHash": hash_of(voxels.tobytes()),
    }
    return voxels, header


def hash_of(voxels: bytes) -> str:
    return "blake2b:" + hashlib.blake2b(voxels, digest_size=32).hexdigest()


def store(stack, data_set: str) -> str:
    """Puts the marked volume into the store and returns its content hash."""
    voxels, header = marked_volume()
    folder = stack.data_dir / "volumes" / data_set
    folder.mkdir()
    (folder / "volume.json").write_text(json.dumps(header))
    (folder / "voxels.i16").write_bytes(voxels.tobytes())
    for path in (folder, *folder.iterdir()):
        stack.stack.run_as.own(path)
    return header["contentHash"]


def marked_scan(stack, owner) -> tuple[str, str]:
    """Returns a ready data set of the owner with the mark in it, and the hash of its volume."""
    data_set = ready_without_upload(stack, owner)
    return data_set, store(stack, data_set)


def ready_data_set(stack) -> tuple[str, str]:
    """Returns a ready data set without an owner, and the hash of its volume."""
    data_set = str(uuid.uuid4())
    content = store(stack, data_set)
    stack.psql("INSERT INTO data_sets (id, state, modality, size_x, size_y, size_z, spacing_x, spacing_y, spacing_z,"
               " volume_bytes) VALUES (%s, 'ready', 'CT', %s, %s, %s, 2, 2, 2, %s)", data_set, SIDE, SIDE, SIDE, 2 * SIDE**3)
    return data_set, content


def order(stack, data_set: str, content: str, keep: dict = KEEP) -> None:
    """Creates an order as `api` does."""
    stack.psql("UPDATE data_sets SET state = 'queued' WHERE id = %s", data_set)
    stack.psql("INSERT INTO ingest_jobs (data_set_id, cut, cut_of) VALUES (%s, %s, %s)", data_set, json.dumps(keep), content)
    stack.psql("NOTIFY ingest_jobs")


def holders_of_mark(*roots: Path) -> list[str]:
    """Returns files that contain the mark at any position."""
    wanted = MARK.tobytes()
    return [str(path) for path, content in contents_below(*roots) if wanted in content]


def expected_left() -> bytes:
    voxels, _ = marked_volume()
    return voxels[:SIDE // 2].tobytes()


KILLER = r"""
// Preloaded into ingestd: ends it by SIGKILL before its n-th step after it began to write a volume.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/socket.h>
#include <unistd.h>

static int armed, steps;
static void step(const char* what) {
  if (!armed) return;
  const char* wanted = getenv("KILL_BEFORE_STEP");
  ++steps;
  if (wanted && steps == atoi(wanted)) {
    dprintf(2, "killed before step %d, %s\n", steps, what);
    kill(getpid(), SIGKILL);
  }
}
#define REAL(name) __typeof__(&name) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)
int mkdir(const char* path, mode_t mode) { REAL(mkdir); armed |= strstr(path, "/.tmp-") != 0; step("mkdir"); return real(path, mode); }
int fsync(int fd) { REAL(fsync); step("fsync"); return real(fd); }
int ftruncate(int fd, off_t n) { REAL(ftruncate); step("ftruncate"); return real(fd, n); }
int ftruncate64(int fd, off64_t n) { REAL(ftruncate64); step("ftruncate"); return real(fd, n); }
int renameat2(int a, const char* b, int c, const char* d, unsigned e) { REAL(renameat2); step("renameat2"); return real(a, b, c, d, e); }
int unlinkat(int fd, const char* path, int flags) { REAL(unlinkat); step("unlinkat"); return real(fd, path, flags); }
int remove(const char* path) { REAL(remove); step("remove"); return real(path); }
ssize_t send(int fd, const void* data, size_t n, int flags) { REAL(send); step("send"); return real(fd, data, n, flags); }
"""


def build_killer(folder: Path) -> Path:
    source, library = folder / "killer.c", folder / "killer.so"
    source.write_text(KILLER)
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", str(library), str(source), "-ldl"], check=True)
    return library


def run_ingestd(stack, admin_port: int, killer: Path | None = None, step: int = 0, faults: Path | None = None) -> subprocess.Popen:
    """Yields a separate ingestd on the stack's stores."""
    folder = stack.data_dir
    environment = {**os.environ}
    if faults:
        environment |= {"DIAPHANE_FAULT_DIR": str(faults)}
    if killer:
        environment |= {"LD_PRELOAD": str(killer), "KILL_BEFORE_STEP": str(step)}
    program = stack.stack.settings.layout.bin / "diaphane-ingestd"
    return subprocess.Popen(
        [str(program), "--postgres", stack.dsn, "--upload-dir", str(folder / "uploads"), "--volume-dir", str(folder / "volumes"),
         "--scratch-dir", str(folder / "scratch"), "--admin-port", str(admin_port), "--lease-ms", "60000", "--light-mb", "0"],
        env=environment, stderr=subprocess.PIPE, text=True)
