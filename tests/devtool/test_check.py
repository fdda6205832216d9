"""./diaphane check: how it parses the output of formatters."""

from __future__ import annotations

from devtool import check, paths


def test_each_unformatted_file_of_the_page_is_a_finding():
    output = "npm warn something\nsrc/views/app.tsx\ndev/protocol.mjs\n"
    assert check.unformatted(output) == [
        "frontend/dev/protocol.mjs: not formatted with Prettier (run ./diaphane check --fix)",
        "frontend/src/views/app.tsx: not formatted with Prettier (run ./diaphane check --fix)",
    ]


def test_a_file_that_does_not_parse_is_a_finding():
    output = "[error] src/main.tsx: SyntaxError: ';' expected. (3:1)\n[error]   1 | const"
    assert check.unformatted(output)[0] == "[error] src/main.tsx: SyntaxError: ';' expected. (3:1)"


def test_a_formatter_that_fails_without_naming_a_file_is_a_finding():
    assert check.unformatted("sh: prettier: not found\n") == ["sh: prettier: not found"]


def test_generated_sources_are_not_formatted():
    assert "src/protocol/gen" in (paths.FRONTEND / ".prettierignore").read_text(encoding="utf-8").split()
