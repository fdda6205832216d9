"""`./diaphane check --only prose`: how documents, texts, comments and commit subjects are written (prose_rules.toml)."""

from __future__ import annotations

import ast
import io
import json
import re
import tokenize
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

from . import build, commands, filelint, passed, paths
from .console import say

RULES = Path(__file__).with_name("prose_rules.toml")
LINTER = paths.TOOLS / "prose"
#: File types whose comments and texts are the project's English prose. German texts and generated files are excluded.
_C_LIKE = {".h", ".cpp", ".cu", ".cuh", ".ts", ".tsx", ".js", ".mjs", ".proto"}
_HASH = {".yaml", ".yml", ".toml", ".cmake", ".sh", ".in"}
#: Files without a type of their own that have comments with #.
_HASH_NAMES = {"CMakeLists.txt", "Containerfile", "diaphane", "packages.txt", ".clang-tidy"}
_LEFT_OUT = ("frontend/src/texts/de", "tools/devtool/prose_rules.toml", "tools/devtool/prose.py", "tests/devtool/test_prose.py")
_URL = re.compile(r"\w://|\]\([^)]*\)|^\s*\[[^\]]+\]:")
_STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"|`(?:[^`\\]|\\.)*`')
_TEST_NAME = re.compile(r"^\s*(?:async )?def test_(\w+)|^TEST(?:_[FP])?\(\s*\w+,\s*(\w+)", re.MULTILINE)
_WORD_BOUNDARY = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|_")
_C_TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"|`(?:[^`\\]|\\.)*`|\'(?:[^\'\\\n]|\\.)\'', re.DOTALL)


@dataclass(frozen=True)
class Passage:
    """A piece of prose, at `name`:`line`. `kind` is documents, texts, comments or names (of tests)."""

    kind: str
    name: str
    line: int
    text: str


def check() -> list[str]:
    rules = tomllib.loads(RULES.read_text(encoding="utf-8"))
    sources = {str(path.relative_to(paths.REPO)): path.read_text(encoding="utf-8", errors="replace") for path in filelint.files()
               if path.suffix in _C_LIKE | _HASH | {".md", ".py", ".lua", ".sql"} or path.name in _HASH_NAMES}
    documents = {name: text for name, text in sources.items() if name.endswith(".md")}
    return (wide_lines(documents, rules["documents"]) + too_many_words(documents, rules["documents"])
            + banned([one for name, text in sources.items() for one in passages(name, text)], rules["banned"])
            + commit_subjects(rules["commits"]) + textlint(sources))


# Documents

def wide_lines(documents: dict[str, str], rules: dict) -> list[str]:
    """Returns lines over the limit, except those with links, which cannot be broken."""
    return [f"{name}:{number}: {len(line)} columns, but at most {rules['columns']} are allowed"
            for name, text in sorted(documents.items()) for number, line in enumerate(text.splitlines(), 1)
            if len(line) > rules["columns"] and not _URL.search(line)]


def too_many_words(documents: dict[str, str], rules: dict) -> list[str]:
    words = sum(len(text.split()) for text in documents.values())
    limit = rules["words"]
    if words <= limit:
        return []
    return [f"all documents together have {words} words, but at most {limit} are allowed"]


# Banned phrases

def passages(name: str, text: str) -> Iterator[Passage]:
    """Yields documents by lines without code, texts as string literals, comments as written, and names of tests as words."""
    if name.startswith(_LEFT_OUT):
        return
    suffix = Path(name).suffix
    if suffix in (".py", ".cpp", ".cu"):
        for found in _TEST_NAME.finditer(text):
            words = _WORD_BOUNDARY.sub(" ", found[1] or found[2]).lower()
            yield Passage("names", name, text.count("\n", 0, found.start(found.lastindex)) + 1, words)
    if suffix == ".md":
        yield from _document(name, text)
    elif suffix == ".py":
        yield from _python(name, text)
    elif suffix in _C_LIKE:
        yield from _c_like(name, text)
    else:
        mark = "--" if suffix in (".lua", ".sql") else "#"
        comment = re.compile(rf"(?:^|\s)({mark}\s.*)")
        for number, line in enumerate(text.splitlines(), 1):
            if found := comment.search(line):
                yield Passage("comments", name, number, found[1].strip())


def _document(name: str, text: str) -> Iterator[Passage]:
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield Passage("documents", name, number, re.sub(r"`[^`]*`", "`", line))


def is_prose(literal: str) -> bool:
    return len(re.findall(r"[A-Za-z]{2,}", literal)) >= 3 and " " in literal.strip()


def _c_like(name: str, text: str) -> Iterator[Passage]:
    for found in _C_TOKEN.finditer(text):
        token, line = found[0], text.count("\n", 0, found.start()) + 1
        if token.startswith("/"):
            for offset, part in enumerate(token.splitlines()):
                yield Passage("comments", name, line + offset, part.strip())
        elif not token.startswith("'") and is_prose(token):
            yield Passage("texts", name, line, token[1:-1])


def _python(name: str, text: str) -> Iterator[Passage]:
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield Passage("comments", name, token.start[0], token.string)
    tree = ast.parse(text)
    docstrings = {id(node.body[0].value) for node in ast.walk(tree)
                  if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef))
                  and node.body and isinstance(node.body[0], ast.Expr) and isinstance(node.body[0].value, ast.Constant)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and is_prose(node.value):
            kind = "comments" if id(node) in docstrings else "texts"
            for offset, part in enumerate(node.value.splitlines()):
                yield Passage(kind, name, node.lineno + offset, part)


def banned(all_passages: list[Passage], rules: list[dict]) -> list[str]:
    found = []
    for rule in rules:
        pattern = re.compile(rule["pattern"], re.IGNORECASE)
        found += [f"{one.name}:{one.line}: '{hit[0]}': {rule['instead']}" for one in all_passages if (hit := pattern.search(one.text))]
    return found


# Commits

def commit_subjects(rules: dict) -> list[str]:
    if commands.run(["git", "merge-base", "--is-ancestor", rules["base"], "HEAD"], cwd=paths.REPO).returncode != 0:
        say(f"commit subjects are not checked: this clone does not contain commit {rules['base'][:12]}")
        return []
    listed = commands.output(["git", "log", "--no-merges", "--format=%h %s", f"{rules['base']}..HEAD"], cwd=paths.REPO)
    return long_subjects(listed.splitlines(), rules["columns"])


def long_subjects(listed: list[str], columns: int) -> list[str]:
    """Returns the commits with too long a subject. `listed` has hashes and subjects."""
    found = []
    for line in listed:
        commit, _, subject = line.partition(" ")
        if len(subject) > columns:
            found.append(f"commit {commit}: the subject has {len(subject)} columns, but at most {columns} are allowed: {subject}")
    return found


# textlint

def textlint(sources: dict[str, str]) -> list[str]:
    """Checks documents, and the page's texts with the line numbers of their sources."""
    folder = paths.REPO / "build" / "prose"
    files = [paths.REPO / name for name in sources if name.endswith(".md")]
    for name, text in sources.items():
        if name.startswith("frontend/src/texts/en/"):
            copy = folder / f"{name}.txt"
            copy.parent.mkdir(parents=True, exist_ok=True)
            lines = [""] * (2 * text.count("\n") + 2)
            for one in passages(name, text):
                if one.kind == "texts":     # on every second line, so that each is a paragraph
                    lines[2 * (one.line - 1)] += f"{one.text} | "
            copy.write_text("\n".join(lines), encoding="utf-8")
            files.append(copy)
    settings = [path.read_text(encoding="utf-8") for path in sorted(LINTER.iterdir()) if path.is_file()]
    entries = {path: passed.entry([path], "textlint", *settings) for path in files}
    files = [path for path, entry in entries.items() if not passed.has(entry)]
    if not files:
        return []
    build.npm_install(LINTER, "prose")
    done = build.npm("exec", "--", "textlint", "--format", "json", *map(str, files), cwd=LINTER)
    start = done.stdout.find("[{")
    if start < 0:
        raise commands.failure("textlint", done)
    found = []
    for file in json.JSONDecoder().raw_decode(done.stdout[start:])[0]:
        path, copied = Path(file["filePath"]), Path(file["filePath"]).is_relative_to(folder)
        name = str(path.relative_to(folder))[:-len(".txt")] if copied else str(path.relative_to(paths.REPO))
        for message in file["messages"]:
            line = (message["line"] + 1) // 2 if copied else message["line"]
            found.append(f"{name}:{line}: {message['message']} ({message['ruleId']})")
        if not file["messages"]:
            passed.keep([entries[path]])
    return found
