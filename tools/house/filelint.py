"""Rules for every file of the repository: no path of one machine, no registry in lock files, no giants."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from . import paths
from .says import warn

LIMIT = 500
# Assembled, so that this file keeps its own rule.
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
    """What the rules forbid in one file."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        if _MACHINE.search(line):
            found.append(f"{name}:{number}: a path of one machine: {line.strip()[:100]}")
    if name.endswith("package-lock.json") and _RESOLVED in text:
        found.append(f"{name}: names the registry it came from ('resolved'); take those lines out")
    if re.search(r"^(<{7} |>{7} )", text, re.MULTILINE):
        found.append(f"{name}: an unresolved merge")
    return found


def giants(name: str, text: str) -> list[str]:
    lines = text.count("\n")
    if lines <= LIMIT or Path(name).name in _NOT_WRITTEN_BY_HAND or name.endswith((".yaml", ".md")):
        return []
    return [f"{name} has {lines} lines; more than {LIMIT} are seldom one subject"]


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
