"""Rules for every file of the repository: no machine-specific paths, no registries in lock files, and no very large files."""

from __future__ import annotations

import re
from pathlib import Path

from . import commands, paths
from .console import warn

LIMIT = 500
LONGEST_FUNCTION = 60
# Functions that may be longer: a list with a line or two per item, and kernels, whose parts share
# registers and barriers.
_LONG = ("ProblemForm form_of(ProblemKind kind)", "__launch_bounds__(kCameraBlock", "__launch_bounds__(kLightBlock")
_NOT_PRODUCT = re.compile(r"_test\.|^bench/|^tests/")
# Assembled from parts, so that this file passes its own rule.
_MACHINE = re.compile(r"(?<![\w.$}-])/(?:%s)/[\w.]" % "|".join(("ro" "ot", "ho" "me", "wo" "rk", "Us" "ers")))
_RESOLVED = '"resolved"' + ":"
_TEXT = {".h", ".cpp", ".cu", ".cuh", ".py", ".ts", ".tsx", ".js", ".mjs", ".css", ".html", ".md", ".txt", ".cmake", ".json",
         ".yaml", ".yml", ".toml", ".proto", ".sql", ".lua", ".sh", ".in", ""}
_NOT_WRITTEN_BY_HAND = {"package-lock.json"}


def files() -> list[Path]:
    listed = commands.output(["git", "ls-files", "-co", "--exclude-standard"], cwd=paths.REPO)
    return [paths.REPO / line for line in sorted(set(listed.splitlines())) if (paths.REPO / line).is_file()]


def violations(name: str, text: str) -> list[str]:
    """Returns the violations in one file."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        if _MACHINE.search(line):
            found.append(f"{name}:{number}: an absolute path of one machine: {line.strip()[:100]}")
    if name.endswith("package-lock.json") and _RESOLVED in text:
        found.append(f"{name}: contains registry addresses ('resolved'). Remove those lines")
    if re.search(r"^(<{7} |>{7} )", text, re.MULTILINE):
        found.append(f"{name}: unresolved merge conflict")
    return found


def giants(name: str, text: str) -> list[str]:
    lines = text.count("\n")
    if lines <= LIMIT or Path(name).name in _NOT_WRITTEN_BY_HAND or name.endswith((".yaml", ".md")):
        return []
    return [f"{name} has {lines} lines, more than the recommended {LIMIT}. Consider splitting it"]


def long_functions(name: str, text: str) -> list[str]:
    """Returns the C++ functions of product code that have too many lines. Relies on clang-format: a function ends with a brace
    below the first character of its first line."""
    if not name.endswith((".cpp", ".h", ".cu", ".cuh")) or _NOT_PRODUCT.search(name):
        return []
    found = []
    outermost, member = (0, ""), (0, "")    # the last lines that began a function or a class, and a member of it
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(r"[^\s}#/]", line):
            outermost = number, line
        elif re.match(r"  [^\s}#/]", line):
            member = number, line
        in_class = re.match(r"(template.*|class|struct)\b", outermost[1]) is not None
        begin = outermost if line == "}" else member if line == "  }" and in_class else None
        if begin and number - begin[0] >= LONGEST_FUNCTION and not any(one in begin[1] for one in _LONG):
            found.append(f"{name}:{begin[0]}: a function of {number - begin[0] + 1} lines, more than {LONGEST_FUNCTION}: {begin[1].strip()}")
    return found


def check() -> list[str]:
    found = []
    for path in files():
        if path.suffix not in _TEXT:
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        name = str(path.relative_to(paths.REPO))
        found += violations(name, text) + long_functions(name, text)
        for warning in giants(name, text):
            warn(warning)
    return found
