"""`./diaphane fuzz`: runs libFuzzer on the parsers of untrusted bytes, with the address and undefined-behaviour sanitizers."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from . import build, install, paths
from .console import CliError, say, step, warn

TARGETS = ("precheck", "codestream", "nifti", "labels", "tar", "report", "volume", "viewer", "stream", "fields", "preset", "recording", "scene_xml", "panorama")
SOURCES = paths.REPO / "tests" / "fuzz"
#: Limits of a run. One that is longer or uses more memory is a finding.
SECONDS_A_RUN, MEGABYTES = 5, 1024
#: Size of the stack, which is small enough for unlimited recursion to overflow it at the depth that
#: 8 KB of input can nest.
STACK_BYTES = 1 << 20


@dataclass(frozen=True)
class Found:
    target: str
    runs: int
    edges: int      # of the target's code that these runs and the corpora reached
    failure: str      # text of the finding, if any

    @property
    def ok(self) -> bool:
        return not self.failure


def run(target: str | None, seconds: int, minimise: bool = False, may_install: bool = True) -> int:
    if target is not None and target not in TARGETS:
        raise CliError(f"unknown target '{target}'; choose one of: {', '.join(TARGETS)}", 64)
    install.ensure("test", may_install)
    chosen = TARGETS if target is None else (target,)
    all_found = fuzz(chosen, seconds)
    for found in all_found:
        say(f"{found.target:<12} {found.runs:>9} runs, {found.edges:>5} edges covered: {'passed' if found.ok else 'FAILED'}")
        if not found.ok:
            warn(found.failure)
    if minimise and all(found.ok for found in all_found):
        for name in chosen:
            _minimise(name)
    return 0 if all(found.ok for found in all_found) else 1


def fuzz(targets: tuple[str, ...], seconds: int) -> list[Found]:
    """Runs as many targets at the same time as there are cores. With 0 seconds, only replays the
    kept corpora."""
    folder = build.configure("fuzz")
    build.ninja(folder, [f"bin/fuzz_{name}" for name in targets])
    step(f"Fuzzing {', '.join(targets)}, {seconds} s per target" if seconds else f"Replaying the fuzz corpora of {', '.join(targets)}")
    with ThreadPoolExecutor(build.jobs()) as pool:
        return list(pool.map(lambda name: _fuzz(folder, name, seconds), targets))


def _fuzz(folder: Path, name: str, seconds: int) -> Found:
    """Writes new inputs to build/fuzz/corpus and findings to build/fuzz/findings. Only reads the kept corpus."""
    corpus, findings = folder / "corpus" / name, folder / "findings"
    corpus.mkdir(parents=True, exist_ok=True)
    findings.mkdir(exist_ok=True)
    done = subprocess.run(
        ["prlimit", f"--stack={STACK_BYTES}", folder / "bin" / f"fuzz_{name}", *([f"-max_total_time={seconds}"] if seconds else ["-runs=0"]), f"-timeout={SECONDS_A_RUN}",
         f"-rss_limit_mb={MEGABYTES}", "-max_len=8192", "-print_final_stats=1", f"-artifact_prefix={findings}/{name}-",
         corpus, SOURCES / "corpus" / name],
        env=_environment(), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        errors="replace")
    stats = [line.split() for line in done.stderr.splitlines() if line.startswith("stat::number_of_executed_units")]
    failure = "" if done.returncode == 0 else "\n".join(done.stderr.splitlines()[-60:])
    edges = re.findall(r"^#\d+\s+\w+\s+cov: (\d+)", done.stderr, re.MULTILINE)
    return Found(name, int(stats[0][1]) if stats else 0, int(edges[-1]) if edges else 0, failure)


def _environment() -> dict[str, str]:
    return {**os.environ, "ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "halt_on_error=1:print_stacktrace=1"}


def _minimise(name: str) -> None:
    """Reduces the kept corpus to the fewest and smallest files with the same coverage."""
    folder, kept = paths.REPO / "build" / "fuzz", SOURCES / "corpus" / name
    fresh = folder / "fresh" / name
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir(parents=True)
    subprocess.run([folder / "bin" / f"fuzz_{name}", "-merge=1", "-max_len=4096", fresh, kept, folder / "corpus" / name],
                   env=_environment(), stdin=subprocess.DEVNULL, capture_output=True, check=True)
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(fresh, kept)
    say(f"{name}: {len(list(kept.iterdir()))} files kept")
