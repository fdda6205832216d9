"""`./diaphane races`: runs the programs' own multi-threaded tests under ThreadSanitizer."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

from . import build, commands, install, paths
from .console import CliError, say, step, warn

#: The test programs that use several threads. All others test pure functions.
PROGRAMS = ("common_service_test", "directory_test", "api_stream_test", "render_thread_pool_test", "render_composite_test",
            "render_schedule_test", "render_session_test", "render_encode_test", "render_serve_test", "render_grpc_test",
            "operator_kube_test", "operator_objects_test")
#: Programs that link gRPC, which is compiled without the sanitizer. `ignore_noninstrumented_modules` ignores its threads. It also
#: hides every lock-order inversion (two were found in render_serve_test), so the other programs run without it.
WITH_GRPC = ("api_stream_test", "render_grpc_test")
#: A sanitized program is 5 to 15 times slower.
SECONDS_A_PROGRAM = 1800


def run(programs: list[str], may_install: bool = True) -> int:
    if unknown := [name for name in programs if name not in PROGRAMS]:
        raise CliError(f"unknown program '{unknown[0]}'; choose one of: {', '.join(PROGRAMS)}", 64)
    install.ensure("test", may_install)
    chosen = programs or list(PROGRAMS)
    folder = build.configure("tsan")
    build.ninja(folder, [f"bin/{name}" for name in chosen])
    step("Running the tests under ThreadSanitizer")
    faults = [name for name in chosen if not _is_clean(folder, name)]
    say(f"{len(chosen) - len(faults)} passed, {len(faults)} failed")
    return 1 if faults else 0


def sanitizer_options(name: str = WITH_GRPC[0]) -> str:
    """Returns the options of the test preset, which suit all programs, without those that a program does not need."""
    presets = json.loads((paths.REPO / "CMakePresets.json").read_text(encoding="utf-8"))["testPresets"]
    [options] = [preset["environment"]["TSAN_OPTIONS"] for preset in presets if preset["name"] == "tsan"]
    if name not in WITH_GRPC:
        options = options.replace(":ignore_noninstrumented_modules=1", "")
    return options.replace("${sourceDir}", str(paths.REPO))


def _is_clean(folder: Path, name: str) -> bool:
    try:
        done = commands.run([folder / "bin" / name, "--gtest_brief=1"], cwd=folder, timeout=SECONDS_A_PROGRAM,
                            env={**os.environ, "TSAN_OPTIONS": sanitizer_options(name)})
    except subprocess.TimeoutExpired:
        warn(f"{name} did not finish within {SECONDS_A_PROGRAM} s")
        return False
    races = done.stdout.count("WARNING: ThreadSanitizer")
    say(f"{name:<26} {'passed' if done.returncode == 0 else f'FAILED, {races} findings'}")
    if done.returncode != 0:
        warn("\n".join(done.stdout.splitlines()[-200:]))
    return done.returncode == 0
