"""`./diaphane check`: static checks of the code."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from typing import Callable

from . import build, contracts, filelint, install, linkrules, paths, prose, tidy
from .console import CliError, say, step
from .testing import Count

_PAGE_SUFFIXES = (".ts", ".tsx", ".js", ".mjs")
PAGE_SOURCES = "**/*.{ts,tsx,js,mjs}"       # in frontend/; .prettierignore excludes generated files


@dataclass(frozen=True)
class Check:
    name: str
    findings: Callable[[], list[str]]
    slow: bool = False      # needs minutes without a cache


CHECKS = [
    Check("files", filelint.check),
    Check("prose", prose.check),
    Check("format", lambda: _format(fix=False)),
    Check("contracts", contracts.check),
    Check("links", linkrules.check),
    Check("types", lambda: _npm_check("exec", "--", "tsc", "-b")),
    Check("lint", lambda: _npm_check("exec", "--", "eslint", ".")),
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
    for check in checks:
        try:
            findings = check.findings()
        except CliError as error:
            findings = [str(error)]
        for finding in findings:
            say(finding)
        step(f"check {check.name}: {'passed' if not findings else f'{len(findings)} findings'}")
        total += Count(failed=1) if findings else Count(passed=1)
    return total


def _format(fix: bool) -> list[str]:
    return _format_cpp(fix) + _format_page(fix)


def _format_cpp(fix: bool) -> list[str]:
    sources = [str(path.relative_to(paths.REPO)) for path in linkrules.cpp_sources()]
    command = ["clang-format", "-i"] if fix else ["clang-format", "--dry-run", "--Werror"]
    done = subprocess.run([*command, *sources], cwd=paths.REPO, capture_output=True, text=True)
    if done.returncode == 0:
        return []
    names = sorted({line.split(":")[0] for line in done.stderr.splitlines() if ": error: " in line})
    return [f"{name}: not formatted with clang-format (run ./diaphane check --fix)" for name in names] or [done.stderr]


def _format_page(fix: bool) -> list[str]:
    """Runs Prettier on the page's TypeScript and JavaScript."""
    if not (paths.FRONTEND / "package.json").exists():
        return []
    build.npm_install()
    done = build.npm("exec", "--", "prettier", "--write" if fix else "--list-different", PAGE_SOURCES)
    return [] if done.returncode == 0 else unformatted(done.stdout)


def unformatted(output: str) -> list[str]:
    """Converts the output of `prettier --list-different` to findings. It lists unformatted files, and marks anything else with
    `[error]`."""
    names = [line for line in output.splitlines() if line.endswith(_PAGE_SUFFIXES) and not line.startswith("[")]
    errors = [line for line in output.splitlines() if line.startswith("[error]")]
    findings = [f"frontend/{name}: not formatted with Prettier (run ./diaphane check --fix)" for name in sorted(names)] + errors
    return findings or [output.strip()]


def _npm(*words: str) -> subprocess.CompletedProcess | None:
    if not (paths.FRONTEND / "package.json").exists():
        return None
    build.npm_install()
    generated = build.npm("run", "protocol")
    return build.npm(*words) if generated.returncode == 0 else generated


def _npm_check(*words: str) -> list[str]:
    done = _npm(*words)
    return [] if done is None or done.returncode == 0 else [done.stdout.strip()]
