"""./diaphane mutants: which faults it makes, which it draws, and how it counts them."""

from __future__ import annotations

import itertools
import json
import math
import random
import re
import subprocess
import threading
import time

import pytest

from harness import wait_until
from devtool import mutant_areas, mutant_judges, mutants, mutations, paths
from devtool.mutants import Options, Result, Run
from devtool.mutations import Mutant


def mutated(line: str, suffix: str = ".cpp") -> list[str]:
    return mutations.of_line(line, mutations.without_words(line, suffix == ".py"), suffix)


@pytest.mark.parametrize(("line", "expected"), [
    ("  if (a < b) return;", ["  if (a <= b) return;", "  if (a >= b) return;", "  if (true) return;", "  if (false) return;"]),
    ("x && !y", ["x || !y", "x && y"]),
    ("  counter_.add(x);", ["  ;"]),
    ("  return a + b;", ["  return a - b;", "  return {};"]),
    ("f(3, 0)", ["f(4, 0)", "f(2, 0)", "f(3, 1)"]),
    ("wait(250)", ["wait(500)", "wait(125)"]),
    ("1.5f", ["3.0f"]),
    ("0.0", ["1.0"]),
    ("std::min(a, b)", ["std::max(a, b)"]),
])
def test_a_line_has_these_faults(line, expected):
    assert mutated(line) == expected


@pytest.mark.parametrize("line", [
    "#include <a>", "std::vector<int> x;", "template <int a = 3>", "  static_assert(a < 3);", '  log::info("x", a < b);',
    "// if (a < b)", '"a < 3"', "auto x = R\"(a < 3)\";", "const char c = '3';", "std::int32_t x;", "1'000",
])
def test_names_words_and_declarations_have_none(line):
    assert mutated(line) == []


def test_each_language_has_its_own():
    assert mutated("a === b", ".ts") == ["a !== b"]
    assert mutated("let a: B | undefined;", ".ts") == []
    assert mutated("return `${a < 3}`;", ".ts") == []
    assert mutated("if not a and b:  # a or b", ".py") == ["if not a or b:  # a or b", "if a and b:  # a or b"]


def test_comments_of_many_lines_are_left_alone():
    text = "/* a < b\n c < d */ e < f\n"
    assert [line[0].line for line in mutations.of_file("x", "x.cpp", text)] == [2]
    assert {mutant.after for mutant in mutations.of_file("x", "x.cpp", text)[0]} == {" c < d */ e <= f", " c < d */ e >= f"}


def test_a_draw_is_repeatable_and_never_gives_one_twice():
    lines = mutations.of_file("x", "x.cpp", "if (a < b) return;\nx && y\nf(3)\n")
    drawn = list(mutations.draw(lines, 7))
    assert drawn == list(mutations.draw(lines, 7)) != list(mutations.draw(lines, 8))
    assert sorted(map(repr, drawn)) == sorted(repr(mutant) for line in lines for mutant in line)


def test_lines_are_drawn_equally_often_however_many_faults_they_have():
    lines = mutations.of_file("x", "x.cpp", "a < b && c < d && e < f + g\nx && y\n")
    first = [next(mutations.draw(lines, seed)).line for seed in range(1000)]
    assert 440 < first.count(1) < 560


def test_a_mutant_changes_its_line_alone():
    [[mutant]] = mutations.of_file("x", "x.cpp", "int a;\nx && y\nint b;\n")
    assert mutant.apply("int a;\nx && y\nint b;\n") == "int a;\nx || y\nint b;\n"
    assert mutant.diff().splitlines()[2:] == ["@@ -2 +2 @@", "-x && y", "+x || y"]


def test_each_area_has_product_files_and_no_tests():
    for area in mutant_areas.AREAS:
        files = mutant_areas.product_files(area, paths.REPO)
        assert len(files) > 5, area
        assert not [file for file in files if re.search(r"\btest|test[_.]|fake", file.replace("use_latest", "")) and area != "tools"], area


def test_the_tests_of_whole_programs_exist():
    for area in mutant_areas.AREAS.values():
        for folder, files in area.deep:
            assert [file for file in (folder, *files) if not (paths.REPO / file).exists()] == []


def result(outcome: str, area: str = "page") -> Result:
    return Result(Mutant(area, "a.ts", 1, "a", "b"), outcome)


def test_what_does_not_compile_or_changes_nothing_is_not_counted():
    found = mutants.summary([result(outcome) for outcome in ("killed", "timeout", "survived", "invalid", "equivalent")])
    assert (found["all"]["killed"], found["all"]["total"]) == (2, 3) == (found["page"]["killed"], found["page"]["total"])


def test_fewer_than_four_in_five_fail():
    assert mutants.is_enough([result("killed")] * 4 + [result("survived")])
    assert not mutants.is_enough([result("killed")] * 7 + [result("survived")] * 2)
    assert not mutants.is_enough([result("invalid")])


def test_the_interval_is_wilsons():
    low, high = mutants.interval(8, 10)     # Brown, Cai and DasGupta 2001
    assert math.isclose(low, 0.490, abs_tol=1e-3) and math.isclose(high, 0.943, abs_tol=1e-3)
    assert mutants.interval(0, 0) == (0.0, 1.0)


class Judge:
    """Finds every third mutant invalid, and takes its time for some."""

    def judge(self, _, mutant: Mutant) -> tuple[str, str]:
        time.sleep(random.random() * 0.01)
        return ("invalid" if mutant.line % 3 == 0 else "killed" if mutant.line % 2 else "survived"), ""

    def restore(self, _) -> None:
        pass


@pytest.mark.parametrize("jobs", [1, 4])
def test_the_first_valid_mutants_of_the_draw_count_however_many_jobs_there_are(tmp_path, jobs):
    text = "\n".join("x && y" for _ in range(60))
    drawn = list(mutations.draw(mutations.of_file("x", "x.cpp", text), 1))
    expected = list(itertools.islice((mutant for mutant in drawn if mutant.line % 3), 20))
    trees = [mutant_judges.Tree(number) for number in range(jobs)]
    for tree in trees:
        tree.root = tmp_path / str(trees.index(tree))
        tree.root.mkdir()
        (tree.root / "x.cpp").write_text(text)
    run = Run(Options(count=20, areas=("x",), json=tmp_path / "out.json"), {"x": Judge()}, iter(drawn))
    threads = [threading.Thread(target=run.work, args=(tree,)) for tree in trees]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {one.mutant.line for one in run.results if one.counts} == {mutant.line for mutant in expected}
    assert all((tree.root / "x.cpp").read_text() == text for tree in trees)
    assert (tmp_path / "out.json").exists()


def test_equal_files_keep_their_time_and_others_go(tmp_path):
    source, target = tmp_path / "a", tmp_path / "b"
    (source / "folder").mkdir(parents=True)
    (source / "folder" / "same").write_text("1")
    mutant_judges.mirror(source, target)
    before = (target / "folder" / "same").stat().st_mtime_ns
    (source / "changed").write_text("2")
    (target / "extra").write_text("3")
    mutant_judges.mirror(source, target)
    assert (target / "folder" / "same").stat().st_mtime_ns == before
    assert (target / "changed").read_text() == "2"
    assert not (target / "extra").exists()


def test_a_command_that_hangs_is_killed_with_its_children(tmp_path, monkeypatch):
    child, wait = tmp_path / "child", subprocess.Popen.wait

    def wait_once_begun(self, timeout=None):
        if timeout is not None:    # on a busy machine, the command may begin after its time is over
            wait_until(child.exists, what="the command's child")
        return wait(self, timeout)

    with monkeypatch.context() as patched:
        patched.setattr(subprocess.Popen, "wait", wait_once_begun)
        code, output = mutant_judges.run_limited(["sh", "-c", "echo begun; sleep 500 & echo $! > new; mv new child; wait"], tmp_path, 1.0)
    assert (code, output) == (None, "begun\n")

    def state() -> str:
        return subprocess.run(["ps", "-o", "stat=", "-p", child.read_text().strip()], capture_output=True, text=True).stdout.strip()

    # The signal has been sent to both, but only the parent's end was awaited.
    wait_until(lambda: state()[:1] in ("", "Z"), what="the child's end")


GOOGLETEST = """#!/bin/sh
case "$*" in
  *filter=-*) exit {others} ;;
  *filter=*) exit {again} ;;
esac
echo "[  FAILED  ] Suite.Case (3 ms)"
exit 1
"""


@pytest.mark.parametrize(("again", "others", "expected"), [(1, 0, "killed"), (0, 0, "survived"), (0, 1, "killed")])
def test_a_case_that_passes_when_it_runs_again_kills_nothing(tmp_path, again, others, expected):
    program = tmp_path / "bin" / "x_test"
    program.parent.mkdir()
    program.write_text(GOOGLETEST.format(again=again, others=others))
    program.chmod(0o755)
    assert mutant_judges.run_googletest(program, 60)[0] == expected


PROJECT = {
    "CMakeLists.txt": """cmake_minimum_required(VERSION 3.20)
project(small CXX)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
include_directories(${CMAKE_SOURCE_DIR})
add_library(math STATIC renderd/math/limit.cpp)
foreach(name one two)
  add_executable(render_${name}_test renderd/math/${name}_test.cpp)
  target_link_libraries(render_${name}_test math)
endforeach()
""",
    "renderd/math/limit.h": "inline int twice(int x) { return x + x; }\nint limited(int x);\n",
    "renderd/math/limit.cpp": """#include "renderd/math/limit.h"
int limited(int x) {
  if (x < 10) return x;
  if (x != x) return 0;
  return 10;
}
""",
    "renderd/math/one_test.cpp": """#include "renderd/math/limit.h"
#include <cstdio>
int main() {
  if (limited(12) == 10 && limited(3) == 3) return 0;
  std::puts("[  FAILED  ] Limit.IsKept (0 ms)");
  return 1;
}
""",
    "renderd/math/two_test.cpp": """#include "renderd/math/limit.h"
int main() { return twice(3) == 6 ? 0 : 1; }
""",
}


def test_the_mutants_of_a_small_project_are_judged_and_undone(tmp_path, monkeypatch):
    for name, text in PROJECT.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(paths, "REPO", tmp_path)
    monkeypatch.setenv("DIAPHANE_MUTANTS_CMAKE", "-DCMAKE_BUILD_TYPE=Release")
    mutants.run(Options(count=50, areas=("renderer",), jobs=2, json=tmp_path / "out.json"))
    found = {(one["line"], one["after"].strip()): (one["outcome"], one["killer"]) for one in json.loads((tmp_path / "out.json").read_text())["mutants"]}
    assert found[3, "if (x >= 10) return x;"] == ("killed", "render_one_test Limit.IsKept")
    assert found[3, "if (x < 11) return x;"] == ("equivalent", "")
    assert found[3, "if (x < 9) return x;"] == ("survived", "")
    assert found[4, "if (x != x) return 1;"] == ("equivalent", "")
    assert found[1, "inline int twice(int x) { return x - x; }"] == ("killed", "render_two_test")
    assert (tmp_path / "renderd/math/limit.cpp").read_text() == PROJECT["renderd/math/limit.cpp"]
    copy = mutant_judges.Tree(1)
    copy.copy_of(mutant_judges.Tree(0))
    assert "no work to do" in copy.ninja("-n").stdout
