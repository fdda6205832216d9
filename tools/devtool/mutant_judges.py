"""Determines for ./diaphane mutants whether tests notice a mutant: copies of the sources and their
builds, and for each language what compiles a mutant and runs the tests that use it."""

from __future__ import annotations

import concurrent.futures
import filecmp
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import Sequence

from . import build, commands, paths
from .console import step, warn
from .mutant_areas import AREAS, deep_tests
from .mutations import Mutant

SOURCES = ("api", "bench", "cmake", "common", "directory", "docs", "frontend", "helm", "ingest", "migrations", "operator", "renderd", "scene", "tests",
           "tools", "volume", "CMakeLists.txt", "CMakePresets.json", "diaphane")
NOT_COPIED = {"node_modules", "__pycache__", ".pytest_cache", "corpus"}
#: Memory limit of a test program, in bytes.
MOST_MEMORY = 8 << 30
#: Time limit for the integration and end-to-end tests of a folder, in seconds.
DEEP_LIMIT = 3600.0
_FAILED_CASE = re.compile(r"^\[  FAILED  \] ([\w/]+\.[\w/]+)", re.MULTILINE)

#: CMake options that exclude the parts that no area needs.
_PARTS = {"DIAPHANE_RENDERER": ("renderer", "scheduler"), "DIAPHANE_RENDERD": ("renderer", "scheduler"), "DIAPHANE_API": ("access",),
          "DIAPHANE_INGEST": ("ingest",), "DIAPHANE_OPERATOR": ("operator",)}


def mirror(source: Path, target: Path) -> None:
    """Makes `target` equal to `source`. Files that are equal keep their time, so that nothing is built twice."""
    if source.is_file():
        if not target.exists() or not filecmp.cmp(source, target, shallow=False):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target)
            os.utime(target)
        return
    target.mkdir(parents=True, exist_ok=True)
    names = {entry.name for entry in source.iterdir()} - NOT_COPIED
    for entry in target.iterdir():
        if entry.name not in names and entry.name != "node_modules":
            shutil.rmtree(entry) if entry.is_dir() and not entry.is_symlink() else entry.unlink()
    for name in sorted(names):
        mirror(source / name, target / name)


class Tree:
    """A copy of the sources, with a build."""

    def __init__(self, number: int) -> None:
        self.root = paths.REPO / "build" / "mutants" / f"tree-{number:02}"
        self.build = self.root / "build" / "mutants"

    def fill(self) -> None:
        for name in SOURCES:
            if (paths.REPO / name).exists():
                mirror(paths.REPO / name, self.root / name)
        for link in (".tools", "frontend/node_modules"):
            if (paths.REPO / link).exists() and not (self.root / link).is_symlink():
                (self.root / link).symlink_to(paths.REPO / link)

    def copy_of(self, base: "Tree") -> None:
        shutil.rmtree(self.root, ignore_errors=True)
        subprocess.run(["cp", "-a", "--reflink=auto", base.root, self.root], check=True)
        if not self.build.exists():
            return
        # Ninja's files name the copy by its path, which has the same length. A new path is a new command, for which Ninja would build
        # everything again, except by a rule that is marked as a generator.
        old, new = str(base.root).encode(), str(self.root).encode()
        for file in [*self.build.glob("*.ninja"), *self.build.glob("CMakeFiles/*.ninja"), self.build / ".ninja_deps"]:
            if not file.is_symlink():
                text = file.read_bytes().replace(old, new)
                if file.name == "rules.ninja":
                    text = re.sub(rb"^(rule .*)$", rb"\1\n  generator = 1", text, flags=re.MULTILINE)
                file.write_bytes(text)

    def ninja(self, *words: str, keep_results: bool = False) -> subprocess.CompletedProcess:
        # Under another name for its file, Ninja neither looks for new files nor configures again.
        plan = self.build / "plan.ninja"
        if not plan.is_symlink():
            plan.symlink_to("build.ninja")
        env = build.environment() if keep_results else {**build.environment(), "CCACHE_READONLY": "1"}
        return commands.run(["ninja", "-C", self.build, "-f", plan.name, *words], env=env)


# C++

class Programs:
    """The areas in C++: builds the test programs that a mutant changes, and runs the cheapest first."""

    #: Cost of compiling a file, relative to one second of a test.
    SECONDS_PER_FILE = 5.0
    #: How many compilers a mutant's build may run at once.
    COMPILERS = str(max(2, build.jobs() // 4))

    def __init__(self, base: Tree, areas: tuple[str, ...], deep: bool = False) -> None:
        self.base = base
        self.deep = deep
        self.prefixes = {area: AREAS[area].programs for area in areas if AREAS[area].programs}
        self.seconds: dict[str, float] = {}
        self.built: dict[Path, int] = {}

    def prepare(self) -> None:
        step("Building the test programs" + (" and the programs" if self.deep else ""))
        switches = [f"-D{option}={'ON' if self.deep or set(needed) & set(self.prefixes) else 'OFF'}" for option, needed in _PARTS.items()]
        extra = os.environ.get("DIAPHANE_MUTANTS_CMAKE", "").split()
        commands.output(["cmake", "-G", "Ninja", "-S", self.base.root, "-B", self.base.build, "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
                         "-DDIAPHANE_CUDA=OFF", "-DDIAPHANE_UNITY=OFF", *switches, *extra], env=build.environment())
        listed = self.base.ninja("-t", "targets", "all").stdout
        wanted = tuple(prefix for prefixes in self.prefixes.values() for prefix in prefixes)
        names = sorted({name for name in re.findall(r"^bin/(\w+_test):", listed, re.MULTILINE) if name.startswith(wanted)})
        targets = [f"bin/{name}" for name in names] + (build.programs(self.base.build) if self.deep else [])
        done = self.base.ninja("-j", str(build.jobs()), *targets, keep_results=True)
        if done.returncode != 0:
            raise commands.failure("building the test programs", done)
        step(f"Running {len(names)} test programs without a mutant")
        with concurrent.futures.ThreadPoolExecutor(build.jobs()) as pool:
            for name, (outcome, _, seconds) in zip(names, pool.map(lambda name: run_googletest(self.base.build / "bin" / name, 600), names)):
                if outcome == "survived":
                    self.seconds[name] = seconds
                else:
                    warn(f"{name} fails without a mutant and is left out")
        self.built = {file: file.stat().st_mtime_ns for file in self.base.build.rglob("*") if file.suffix in (".o", ".a") or file.parent.name == "bin"}

    def affected(self, tree: Tree, area: str) -> list[str]:
        """Returns the test programs that must be built again, cheapest first."""
        names = [name for name in self.seconds if name.startswith(self.prefixes[area])]
        linked = re.findall(r"Linking CXX executable bin/(\w+)", tree.ninja("-n", *(f"bin/{name}" for name in names)).stdout)
        costs = {name: tree.ninja("-n", f"bin/{name}").stdout.count("Building CXX") * self.SECONDS_PER_FILE + self.seconds[name] for name in linked}
        return sorted(costs, key=costs.get)

    def judge(self, tree: Tree, mutant: Mutant) -> tuple[str, str]:
        changed = False
        for name in self.affected(tree, mutant.area):
            if tree.ninja("-j", self.COMPILERS, f"bin/{name}").returncode != 0:
                return "invalid", ""
            if is_same_program(self.base.build / "bin" / name, tree.build / "bin" / name):
                continue
            changed = True
            outcome, case, _ = run_googletest(tree.build / "bin" / name, 60 + 10 * self.seconds[name])
            if outcome != "survived":
                return outcome, f"{name} {case}".strip()
        if changed and self.deep and (files := deep_tests(mutant)):
            if tree.ninja("-j", self.COMPILERS, *build.programs(tree.build)).returncode != 0:
                return "invalid", ""
            return run_pytest(tree, files, DEEP_LIMIT)
        return ("survived" if changed else "equivalent"), ""

    def restore(self, tree: Tree) -> None:
        """Restores the files that the mutant's build has replaced or removed."""
        for file, modified in self.built.items():
            copy = tree.build / file.relative_to(self.base.build)
            if not copy.exists() or copy.stat().st_mtime_ns != modified:
                shutil.copy2(file, copy)


def run_googletest(program: Path, limit: float) -> tuple[str, str, float]:
    """Returns the outcome, the failed case, and the time."""
    def run_cases(*words: str) -> tuple[int | None, str]:
        # Memory is limited, because a mutant may allocate it without end.
        return run_limited(["prlimit", f"--data={MOST_MEMORY}", "--core=0", str(program), "--gtest_brief=1", "--gtest_fail_fast", *words],
                           program.parent.parent, limit)

    began = time.monotonic()
    code, output = run_cases()
    case = failed_case(output)
    if code is not None and code != 0 and case and run_cases(f"--gtest_filter={case}")[0] == 0:
        # A case that passes when it runs again depends on the machine's load, not on the mutant.
        code, output = run_cases(f"--gtest_filter=-{case}")
        case = failed_case(output)
    outcome = "survived" if code == 0 else "timeout" if code is None else "killed"
    return outcome, case, time.monotonic() - began


def failed_case(output: str) -> str:
    found = _FAILED_CASE.search(output)
    return found.group(1) if found else ""


def run_limited(command: list[str], folder: Path, limit: float, env: dict[str, str] | None = None) -> tuple[int | None, str]:
    """Returns the exit code, or None if the command and its children had to be killed, and the output."""
    # The output goes into a file, because a pipe stays open as long as any child that the command
    # has left behind.
    with tempfile.TemporaryFile() as output:
        running = subprocess.Popen(command, cwd=folder, env={**os.environ, **(env or {})}, stdin=subprocess.DEVNULL, stdout=output,
                                   stderr=subprocess.STDOUT, start_new_session=True)
        try:
            code = running.wait(limit)
        except subprocess.TimeoutExpired:
            code = None
            os.killpg(running.pid, signal.SIGKILL)
            running.wait()
        output.seek(0)
        return code, output.read().decode(errors="replace")


def is_same_program(one: Path, other: Path) -> bool:
    """Whether two programs are equal except for their debug information."""
    stripped = []
    for number, file in enumerate((one, other)):
        stripped.append(other.with_name(f"{other.name}.stripped{number}"))
        subprocess.run(["strip", "-R", ".note.gnu.build-id", "-o", stripped[-1], file], check=True, capture_output=True)
    same = filecmp.cmp(*stripped, shallow=False)
    for file in stripped:
        file.unlink()
    return same


# The page

class Page:
    """The page: TypeScript must accept a mutant, and Vitest runs the tests that import its file."""

    LIMIT = 300.0

    def __init__(self, base: Tree, deep: bool = False) -> None:
        self.base = base
        self.deep = deep
        self.guard = threading.Lock()
        self.checker: subprocess.Popen | None = None

    def prepare(self) -> None:
        build.npm_install()
        done = build.npm("run", "protocol", cwd=self.base.root / "frontend")
        if done.returncode != 0:
            raise commands.failure("npm run protocol", done)
        self.checker = subprocess.Popen(["node", str(Path(__file__).with_name("mutant_types.mjs")), str(self.base.root / "frontend")],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def is_valid(self, file: str, text: str) -> bool:
        with self.guard:
            self.checker.stdin.write(json.dumps({"file": str(self.base.root / file), "text": text}) + "\n")
            self.checker.stdin.flush()
            return self.checker.stdout.readline().strip() == "0"

    def judge(self, tree: Tree, mutant: Mutant) -> tuple[str, str]:
        text = (tree.root / mutant.file).read_text(encoding="utf-8")
        if not self.is_valid(mutant.file, text):
            return "invalid", ""
        code, output = run_limited(["node_modules/.bin/vitest", "related", mutant.file.removeprefix("frontend/"), "--run", "--bail", "1",
                                    "--testTimeout", "60000", "--maxWorkers", "1"], tree.root / "frontend", self.LIMIT, {"CI": "true", "NO_COLOR": "1"})
        if code == 0 or "No test files found" in output:
            return self.judge_whole(tree, deep_tests(mutant)) if self.deep else ("survived", "")
        failed = re.search(r"^ *FAIL +(.*)$", output, re.MULTILINE)
        return ("timeout" if code is None else "killed"), failed.group(1) if failed else ""

    def judge_whole(self, tree: Tree, files: tuple[str, ...]) -> tuple[str, str]:
        built = build.npm("run", "build", cwd=tree.root / "frontend")
        return run_pytest(tree, files, DEEP_LIMIT) if built.returncode == 0 else ("invalid", "")

    def restore(self, tree: Tree) -> None:
        pass

    def close(self) -> None:
        if self.checker:
            self.checker.stdin.close()
            self.checker.wait()


# The tools

class Tools:
    """The tools: pytest runs the test files that name the module."""

    LIMIT = 300.0

    def prepare(self) -> None:
        pass

    def judge(self, tree: Tree, mutant: Mutant) -> tuple[str, str]:
        try:
            compile((tree.root / mutant.file).read_text(encoding="utf-8"), mutant.file, "exec")
        except SyntaxError:
            return "invalid", ""
        named = re.compile(rf"\b{Path(mutant.file).stem}\b")
        files = [str(file) for file in sorted((tree.root / "tests" / "devtool").glob("test_*.py")) if named.search(file.read_text(encoding="utf-8"))]
        if not files:
            return "survived", ""
        return run_pytest(tree, files, self.LIMIT)

    def restore(self, tree: Tree) -> None:
        pass


def run_pytest(tree: Tree, files: Sequence[str], limit: float) -> tuple[str, str]:
    code, output = run_limited([str(paths.VENV_PYTHON), "-m", "pytest", "-c", "tests/pytest.ini", "--rootdir", "tests", "-q", "-x", "-m", "not nightly",
                                *files], tree.root, limit, {"DIAPHANE_BUILD": str(tree.build)})
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", output, re.MULTILINE)
    return ("survived" if code in (0, 5) else "timeout" if code is None else "killed"), failed.group(1) if failed else ""
