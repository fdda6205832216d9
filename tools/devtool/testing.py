"""`./diaphane test`: builds, runs the suites, counts their cases, and ends with their times and `N passed, N failed`.

There are two lanes. The gate is what every change must pass. The nightly lane (`--all`) adds the tests with the mark `nightly`,
longer fuzzing, the sanitizers, mutants, and the Kubernetes suites.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import math
import os
import shutil
import tempfile
import threading
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Callable, Iterator

from . import build, chromium, clamav, commands, fuzz, gpu, install, kubernetes, mutants, paths, races, whole_node
from .console import CliError, say, step, warn


@dataclass(frozen=True)
class Count:
    passed: int = 0
    failed: int = 0
    skipped: int = 0

    def __add__(self, other: "Count") -> "Count":
        return Count(self.passed + other.passed, self.failed + other.failed, self.skipped + other.skipped)

    def at_least_one_failed(self, code: int) -> "Count":
        """Counts a failure if the runner failed although its report contains none (a crash)."""
        return Count(self.passed, max(self.failed, 1), self.skipped) if code != 0 else self

    def __str__(self) -> str:
        return f"{self.passed} passed, {self.failed} failed"


@dataclass(frozen=True)
class Suite:
    name: str
    kind: str
    run: Callable[[Path], Count]   # receives a folder for its report
    #: Number of cores that the suite keeps busy. It runs in parallel with others while there are
    #: enough for all.
    cores: float = math.inf


def suites(nightly: bool = False) -> list[Suite]:
    """Returns the suites in the order in which they start: those that run in parallel from slow to
    fast, then those that need the machine for themselves."""
    lane = () if nightly else ("-m", "not nightly")
    # The nightly benches, long fuzzing and attacks have the machine for themselves.
    beside = math.inf if nightly else 1.0
    return [
        Suite("integration", "integration", lambda reports: _pytest("integration", reports, *lane, "--shared", reports / SHARED, workers=1 if nightly else _workers()), cores=1),
        Suite("end-to-end", "e2e", lambda reports: _end_to_end("first", reports, *lane), cores=1),
        Suite("C++", "unit", lambda reports: _ctest(["--test-dir", paths.build_dir(), "-LE", "gpu"], _fresh(reports / "C++"), nightly), cores=beside),
        Suite("web page", "unit", _vitest, cores=beside),
        Suite("fuzzing", "unit", lambda reports: _fuzz(NIGHTLY_FUZZ_SECONDS if nightly else 0), cores=beside),
        Suite("tools", "unit", lambda reports: _pytest("devtool", reports), cores=beside),
        Suite("Python client", "unit", lambda reports: _pytest("client", reports), cores=beside),
        Suite("studies", "unit", lambda reports: _pytest("studies", reports), cores=beside),
        Suite("PACS gateway", "unit", lambda reports: _pytest("pacs", reports), cores=beside),
        Suite("backups", "unit", lambda reports: _pytest("backup", reports), cores=beside),
        # Takes files from the first run as soon as a core is free.
        Suite("end-to-end (second run)", "e2e", lambda reports: _end_to_end("second", reports, *lane), cores=1),
        Suite("Kubernetes (subset)", CHOSEN, lambda reports: _pytest("cluster", reports, "-m", "chosen")),
        Suite("Kubernetes", "cluster", _cluster),
        Suite("Kubernetes node", "node", _whole_node),
        Suite("sanitizers", "sanitizers", _sanitizers),
        Suite("mutants", "mutants", _mutants),
        Suite("GPU", "gpu", lambda reports: _ctest(["--test-dir", paths.build_dir(), "-L", "gpu"], _fresh(reports / "GPU"))),
    ]


#: Suites that run only on request, because they need a device, or minutes to build Kubernetes or
#: everything else once more.
BY_NAME = ("gpu", "cluster", "node", "sanitizers", "mutants")
#: Those of these suites that the nightly lane runs if the machine can.
NIGHTLY = ("cluster", "node", "sanitizers", "mutants")
#: Cluster tests with the mark `chosen` run with all other tests if the control plane is already built.
CHOSEN = "chosen"


#: Cluster tests that mostly wait, for leases to expire and nodes to be given up. They run in parallel to the others, each half on
#: its own control plane.
WAITING = ("test_faults.py", "test_operator.py", "test_silence.py", "test_upgrade.py")


def is_run(suite: Suite, kind: str | None, plane: bool, nightly: bool = False) -> bool:
    """Whether a suite runs. `plane` tells whether Kubernetes' control plane is built."""
    if suite.kind == CHOSEN:
        return kind is None and plane and not nightly
    if kind is None:
        return suite.kind not in BY_NAME or (nightly and suite.kind in NIGHTLY)
    return suite.kind == kind


class Run:
    """The counts and durations of the suites of a run."""

    def __init__(self) -> None:
        self.total = Count()
        self.times: list[tuple[str, float, Count]] = []
        self.guard_ = threading.Lock()

    def add(self, name: str, work: Callable[[], Count]) -> None:
        begin = time.monotonic()
        count = work()
        with self.guard_:
            self.times.append((name, time.monotonic() - begin, count))
            self.total += count
        skipped = f", {count.skipped} skipped" if count.skipped else ""
        step(f"{name}: {count}{skipped}")

    def add_all(self, chosen: list[Suite], reports: Path, cores: float) -> None:
        """Starts each suite, in this order, as soon as those that run leave it enough cores, or none runs."""
        waiting, running = list(chosen), {}
        with concurrent.futures.ThreadPoolExecutor(max(1, len(waiting))) as pool:
            while waiting or running:
                free = cores - sum(running.values())
                if (suite := next((one for one in waiting if one.cores <= free or not running), None)) is not None:
                    waiting.remove(suite)
                    running[pool.submit(self.add, suite.name, lambda suite=suite: suite.run(reports))] = suite.cores
                    continue
                done, _ = concurrent.futures.wait(running, return_when=concurrent.futures.FIRST_COMPLETED)
                for one in done:
                    del running[one]
                    one.result()


def run(kind: str | None, may_install: bool = True, with_checks: bool = False, nightly: bool = False) -> int:
    from . import check

    done = Run()
    try:
        _prepare(kind, may_install)
        if with_checks:
            done.add("quick checks", lambda: check.count(slow=False))
        node = whole_node.absence() if nightly and kind is None else ""
        done.add("build", lambda: _build(kind, nightly and kind is None, not node) or Count())
        reports = _fresh(paths.build_dir() / "reports" / "devtool")
        missing = kubernetes.missing()
        if kind is None and missing and not nightly:
            say(f"NOT RUN: the Kubernetes tests, because the control plane is not built ({', '.join(missing)}). Run `./diaphane test cluster` to build it "
                "once for all your checkouts (22 minutes on two cores). After that, this command runs a subset of them.")
        if node:
            say(f"NOT RUN: the Kubernetes node, because this machine cannot run one ({node})")
        chosen = [suite for suite in suites(nightly) if is_run(suite, kind, not missing, nightly)]
        with shared_folder(reports):
            done.add_all([suite for suite in chosen if suite.kind != "node" or not node], reports, cores=build.jobs())
        if with_checks:
            done.add("slow checks", lambda: check.count(slow=True))
        _say_times(done.times, reports)
        _say_failures(reports)
    except CliError as error:
        warn(str(error))
        done.total += Count(failed=1)
    except KeyboardInterrupt:
        warn("interrupted")
        done.total += Count(failed=1)
    total = done.total
    if total.skipped:
        say(f"{total.skipped} skipped")
    say(str(total))
    return 0 if total.failed == 0 and total.passed > 0 else 1


#: Name of the folder, beside the reports, for what the runs of pytest make once for all: an empty database and a scan.
SHARED = "shared"


@contextlib.contextmanager
def shared_folder(reports: Path) -> Iterator[None]:
    """Makes a link to a folder that the ordinary user can reach, who often cannot reach the checkout."""
    with tempfile.TemporaryDirectory(prefix="diaphane-shared-") as folder:
        Path(folder).chmod(0o755)
        (reports / SHARED).symlink_to(folder)
        yield
        (reports / SHARED).unlink()


def _prepare(kind: str | None, may_install: bool) -> None:
    # Without a device or root, every test would be skipped, which looks like success.
    if kind == "gpu" and (why := gpu.absence()):
        raise CliError(f"cannot run the GPU tests: {why}")
    if kind == "node" and (why := whole_node.absence()):
        raise CliError(f"cannot run a Kubernetes node on this machine: {why}")
    # On a machine that has a GPU but no build tools, the renderer's tests come with it
    # (DIAPHANE_BUILD).
    if kind != "gpu" or "DIAPHANE_BUILD" not in os.environ:
        install.ensure("test", may_install)
    if kind in (None, "integration"):
        clamav.ensure(may_install)


def _build(kind: str | None, cluster: bool = False, node: bool = False) -> None:
    """Builds what the suites of `kind` need. `cluster` and `node` add what these suites of the
    nightly lane need."""
    if cluster or kind in ("cluster", "node"):
        kubernetes.ensure()
    if kind == "node" or (cluster and node):
        whole_node.ensure()
    # The cluster tests also open a page in a browser.
    if kind != "gpu":
        build.npm_install()
        if kind != "unit":
            build.build_page()
    if "DIAPHANE_BUILD" in os.environ:
        say(f"Using the build in {paths.build_dir()} without rebuilding it (DIAPHANE_BUILD is set)")
    elif kind in ("integration", "e2e", "cluster", "node"):
        build.build_programs()
    else:
        build.ninja(build.configure(), ["all"])


def _say_times(times: list[tuple[str, float, Count]], reports: Path) -> None:
    say("Times:")
    for name, seconds, count in times:
        say(f"  {seconds:7.1f} s  {name}{f' ({count})' if count != Count() else ''}")
    say("Slowest tests:")
    for seconds, name in slowest(reports):
        say(f"  {seconds:7.1f} s  {name}")


def slowest(reports: Path, most: int = 10) -> list[tuple[float, str]]:
    """Returns the seconds and names of the slowest tests."""
    return sorted(((float(case.get("time") or 0), _name(case)) for case in _testcases(reports)), reverse=True)[:most]


def _say_failures(reports: Path) -> None:
    """Repeats the names of the failed tests and the reasons, because logs of programs may have
    scrolled them out of view."""
    found = failures(reports)
    if found:
        say("Failed tests:")
    for name, reason in found:
        say(f"  {name}\n    {reason}")


def failures(reports: Path, longest: int = 600) -> list[tuple[str, str]]:
    """Returns the names of the failed tests, each with the first `longest` characters of the reason."""
    return [(_name(case), (outcome.get("message") or outcome.text or "").strip()[:longest])
            for case in _testcases(reports) for outcome in (*case.findall("failure"), *case.findall("error"))]


def _name(case: ElementTree.Element) -> str:
    return f"{case.get('classname')}::{case.get('name')}"


def _fresh(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


# Reports. All runners write JUnit's XML.

def count_of(report: Path) -> Count:
    """Counts the tests of a file, or of all files of a folder."""
    cases = _testcases(report)
    failed = sum(any(case.find(tag) is not None for tag in ("failure", "error")) for case in cases)
    skipped = sum(case.find("skipped") is not None or case.get("status") == "notrun" for case in cases)
    return Count(len(cases) - failed - skipped, failed, skipped)


def _testcases(report: Path) -> list[ElementTree.Element]:
    cases: list[ElementTree.Element] = []
    for file in sorted(report.rglob("*.xml")) if report.is_dir() else [report]:
        with contextlib.suppress(OSError, ElementTree.ParseError):
            cases += ElementTree.parse(file).getroot().iter("testcase")
    return cases


# GoogleTest

def _ctest(where: list[object], reports: Path, nightly: bool = False) -> Count:
    """Runs ctest. `where` contains options that choose the build and the tests."""
    step("Running the C++ tests")
    programs = reports / "programs.xml"
    done = commands.run(["ctest", *where, "--output-on-failure", "--no-tests=error", "-j", build.jobs(), "--output-junit", programs], cwd=paths.REPO,
                        env={**build.environment(), "GTEST_OUTPUT": f"xml:{reports}/", **({"DIAPHANE_NIGHTLY": "1"} if nightly else {})})
    if done.returncode != 0:
        say(done.stdout)
    keep_crashed(programs)
    return count_of(reports).at_least_one_failed(done.returncode)


def keep_crashed(programs: Path) -> None:
    """Leaves the programs in ctest's report that failed without a failed case in a report of their own."""
    crashed = ElementTree.Element("testsuite")
    crashed.extend(case for case in _testcases(programs) if case.find("failure") is not None
                   and not count_of(programs.with_name(f"{case.get('name')}.xml")).failed)
    ElementTree.ElementTree(crashed).write(programs)


# libFuzzer

#: Seconds per target in the nightly lane, where thirteen on two cores take seven minutes. The gate
#: replays the kept corpus.
NIGHTLY_FUZZ_SECONDS = 60


def _fuzz(seconds: int) -> Count:
    """Runs all fuzz targets. With 0 seconds, replays the kept corpus."""
    found = fuzz.fuzz(fuzz.TARGETS, seconds)
    for one in found:
        if not one.ok:
            say(f"fuzz {one.target}:\n{one.failure}")
    return Count(passed=sum(one.ok for one in found), failed=sum(not one.ok for one in found))


def _sanitizers(reports: Path) -> Count:
    """Runs the C++ tests under AddressSanitizer and UndefinedBehaviorSanitizer, and the
    multi-threaded ones under ThreadSanitizer."""
    build.ninja(build.configure("asan"), ["all"])
    count = _ctest(["--preset", "asan"], _fresh(reports / "asan"))
    raced = races.run([], may_install=False) == 0
    return count + Count(passed=int(raced), failed=int(not raced))


#: Time after which the nightly lane starts no more mutants.
NIGHTLY_MUTANT_SECONDS = 2.5 * 3600


def _mutants(_: Path) -> Count:
    """Tests mutants, with another draw each day. The outcomes are kept in
    build/reports/mutants.json."""
    options = mutants.Options(seed=date.today().toordinal(), jobs=mutants.default_jobs(), json=paths.REPO / "build" / "reports" / "mutants.json",
                              end=time.monotonic() + NIGHTLY_MUTANT_SECONDS, deep=True)
    enough = mutants.run(options, may_install=False) == 0
    return Count(passed=int(enough), failed=int(not enough))


# Vitest

def _vitest(reports: Path) -> Count:
    report = reports / "vitest.xml"
    step("Running the web page's tests")
    done = build.npm("run", "test", "--", "--reporter=default", "--reporter=junit", f"--outputFile.junit={report}")
    if done.returncode != 0:
        say(done.stdout)
    return count_of(report).at_least_one_failed(done.returncode)


# pytest

def _whole_node(reports: Path) -> Count:
    """Tests a complete node. Everything is built outside the namespaces, where there is a network,
    and runs inside, where there is none."""
    archive = whole_node.image_archive()
    with whole_node.place() as place:
        return _pytest("cluster/test_whole_node.py", reports, within=whole_node.NAMESPACES, DIAPHANE_WHOLE_NODE=str(place), DIAPHANE_IMAGE=str(archive))


def _cluster(reports: Path) -> Count:
    folder = paths.REPO / "tests" / "cluster"
    with concurrent.futures.ThreadPoolExecutor(min(2, build.jobs())) as pool:
        others = pool.submit(_pytest, "cluster", reports, *(f"--ignore={folder / name}" for name in WAITING))
        waiting = pool.submit(_pytest, "cluster", reports, only=WAITING)
        return others.result() + waiting.result()


def _end_to_end(which: str, reports: Path, *lane: str) -> Count:
    """Runs the files that the other run has not claimed. The nightly lane has no `lane`, and uses the whole browser."""
    browser = {} if lane else {"DIAPHANE_CHROMIUM": chromium.WHOLE}
    return _pytest("e2e", reports, *lane, "--claims", reports / "claims", "--shared", reports / SHARED, report=f"e2e-{which}", **browser)


def _pytest(folder: str, reports: Path, *selection: object, only: tuple[str, ...] = (), within: tuple[str, ...] = (), workers: int = 1,
            report: str = "", **more: str) -> Count:
    """Runs a folder of tests, one file of it, or the tests in `only`, with this many workers in
    parallel."""
    tests = paths.REPO / "tests"
    report = reports / f"{report or Path(folder).stem}{'-some' if only else ''}.xml"
    step(f"Running tests/{folder}{': ' * bool(only)}{', '.join(only)}")
    env = {**build.environment(), "PYTHONDONTWRITEBYTECODE": "1", **more}
    parallel = ("-n", workers, "--no-loadscope-reorder") if workers > 1 else ()
    done = commands.run([*within, paths.VENV_PYTHON, "-m", "pytest", "-c", tests / "pytest.ini", "--rootdir", tests, "-q", f"--junitxml={report}",
                         *parallel, *selection, *(tests / folder / name for name in only or [""])], cwd=tests, env=env)
    if done.returncode != 0:
        say(done.stdout)
    return count_of(report).at_least_one_failed(done.returncode)


def _workers() -> int:
    """Returns how many processes share the tests of a suite that waits half of the time. Each
    starts its own programs."""
    return min(build.jobs(), 4) + 1
