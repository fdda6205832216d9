"""`./diaphane check`: static checks of the code."""

from __future__ import annotations

import concurrent.futures
import functools
import subprocess
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

from . import build, client_code, commands, contracts, filelint, install, linkrules, passed, paths, prose, tidy
from .console import CliError, say, step
from .testing import Count

_PAGE_SUFFIXES = (".ts", ".tsx", ".js", ".mjs")
#: Everything that the checks of the page's code depend on. The lock file contains the versions of the tools.
_PAGE = ("frontend/", "api/proto/")


#: Folders of services in Python, each with a package diaphane_NAME.
SERVICES = ("backup", "pacs", "studies")


@dataclass(frozen=True)
class Check:
    name: str
    findings: Callable[[], list[str]]
    slow: bool = False      # needs minutes without a cache
    #: The beginnings of the names of all files on which the findings depend, if they depend on nothing else. The check is skipped
    #: while these are as they were when it passed, in whichever checkout.
    inputs: tuple[str, ...] = ()


CHECKS = [
    Check("files", filelint.check),
    Check("prose", prose.check),
    Check("format", lambda: _format(fix=False)),
    Check("contracts", contracts.check),
    Check("links", linkrules.check),
    Check("types", lambda: _npm_check("exec", "--", "tsc", "-b"), inputs=_PAGE),
    Check("lint", lambda: _npm_check("exec", "--", "eslint", "."), inputs=_PAGE),
    Check("client", client_code.check, inputs=("clients/", "api/proto/", "api/openapi.yaml", "tools/devtool/client_code.py", "tools/check-requirements.txt")),
    Check("services", lambda: [finding for name in SERVICES for finding in client_code.lint(paths.REPO / name, f"diaphane_{name}")],
          inputs=("clients/python/", *(f"{name}/" for name in SERVICES), "tools/check-requirements.txt")),
    Check("tidy", tidy.check, slow=True),
]


def run(only: list[str], fix: bool) -> int:
    unknown = set(only) - {check.name for check in CHECKS}
    if unknown:
        raise CliError(f"unknown check: {', '.join(sorted(unknown))}; choose one of: {', '.join(c.name for c in CHECKS)}")
    install.ensure("check")
    if fix:
        _format(fix=True)
        _npm("exec", "--", "eslint", ".", "--fix")
    count = _count([check for check in CHECKS if not only or check.name in only])
    say(f"{count.passed} checks passed, {count.failed} failed")
    return 1 if count.failed else 0


def count(slow: bool) -> Count:
    """Runs the slow or the quick checks, each counted as a test."""
    return _count([check for check in CHECKS if check.slow == slow])


def _count(checks: list[Check]) -> Count:
    total = Count()
    with concurrent.futures.ThreadPoolExecutor(build.jobs()) as pool:
        for check, findings in zip(checks, pool.map(findings_of, checks)):
            for finding in findings:
                say(finding)
            step(f"check {check.name}: {'passed' if not findings else f'{len(findings)} findings'}")
            total += Count(failed=1) if findings else Count(passed=1)
    return total


def findings_of(check: Check) -> list[str]:
    entry = _entry(check) if check.inputs else None
    if entry and passed.has(entry):
        return []
    try:
        findings = check.findings()
    except CliError as error:
        findings = [str(error)]
    if entry and not findings:
        passed.keep([entry])
    return findings


def _entry(check: Check) -> Path:
    files = [path for path in filelint.files() if str(path.relative_to(paths.REPO)).startswith(check.inputs)]
    return passed.entry(files, check.name, Path(__file__).read_text(encoding="utf-8"))


def _format(fix: bool) -> list[str]:
    return _format_cpp(fix) + _format_page(fix)


def _format_cpp(fix: bool) -> list[str]:
    version = commands.output(["clang-format", "--version"])
    entries = _not_passed(linkrules.cpp_sources(), version, (paths.REPO / ".clang-format").read_text(encoding="utf-8"))
    if not entries:
        return []
    command = ["clang-format", "-i"] if fix else ["clang-format", "--dry-run", "--Werror"]
    done = commands.run([*command, *entries], cwd=paths.REPO)
    if done.returncode == 0:
        passed.keep([] if fix else entries.values())
        return []
    names = sorted({line.split(":")[0] for line in done.stdout.splitlines() if ": error: " in line})
    return [f"{name}: not formatted with clang-format (run ./diaphane check --fix)" for name in names] or [done.stdout]


def _not_passed(files: list[Path], *words: str) -> dict[Path, Path]:
    """Returns the files, by their names in the checkout, that a formatter has not passed as they are now."""
    entries = {path.relative_to(paths.REPO): passed.entry([path], "format", *words) for path in files}
    return {name: entry for name, entry in entries.items() if not passed.has(entry)}


def _format_page(fix: bool) -> list[str]:
    """Runs Prettier on the page's TypeScript and JavaScript."""
    with _ONE:
        build.npm_install()
    settings = [(paths.FRONTEND / name).read_text(encoding="utf-8") for name in (".prettierrc.json", ".prettierignore", "package-lock.json")]
    sources = [path for path in filelint.files() if path.is_relative_to(paths.FRONTEND) and path.suffix in _PAGE_SUFFIXES]
    entries = _not_passed(sources, *settings)
    if not entries:
        return []
    names = [str((paths.REPO / name).relative_to(paths.FRONTEND)) for name in entries]
    done = build.npm("exec", "--", "prettier", "--write" if fix else "--list-different", *names)
    if done.returncode == 0:
        passed.keep([] if fix else entries.values())
        return []
    return unformatted(done.stdout)


def unformatted(output: str) -> list[str]:
    """Converts the output of `prettier --list-different` to findings. It lists unformatted files, and marks anything else with
    `[error]`."""
    names = [line for line in output.splitlines() if line.endswith(_PAGE_SUFFIXES) and not line.startswith("[")]
    errors = [line for line in output.splitlines() if line.startswith("[error]")]
    findings = [f"frontend/{name}: not formatted with Prettier (run ./diaphane check --fix)" for name in sorted(names)] + errors
    return findings or [output.strip()]


def _npm(*arguments: str) -> subprocess.CompletedProcess:
    with _ONE:
        build.npm_install()
        generated = _protocol()
    return build.npm(*arguments) if generated.returncode == 0 else generated


#: Held to prepare the page, because checks that run in parallel must do so one after another.
_ONE = threading.Lock()


@functools.cache
def _protocol() -> subprocess.CompletedProcess:
    return build.npm("run", "protocol")


def _npm_check(*arguments: str) -> list[str]:
    done = _npm(*arguments)
    return [] if done.returncode == 0 else [done.stdout.strip()]
