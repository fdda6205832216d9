"""`./diaphane bounds`: writes docs/bounds.md from docs/bounds.toml, which also quotes the code that enforces each limit."""

from __future__ import annotations

import textwrap
import tomllib
from dataclasses import dataclass

from . import paths
from .console import say

SOURCE = paths.REPO / "docs" / "bounds.toml"
PAGE = paths.REPO / "docs" / "bounds.md"


@dataclass(frozen=True)
class Limit:
    """One limit of one kind of input. Without scopes it applies to one request."""

    kind: str
    dimension: str
    limit: str
    scopes: tuple[str, ...]
    quotes: tuple[tuple[str, str], ...]   # (file, literal text in it)
    tests: tuple[str, ...]


def run() -> int:
    PAGE.write_text(page(), encoding="utf-8")
    say(f"Written: {PAGE.relative_to(paths.REPO)}")
    return 0


def limits() -> list[Limit]:
    return [Limit(kind, one["dimension"], one["limit"], tuple(one.get("scopes", ["request"])),
                  tuple((file, literal) for file, literals in one["code"].items() for literal in literals), tuple(one["tests"]))
            for kind, ones in _source()["limits"].items() for one in ones]


def page() -> str:
    source, parts, kind = _source(), [], ""
    for one in limits():
        if one.kind != kind:
            kind = one.kind
            parts.append(f"\n### {kind}\n\n")
        scopes = "" if one.scopes == ("request",) else f" ({', '.join(one.scopes)})"
        tests = ", ".join(f"`{test}`" for test in one.tests)
        parts.append(textwrap.fill(f"- **{one.dimension}**{scopes}: {one.limit} ({tests})", 100, subsequent_indent="  ",
                                   break_long_words=False, break_on_hyphens=False) + "\n")
    return f"{source['before'].strip()}\n{''.join(parts)}\n{source['after'].strip()}\n"


def _source() -> dict:
    return tomllib.loads(SOURCE.read_text(encoding="utf-8"))
