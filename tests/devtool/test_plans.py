"""Properties of the pure parts of tools/devtool. They start nothing, so they run in milliseconds."""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import sys
import threading
import time
import tomllib
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))

from devtool import archive_settings, commands, contracts, datadir, filelint, gpu, install, linkrules, logfiles, packages, paths, plan, ports, testing, venv  # noqa: E402
from devtool.layout import Layout  # noqa: E402
from devtool.linkrules import PROGRAM, Graph  # noqa: E402
from devtool.console import CliError  # noqa: E402
from devtool.users import RunAs  # noqa: E402


# Ports

def test_a_port_claimed_by_another_process_is_not_available():
    import subprocess
    import sys
    port = 100_000 + os.getpid()    # a claim is a name, and no other suite that runs meanwhile draws this one
    code = f"from devtool import ports; print(ports.claim({port}), flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parents[2] / "tools", text=True,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == "True\n"
        assert not ports.claim(port)
        other.communicate("\n")
    assert ports.claim(port)
    ports.give_back([port])


def test_each_start_gets_its_own_ports():
    given = [port for _ in range(20) for port in ports.random_free().values()]
    assert len(set(given)) == len(given)
    ports.give_back(given)
    # Suites that run meanwhile may have taken those of a start or two.
    assert sum(ports.claim(port) for port in given) >= len(given) - 2 * len(ports.DEFAULTS)
    ports.give_back(given)


def test_default_ports_are_used_when_free():
    given, notes = ports.allot(ports.DEFAULTS, free=lambda port: True)
    assert given == ports.DEFAULTS
    assert notes == []


def test_a_taken_port_is_reported_and_the_next_free_one_used():
    given, notes = ports.allot({"edge": 8080}, free=lambda port: port not in (8080, 8081))
    assert given == {"edge": 8082}
    assert notes == ["Port 8080 (edge) is in use. Using 8082 instead."]


def test_ports_are_unique_and_defaults_of_other_programs_stay_free():
    given, notes = ports.allot(ports.DEFAULTS, free=lambda port: port != 8080)
    assert len(set(given.values())) == len(given)
    assert len(notes) == 1
    assert {name: port for name, port in given.items() if name != "edge"} == {
        name: port for name, port in ports.DEFAULTS.items() if name != "edge"}


# Commands

def test_a_command_that_fails_is_reported_with_the_end_of_both_its_outputs():
    assert commands.output(["sh", "-c", "echo one; echo two >&2"]) == "one\ntwo\n"
    with pytest.raises(CliError, match="^counting failed:\n8\n9$"):
        commands.output(["sh", "-c", "seq 0 8; echo 9 >&2; exit 1"], "counting", lines=2)


# Packages

def test_missing_packages_are_those_not_installed_by_dpkg():
    answer = "git install ok installed\nnginx-light deinstall ok config-files\n"
    assert packages.missing(["git", "nginx-light", "redis-server"], lambda names: answer) == [
        "nginx-light", "redis-server"]


def test_package_list_has_no_comments_or_blanks():
    assert all(name and not set(" #[]") & set(name) for name in packages.required())


def test_browsers_are_for_tests_and_the_cuda_compiler_for_gpus():
    assert "chromium" in packages.required() and "chromium" not in packages.required(tests=False)
    assert venv.CUDA in install.parts("up", "") and venv.CUDA not in install.parts("up", "no driver")
    assert venv.CUDA in install.parts("test", "no driver") and venv.CUDA in install.parts("image", "no driver")


# Plan

@pytest.fixture
def settings():
    layout = Layout(Path("/p/bin"), Path("/p/dist"), Path("/p/migrations"), Path("/p/edge"))
    return plan.Settings(data=Path("/d"), ports=dict(ports.DEFAULTS), layout=layout, postgres_password="s3cret")


def test_passwords_are_not_on_command_lines(settings):
    assert all("s3cret" not in word for program in plan.programs(settings) for word in program.argv)
    assert all("s3cret" not in word for word in plan.migrate(settings)[0])


def test_only_database_clients_get_the_database_password(settings):
    holders = {p.name for p in plan.programs(settings) if any("s3cret" in value for value in p.env.values())}
    assert holders == {"api", "ingestd"}


def test_stopping_takes_at_most_five_seconds_without_the_database(settings):
    tiers: dict[int, float] = {}
    for program in plan.programs(settings):
        if program.name == "postgres":
            assert program.stop_seconds == plan.POSTGRES_STOP_SECONDS
            continue
        tiers[program.tier] = max(tiers.get(program.tier, 0), program.stop_seconds)
    assert sum(tiers.values()) < 5


def test_the_analysis_is_left_out_until_its_libraries_are_installed(settings):
    [analysis, pacs] = [program for program in plan.programs(settings) if program.optional]
    assert (analysis.name, pacs.name) == ("analysis", "pacs") and analysis.missing()
    assert f"http://127.0.0.1:{analysis.port}" in [value for program in plan.programs(settings) if program.name == "api" for value in program.env.values()]


def test_the_gateway_to_archives_is_left_out_without_its_settings(settings, tmp_path):
    def of(name: str, data: Path):
        return next(program for program in plan.programs(dataclasses.replace(settings, data=data)) if program.name == name)

    assert tmp_path / "archives.toml" in of("pacs", tmp_path).missing()
    assert of("api", tmp_path).env["DIAPHANE_ARCHIVE_URL"] == ""
    (tmp_path / "archives.toml").touch()
    assert tmp_path / "archives.toml" not in of("pacs", tmp_path).missing()
    assert of("api", tmp_path).env["DIAPHANE_ARCHIVE_URL"] == f"http://127.0.0.1:{of('pacs', tmp_path).port}"


def test_archives_on_the_command_line_become_settings_and_never_replace_a_users_file(tmp_path):
    text = archive_settings.from_options(["main=https://pacs.example/dicom-web", "old=dicom://ORTHANC@10.0.0.2:4242"])
    parsed = tomllib.loads(text)["archive"]
    assert [one["name"] for one in parsed] == ["main", "old"]
    assert parsed[0]["url"] == "https://pacs.example/dicom-web" and (parsed[1]["ae_title"], parsed[1]["port"]) == ("ORTHANC", 4242)
    for wrong in ("main", "=https://x", "Main=https://x", "main=ftp://x", 'main=https://x" y', "main=dicom://ORTHANC@x"):
        with pytest.raises(CliError):
            archive_settings.from_options([wrong])
    archive_settings.write(tmp_path, text, RunAs())
    datadir.check(tmp_path)     # with this file, a new folder is still one of Diaphane's
    archive_settings.write(tmp_path, archive_settings.from_options(["main=https://other.example"]), RunAs())
    assert "other.example" in (tmp_path / "archives.toml").read_text()
    (tmp_path / "archives.toml").write_text("# mine\n")
    with pytest.raises(CliError):
        archive_settings.write(tmp_path, text, RunAs())


def test_the_edge_knows_whether_there_is_a_gateway_to_archives(settings, tmp_path):
    own = dataclasses.replace(settings, data=tmp_path)
    assert plan.nginx_conf(own, "@ARCHIVES@") == "off"
    (tmp_path / "archives.toml").touch()
    assert plan.nginx_conf(own, "@ARCHIVES@") == "on"


def test_every_placeholder_of_the_edge_configuration_is_replaced(settings):
    template = (Path(__file__).resolve().parents[2] / "api" / "edge" / "nginx.conf.in").read_text(encoding="utf-8")
    conf = plan.nginx_conf(settings, template)
    assert not [line for line in conf.splitlines() if "@" in line and not line.lstrip().startswith("#")
                and any(f"@{word}@" in line for word in ("LISTEN", "API_PORT", "RUN_DIR", "LOG"))]
    assert "127.0.0.1:8080" in conf


# Logs

def test_a_log_that_is_too_large_is_rotated(tmp_path):
    log = tmp_path / "api.log"
    for generation in ("first", "second", "third", "fourth"):
        log.write_text(generation * 10, encoding="ascii")
        logfiles.bound(log, limit=8)
    assert log.read_bytes() == b""
    assert (tmp_path / "api.log.1").read_text(encoding="ascii").startswith("fourth")
    assert (tmp_path / "api.log.2").read_text(encoding="ascii").startswith("third")
    assert len(list(tmp_path.iterdir())) == 3


# Link rules

def graph(*links: tuple[str, str], **shapes: str) -> Graph:
    names = {name for link in links for name in link}
    return Graph({name: shapes.get(name, "octagon") for name in names}, frozenset(links))


def test_an_allowed_link_passes():
    assert linkrules.violations(graph(("a", "b")), {"a": ["b"], "b": []}) == []


def test_a_forbidden_link_is_reported():
    assert len(linkrules.violations(graph(("b", "a")), {"a": ["b"], "b": []})) == 1


def test_a_target_without_a_rule_is_reported():
    assert len(linkrules.violations(graph(("a", "new")), {"a": ["new"]})) == 1


def test_linking_a_program_is_reported_even_in_tests():
    found = linkrules.violations(graph(("a_test", "a_main"), a_main=PROGRAM), {"a_main": []})
    assert len(found) == 1


def test_a_test_may_link_any_library():
    assert linkrules.violations(graph(("a_test", "b")), {"b": []}) == []


def test_the_link_graph_omits_third_party_libraries():
    dot = '''
    "node0" [ label = "a", shape = octagon ];
    "node1" [ label = "/usr/lib/libz.so", shape = septagon ];
    "node2" [ label = "Threads::Threads", shape = pentagon ];
    "node3" [ label = "b", shape = pentagon ];
    "node0" -> "node1"  // a -> /usr/lib/libz.so
    "node0" -> "node2"  // a -> Threads::Threads
    "node0" -> "node3" [ style = dotted ] // a -> b
    '''
    assert linkrules.parse(dot) == Graph({"a": "octagon", "b": "pentagon"}, frozenset({("a", "b")}))


def test_including_an_external_header_outside_its_folder_is_reported():
    owners = {"cpprest/": ["api/http"]}
    text = '#include <cpprest/json.h>\n'
    assert linkrules.header_violations({"api/http/a.cpp": text}, owners) == []
    assert len(linkrules.header_violations({"api/scans/a.cpp": text}, owners)) == 1


@pytest.mark.parametrize("header", ["bench/load/person.h", "tests/support/api/fake.h"])
def test_the_product_includes_nothing_that_only_measures_or_tests_it(header):
    text = f'#include "{header}"\n'
    assert len(linkrules.trial_violations({"api/stream/hub.cpp": text})) == 1
    assert linkrules.trial_violations({name: text for name in ("api/stream/hub_test.cpp", "bench/load/main.cpp", "tests/fuzz/viewer.cpp")}) == []


def test_a_header_beside_the_product_that_only_tests_include_is_found():
    include = '#include "api/scans/fake.h"\n'
    sources = {"api/scans/fake.h": "", "api/scans/fake.cpp": include, "api/scans/tus_test.cpp": include, "bench/load/main.cpp": include}
    assert len(linkrules.support_violations(sources)) == 1
    assert linkrules.support_violations({**sources, "api/scans/tus.cpp": include}) == []


@pytest.mark.parametrize("name, header, part", [
    ("api/scans/uploads.cpp", "api/scans/data_set_repository.h", "layer 'service'"),
    ("api/scans/uploads.cpp", "api/routing/message.h", "layer 'service'"),
    ("api/scans/scan_routes.cpp", "api/shared/database.h", "layer 'routes'"),
    ("api/scans/data_set_repository.cpp", "api/scans/data_set_format.h", "layer 'repository'"),
    ("api/accounts/accounts.h", "api/scans/uploads.h", "api/accounts may include only: api/shared"),
    ("api/shared/secrets.h", "api/accounts/accounts.h", "api/shared may include only: nothing"),
])
def test_an_include_against_the_layer_order_is_reported(name, header, part):
    book = linkrules.rules()
    found = linkrules.layer_violations({name: f'#include "{header}"\n'}, book["layers"], book["features"])
    assert len(found) == 1 and part in found[0]


@pytest.mark.parametrize("name, header", [
    ("api/scans/uploads.h", "api/accounts/accounts.h"), ("api/scans/uploads_test.cpp", "api/sharing/sharing.h"),
    ("api/accounts/account_routes.cpp", "api/sessions/render_time.h"), ("api/scans/data_set_repository.h", "api/shared/database.h"),
    ("api/main.cpp", "api/scans/data_set_repository.h"), ("api/mail/transport.h", "api/accounts/mailer.h"),
])
def test_an_include_in_the_layer_order_passes(name, header):
    book = linkrules.rules()
    assert linkrules.layer_violations({name: f'#include "{header}"\n'}, book["layers"], book["features"]) == []


# Files and contracts

@pytest.mark.parametrize("line", ["see /ro" "ot/x", "'/ho" "me/ann/scan'", "path=/wo" "rk/main"])
def test_machine_specific_paths_are_reported(line):
    assert len(filelint.violations("a.md", line)) == 1


@pytest.mark.parametrize("line", ["${HOME}/ho" "me/x is not one", "https://example.org/ro" "ot/x", "a/wo" "rk/b"])
def test_similar_paths_are_not_reported(line):
    assert filelint.violations("a.md", line) == []


def test_long_functions_are_reported_only_in_product_code():
    body = "".join(f"  call({n});\n" for n in range(filelint.LONGEST_FUNCTION - 1))
    free = f"int f(int a,\n      int b) {{\n{body}}}\n"
    method = "class C {\n  int f() {\n" + body.replace("  ", "    ") + "  }\n};\n"
    short = f"int f() {{\n{body}".rsplit("\n", 2)[0] + "\n}\n"
    assert [where.split(": ")[0] for where in filelint.long_functions("api/a.cpp", short + free + method)] == ["api/a.cpp:61", "api/a.cpp:124"]
    assert filelint.long_functions("api/a.cpp", short) == []
    assert filelint.long_functions("api/a_test.cpp", free) == []


def test_an_operation_without_documented_errors_is_reported():
    whole = {"operationId": "a", "summary": "s", "responses": {"200": {}, "default": {}}}
    assert contracts.style({"paths": {"/a": {"get": whole}}}) == []
    assert len(contracts.style({"paths": {"/a": {"get": whole | {"responses": {"200": {}}}}}})) == 1
    assert len(contracts.style({"paths": {"/a": {"get": whole}, "/b": {"get": whole}}})) == 1


# Counting

def test_cases_of_all_runners_are_counted_by_their_results(tmp_path):
    (tmp_path / "pytest.xml").write_text(
        "<s><testcase/><testcase><failure/></testcase><testcase><error/></testcase><testcase><skipped/></testcase></s>")
    (tmp_path / "googletest").mkdir()
    (tmp_path / "googletest" / "film_test.xml").write_text(
        '<s><testcase status="run" result="completed"/><testcase status="run" result="skipped"><skipped/></testcase>'
        '<testcase status="notrun" result="suppressed"/></s>')
    (tmp_path / "broken.xml").write_text("<s><testcase/>")
    assert testing.count_of(tmp_path) == testing.Count(2, 2, 3)
    assert testing.count_of(tmp_path / "absent.xml") == testing.Count()


def test_only_a_program_that_crashed_counts_beside_its_cases(tmp_path):
    (tmp_path / "film_test.xml").write_text("<s><testcase/><testcase><failure/></testcase></s>")
    (tmp_path / "late_test.xml").write_text("<s><testcase/></s>")
    (tmp_path / "programs.xml").write_text("<s>" + "".join(
        f'<testcase classname="{name}" name="{name}"><failure message=""/></testcase>' for name in ("film_test", "late_test", "crashed_test"))
        + '<testcase name="good_test"/></s>')
    testing.keep_crashed(tmp_path / "programs.xml")
    assert testing.count_of(tmp_path) == testing.Count(2, 3)
    assert {name for name, _ in testing.failures(tmp_path)} >= {"late_test::late_test", "crashed_test::crashed_test"}


def test_a_runner_that_fails_without_a_report_is_a_failure():
    assert testing.Count(3, 0).at_least_one_failed(1) == testing.Count(3, 1)
    assert testing.Count(3, 2).at_least_one_failed(1) == testing.Count(3, 2)


def test_every_cluster_test_runs_in_exactly_one_half(monkeypatch, tmp_path):
    there = {one.name for one in (paths.REPO / "tests" / "cluster").glob("test_*.py")}
    runs = []

    def pytest_is_asked(folder, reports, *words, only=()):
        left_out = {Path(word.removeprefix("--ignore=")).name for word in words}
        runs.append((set(only) or there) - left_out)
        return testing.Count(1)
    monkeypatch.setattr(testing, "_pytest", pytest_is_asked)
    assert testing._cluster(tmp_path) == testing.Count(2)
    assert sorted(name for run in runs for name in run) == sorted(there)


def test_selected_cluster_tests_run_where_the_control_plane_is_built():
    def run(kind, plane):
        return [suite.kind for suite in testing.suites() if testing.is_run(suite, kind, plane)]

    always = ["integration", "e2e"] + ["unit"] * 8 + ["e2e"]
    assert run(None, False) == always and run(None, True) == [*always, testing.CHOSEN]
    nightly = [suite.kind for suite in testing.suites(nightly=True) if testing.is_run(suite, None, True, nightly=True)]
    assert nightly == [*always, *testing.NIGHTLY]
    assert run("cluster", True) == ["cluster"] and run("gpu", True) == ["gpu"] and run("unit", True) == ["unit"] * 8


def test_suites_run_in_parallel_and_are_counted_and_timed(tmp_path):
    together = threading.Barrier(2, timeout=60)

    def meets(_):
        together.wait()
        return testing.Count(2)

    done = testing.Run()
    done.add_all([testing.Suite("alone", "unit", lambda _: testing.Count(1, 1)), testing.Suite("one", "e2e", meets, cores=1),
                  testing.Suite("other", "integration", meets, cores=1)], tmp_path, cores=2)
    assert done.total == testing.Count(5, 1)
    assert done.times[0][0] == "alone" and {name for name, _, _ in done.times[1:]} == {"one", "other"}


def test_the_folder_that_runs_share_can_be_reached_by_all_users_and_is_removed(tmp_path):
    with testing.shared_folder(tmp_path):
        folder = (tmp_path / testing.SHARED).resolve()
        assert folder.stat().st_mode & 0o005 == 0o005
        (folder / "made").write_text("once")
    assert not folder.exists() and list(tmp_path.iterdir()) == []


def test_running_suites_never_need_more_cores_than_available(tmp_path):
    costs = {"a": 1.0, "b": 0.5, "c": 1.0, "d": 0.5, "alone": math.inf, "e": 1.5}
    guard, running, most = threading.Lock(), [], []
    first_two = threading.Barrier(2, timeout=60)

    def runs(name):
        with guard:
            running.append(name)
        if name in "ab":
            first_two.wait()    # they fit together, so that two run at the same time however late their threads start
        with guard:
            most.append(sum(costs[one] for one in running) if len(running) > 1 else 0)
        time.sleep(0.05)
        with guard:
            running.remove(name)
        return testing.Count(1)

    done = testing.Run()
    done.add_all([testing.Suite(name, "unit", lambda _, name=name: runs(name), cores=cost) for name, cost in costs.items()], tmp_path, cores=2)
    assert 0 < max(most) <= 2 and done.total == testing.Count(len(costs))


def test_the_slowest_tests_of_all_reports_are_listed(tmp_path):
    (tmp_path / "integration.xml").write_text('<testsuite><testcase classname="integration.test_a" name="b" time="3.5"/></testsuite>')
    (tmp_path / "C++").mkdir()
    (tmp_path / "C++" / "film_test.xml").write_text('<testsuites><testsuite><testcase classname="Film" name="Grows" time="7"/></testsuite></testsuites>')
    assert testing.slowest(tmp_path) == [(7, "Film::Grows"), (3.5, "integration.test_a::b")]
    assert testing.slowest(tmp_path, most=1) == [(7, "Film::Grows")]


# Node

@pytest.mark.parametrize("version, enough", [
    ((0,), False), ((18, 20), False), ((20, 18), False), ((20, 19), True), ((21, 7), False), ((22, 12), False),
    ((22, 13), True), ((23, 11), False), ((24, 0), True), ((26, 1), True)])
def test_node_is_used_only_if_it_is_new_enough(version: tuple[int, ...], enough: bool):
    assert venv.new_enough(version) == enough


# GPU

def test_a_gpu_is_detected_without_its_driver(tmp_path):
    def device(name: str, vendor: str, kind: str) -> None:
        (tmp_path / name).mkdir()
        (tmp_path / name / "vendor").write_text(f"{vendor}\n")
        (tmp_path / name / "class").write_text(f"{kind}\n")

    device("audio", "0x10de", "0x040300")
    device("other", "0x8086", "0x030000")
    assert not gpu.is_plugged_in(tmp_path)
    device("compute", "0x10de", "0x030200")
    assert gpu.is_plugged_in(tmp_path)


class Driver:
    """A libcuda with given answers."""

    def __init__(self, init: int = 0, count_code: int = 0, devices: int = 0):
        self.cuInit = lambda flags: init
        self.count_code_, self.devices_ = count_code, devices

    def cuDeviceGetCount(self, count) -> int:
        count._obj.value = self.devices_
        return self.count_code_


@pytest.mark.parametrize("driver, said", [
    (Driver(devices=1), ""), (Driver(devices=0), "found no device"), (Driver(init=100), "failed to initialise (CUDA error 100)"),
    (Driver(count_code=3), "failed to list its devices (CUDA error 3)")])
def test_a_missing_gpu_is_reported_with_the_reason(driver: Driver, said: str):
    why = gpu.absence(load=lambda name: driver)
    assert said in why and bool(why) == bool(said)


def test_without_a_driver_gpu_tests_fail_with_a_reason(monkeypatch, capsys):
    def no_driver(name: str):
        raise OSError(name)

    monkeypatch.setattr(gpu, "absence", functools.partial(gpu.absence, no_driver))
    monkeypatch.setattr(testing, "_build", lambda kind: pytest.fail("built something"))
    assert testing.run("gpu") == 1
    said = capsys.readouterr()
    assert "cannot run the GPU tests: the NVIDIA driver is not installed" in said.err


# Data directories

def test_an_unsuitable_data_directory_is_refused_before_anything_is_created(tmp_path: Path):
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "dear.txt").write_text("not Diaphane's")
    (tmp_path / "file").write_text("")
    for name, why in {"my data": "may contain only", "letters": "files that are not Diaphane's", "file": "not a directory",
                      "file/below": "cannot create"}.items():
        with pytest.raises(CliError, match=why):
            datadir.check(tmp_path / name)
    datadir.check(tmp_path / "new" / "place")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "letters"]


def test_reasons_of_all_failed_tests_are_repeated(tmp_path):
    (tmp_path / "integration.xml").write_text(
        '<testsuites><testsuite><testcase classname="integration.test_a" name="good" time="1"/>'
        '<testcase classname="integration.test_a" name="bad" time="1"><failure message="assert 1 == 2">long log</failure></testcase>'
        '<testcase classname="integration.test_a" name="broken" time="1"><error>no fixture</error></testcase></testsuite></testsuites>')
    assert testing.failures(tmp_path, longest=10) == [
        ("integration.test_a::bad", "assert 1 ="), ("integration.test_a::broken", "no fixture")]


def test_package_scripts_keep_stdout_while_apt_reports_status(tmp_path, monkeypatch):
    """apt-get does not pass the file of its status on to dpkg, so that this must not be standard output."""
    apt = tmp_path / "apt-get"
    apt.write_text('#!/bin/sh\nfor word; do case $word in APT::Status-Fd=*) fd=${word#*=};; esac; done\n'
                   'eval "echo pmstatus:ccache:50:Configuring >&$fd"\neval "sh -c \'echo said by a script\' $fd>&-"\n')
    apt.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    monkeypatch.setattr(packages, "_as_root", lambda: [])
    shown = []
    monkeypatch.setattr(packages, "progress", shown.append)
    assert packages._apt("install", "ccache", check=False) == 0
    assert len(shown) == 1 and "50%" in shown[0]
