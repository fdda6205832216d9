"""`./diaphane study`: analyses an export, or simulates one."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from . import export, figures, report, simulate
from .texts import LANGUAGES


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="./diaphane study", description="Analyses the export of a study, or simulates one.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    analyse = commands.add_parser("analyse", help="print the tables of an export and draw its figures")
    analyse.add_argument("export", type=Path, metavar="EXPORT", help="JSON export of a study")
    analyse.add_argument("--out", type=Path, metavar="FOLDER", help="write the figures (SVG and PNG) and results.json to this folder")
    analyse.add_argument("--language", choices=LANGUAGES, default="en")
    made = commands.add_parser("simulate", help="write the export of a simulated study whose answer is known")
    made.add_argument("kind", choices=sorted(simulate.CROWDS), metavar="KIND", help=", ".join(sorted(simulate.CROWDS)))
    made.add_argument("--participants", type=_participants, default=simulate.PARTICIPANTS, metavar="N", help="default: %(default)s")
    made.add_argument("--seed", type=int, default=1, metavar="N")
    made.add_argument("--out", type=Path, metavar="FILE", help="default: standard output")
    options = parser.parse_args(arguments)
    try:
        return _analyse(options) if options.command == "analyse" else _simulate(options)
    except (export.ExportError, OSError) as error:
        print(f"diaphane: {error}", file=sys.stderr)
        return 1


def _participants(text: str) -> int:
    number = int(text)
    if not 30 <= number <= 1000:
        raise argparse.ArgumentTypeError("not a number from 30 to 1000")
    return number


def _simulate(options: argparse.Namespace) -> int:
    text = json.dumps(simulate.CROWDS[options.kind](np.random.default_rng(options.seed), options.participants), ensure_ascii=False) + "\n"
    if options.out:
        options.out.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)
    return 0


def _analyse(options: argparse.Namespace) -> int:
    result = report.analyse(export.read(options.export), options.language)
    for section in result["sections"]:
        _print(section)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        for section in result["sections"]:
            for figure in section["figures"]:
                stem = f"{figure['id']}-{section['id']}" if section["id"].startswith("viewpoint-") else figure["id"]
                for kind in ("svg", "png"):
                    (options.out / f"{stem}.{kind}").write_bytes(figures.written(figure["svg"], kind))
        (options.out / "results.json").write_text(json.dumps(report.as_json(result), ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
        print(f"\n{options.out}")
    return 0


def _print(section: dict[str, Any]) -> None:
    print(f"\n{section['title']}\n{'=' * len(section['title'])}")
    for table in section["tables"]:
        lines = [table["columns"], *table["rows"]]
        widths = [max(len(line[i]) for line in lines) for i in range(len(table["columns"]))]
        print(f"\n{table['title']}")
        for line in lines:
            print("  " + "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip())
    for note in section["notes"]:
        print(f"\n{note}")


if __name__ == "__main__":
    sys.exit(main())
