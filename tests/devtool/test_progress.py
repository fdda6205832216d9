"""What `./diaphane up` says of its progress, and in which order it works."""

from __future__ import annotations

import io
import threading
from types import SimpleNamespace

import pytest

from devtool import build, console, install, packages, prepare, progress, venv
from devtool.console import CliError

OBJECTS = [f"Building CXX object renderd/serve/CMakeFiles/render_serve.dir/file_{number}.cpp.o" for number in range(100)]


def test_the_first_estimate_divides_the_work_between_the_jobs():
    one, two = (progress.BuildEstimate(OBJECTS, jobs) for jobs in (1, 2))
    assert one.seconds_left(0.0) == pytest.approx(250.0)
    assert two.seconds_left(0.0) == pytest.approx(125.0)


@pytest.mark.parametrize("seconds_per_step", [0.2, 1.5, 6.0])
def test_the_estimate_follows_the_speed_of_the_machine(seconds_per_step):
    estimate = progress.BuildEstimate(OBJECTS, jobs=2)
    for name in OBJECTS[:60]:
        estimate.finish(name)
    truth = 40 * seconds_per_step
    assert estimate.seconds_left(60 * seconds_per_step) == pytest.approx(truth, rel=0.35, abs=5.0)


def test_a_remaining_long_step_counts_more_than_a_short_one():
    long, short = "Building CXX object renderd/engine/cpu/CMakeFiles/render_cpu.dir/kernel_avx2.cpp.o", "Linking CXX executable bin/diaphane-api"
    estimate = progress.BuildEstimate([long, short], jobs=1)
    before = estimate.seconds_left(0.0)
    estimate.finish(short)
    assert estimate.seconds_left(0.2) > 0.9 * before


def test_an_unplanned_step_is_counted():
    estimate = progress.BuildEstimate(OBJECTS[:1], jobs=1)
    for name in ("Re-running CMake...", OBJECTS[0]):
        estimate.finish(name)
    assert estimate.text(3.0) == "2 of 2 steps, a few seconds left"


@pytest.mark.parametrize("line,step", [
    ("@3/322@ Building CXX object common/CMakeFiles/common.dir/log.cpp.o", "Building CXX object common/CMakeFiles/common.dir/log.cpp.o"),
    ("[3/322] Linking CXX static library common/libcommon.a", "Linking CXX static library common/libcommon.a"),
    ("common/log.cpp:3:1: error: expected unqualified-id", None),
    ("FAILED: common/CMakeFiles/common.dir/log.cpp.o", None),
])
def test_status_lines_of_ninja_are_distinguished_from_compiler_output(line, step):
    assert progress.ninja_step(line) == step


@pytest.mark.parametrize("seconds,text", [(3, "a few seconds left"), (31, "about 40 seconds left"), (58, "about 1 minute left"),
                                          (95, "about 2 minutes left"), (284, "about 5 minutes left")])
def test_remaining_time_is_rounded(seconds, text):
    assert progress.time_left(seconds) == text


def test_download_estimate_includes_unpacking():
    apt = progress.AptProgress()
    assert apt.read("dlstatus:1:20.0:Retrieving file 1 of 300 (40s remaining)", now=0.0)
    assert apt.read("dlstatus:150:50.0:Retrieving file 150 of 300 (10s remaining)", now=10.0)
    assert apt.text(10.0) == "downloading, 50%, about 40 seconds left"
    assert apt.read("pmstatus:libvtk9-dev:10.0:Unpacking libvtk9-dev (amd64)", now=20.0)
    assert apt.read("pmstatus:libvtk9-dev:80.0:Configuring libvtk9-dev (amd64)", now=52.0)
    assert apt.text(52.0) == "unpacking and configuring, 80%, a few seconds left"


def test_other_apt_output_is_not_progress():
    apt = progress.AptProgress()
    assert not any(apt.read(line, 0.0) for line in ("E: Unable to locate package libnothing", "dlstatus:", "", "dlstatus:1:many:files"))


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_terminal_progress_is_one_line_that_the_next_message_overwrites(monkeypatch):
    monkeypatch.setattr(console, "_out", terminal := Terminal())
    console.progress("1 of 3")
    console.progress("2 of 3")
    console.say("Done")
    shown = terminal.getvalue().split("\r\x1b[K")
    assert [text.partition("] ")[2] for text in shown[1:3]] == ["1 of 3", "2 of 3"] and shown[3] == "Done\n"


def test_a_log_gets_a_progress_line_every_15_seconds(monkeypatch):
    clock = [1000.0]
    monkeypatch.setattr(console, "_out", log := io.StringIO())
    monkeypatch.setattr(console, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    console.step("Building")
    for seconds in range(1, 40):
        clock[0] = 1000.0 + seconds
        console.progress(f"{seconds} of 40")
    assert [line.partition("] ")[2] for line in log.getvalue().splitlines()] == ["Building", "15 of 40", "30 of 40"]


@pytest.fixture
def start(monkeypatch):
    """Replaces everything that a start does. Returns the record of what was done."""
    done: list[str] = []
    part = venv.Part("build-tools", "CMake")
    monkeypatch.setattr(install, "missing_or_exit", lambda *_: (["libvtk9-dev"], [part]))
    monkeypatch.setattr(venv, "ensure", lambda wanted: done.append(wanted.name))
    monkeypatch.setattr(packages, "install", lambda *_, **__: done.append("packages"))
    monkeypatch.setattr(build, "may_build_page", lambda: True)
    monkeypatch.setattr(build, "npm_install", lambda: done.append("npm"))
    monkeypatch.setattr(build, "build_page", lambda: done.append("page"))
    monkeypatch.setattr(build, "build_programs", lambda *_, **_named: done.append("programs"))
    return done


def test_tools_and_packages_are_installed_in_parallel(start, monkeypatch):
    has_npm = threading.Event()
    monkeypatch.setattr(packages, "install", lambda *_, **__: start.append("packages") if has_npm.wait(20) else None)
    monkeypatch.setattr(build, "npm_install", lambda: (start.append("npm"), has_npm.set()))
    prepare.for_up(may_install=True)
    assert start[:3] == ["build-tools", "npm", "packages"] and set(start[3:]) == {"page", "programs"}


def test_page_build_waits_for_packages_and_program_build_for_tools(start, monkeypatch):
    has_packages = threading.Event()
    monkeypatch.setattr(packages, "install", lambda *_, **__: (start.append("packages"), has_packages.set()))
    monkeypatch.setattr(venv, "ensure", lambda wanted: (has_packages.wait(20), start.append(wanted.name)))
    prepare.for_up(may_install=True)
    assert start[:2] == ["packages", "build-tools"]
    assert start.index("npm") < start.index("page") and "programs" in start


def test_nothing_is_built_if_packages_fail_to_install(start, monkeypatch):
    def fail(*_, **__):
        raise CliError("apt-get install failed")

    monkeypatch.setattr(packages, "install", fail)
    with pytest.raises(CliError, match="apt-get"):
        prepare.for_up(may_install=True)
    assert "page" not in start and "programs" not in start


def test_programs_are_not_built_if_tools_fail_to_install(start, monkeypatch):
    def fail(_):
        raise CliError("pip failed")

    monkeypatch.setattr(venv, "ensure", fail)
    with pytest.raises(CliError, match="pip"):
        prepare.for_up(may_install=True)
    assert "programs" not in start


def test_a_failed_page_build_stops_the_start(start, monkeypatch):
    def fail():
        raise CliError("building the web page failed")

    monkeypatch.setattr(build, "build_page", fail)
    with pytest.raises(CliError, match="page"):
        prepare.for_up(may_install=True)


@pytest.fixture
def cmake_calls(monkeypatch, tmp_path):
    """The options of each call of CMake, in a checkout that was never built."""
    calls = []

    def output(argv, *_args, **_named):
        calls.append(argv[3:])
        folder = tmp_path / "build" / "release"
        folder.mkdir(parents=True, exist_ok=True)
        for name in ("build.ninja", "CMakeCache.txt"):
            (folder / name).touch()

    (tmp_path / "CMakePresets.json").write_text("{}", encoding="ascii")
    monkeypatch.setattr(build.paths, "REPO", tmp_path)
    monkeypatch.setattr(build.paths, "STAMPS", tmp_path / "stamps")
    monkeypatch.setattr(build.commands, "output", output)
    monkeypatch.setattr(build, "_has_needed_instructions", lambda: True)
    return calls


def test_a_first_start_builds_only_the_kernel_of_this_processor(cmake_calls):
    build.configure(portable=False)
    build.configure(portable=False)
    assert cmake_calls == [["-DDIAPHANE_PORTABLE=OFF"]]
    build.configure()
    assert cmake_calls[1:] == [["--fresh"]], "everything else needs all kernels"
    build.configure(portable=False)
    assert len(cmake_calls) == 2, "and a later start keeps them"


def test_a_first_start_builds_every_kernel_on_an_old_processor(cmake_calls, monkeypatch):
    monkeypatch.setattr(build, "_has_needed_instructions", lambda: False)
    build.configure(portable=False)
    build.configure()
    assert cmake_calls == [[]]


@pytest.mark.parametrize("flags, suffices", [("fpu sse2 avx2 bmi2 fma avx512f", True), ("fpu sse2 avx bmi2 fma", False), ("", False)])
def test_the_instructions_of_the_processor_are_read_from_the_kernel(tmp_path, flags, suffices):
    cpuinfo = tmp_path / "cpuinfo"
    cpuinfo.write_text(f"processor\t: 0\nflags\t\t: {flags}\n", encoding="ascii")
    assert build._has_needed_instructions(cpuinfo) == suffices
    assert not build._has_needed_instructions(tmp_path / "absent")
