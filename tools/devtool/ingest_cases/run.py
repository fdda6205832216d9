"""Creates each case, obtains its results, and compares them with the table."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

from .judge import Judged, in_browser, on_server
from .table import ANY_BUT_BUILT, CASES, Case


@dataclass(frozen=True)
class Row:
    case: Case
    server: Judged
    browser: Judged
    faults: tuple[str, ...]         # empty if the results are as expected


def run(cases: Sequence[Case] = tuple(CASES)) -> list[Row]:
    with tempfile.TemporaryDirectory() as scratch:
        folders = [Path(scratch) / f"{i:03d}" for i in range(len(cases))]
        for case, folder in zip(cases, folders):
            case.make(folder / "disc")
        sent = Path(scratch) / "sent"
        browsers = in_browser([folder / "disc" for folder in folders], sent)
        rows = []
        for i, (case, folder, browser) in enumerate(zip(cases, folders, browsers)):
            server = on_server(folder / "disc", folder, *case.options)
            faults = [*_of_server(case, server), *_of_browser(case, browser)]
            if server.volume is not None and "built" in browser.outcome:
                faults += _of_sent(case, server, on_server(sent / str(i), sent / str(i)))
            rows.append(Row(case, server, browser, tuple(faults)))
    return rows


def _of_server(case: Case, server: Judged) -> list[str]:
    if not _matches(case.expected, server.outcome):
        return [f"the server: {server.outcome} ({server.words})"]
    if case.says not in server.words:
        return [f"the server says: {server.words}"]
    return _off(case, server)


def _matches(expected: str, outcome: str) -> bool:
    return "built" not in outcome if expected == ANY_BUT_BUILT else outcome == expected


def _off(case: Case, server: Judged) -> list[str]:
    if server.volume is None:
        return []
    if wrong := case.check(server.volume):
        return [wrong]
    if case.truth is None:
        return []
    error = server.volume.worst_error(case.truth, case.unit, case.air)
    return [] if error <= case.tolerance else [f"a voxel is {error:.1f} off the phantom, more than {case.tolerance}"]


def _of_browser(case: Case, browser: Judged) -> list[str]:
    expected = case.expected if case.browser is None else case.browser
    return [] if _matches(expected, browser.outcome) else [f"the browser: {browser.outcome}, not {expected} ({browser.words})"]


def _of_sent(case: Case, server: Judged, sent: Judged) -> list[str]:
    """Checks that the files that the page sends of the first series, without names, give the same volume as the disc."""
    if sent.outcome != "built" or sent.volume is None:
        return [f"what the page sends: {sent.outcome} ({sent.words})"]
    if case.expected == "built" and sent.volume.voxels.shape != server.volume.voxels.shape:
        return ["what the page sends becomes a volume of another size"]
    return [f"what the page sends: {fault}" for fault in _off(case, sent)]


def table(rows: Sequence[Row]) -> list[str]:
    """Returns one line per case: case | expected | got."""
    def got(row: Row) -> str:
        text = row.server.outcome
        if row.browser.outcome != row.server.outcome:
            text += f"; browser: {row.browser.outcome}"
        return text if not row.faults else "MISS: " + "; ".join(row.faults)

    lines = [("case", "", "expected", "got", "in words")]
    lines += [(str(row.case.number or "real"), row.case.name, row.case.expected, got(row), row.server.words) for row in rows]
    widths = [max(len(line[i]) for line in lines) for i in range(3)]
    widths.append(max(len(line[3]) for line, row in zip(lines[1:], rows) if not row.faults) if rows else 0)
    return [" | ".join(text.ljust(width) for text, width in zip(line, [*widths, 0])).rstrip() for line in lines]
