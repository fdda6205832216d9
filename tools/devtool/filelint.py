"""Rules for every file of the repository: no machine-specific paths, no registries in lock files, and no very large files."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from . import paths
from .console import warn

LIMIT = 500
# Assembled from parts, so that this file passes its own rule.
_MACHINE = re.compile(r"(?<![\w.$}-])/(?:%s)/[\w.]" % "|".join(("ro" "ot", "ho" "me", "wo" "rk", "Us" "ers")))
_RESOLVED = '"resolved"' + ":"
_TEXT = {".h", ".cpp", ".cu", ".cuh", ".py", ".ts", ".tsx", ".js", ".mjs", ".css", ".html", ".md", ".txt", ".cmake", ".json",
         ".yaml", ".yml", ".toml", ".proto", ".sql", ".lua", ".sh", ".in", ""}
_NOT_WRITTEN_BY_HAND = {"package-lock.json"}


def files() -> list[Path]:
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=paths.REPO, capture_output=True,
                            text=True, check=True).stdout
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


def check() -> list[str]:
    found = []
    for path in files():
        if path.suffix not in _TEXT:
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        name = str(path.relative_to(paths.REPO))
        found += violations(name, text)
        for warning in giants(name, text):
            warn(warning)
    return found
