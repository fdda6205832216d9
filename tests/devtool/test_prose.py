"""The checks of documents, texts, comments and commit subjects, and the check of cycles."""

from __future__ import annotations

import re
import tomllib

import pytest

from devtool import cycles, linkrules, prose

RULES = tomllib.loads(prose.RULES.read_text(encoding="utf-8"))


def test_wide_lines_are_found_except_links_and_pictures():
    rules = {"columns": 20}
    text = "short\n" + "x" * 21 + "\n[a link](https://example.org/long)\n![a picture](figures/a-long-name.svg)\n"
    assert prose.wide_lines({"a.md": text}, rules) == ["a.md:2: 21 columns, but at most 20 are allowed"]


def test_words_are_counted_as_wc_does():
    documents = {"a.md": "one two\n\n- three", "b.md": "four"}
    assert prose.too_many_words(documents, {"words": 5}) == []     # the dash of a list counts as a word
    [found] = prose.too_many_words(documents, {"words": 4})
    assert "have 5 words" in found


def test_documents_are_read_without_code_and_sources_by_comments_and_texts():
    document = "Say *this*: `is no code`.\n```\nis no code\n```\nEnd.\n"
    assert [one.text for one in prose.passages("a.md", document)] == ["Say *this*: `.", "End."]
    source = 'int a; // one two\nlog("an error has occurred"); /* three\n four */ key("not_text");\n'
    assert [(one.kind, one.line, one.text) for one in prose.passages("a.cpp", source)] == [
        ("comments", 1, "// one two"), ("texts", 2, "an error has occurred"), ("comments", 2, "/* three"), ("comments", 3, "four */")]
    python = '"""A docstring of words."""\nsay("the text of it")  # a comment\n'
    assert sorted((one.kind, one.text) for one in prose.passages("a.py", python)) == [
        ("comments", "# a comment"), ("comments", "A docstring of words."), ("texts", "the text of it")]
    sql = "-- One line.\nCREATE TABLE a (\n  b text,  -- another\n  c int DEFAULT 1 --2\n);\n"
    assert [(one.kind, one.line, one.text) for one in prose.passages("a.sql", sql)] == [
        ("comments", 1, "-- One line."), ("comments", 3, "-- another")]
    assert [one.text for one in prose.passages("CMakeLists.txt", "add(a)  # why\n")] == ["# why"]


@pytest.mark.parametrize("text", [
    "who may what", "what is lent is told", "not just now", "load the page anew", "for who has lost it", "this is no cursor",
    "is none of those", "60 frames a second", "for whoever asks", "it was mended", "silent for so long", "goes on elsewhere",
    "not heard of", "workers that there are", "what is wanted", "held against the limit", "takes work", "the database is away",
    "works no more.", "tried in vain", "whose it is", "he may go", "from 0 on", "names with commas", "to be looked at", "nobody asks",
    "not any more", "a value that makes no sense", "is of no use", "the way of a session", "is thrown away", "by keys alone",
    "holds nobody up", "may nothing",
])
def test_a_banned_phrase_is_found_and_its_alternative_is_named(text):
    found = prose.banned([prose.Passage("documents", "a.md", 7, text)], [{**rule, "documents": 0} for rule in RULES["banned"]])
    assert found and found[0].startswith("a.md:7: '") and re.search("write|name|say", found[0].partition("': ")[2])


def test_names_of_tests_are_read_as_words():
    python = "class A:\n    def test_a_server_is_away(self):\n        pass\n"
    assert [(one.line, one.text) for one in prose.passages("a.py", python) if one.kind == "names"] == [(2, "a server is away")]
    cpp = "TEST_F(Store,\n       IsAway) {}\nTEST(Http, ReadsHTTPHeader) {}\n"
    assert [(one.line, one.text) for one in prose.passages("a.cpp", cpp)] == [(2, "is away"), (3, "reads http header")]


@pytest.mark.parametrize("text", [
    "There is no device.", "It is no longer valid.", "a second factor", "within a second", "the pods of whom it may concern",
    "A viewer can tell them apart.", "he1 and the", "This is not a cursor.", "Whoever opens the link joins.", "Users are told why.", "Nobody else can enter it.", "60 frames per second",
])
def test_ordinary_english_is_accepted(text):
    assert prose.banned([prose.Passage("documents", "a.md", 1, text)], [{**rule, "documents": 0} for rule in RULES["banned"]]) == []


def test_every_banned_pattern_has_an_alternative_and_compiles():
    assert len({rule["pattern"] for rule in RULES["banned"]}) == len(RULES["banned"]) > 20
    for rule in RULES["banned"]:
        assert re.compile(rule["pattern"]) and rule["instead"]


def test_long_subjects_of_commits_are_found():
    [found] = prose.long_subjects(["abc1234 area: what", f"def5678 {'x' * 73}"], 72)
    assert "def5678" in found and "73" in found


def test_commit_subjects_are_skipped_without_the_base_commit(monkeypatch):
    said = []
    monkeypatch.setattr(prose, "say", said.append)
    assert prose.commit_subjects({"base": "f" * 40, "columns": 72}) == []
    assert len(said) == 1 and "are not checked" in said[0]


def test_cycles_of_includes_are_found():
    sources = {"a.h": '#include "b.h"\n', "b.h": '#include "c/c.h"\n#include <vector>', "c/c.h": '#include "a.h"', "d.h": '#include "a.h"'}
    assert set(cycles.cycle(cycles.includes(sources))) == {"a.h", "b.h", "c/c.h"}
    sources["c/c.h"] = ""
    assert cycles.cycle(cycles.includes(sources)) == []


def test_cycles_of_imports_are_found():
    sources = {"x/a.ts": 'import { b,\n  c } from "./b.js";\nimport { b } from "./b";', "x/b.ts": 'export { d } from "../y";', "y/index.ts": 'import "../x/a";'}
    assert set(cycles.cycle(cycles.imports(sources))) == {"x/a.ts", "x/b.ts", "y/index.ts"}
    for imported in ('import type { A } from "../x/a";', 'const a = await import("../x/a");'):
        sources["y/index.ts"] = imported
        assert set(cycles.cycle(cycles.imports(sources))) == {"x/a.ts", "x/b.ts", "y/index.ts"}
    sources["y/index.ts"] = "export const d = 1;"
    assert cycles.cycle(cycles.imports(sources)) == []


def test_a_file_name_prefix_may_not_spread():
    assert linkrules.prefix_violations(["a/cuda_x.h", "a/cuda_y.h"], {"cuda_": 2}) == []
    [found] = linkrules.prefix_violations(["a/cuda_x.h", "a/cuda_y.h", "b/cuda_z.h"], {"cuda_": 2})
    assert "3 files begin with cuda_" in found
