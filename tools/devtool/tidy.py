"""Runs clang-tidy on the project's C++ files.

Most of its time goes into headers. Some files of a target are therefore first checked together,
as one text. If that has findings, each file is checked alone. ccache remembers which files had
no findings, for all checkouts of the user, and takes tidy_compiler.sh for a compiler."""

from __future__ import annotations

import concurrent.futures
import functools
import json
import os
import re
import shlex
from dataclasses import dataclass
from pathlib import Path

from . import build, build_stamp, commands, paths

_COMPILER = Path(__file__).with_name("tidy_compiler.sh")
#: Maximum number of files that are checked together. With more, a change of one would take longer
#: to check, and the last process would run long after the others have ended.
_TOGETHER = 8

#: Flags that only GCC understands, or that make no difference to clang-tidy.
_NOT_FOR_CLANG = ("-Winvalid-pch", "-fpch-preprocess", "-Wno-subobject-linkage", "--param=ggc-")
#: Sources and headers that other programs generate, as Ninja names them.
_GENERATED = (".h", ".cc", ".cpp")


def check() -> list[str]:
    """Returns clang-tidy's findings."""
    folder = build.configure()
    build.ninja(folder, _generated(folder))
    with concurrent.futures.ThreadPoolExecutor(build.jobs()) as pool:
        found = pool.map(lambda group: findings(group, folder), groups(_compile_commands(folder)))
        return [finding for several in found for finding in several]


@dataclass(frozen=True)
class Group:
    """Files of one target that are compiled with the same flags."""

    name: str
    sources: list[Path]
    flags: list[str]


def groups(compile_commands: dict[Path, list[str]]) -> list[Group]:
    """Returns the files that can be checked together, the largest groups first."""
    alike: dict[tuple[str, ...], list[Path]] = {}
    for source, arguments in compile_commands.items():
        at = arguments.index("-o")
        # The folder of the object file identifies the target.
        target = arguments[at + 1].partition(".dir/")[0].replace("/", "-")
        flags = [word for word in [*arguments[1:at], *arguments[at + 2:]] if word not in ("-c", str(source))]
        alike.setdefault((target, *flags), []).append(source)
    found = [Group(f"{target}-{sources[first].stem}", sources[first:first + _TOGETHER], flags)
             for (target, *flags), sources in alike.items() for first in range(0, len(sources), _TOGETHER)]
    return sorted(found, key=lambda group: -len(group.sources))


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


def findings(group: Group, folder: Path) -> list[str]:
    together = folder / "tidy" / f"{group.name}.cpp"
    together.parent.mkdir(exist_ok=True)
    together.write_text(joined_text([source.read_text(encoding="utf-8") for source in group.sources]), encoding="utf-8")
    # ccache may know the results of the single files only, if they cannot be checked together, for
    # example because two of them define the same name.
    if not _tidy(together, group, folder, only_cached=True) or all(not _tidy(source, group, folder, only_cached=True) for source in group.sources):
        return []
    if not _tidy(together, group, folder):
        return []
    return [found for source in group.sources if (found := _tidy(source, group, folder))]


def _tidy(source: Path, group: Group, folder: Path, only_cached: bool = False) -> str:
    """Returns clang-tidy's output if it has findings. With `only_cached`, also returns a text if
    ccache does not know the result."""
    result = f"tidy/{group.name}-{source.stem}"
    command = [*group.flags, "-MD", "-MF", f"{result}.d", "-o", f"{result}.o", "-c", str(source)]
    root = os.path.relpath(paths.REPO, folder)
    done = commands.run(["nice", "ccache", _COMPILER, *(word.replace(str(paths.REPO), root) for word in command)], cwd=folder,
                        env=_environment() | ({"DIAPHANE_ONLY_CACHED": "1"} if only_cached else {}))
    return done.stdout.replace(f"{root}/", "").strip() or "no result" if done.returncode else ""


@functools.cache
def _version() -> str:
    return commands.output(["clang-tidy", "--version"])


def _environment() -> dict[str, str]:
    settings = build_stamp.digest([paths.REPO / ".clang-tidy"], _version(), _COMPILER.read_text(encoding="utf-8"))
    return {**os.environ, "CCACHE_COMPILERTYPE": "clang", "CCACHE_COMPILERCHECK": f"string:{settings}", "CCACHE_DEPEND": "1",
            "CCACHE_NOHASHDIR": "1", "CCACHE_SLOPPINESS": "time_macros,include_file_mtime,include_file_ctime"}


def _generated(folder: Path) -> list[str]:
    listed = commands.output(["ninja", "-C", folder, "-t", "targets", "rule", "CUSTOM_COMMAND"], env=build.environment())
    return sorted(name for name in listed.splitlines() if name.endswith(_GENERATED))


def _compile_commands(folder: Path) -> dict[Path, list[str]]:
    """Returns the compile command of each of the project's C++ files, without GCC's precompiled headers and flags."""
    found = {}
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
            if not needs_gcc(source):
                found[source] = _for_clang(command)
    return found


def needs_gcc(source: Path) -> bool:
    """Returns whether a file includes ITK, whose headers of Debian reject every compiler but GCC."""
    return source.exists() and "#include <itk" in source.read_text(encoding="utf-8")


def compiled_alone(file: str, command: list[str], unity: str | None = None) -> dict[Path, list[str]]:
    """Returns a compile command for each file that `command` compiles: `file`, or what the text `unity` of a unity file includes."""
    if unity is None:
        return {Path(file): command}
    alone = {}
    for name in re.findall(r'^#include "(.*)"$', unity, re.MULTILINE):
        if name.startswith(".."):    # generated files are named relative to the unity file's folder
            continue
        source = paths.REPO / name
        target = command[command.index("-o") + 1]
        folder, _, objects = target.partition("/CMakeFiles/")
        made = f"{folder}/CMakeFiles/{objects.partition('/')[0]}/{os.path.relpath(name, folder)}.o"
        alone[source] = [{target: made, file: str(source)}.get(word, word) for word in command]
    return alone


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
