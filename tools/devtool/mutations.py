"""Small faults that ./diaphane mutants puts into source files, and the selection of those that it
tests.

The operators are the usual ones of mutation testing: relational, logical and arithmetic
operators, negations, conditions, constants, returned values and deleted statements. Existing
tools have more, but universalmutator's rules do not distinguish a template from a comparison, so
that few of its mutants of C++ compile, and Stryker and mutmut support one language each."""

from __future__ import annotations

import random
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

COMPILED = (".cpp", ".h")
SCRIPTS = (".ts", ".tsx")

_RELATIONS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",),
              "===": ("!==",), "!==": ("===",), "&&": ("||",), "||": ("&&",), "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",),
              "%": ("*",), "&": ("|",), "|": ("&",), "<<": (">>",), ">>": ("<<",), "+=": ("-=",), "-=": ("+=",), "*=": ("/=",),
              "/=": ("*=",), "and": ("or",), "or": ("and",)}
_WORDS = {"true": "false", "false": "true", "True": "False", "False": "True", "min": "max", "max": "min", "any_of": "all_of",
          "all_of": "any_of", "some": "every", "every": "some", "floor": "ceil", "ceil": "floor"}
# Formatters put spaces around each binary operator and none around the brackets of templates.
_OPERATOR = re.compile(r"(?<= )(?:" + "|".join(re.escape(one) for one in sorted(_RELATIONS, key=len, reverse=True)) + r")(?=[ \n])")
_WORD = re.compile(r"\b(?:true|false|True|False)\b|\b(?:min|max|any_of|all_of|some|every|floor|ceil)(?=\()")
_NOT = re.compile(r"!(?=[\w(])|\bnot (?!in\b)")
_INTEGER = re.compile(r"(?<![\w.'])\d+(?![\w.'])")
_REAL = re.compile(r"(?<![\w.'])\d+\.\d*(?:e-?\d+)?(?=f?\b|f?[^\w.])")
_IF = re.compile(r"\bif \((.*)\) (?=\{|[^)]*;$)")
_RETURN = re.compile(r"\breturn (?!\{\})([^;]+);$")
_STATEMENT = re.compile(r"^\s*(?!return|throw|using|co_)(?:[\w.:\[\]>-]+\(.*\)|[\w.:\[\]>-]+ [-+*/|&]?= .*|\+\+.*|break|continue);$")
_UNTOUCHED = re.compile(r"^\s*(?:#|import\b|from\b|export .* from\b|using\b|namespace\b|template\b|@)|\bassert\b|\bstatic_assert\b|\blog::|\bconsole\.")

_HIDDEN = re.compile(
    r"""//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![\w])'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`""", re.DOTALL)
_HIDDEN_PYTHON = re.compile(r'''"""(?:\\.|[^\\])*?"""|#[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*\'''', re.DOTALL)


@dataclass(frozen=True)
class Mutant:
    area: str
    file: str       # relative to the checkout
    line: int       # from 1
    before: str
    after: str

    def apply(self, text: str) -> str:
        lines = text.split("\n")
        assert lines[self.line - 1] == self.before
        lines[self.line - 1] = self.after
        return "\n".join(lines)

    def diff(self) -> str:
        header = f"@@ -{self.line} +{self.line} @@"
        return "\n".join((f"--- {self.file}", f"+++ {self.file}", header, f"-{self.before}", f"+{self.after}"))


def without_words(text: str, python: bool) -> str:
    """Replaces comments and strings by as many spaces, so that positions stay the same."""
    return (_HIDDEN_PYTHON if python else _HIDDEN).sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def of_line(line: str, code: str, suffix: str) -> list[str]:
    """Returns the variants of a line, each with one fault. `code` is the line without comments and strings."""
    if _UNTOUCHED.search(code) or not code.strip():
        return []
    found: list[str] = []

    def put(start: int, end: int, new: str) -> None:
        found.append(line[:start] + new + line[end:])

    for match in _OPERATOR.finditer(code):
        if suffix in SCRIPTS and match.group() in "&|":     # mostly types, which do not exist at run time
            continue
        for new in _RELATIONS[match.group()]:
            put(*match.span(), new)
    for match in _WORD.finditer(code):
        put(*match.span(), _WORDS[match.group()])
    for match in _NOT.finditer(code):
        put(*match.span(), "")
    for match in _INTEGER.finditer(code):
        for value in _other_numbers(int(match.group())):
            put(*match.span(), str(value))
    for match in _REAL.finditer(code):
        put(*match.span(), repr(2 * float(match.group()) or 1.0))
    bare = code.rstrip()
    if suffix != ".py":
        for match in _IF.finditer(bare):
            if _is_balanced(match.group(1)):
                put(*match.span(1), "true")
                put(*match.span(1), "false")
        if (match := _RETURN.search(bare)) and suffix in COMPILED and match.group(1) not in ("true", "false"):
            put(*match.span(1), "{}")
        if _STATEMENT.match(bare) and _is_balanced(bare):
            put(len(bare) - len(bare.lstrip()), len(bare), ";")
    return list(dict.fromkeys(new for new in found if new != line))


def _other_numbers(value: int) -> list[int]:
    """Returns other values of a constant. Small ones, such as counts and indices, are off by one.
    Large ones, mostly sizes or durations, are doubled and halved, because no test would notice a
    difference of one."""
    if value > 10:
        return [2 * value, value // 2]
    return [value + 1, value - 1] if value > 0 else [1]


def _is_balanced(code: str) -> bool:
    depth = 0
    for letter in code:
        depth += letter in "([{"
        depth -= letter in ")]}"
        if depth < 0:
            return False
    return depth == 0


def of_file(area: str, file: str, text: str) -> list[list[Mutant]]:
    """Returns the mutants of each line that has any."""
    suffix = Path(file).suffix
    codes = without_words(text, suffix == ".py").split("\n")
    lines = ([Mutant(area, file, number, line, new) for new in of_line(line, code, suffix)]
             for number, (line, code) in enumerate(zip(text.split("\n"), codes), 1))
    return [mutants for mutants in lines if mutants]


def draw(lines: list[list[Mutant]], seed: int) -> Iterator[Mutant]:
    """Yields the mutants in random order: draws a line, each with the same probability, and one of
    its mutants, none of them twice."""
    rng, left = random.Random(seed), [list(mutants) for mutants in lines]
    while left:
        at = rng.randrange(len(left))
        yield left[at].pop(rng.randrange(len(left[at])))
        if not left[at]:
            left[at] = left[-1]
            left.pop()
