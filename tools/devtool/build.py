"""Builds the programs and the page with CMake, Ninja and npm."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

from . import build_stamp, commands, paths, progress, venv
from .console import CliError, say, step
from .console import progress as show_progress


def environment() -> dict[str, str]:
    """Returns the compilers' environment: the CMake of .tools/venv and, unless the user has one, the CUDA compiler in it."""
    env = dict(os.environ)
    env["PATH"] = f"{paths.VENV / 'bin'}:{env.get('PATH', '')}"
    root = venv.cuda_root()
    if "CUDACXX" not in env and (root / "bin" / "nvcc").exists():
        env["CUDACXX"] = str(root / "bin" / "nvcc")
        env["CUDAToolkit_ROOT"] = str(root)
    return env


def jobs() -> int:
    """Returns the number of cores, but at most one job per 1.5 GB of memory, because Boost, gRPC and VTK need that much per
    compiler."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(1, min(len(os.sched_getaffinity(0)), int(memory / 1.5e9)))


#: The instructions that programs need which are not portable (renderd/engine/cpu/kernel.cpp).
_NEEDED_INSTRUCTIONS = {"avx2", "fma", "bmi2"}


def _has_needed_instructions(cpuinfo: Path = Path("/proc/cpuinfo")) -> bool:
    try:
        flags = next((line for line in cpuinfo.read_text(encoding="utf-8").splitlines() if line.startswith("flags")), "")
    except OSError:
        return False
    return set(flags.partition(":")[2].split()) >= _NEEDED_INSTRUCTIONS


def configure(preset: str = "release", portable: bool = True) -> Path:
    """Returns the build directory of a preset, configured if it was not, or if the compilers changed.

    Without `portable`, a first build leaves out the kernel for processors that this machine does not have."""
    folder = paths.REPO / "build" / preset
    env = environment()

    def expected(portable: bool) -> str:
        return build_stamp.digest([paths.REPO / "CMakePresets.json"], env.get("CUDACXX", ""), *([] if portable else ["only here"]))

    is_configured = (folder / "build.ninja").exists()
    if not (is_configured and any(build_stamp.is_current(f"configure-{preset}", expected(kind)) for kind in {True, portable})):
        only_here = not portable and _has_needed_instructions()
        step(f"Configuring build/{preset}")
        options = ["--fresh"] if (folder / "CMakeCache.txt").exists() else []
        options += ["-DDIAPHANE_PORTABLE=OFF"] if only_here else []
        commands.output(["cmake", "--preset", preset, *options], f"configuring build/{preset} with CMake", 1000, cwd=paths.REPO, env=env)
        build_stamp.set_current(f"configure-{preset}", expected(not only_here))
    return folder


def ninja(folder: Path, targets: list[str]) -> None:
    """Builds the targets. Prints nothing if they are current, the progress while they are built, and all output of the compilers."""
    if not targets:
        return
    estimate = progress.BuildEstimate(_planned_steps(folder, targets), jobs())
    if estimate.steps:
        step(f"Building the programs in {folder.relative_to(paths.REPO)} with {jobs()} parallel jobs: {estimate.text(0.0)}")
    began = time.monotonic()
    with subprocess.Popen(["ninja", "-C", str(folder), "-j", str(jobs()), *targets], stdin=subprocess.DEVNULL,
                          env={**environment(), "NINJA_STATUS": "@%f/%t@ "}, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace") as running:
        for line in running.stdout:
            if finished := progress.ninja_step(line.rstrip("\n")):
                if not progress.is_work(finished):
                    continue
                estimate.finish(finished)
                show_progress(f"Building the programs: {estimate.text(time.monotonic() - began)}")
            elif not line.startswith(("ninja: Entering directory", "ninja: no work to do")):
                say(line.rstrip("\n"))
    if running.returncode != 0:
        raise CliError("build failed; see the compiler output above")
    if estimate.steps:
        step("Built the programs")


def _planned_steps(folder: Path, targets: list[str]) -> list[str]:
    """Returns what Ninja will do, as far as it is known before CMake has checked for new files."""
    # A dry run of build.ninja itself would stop before the targets, because CMake's check for new files is always due.
    plan = folder / "plan.ninja"
    if not plan.exists():
        plan.symlink_to("build.ninja")
    planned = commands.run(["ninja", "-C", folder, "-f", plan.name, "-n", *targets], env=environment()).stdout
    return [name for line in planned.splitlines() if (name := progress.ninja_step(line))]


def programs(folder: Path) -> list[str]:
    """Returns the targets of all programs that a user runs."""
    listed = commands.run(["ninja", "-C", folder, "-t", "targets", "all"], env=environment()).stdout
    names = (line.partition(":")[0] for line in listed.splitlines())
    return sorted(name for name in names if name.startswith("bin/diaphane-"))


def build_programs(*names: str, portable: bool = True) -> None:
    """Builds these programs (such as `diaphane-api`), or all of them. `portable` is that of configure()."""
    if "DIAPHANE_BUILD" in os.environ:
        say(f"Using the programs in {paths.build_dir()} without rebuilding them (DIAPHANE_BUILD is set)")
        return
    folder = configure(portable=portable)
    known = programs(folder)
    absent = [name for name in names if f"bin/{name}" not in known]
    if absent:
        raise CliError(f"this checkout has no build target {', '.join(absent)}")
    ninja(folder, [f"bin/{name}" for name in names] or known)


#: The programs of an instance on one machine.
RUN_BY_UP = ("diaphane-api", "diaphane-gateway", "diaphane-ingestd", "diaphane-renderd", "diaphane-sample")


# The page

def _page_inputs() -> list[Path]:
    generated = paths.FRONTEND / "src" / "protocol" / "gen"
    patterns = ("src/**/*", "public/**/*", "dev/*.mjs", "*.json", "*.ts", "*.js", "*.html")
    files = {file for pattern in patterns for file in paths.FRONTEND.glob(pattern) if file.is_file()}
    return sorted(file for file in files if generated not in file.parents) + sorted(
        (paths.REPO / "api" / "proto").glob("*.proto"))


def npm(*arguments: str, env: dict[str, str] | None = None, cwd: Path = paths.FRONTEND) -> subprocess.CompletedProcess:
    node = venv.ensure_node()
    environ = {**os.environ, "PATH": f"{node}:{os.environ.get('PATH', '')}", "CI": "true",
               "NO_COLOR": "1", **(env or {})}
    return commands.run(["npm", *arguments], cwd=cwd, env=environ)


def npm_install(folder: Path = paths.FRONTEND, stamp: str = "npm") -> None:
    """Installs the packages of the web page, or of another folder with a stamp of its own."""
    expected = build_stamp.digest([folder / "package.json", folder / "package-lock.json"])
    if (folder / "node_modules").is_dir() and build_stamp.is_current(stamp, expected):
        return
    step(f"Installing the npm packages of {folder.relative_to(paths.REPO)}")
    done = npm("ci", "--no-audit", "--no-fund", cwd=folder)
    if done.returncode != 0:
        raise commands.failure("npm ci", done)
    build_stamp.set_current(stamp, expected)


def may_build_page() -> bool:
    """Returns false if the programs and the page of another build are used."""
    return "DIAPHANE_BUILD" not in os.environ


def build_page() -> bool:
    """Builds the page if its sources changed. Returns whether it did."""
    if not may_build_page():
        return False
    npm_install()
    expected = build_stamp.digest(_page_inputs())
    if (paths.FRONTEND / "dist" / "index.html").exists() and build_stamp.is_current("page", expected):
        return False
    step("Building the web page")
    done = npm("run", "build")
    if done.returncode != 0:
        raise commands.failure("building the web page", done)
    build_stamp.set_current("page", expected)
    return True
