"""Labels of body and support (ingest/body) on real scans and on phantoms with a known answer."""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from .. import paths
from ..bench import Result, result
from ..bench_scans import SHARED_SCANS, scans_of
from ..console import CliError, say

ABOUT = "what the labels of body and support keep and hide, on real scans and on phantoms, and how long they and the parts take"
PROGRAMS = ("diaphane-labels", "diaphane-sample")

LEAST_KEPT, LEAST_HIDDEN = 0.99, 0.95
MOST_OF_BUILD = 0.1
MOST_SECONDS = {"256 x 256 x 256": 0.3, "512 x 512 x 400": 1.5}
MOST_PARTS_SECONDS = {"256 x 256 x 256": 1.5, "512 x 512 x 400": 4.0}


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scans", type=Path, default=SHARED_SCANS,
                        help="folder of NIfTI files (default: %(default)s)")
    parser.add_argument("--also", type=Path, nargs="*", default=[], help="more files or DICOM folders")
    parser.add_argument("--slices", type=Path, help="write PNG slices with coloured labels to this folder")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    with tempfile.TemporaryDirectory() as made:
        scratch = Path(made)
        scans = [*scans_of(options.scans, scratch), *options.also]
        write = ["--write", made] if options.slices else []
        rows = _label(*write, "--phantoms", *([] if quick else ["--large"]), *map(str, scans))
        _print(rows)
        if options.slices:
            from .support.label_slices import write_slices

            options.slices.mkdir(parents=True, exist_ok=True)
            for row in rows:
                write_slices(row, scratch, options.slices)
            say(f"Slices: {options.slices}")
    return _results(rows)


def _label(*arguments: str) -> list[dict[str, Any]]:
    done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-labels"), *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise CliError(done.stderr.strip())
    return [json.loads(line) for line in done.stdout.splitlines()]


def _print(rows: list[dict[str, Any]]) -> None:
    width = max(len(row["name"]) for row in rows)
    say(f"{'':<{width}}  {'voxels':>15}  outside   body  support  metal   brain    bone   lungs airways vessels  label ms  brain ms  parts ms  build ms   kept  hidden")
    for row in rows:
        shares = " ".join(f"{100 * share:7.2f}" for share in row["shares"])
        build = f"{1000 * row['build_s']:9.0f}" if "build_s" in row else " " * 9
        found = f"{row['kept']:7.4f} {row['hidden']:7.4f}" if "kept" in row else ""
        size = " x ".join(map(str, row["size"]))
        say(f"{row['name']:<{width}}  {size:>15} {shares} {1000 * row['label_s']:9.0f} {1000 * row['brain_s']:9.0f} {1000 * row['parts_s']:9.0f} {build} {found}".rstrip())


def _results(rows: list[dict[str, Any]]) -> list[Result]:
    phantoms = [row for row in rows if "kept" in row]
    results = [result("phantoms: least share of a body that is kept", [min(row["kept"] for row in phantoms)], "", at_least=LEAST_KEPT),
               result("phantoms: least share of a support that is hidden", [min(row["hidden"] for row in phantoms)], "",
                      at_least=LEAST_HIDDEN)]
    for what, key, limits in (("time", "label_s", MOST_SECONDS), ("time to find parts", "parts_s", MOST_PARTS_SECONDS)):
        for size, limit in limits.items():
            results += [result(f"{what} for {size} voxels", [row[key]], "s", at_most=limit)
                        for row in phantoms if row["name"].endswith(size)]
    built = [row["label_s"] / row["build_s"] for row in rows if row.get("build_s", 0) > 0]
    if built:
        results.append(result("time, as a share of reading and building a real scan", built, "", at_most=MOST_OF_BUILD))
    return results
