"""`./diaphane test`: builds, runs the suites from fast to slow, counts their cases, ends with `N passed, N failed`."""

from __future__ import annotations

import concurrent.futures
import json
import os
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

from . import build, clamav, fuzz, gpu, install, kubernetes, paths, whole_node
from .says import HouseError, say, step, warn


@dataclass(frozen=True)
class Count:
    passed: int = 0
    failed: int = 0
    skipped: int = 0

    def __add__(self, other: "Count") -> "Count":
        return Count(self.passed + other.passed, self.failed + other.failed, self.skipped + other.skipped)

    def at_least_one_failed(self, code: int) -> "Count":
        """A runner that ends with an error has a failure, even when its report knows of none (a crash)."""
        return Count(self.passed, max(self.failed, 1), self.skipped) if code != 0 else self

    def __str__(self) -> str:
        return f"{self.passed} passed, {self.failed} failed"


@dataclass(frozen=True)
class Suite:
    name: str
    kind: str
    run: Callable[[Path], Count]   # given a folder for its report


def suites() -> list[Suite]:
    """From fast to slow."""
    return [
        Suite("the house", "unit", lambda reports: _pytest("house", reports)),
        Suite("the page", "unit", _vitest),
        Suite("C++", "unit", lambda reports: _ctest(["-LE", "gpu"], reports)),
        Suite("fuzzing", "unit", _fuzz),
        Suite("integration", "integration", lambda reports: _pytest("integration", reports)),
        Suite("end to end", "e2e", lambda reports: _pytest("e2e", reports)),
        Suite("Kubernetes, a part", CHOSEN, lambda reports: _pytest("cluster", reports, "-m", "chosen")),
        Suite("Kubernetes", "cluster", _cluster),
        Suite("a whole node", "node", _whole_node),
        Suite("GPU", "gpu", lambda reports: _ctest(["-L", "gpu"], reports)),
    ]


#: Run only when they are asked for: without a device, or the minutes that Kubernetes takes to build, they tell nothing.
BY_NAME = ("gpu", "cluster", "node")
#: Of the cluster's tests those that are marked `chosen`: with all others where the control plane is there already.
CHOSEN = "chosen"


#: Of them those that mostly wait, for leases to end and nodes to be given up: run beside all others, each half on a control plane of its own.
WAITING = ("test_faults.py", "test_operator.py", "test_silence.py", "test_upgrade.py")


def is_run(suite: Suite, kind: str | None, plane: bool) -> bool:
    """`plane`: Kubernetes' control plane is built."""
    if suite.kind == CHOSEN:
        return kind is None and plane
    return suite.kind == kind or (kind is None and suite.kind not in BY_NAME)


def run(kind: str | None, may_install: bool = True, with_checks: bool = False) -> int:
    from . import check

    total = Count()
    try:
        _prepare(kind, may_install)
        if with_checks:
            total += _report("quick checks", check.count(slow=False))
        _build(kind)
        reports = _fresh(paths.build_dir() / "reports" / "house")
        missing = kubernetes.missing()
        if kind is None and missing:
            say(f"NOT RUN: the tests on Kubernetes. Its control plane is not built here ({', '.join(missing)}); `./diaphane test cluster` builds it "
                "once for this person's checkouts (22 minutes on two cores), and from then on a part of them is run here.")
        for suite in suites():
            if is_run(suite, kind, not missing):
                total += _report(suite.name, suite.run(reports))
        if with_checks:
            total += _report("slow checks", check.count(slow=True))
    except HouseError as error:
        warn(str(error))
        total += Count(failed=1)
    except KeyboardInterrupt:
        warn("interrupted")
        total += Count(failed=1)
    if total.skipped:
        say(f"{total.skipped} skipped")
    say(str(total))
    return 0 if total.failed == 0 and total.passed > 0 else 1


def _prepare(kind: str | None, may_install: bool) -> None:
    # Else every test of it would be skipped, which looks like success.
    if kind == "gpu" and (why := gpu.absence()):
        raise HouseError(f"there is no GPU to test on: {why}")
    if kind == "node" and (why := whole_node.absence()):
        raise HouseError(f"no node of Kubernetes can be run here: {why}")
    # On a machine that has a GPU and nothing else, the renderer's tests are brought along (DIAPHANE_BUILD).
    if kind != "gpu" or "DIAPHANE_BUILD" not in os.environ:
        install.ensure("test", may_install)
    if kind in (None, "integration"):
        clamav.ensure(may_install)


def _build(kind: str | None) -> None:
    if kind in ("cluster", "node"):
        kubernetes.ensure()
    if kind == "node":
        whole_node.ensure()
    # A browser looks at a cluster's page too.
    if kind != "gpu" and (paths.FRONTEND / "package.json").exists():
        build.npm_install()
        if kind != "unit":
            build.build_page()
    if "DIAPHANE_BUILD" in os.environ:
        say(f"Using what is in {paths.build_dir()} as it is (DIAPHANE_BUILD)")
    elif kind in ("integration", "e2e", "cluster", "node"):
        build.build_programs()
    else:
        build.ninja(build.configure(), ["all"])


def _report(name: str, count: Count) -> Count:
    skipped = f", {count.skipped} skipped" if count.skipped else ""
    step(f"{name}: {count}{skipped}")
    return count


def _fresh(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


# GoogleTest

def _ctest(selection: list[str], reports: Path) -> Count:
    folder = paths.build_dir()
    cases = folder / "reports"
    for old in cases.glob("*.json"):
        old.unlink()
    junit = reports / "ctest.xml"
    step("Running the C++ tests")
    done = subprocess.run(
        ["ctest", "--test-dir", str(folder), "--output-on-failure", "--no-tests=error", "-j", str(build.jobs()),
         "--output-junit", str(junit), *selection],
        env=build.environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, errors="replace")
    if done.returncode != 0:
        say(done.stdout)
    failed_programs = [t.get("name") for t in _testcases(junit) if t.find("failure") is not None]
    return _ctest_count(cases, failed_programs).at_least_one_failed(done.returncode)


def _ctest_count(cases: Path, failed_programs: list[str]) -> Count:
    """Cases of all reports; a program that failed without one there (it crashed) counts as one failure more."""
    total = Count()
    for report in sorted(cases.glob("*.json")):
        count = googletest_count(json.loads(report.read_text(encoding="utf-8")))
        if count.failed == 0 and report.stem in failed_programs:
            count += Count(failed=1)
        total += count
    return total + Count(failed=sum(not (cases / f"{name}.json").exists() for name in failed_programs))


def googletest_count(report: dict) -> Count:
    results = [case for suite in report.get("testsuites", []) for case in suite.get("testsuite", [])]
    failed = sum("failures" in case for case in results)
    skipped = sum(case.get("result") in ("SKIPPED", "SUPPRESSED") or case.get("status") == "NOTRUN" for case in results)
    return Count(len(results) - failed - skipped, failed, skipped)


# libFuzzer

#: For each target; as many at a time as there are cores: eleven on two take three minutes. Longer runs: `./diaphane fuzz --seconds N`.
FUZZ_SECONDS = 30


def _fuzz(_: Path) -> Count:
    found = fuzz.fuzz(fuzz.TARGETS, FUZZ_SECONDS)
    for one in found:
        if not one.well:
            say(f"fuzz {one.target}:\n{one.words}")
    return Count(passed=sum(one.well for one in found), failed=sum(not one.well for one in found))


# Vitest

def _vitest(reports: Path) -> Count:
    if not (paths.FRONTEND / "package.json").exists():
        return Count()
    report = reports / "vitest.json"
    step("Running the page's tests")
    done = build.npm("run", "test", "--", "--reporter=default", "--reporter=json", f"--outputFile.json={report}")
    if done.returncode != 0:
        say(done.stdout)
    count = Count()
    if report.exists():
        seen = json.loads(report.read_text(encoding="utf-8"))
        skipped = seen.get("numPendingTests", 0) + seen.get("numTodoTests", 0)
        count = Count(seen.get("numPassedTests", 0), seen.get("numFailedTests", 0), skipped)
    return count.at_least_one_failed(done.returncode)


# pytest

def _whole_node(reports: Path) -> Count:
    """Built outside, where there is a network; run inside, where there is none."""
    archive = whole_node.image_archive()
    with whole_node.place() as place:
        return _pytest("cluster/test_whole_node.py", reports, within=whole_node.NAMESPACES, DIAPHANE_WHOLE_NODE=str(place), DIAPHANE_IMAGE=str(archive))


def _cluster(reports: Path) -> Count:
    folder = paths.REPO / "tests" / "cluster"
    with concurrent.futures.ThreadPoolExecutor(min(2, build.jobs())) as pool:
        others = pool.submit(_pytest, "cluster", reports, *(f"--ignore={folder / name}" for name in WAITING))
        waiting = pool.submit(_pytest, "cluster", reports, only=WAITING)
        return others.result() + waiting.result()


def _pytest(folder: str, reports: Path, *selection: str, only: tuple[str, ...] = (), within: tuple[str, ...] = (), **more: str) -> Count:
    """Of a folder of tests, one file of it, or `only` some."""
    tests = paths.REPO / "tests"
    if not folder.endswith(".py") and not any((tests / folder).glob("test_*.py")):
        return Count()
    report = reports / f"{Path(folder).stem}{'-some' if only else ''}.xml"
    step(f"Running tests/{folder}{': ' * bool(only)}{', '.join(only)}")
    env = {**build.environment(), "PYTHONDONTWRITEBYTECODE": "1", **more}
    done = subprocess.run(
        [*within, str(paths.VENV_PYTHON), "-m", "pytest",
         "-c", str(tests / "pytest.ini"), "--rootdir", str(tests), "-q", "--durations=5", f"--junitxml={report}",
         *selection, *(str(tests / folder / name) for name in only or [""])],
        cwd=tests, env=env, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        errors="replace")
    if done.returncode != 0:
        say(done.stdout)
    return pytest_count(_testcases(report)).at_least_one_failed(done.returncode)


def pytest_count(cases: list[ElementTree.Element]) -> Count:
    failed = sum(any(case.find(tag) is not None for tag in ("failure", "error")) for case in cases)
    skipped = sum(case.find("skipped") is not None for case in cases)
    return Count(len(cases) - failed - skipped, failed, skipped)


def _testcases(report: Path) -> list[ElementTree.Element]:
    try:
        return list(ElementTree.parse(report).getroot().iter("testcase"))
    except (OSError, ElementTree.ParseError):
        return []
