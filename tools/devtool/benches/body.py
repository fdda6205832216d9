"""Labels of body and support (ingest/body) on real scans and on phantoms with a known answer."""

from __future__ import annotations

import argparse
import gzip
import json
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from .. import paths
from ..bench import Result, result
from ..bench_volumes import CRANIUM
from ..console import CliError, say

ABOUT = "what the labels of body and support keep and hide, on real scans and on phantoms, and how long they take"
PROGRAMS = ("diaphane-labels", "diaphane-sample")

CH2 = Path("/usr/share/mricron/templates/ch2.nii.gz")     # Debian's mricron-data
LEAST_KEPT, LEAST_HIDDEN = 0.99, 0.95
MOST_OF_BUILD = 0.1
MOST_SECONDS = {"256 x 256 x 256": 0.3, "512 x 512 x 400": 1.5}


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scans", type=Path, default=paths.REPO.parent / "shared" / "scans",
                        help="folder of NIfTI files (default: %(default)s)")
    parser.add_argument("--also", type=Path, nargs="*", default=[], help="more files or DICOM folders")
    parser.add_argument("--slices", type=Path, help="write PNG slices with coloured labels to this folder")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    with tempfile.TemporaryDirectory() as made:
        scratch = Path(made)
        scans = [*_scans(options.scans, scratch), *options.also]
        write = ["--write", made] if options.slices else []
        rows = _label(*write, "--phantoms", *([] if quick else ["--large"]), *map(str, scans))
        _print(rows)
        if options.slices:
            from ..label_slices import write_slices

            options.slices.mkdir(parents=True, exist_ok=True)
            for row in rows:
                write_slices(row, scratch, options.slices)
            say(f"Slices: {options.slices}")
    return _results(rows)


def _scans(folder: Path, scratch: Path) -> list[Path]:
    found: list[Path] = []
    if not folder.is_dir():
        say(f"skipped: the scans of {folder}, which does not exist")
    for file in sorted(folder.glob("*.nii.gz")):
        found.append(_first_moment(file, scratch))
    if CRANIUM.exists():
        target = scratch / "cranium"
        subprocess.run([str(paths.build_dir() / "bin" / "diaphane-sample"), f"--write-dicom={target}"], check=True,
                       stdout=subprocess.DEVNULL)
        found.append(target)
    else:
        say("skipped: cranium (install Debian's invesalius-examples)")
    if CH2.exists():
        found.append(CH2)
    else:
        say("skipped: ch2 (install Debian's mricron-data)")
    return found


def _first_moment(file: Path, scratch: Path) -> Path:
    """Returns the file, or the first volume of a time series as a new file."""
    data = bytearray(gzip.decompress(file.read_bytes()))
    dimensions = struct.unpack_from("<8h", data, 40)
    if dimensions[0] <= 3:
        return file
    start, bits = int(struct.unpack_from("<f", data, 108)[0]), struct.unpack_from("<h", data, 72)[0]
    size = dimensions[1] * dimensions[2] * dimensions[3] * bits // 8
    struct.pack_into("<8h", data, 40, 3, *dimensions[1:4], 1, 1, 1, 1)
    first = scratch / file.name
    first.write_bytes(gzip.compress(bytes(data[:start + size])))
    return first


def _label(*arguments: str) -> list[dict[str, Any]]:
    done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-labels"), *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise CliError(done.stderr.strip())
    return [json.loads(line) for line in done.stdout.splitlines()]


def _print(rows: list[dict[str, Any]]) -> None:
    width = max(len(row["name"]) for row in rows)
    say(f"{'':<{width}}  {'voxels':>15}  outside   body  support  metal  label ms  build ms   kept  hidden")
    for row in rows:
        shares = " ".join(f"{100 * share:7.2f}" for share in row["shares"])
        build = f"{1000 * row['build_s']:9.0f}" if "build_s" in row else " " * 9
        found = f"{row['kept']:7.4f} {row['hidden']:7.4f}" if "kept" in row else ""
        size = " x ".join(map(str, row["size"]))
        say(f"{row['name']:<{width}}  {size:>15} {shares} {1000 * row['label_s']:9.0f} {build} {found}".rstrip())


def _results(rows: list[dict[str, Any]]) -> list[Result]:
    phantoms = [row for row in rows if "kept" in row]
    results = [result("phantoms: least share of a body that is kept", [min(row["kept"] for row in phantoms)], "", at_least=LEAST_KEPT),
               result("phantoms: least share of a support that is hidden", [min(row["hidden"] for row in phantoms)], "",
                      at_least=LEAST_HIDDEN)]
    for size, limit in MOST_SECONDS.items():
        results += [result(f"time for {size} voxels", [row["label_s"]], "s", at_most=limit)
                    for row in phantoms if row["name"].endswith(size)]
    built = [row["label_s"] / row["build_s"] for row in rows if row.get("build_s", 0) > 0]
    if built:
        results.append(result("time, as a share of reading and building a real scan", built, "", at_most=MOST_OF_BUILD))
    return results
