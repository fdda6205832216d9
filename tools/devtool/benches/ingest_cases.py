"""The 25 cases of ingest and real files: the expected results, and those of the server and the browser."""

from __future__ import annotations

from .. import build
from ..bench import Result, result
from ..console import say

ABOUT = "every ingest case as generated files, each compared with its expected result"
PROGRAMS = ("diaphane-scan",)


def measure(quick: bool) -> list[Result]:
    from ..ingest_cases import real, run, table

    build.npm_install()
    rows = run.run([*table.CASES, *real.DISCS, *([] if quick else real.files())])
    for line in run.table(rows):
        say(line)
    good = sum(1 for row in rows if not row.faults)
    return [result("as expected, of all", [good], "rows", at_least=len(rows)),
            result("cases of the design", [len({row.case.number for row in rows} - {0})], "cases", at_least=25)]
