"""./diaphane check: how it parses the output of formatters."""

from __future__ import annotations

from devtool import check, filelint, passed, paths


def test_each_unformatted_file_of_the_page_is_a_finding():
    output = "npm warn something\nsrc/views/app.tsx\ndev/protocol.mjs\n"
    assert check.unformatted(output) == [
        "frontend/dev/protocol.mjs: not formatted with Prettier (run ./diaphane check --fix)",
        "frontend/src/views/app.tsx: not formatted with Prettier (run ./diaphane check --fix)",
    ]


def test_a_file_with_a_syntax_error_is_a_finding():
    output = "[error] src/main.tsx: SyntaxError: ';' expected. (3:1)\n[error]   1 | const"
    assert check.unformatted(output)[0] == "[error] src/main.tsx: SyntaxError: ';' expected. (3:1)"


def test_a_formatter_that_fails_without_naming_a_file_is_a_finding():
    assert check.unformatted("sh: prettier: not found\n") == ["sh: prettier: not found"]


def test_generated_sources_are_not_formatted():
    assert "src/protocol/gen" in (paths.FRONTEND / ".prettierignore").read_text(encoding="utf-8").split()


def test_a_check_that_passed_is_skipped_until_one_of_its_files_changes(tmp_path, monkeypatch):
    (tmp_path / "page").mkdir()
    source, other = tmp_path / "page" / "a.ts", tmp_path / "b.cpp"
    source.write_text("1", encoding="utf-8")
    other.write_text("1", encoding="utf-8")
    monkeypatch.setattr(passed, "FOLDER", tmp_path / "passed")
    monkeypatch.setattr(paths, "REPO", tmp_path)
    monkeypatch.setattr(filelint, "files", lambda: [source, other])
    runs, findings = [], ["wrong"]
    one = check.Check("lint", lambda: runs.append(1) or findings, inputs=("page/",))

    assert check.findings_of(one) == ["wrong"] and check.findings_of(one) == ["wrong"], "only passing is remembered"
    findings.clear()
    for _ in range(2):
        assert check.findings_of(one) == []
    assert len(runs) == 3
    other.write_text("2", encoding="utf-8")
    check.findings_of(one)
    assert len(runs) == 3, "the check does not read this file"
    source.write_text("2", encoding="utf-8")
    check.findings_of(one)
    assert len(runs) == 4
