"""clang-tidy, one translation unit at a time, skipped while nothing that it saw has changed."""

from __future__ import annotations

import concurrent.futures
import hashlib
import json
import re
import shlex
import subprocess
from pathlib import Path

from . import build, paths

_CACHE = paths.STAMPS / "tidy"
_FOLDERS = "api|common|ingest|operator|renderd|volume"


def check() -> list[str]:
    """Findings, the words of clang-tidy. Needs a finished build: its records say which headers each unit saw."""
    folder = build.configure()
    build.ninja(folder, ["all"])
    seen = _dependencies(folder)
    database = folder / "tidy"
    units = _units(folder, database)
    common = _tool_digest()
    todo = {}
    for source, command in units.items():
        key = _digest(source, command, seen.get(source, []), common)
        if not (_CACHE / key).exists():
            todo[source] = key
    _CACHE.mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(build.jobs()) as pool:
        results = list(pool.map(lambda item: _tidy(item[0], database, _CACHE / item[1]), todo.items()))
    _forget_old()
    return [words for words in results if words]


def _units(folder: Path, database: Path) -> dict[Path, str]:
    """Our C++ units and how they are compiled, written down for clang without GCC's precompiled headers and flags."""
    units = {}
    for entry in json.loads((folder / "compile_commands.json").read_text(encoding="utf-8")):
        source = Path(entry["file"])
        # Tests are left to the compiler's warnings: they are half of the time, and their style is GoogleTest's.
        if source.suffix != ".cpp" or source.stem.endswith(("_test", "_bench")) or not source.is_relative_to(paths.REPO) or source.is_relative_to(folder):
            continue
        words = shlex.split(entry["command"])
        # The launcher (ccache) comes before the compiler.
        first = next(i for i, word in enumerate(words) if re.search(r"(^|/)(c\+\+|g\+\+|clang\+\+)(-\d+)?$", word))
        units[source] = _for_clang(words[first:])
    database.mkdir(exist_ok=True)
    listed = [{"directory": str(folder), "file": str(source), "command": command} for source, command in units.items()]
    text = json.dumps(listed, indent=0)
    target = database / "compile_commands.json"
    if not target.exists() or target.read_text(encoding="utf-8") != text:
        target.write_text(text, encoding="utf-8")
    return units


def _for_clang(words: list[str]) -> str:
    kept = []
    skip = False
    for number, word in enumerate(words):
        if skip:
            skip = False
        elif word == "-include" and "cmake_pch" in words[number + 1]:
            skip = True
        elif word not in ("-Winvalid-pch", "-fpch-preprocess"):
            kept.append(word)
    return shlex.join(kept)


def _dependencies(folder: Path) -> dict[Path, list[Path]]:
    """Files that each source was last compiled with, from Ninja's log."""
    done = subprocess.run(["ninja", "-C", str(folder), "-t", "deps"], env=build.environment(), capture_output=True,
                          text=True, errors="replace")
    seen: dict[Path, list[Path]] = {}
    for block in done.stdout.split("\n\n"):
        files = [(folder / line.strip()).resolve() for line in block.splitlines()[1:] if line.strip()]
        for file in files:
            if file.suffix == ".cpp":
                seen[file] = files
                break
    return seen


_file_digests: dict[Path, str] = {}


def _file_digest(path: Path) -> str:
    """By content for ours, by size and time for the system's: those come from packages."""
    if path not in _file_digests:
        try:
            if path.is_relative_to(paths.REPO):
                _file_digests[path] = hashlib.sha256(path.read_bytes()).hexdigest()
            else:
                state = path.stat()
                _file_digests[path] = f"{state.st_size}:{state.st_mtime_ns}"
        except OSError:
            _file_digests[path] = "absent"
    return _file_digests[path]


def _digest(source: Path, command: str, dependencies: list[Path], common: str) -> str:
    parts = [common, command, *(f"{path}={_file_digest(path)}" for path in sorted({source, *dependencies}))]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _tool_digest() -> str:
    version = subprocess.run(["clang-tidy", "--version"], capture_output=True, text=True).stdout
    return version + (paths.REPO / ".clang-tidy").read_text(encoding="utf-8")


def _tidy(source: Path, database: Path, remembered: Path) -> str:
    """What clang-tidy says; when that is nothing, it is remembered at once, so that an interrupted run is not lost."""
    command = ["nice", "clang-tidy", "-p", str(database), "--quiet",
               f"--header-filter=^{re.escape(str(paths.REPO))}/({_FOLDERS})/",
               "--extra-arg=-Wno-unknown-warning-option", "--extra-arg=-Wno-ignored-optimization-argument", str(source)]
    done = subprocess.run(command, cwd=paths.REPO, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          errors="replace")
    if done.returncode == 0:
        remembered.touch()
        return ""
    return done.stdout.replace(f"{paths.REPO}/", "").strip() or done.stderr.strip()


def _forget_old(keep: int = 4000) -> None:
    entries = sorted(_CACHE.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in entries[keep:]:
        path.unlink()
