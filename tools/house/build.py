"""Building: CMake, Ninja and the page."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from . import paths, stamp, venv
from .says import HouseError, say, step


def environment() -> dict[str, str]:
    """What compilers see: the CMake of .tools/venv and, unless the person has one, the CUDA compiler beside it."""
    env = dict(os.environ)
    env["PATH"] = f"{paths.VENV / 'bin'}:{env.get('PATH', '')}"
    root = venv.cuda_root()
    if "CUDACXX" not in env and (root / "bin" / "nvcc").exists():
        env["CUDACXX"] = str(root / "bin" / "nvcc")
        env["CUDAToolkit_ROOT"] = str(root)
    return env


def jobs() -> int:
    """As many as cores, and at most one for each 1.5 GB: Boost, gRPC and VTK take that much a compiler."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(1, min(len(os.sched_getaffinity(0)), int(memory / 1.5e9)))


def configure(preset: str = "release") -> Path:
    """The build directory of a preset, configured when it was not or when the compilers changed."""
    folder = paths.REPO / "build" / preset
    env = environment()
    wanted = stamp.digest([paths.REPO / "CMakePresets.json"], env.get("CUDACXX", ""))
    if not (folder / "build.ninja").exists() or not stamp.is_current(f"configure-{preset}", wanted):
        step(f"Configuring build/{preset}")
        fresh = ["--fresh"] if (folder / "CMakeCache.txt").exists() else []
        done = subprocess.run(["cmake", "--preset", preset, *fresh], cwd=paths.REPO, env=env, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            raise HouseError(f"CMake cannot configure build/{preset}:\n{done.stdout}")
        stamp.set_current(f"configure-{preset}", wanted)
    return folder


def ninja(folder: Path, targets: list[str]) -> None:
    """Builds the targets; prints nothing when there was nothing to do, and the compiler's words when one fails."""
    if not targets:
        return
    say_none = subprocess.run(["ninja", "-C", str(folder), "-n", *targets], env=environment(), capture_output=True,
                              text=True)
    if "no work to do" in say_none.stdout:
        return
    step(f"Building {folder.relative_to(paths.REPO)} ({jobs()} at a time; the first time takes minutes)")
    done = subprocess.run(["ninja", "-C", str(folder), "-j", str(jobs()), *targets],
                          env={**environment(), "NINJA_STATUS": "[%f/%t %es] "}, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        raise HouseError("the build failed; the compiler's words are above")
    step("Built")


def programs(folder: Path) -> list[str]:
    """The targets of all programs that a user runs."""
    listed = subprocess.run(["ninja", "-C", str(folder), "-t", "targets", "all"], env=environment(),
                            capture_output=True, text=True).stdout
    names = (line.partition(":")[0] for line in listed.splitlines())
    return sorted(name for name in names if name.startswith("bin/diaphane-"))


def build_programs(*names: str) -> None:
    """Builds those programs (`diaphane-api`), or all of them."""
    if "DIAPHANE_BUILD" in os.environ:
        say(f"Using the programs in {paths.build_dir()} as they are (DIAPHANE_BUILD)")
        return
    folder = configure()
    known = programs(folder)
    absent = [name for name in names if f"bin/{name}" not in known]
    if absent:
        raise HouseError(f"this checkout has no target for {', '.join(absent)}")
    ninja(folder, [f"bin/{name}" for name in names] or known)


# The page

def _page_inputs() -> list[Path]:
    generated = paths.FRONTEND / "src" / "protocol" / "gen"
    patterns = ("src/**/*", "public/**/*", "dev/*.mjs", "*.json", "*.ts", "*.js", "*.html")
    files = {file for pattern in patterns for file in paths.FRONTEND.glob(pattern) if file.is_file()}
    return sorted(file for file in files if generated not in file.parents) + sorted(
        (paths.REPO / "api" / "proto").glob("*.proto"))


def npm(*words: str, env: dict[str, str] | None = None) -> subprocess.CompletedProcess:
    node = venv.ensure_node()
    environ = {**os.environ, "PATH": f"{node}:{os.environ.get('PATH', '')}", "CI": "true",
               "NO_COLOR": "1", **(env or {})}
    return subprocess.run(["npm", *words], cwd=paths.FRONTEND, env=environ, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def npm_install() -> None:
    wanted = stamp.digest([paths.FRONTEND / "package.json", paths.FRONTEND / "package-lock.json"])
    if (paths.FRONTEND / "node_modules").is_dir() and stamp.is_current("npm", wanted):
        return
    step("Installing the page's locked npm packages")
    done = npm("ci", "--no-audit", "--no-fund")
    if done.returncode != 0:
        raise HouseError("npm ci failed:\n" + "\n".join(done.stdout.splitlines()[-30:]))
    stamp.set_current("npm", wanted)


def build_page() -> None:
    if "DIAPHANE_BUILD" in os.environ:
        return
    if not (paths.FRONTEND / "package.json").exists():
        raise HouseError("this checkout has no frontend/package.json: there is no page to build")
    npm_install()
    wanted = stamp.digest(_page_inputs())
    if (paths.FRONTEND / "dist" / "index.html").exists() and stamp.is_current("page", wanted):
        return
    step("Building the page")
    done = npm("run", "build")
    if done.returncode != 0:
        raise HouseError("the page does not build:\n" + "\n".join(done.stdout.splitlines()[-40:]))
    stamp.set_current("page", wanted)
