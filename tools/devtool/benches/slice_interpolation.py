"""How well slices are interpolated (volume/slice_interpolation) where a scan has only every third of its slices."""

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

ABOUT = "the error of interpolated slices: along the motion between slices, as pictures show them, and straight across"
PROGRAMS = ("diaphane-slice-error", "diaphane-sample")

LEAST_SLICES = 30   # with fewer, a third of them shows too little of the anatomy


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scans", type=Path, default=SHARED_SCANS, help="folder of NIfTI files (default: %(default)s)")


def measure(_quick: bool, options: argparse.Namespace) -> list[Result]:
    with tempfile.TemporaryDirectory() as made:
        scans = scans_of(options.scans, Path(made))
        done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-slice-error"), *map(str, scans)], capture_output=True,
                              text=True)
        if done.returncode != 0:
            raise CliError(done.stderr.strip())
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    _print(rows)
    return [result(f"{row['name']}: error along the motion / straight across", [row["along_motion"] / row["linear"]], "", at_most=1)
            for row in rows if row["size"][2] >= LEAST_SLICES]


def _print(rows: list[dict[str, Any]]) -> None:
    width = max(len(row["name"]) for row in rows)
    say(f"{'':<{width}}  {'voxels':>15}  spacing mm         straight    cubic  along the motion       s")
    for row in rows:
        size, spacing = " x ".join(map(str, row["size"])), " ".join(f"{mm:.2f}" for mm in row["spacing"])
        say(f"{row['name']:<{width}}  {size:>15}  {spacing:<17} {row['linear']:9.2f} {row['cubic']:8.2f} {row['along_motion']:17.2f}"
            f" {row['seconds']:7.2f}")
