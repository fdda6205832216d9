"""Runs clang-tidy on the files whose inputs have changed.

Most of its time goes into headers. So files with the same flags are first read together, as one text; where that has findings, each
file is read alone.
"""

from __future__ import annotations

import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path

from . import build, commands, paths

#: Files that clang-tidy has passed, and the headers of each. Shared by all checkouts of the user: keys hold no path of a checkout.
_CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "diaphane" / "tidy"
_HEADERS = _CACHE.with_name("tidy-headers")
_FOLDERS = "api|common|directory|ingest|operator|renderd|volume"
_COMMAND = ["nice", "clang-tidy", "--quiet"]
#: How many files are read together at most. With more, one process would still run when the others have ended.
_TOGETHER = 16

#: What only GCC understands, or what makes no difference to clang-tidy.
_NOT_FOR_CLANG = ("-Winvalid-pch", "-fpch-preprocess", "-Wno-subobject-linkage", "--param=ggc-")
#: Sources and headers that other programs generate, as Ninja names them.
_GENERATED = (".h", ".cc", ".cpp")


def check() -> list[str]:
    """Returns clang-tidy's findings."""
    folder = build.configure()
    build.ninja(folder, _generated(folder))
    database = folder / "tidy"
    commands = _commands(folder, database)
    common = _tool_digest()
    for shared in (_CACHE, _HEADERS):
        shared.mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(build.jobs()) as pool:
        todo = _changed(commands, folder, common, pool)
        joined = groups({source: commands[source] for source in todo})
        passed = pool.map(lambda group: _tidy_together(*group, database), enumerate(joined))
        for group, sound in zip(joined, passed):
            if sound:
                for source in group.sources:
                    (_CACHE / todo.pop(source)).touch()
        results = list(pool.map(lambda item: _tidy(item[0], database, _CACHE / item[1]), todo.items()))
    _forget_old()
    return [text for text in results if text]


@dataclass(frozen=True)
class Group:
    """Files that are compiled with the same flags."""

    sources: list[Path]
    flags: list[str]


def groups(commands: dict[Path, list[str]]) -> list[Group]:
    """Returns the files that can be read together, the largest groups first."""
    alike: dict[tuple[str, ...], list[Path]] = {}
    for source, arguments in commands.items():
        at = arguments.index("-o")
        # The folder of a target's objects tells the targets apart.
        target = arguments[at + 1].partition(".dir/")[0]
        flags = [word for word in [*arguments[1:at], *arguments[at + 2:]] if word not in ("-c", str(source))]
        alike.setdefault((target, *flags), []).append(source)
    found = [Group(sources[first:first + _TOGETHER], list(flags)) for (_, *flags), sources in alike.items()
             for first in range(0, len(sources), _TOGETHER)]
    return sorted((group for group in found if len(group.sources) > 1), key=lambda group: -len(group.sources))


def joined_text(texts: list[str]) -> str:
    """Returns the texts as one. Each header is included once, unless one text includes it twice, which is a finding."""
    included: set[str] = set()
    lines: list[str] = []
    for text in texts:
        own = text.splitlines()
        includes = [line for line in own if line.startswith("#include")]
        left_out = {line for line in includes if line in included and includes.count(line) == 1}
        lines += [line for line in own if line not in left_out]
        included.update(includes)
    return "\n".join([*lines, ""])


def _tidy_together(number: int, group: Group, database: Path) -> bool:
    """Returns whether clang-tidy finds nothing in these files."""
    file = database / f"together-{number}.cpp"
    file.write_text(joined_text([source.read_text(encoding="utf-8") for source in group.sources]), encoding="utf-8")
    return commands.run([*_COMMAND, *_options(), file, "--", *group.flags], cwd=database.parent).returncode == 0


def _generated(folder: Path) -> list[str]:
    listed = commands.output(["ninja", "-C", folder, "-t", "targets", "rule", "CUSTOM_COMMAND"], env=build.environment())
    return sorted(name for name in listed.splitlines() if name.endswith(_GENERATED))


def _commands(folder: Path, database: Path) -> dict[Path, list[str]]:
    """Returns the compile command of each of the project's C++ files, and writes them as a database for clang, without GCC's
    precompiled headers and flags."""
    commands = {}
    for entry in json.loads((folder / "compile_commands.json").read_text(encoding="utf-8")):
        if entry["file"].endswith(".cu"):    # compiled by nvcc, whose flags clang does not know
            continue
        # The launcher (ccache) comes before the compiler.
        arguments = shlex.split(entry["command"])
        first = next(i for i, word in enumerate(arguments) if re.search(r"(^|/)(c\+\+|g\+\+|clang\+\+)(-\d+)?$", word))
        text = Path(entry["file"]).read_text(encoding="utf-8", errors="replace") if "/Unity/" in entry["file"] else None
        for source, command in compiled_alone(entry["file"], arguments[first:], text).items():
            # Excludes tests, which would take half of the time and follow GoogleTest's style.
            if source.suffix != ".cpp" or source.stem.endswith("_test") or not source.is_relative_to(paths.REPO) or source.is_relative_to(folder):
                continue
            commands[source] = _for_clang(command)
    database.mkdir(exist_ok=True)
    listed = [{"directory": str(folder), "file": str(source), "command": shlex.join(command)} for source, command in commands.items()]
    text = json.dumps(listed, indent=0)
    target = database / "compile_commands.json"
    if not target.exists() or target.read_text(encoding="utf-8") != text:
        target.write_text(text, encoding="utf-8")
    return commands


def compiled_alone(file: str, command: list[str], unity: str | None = None) -> dict[Path, list[str]]:
    """Returns a compile command for each file that `command` compiles: `file`, or what the text `unity` of a unity file includes."""
    if unity is None:
        return {Path(file): command}
    alone = {}
    for name in re.findall(r'^#include "(.*)"$', unity, re.MULTILINE):
        if name.startswith(".."):    # generated, and so named from the unity file's folder
            continue
        source = paths.REPO / name
        target = command[command.index("-o") + 1]
        folder, _, objects = target.partition("/CMakeFiles/")
        made = f"{folder}/CMakeFiles/{objects.partition('/')[0]}/{os.path.relpath(name, folder)}.o"
        alone[source] = [{target: made, file: str(source)}.get(word, word) for word in command]
    return alone


def _changed(commands: dict[Path, list[str]], folder: Path, common: str, pool: concurrent.futures.Executor) -> dict[Path, str]:
    """Returns the files that clang-tidy has not passed as they are now, each with the key of its result."""
    # While none of the headers that were found last time, in whichever checkout, has changed, these are still all.
    keys = {source: _digest(source, arguments, _recalled(source, arguments), common) for source, arguments in commands.items()}
    changed = [source for source, key in keys.items() if not _passed(key)]
    for source, found in zip(changed, pool.map(lambda source: _headers(commands[source], folder), changed)):
        _recall_next_time(source, commands[source], found)
        keys[source] = _digest(source, commands[source], found, common)
    return {source: keys[source] for source in changed if not _passed(keys[source])}


def _passed(key: str) -> bool:
    try:
        os.utime(_CACHE / key)    # the results that are used are kept
    except FileNotFoundError:
        return False
    return True


def _portable(text: str) -> str:
    """Returns the parts that are the same in all checkouts."""
    return text.replace(str(paths.REPO), ".")


def _record(source: Path, command: list[str]) -> Path:
    """Returns where the headers of this version of a file are noted. All checkouts share the notes, because finding the headers of all
    files takes minutes."""
    return _HEADERS / hashlib.sha256(_portable(f"{source} {_file_digest(source)} {shlex.join(command)}").encode()).hexdigest()


def _recalled(source: Path, command: list[str]) -> list[Path]:
    try:
        return [paths.REPO / name for name in json.loads(_record(source, command).read_text(encoding="utf-8"))]
    except (OSError, ValueError):
        return []


def _recall_next_time(source: Path, command: list[str], headers: list[Path]) -> None:
    names = [str(path.relative_to(paths.REPO) if path.is_relative_to(paths.REPO) else path) for path in headers]
    record = _record(source, command)
    # Renamed, so that another checkout never reads half of it.
    beside = record.with_suffix(f".{os.getpid()}")
    beside.write_text(json.dumps(names), encoding="utf-8")
    beside.replace(record)


def _headers(command: list[str], folder: Path) -> list[Path]:
    """Returns all files that the preprocessor reads for a compile command."""
    at = command.index("-o")
    done = subprocess.run([*command[:at], *command[at + 2:], "-M"], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          errors="replace")
    names = done.stdout.partition(":")[2].replace("\\\n", " ").split()
    return [(folder / name).resolve() for name in names]


def _for_clang(arguments: list[str]) -> list[str]:
    kept = []
    skip = False
    for number, word in enumerate(arguments):
        if skip:
            skip = False
        elif word == "-include" and "cmake_pch" in arguments[number + 1]:
            skip = True
        elif not word.startswith(_NOT_FOR_CLANG):
            kept.append(word)
    return kept


_file_digests: dict[Path, str] = {}


def _file_digest(path: Path) -> str:
    """Hashes own files by content, and system files by size and time, because they come from packages."""
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


def _digest(source: Path, command: list[str], dependencies: list[Path], common: str) -> str:
    files = sorted(_portable(f"{path}={_file_digest(path)}") for path in {source, *dependencies})
    return hashlib.sha256("\n".join([common, _portable(shlex.join(command)), *files]).encode()).hexdigest()


def _tool_digest() -> str:
    return commands.output(["clang-tidy", "--version"]) + (paths.REPO / ".clang-tidy").read_text(encoding="utf-8")


def _options() -> list[str]:
    return [f"--config-file={paths.REPO / '.clang-tidy'}", f"--header-filter=^{re.escape(str(paths.REPO))}/({_FOLDERS})/",
            "--extra-arg=-Wno-unknown-warning-option", "--extra-arg=-Wno-ignored-optimization-argument"]


def _tidy(source: Path, database: Path, remembered: Path) -> str:
    """Returns clang-tidy's output. An empty result is remembered at once, so that an interrupted run is not lost."""
    done = subprocess.run([*_COMMAND, "-p", str(database), *_options(), str(source)], cwd=paths.REPO, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          errors="replace")
    if done.returncode == 0:
        remembered.touch()
        return ""
    return done.stdout.replace(f"{paths.REPO}/", "").strip() or done.stderr.strip()


def _forget_old(keep: int = 4000) -> None:
    for shared in (_CACHE, _HEADERS):
        entries = sorted(shared.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)
        for path in entries[keep:]:
            path.unlink(missing_ok=True)
