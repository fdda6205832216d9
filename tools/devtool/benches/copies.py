"""Time to a session's first picture when the volume comes from slow shared storage, and when it comes from the node's copy.

A library preloaded into renderd limits reads of the store's voxels to a fixed rate. Copies are read at the speed of the disk."""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from .. import ports
from ..bench import Result, result
from ..bench_client import Person, cranium, messages
from ..bench_stack import folder, prepared
from ..bench_volumes import grow
from ..users import ordinary_user

ABOUT = "time from asking for a session to its first picture, with the volume on a claim of 50 MB/s and copied to the node (target: 1 s; --volume)"

MB_PER_SECOND = 50
SLOW = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
// A piece of at most 1 MB, and then the time that it would have taken.
ssize_t read(int fd, void* data, size_t bytes) {
  static ssize_t (*real)(int, void*, size_t);
  if (!real) real = (ssize_t (*)(int, void*, size_t))dlsym(RTLD_NEXT, "read");
  char link[64], path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  ssize_t length = readlink(link, path, sizeof path - 1);
  path[length < 0 ? 0 : length] = 0;
  if (!strstr(path, "/volumes/") || !strstr(path, "voxels.i16")) return real(fd, data, bytes);
  ssize_t done = real(fd, data, bytes < 1 << 20 ? bytes : 1 << 20);
  double seconds = done > 0 ? done / (RATE * 1e6) : 0;
  struct timespec wait = {(time_t)seconds, (long)((seconds - (time_t)seconds) * 1e9)};
  nanosleep(&wait, 0);
  return done;
}
"""


@dataclass
class Seen:
    """Seconds at the beginning of one session."""

    picture: float    # from requesting the session to its first picture
    loading: float    # of that, renderd's time until the volume is on its device: reading, hashing and loading
    rendering: float  # of that, the samples of the first picture


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--volume", choices=("small", "large", "both"), default="both",
                        help="the sample scan (14 MB), or the same with voxels of half the size (113 MB)")
    parser.add_argument("--runs", type=int, default=5, help="number of runs (default: 5, with --quick: 1)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    results = []
    messages()
    with folder(ordinary_user()) as base, tempfile.TemporaryDirectory() as made:
        slow = base / "slow.so"
        source = Path(made) / "slow.c"
        source.write_text(SLOW, encoding="ascii")
        subprocess.run(["cc", "-shared", "-fPIC", f"-DRATE={MB_PER_SECOND}", "-o", str(slow), str(source), "-ldl"], check=True)
        slow.chmod(0o755)
        copies = base / "copies"
        copies.mkdir()
        ordinary_user().own(copies)
        with prepared(base, LD_PRELOAD=str(slow), DIAPHANE_VOLUME_COPIES_DIR=str(copies)) as stack:
            person = Person(stack)
            data_set = person.upload(cranium(stack, Path(made)))
            person.wait_ready(data_set)
            volume = stack.data / "volumes" / data_set
            for size in ("small", "large") if options.volume == "both" else (options.volume,):
                if size == "large":
                    stack.stop_program("renderd")
                    grow(volume)
                    stack.start_program("renderd")
                cold, warm = [], []
                for _ in range(1 if quick else options.runs):
                    for copy in copies.glob("*.sealed"):
                        copy.unlink()
                    cold.append(_first_picture(stack, person, data_set))
                    _wait(lambda: list(copies.glob(f"{data_set}.*.sealed")))
                    warm.append(_first_picture(stack, person, data_set))
                megabytes = f"{(volume / 'voxels.i16').stat().st_size / 1e6:.0f} MB"
                results += _results(f"claim of {MB_PER_SECOND} MB/s, {megabytes}", cold, None)
                results += _results(f"copy on the node, {megabytes}", warm, 1.0)
        ports.give_back(stack.ports.values())
    return results


def _results(name: str, seen: list[Seen], at_most: float | None) -> list[Result]:
    return [result(f"{name}: first picture", [one.picture for one in seen], "s", at_most=at_most),
            result(f"{name}: of which loading", [one.loading for one in seen], "s"),
            result(f"{name}: of which rendering", [one.rendering for one in seen], "s")]


def _first_picture(stack, person: Person, data_set: str) -> Seen:
    """Measures the first picture of a renderd that has not loaded any volume."""
    stack.stop_program("renderd")
    stack.start_program("renderd")
    stack.wait_ready("renderd", 30)
    _wait(lambda: person.http.get("/v1/me").status_code == 200)
    log = stack.log_path("renderd")
    said = log.stat().st_size
    began = time.monotonic()
    viewer = person.viewer(data_set, 512, 512)
    frame = viewer.frame()
    picture = time.monotonic() - began
    viewer.close()
    for session in person.http.get("/v1/sessions").json()["items"]:
        person.http.delete(f"/v1/sessions/{session['session_id']}")
    lines = [json.loads(line) for line in log.read_bytes()[said:].splitlines() if line.startswith(b"{")]
    loading = next(float(line["seconds"]) for line in lines if line.get("event") == "volume_loaded")
    return Seen(picture, loading, frame.render_us / 1e6)


def _wait(condition, seconds: float = 30) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError("the first picture did not arrive")
        time.sleep(0.02)
