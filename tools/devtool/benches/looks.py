"""Renders every preset of every scan and measures faults of the pictures: burnt-out or black areas, and subjects that fill
too little or too much of the picture."""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from .. import paths
from ..bench import Result, result
from ..bench_scans import SHARED_SCANS, scans_of
from ..console import CliError, say

if TYPE_CHECKING:
    import numpy as np

    from .support.picture_judge import Judged

ABOUT = "pictures of all presets of all scans at 1 s, at 5 s and finished, checked for burnt-out and black areas and for framing"
PROGRAMS = ("diaphane-render", "diaphane-sample")

STAGES = {"1s": ("--seconds", "1", "--denoise"), "5s": ("--seconds", "5", "--denoise"), "finished": ("--error", "0.02", "--seconds", "60")}


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scans", type=Path, default=SHARED_SCANS, help="folder of NIfTI files (default: %(default)s)")
    parser.add_argument("--also", type=Path, nargs="*", default=[], help="more files, DICOM folders or folders of the volume store")
    parser.add_argument("--size", type=int, default=360, help="width and height of the pictures (default: %(default)s)")
    parser.add_argument("--engine", choices=("auto", "cpu", "cuda"), default="auto", help="engine of the renderer (default: auto)")
    parser.add_argument("--out", type=Path, default=paths.REPO / "out" / "looks",
                        help="folder for a sheet per scan and looks.json (default: %(default)s)")


def measure(quick: bool, options: argparse.Namespace) -> list[Result]:
    import numpy as np

    from PIL import Image

    from .support.picture_judge import judge

    options.out.mkdir(parents=True, exist_ok=True)
    stages = {"finished": ("--samples", "4")} if quick else STAGES
    size = 96 if quick else options.size
    judged: list[Judged] = []
    with tempfile.TemporaryDirectory() as made:
        scratch = Path(made)
        scans = [*scans_of(options.scans, scratch), *options.also]
        for scan in scans[:1] if quick else scans:
            name, rows = scan.name.split(".")[0], []
            for preset in _render(scan, "--list-presets").split():
                common = ("--preset", preset, "--size", f"{size}x{size}", "--engine", options.engine, "--quiet")
                row = [_picture(scratch, scan, *common, *stop) for stop in stages.values()]
                subject = _subject(scratch, scan, *common)
                judged.append(judge(name, preset, row[-1], subject))
                say(f"{name:<28} {preset:<8} {', '.join(judged[-1].faults()) or 'in order'}")
                rows.append(np.concatenate(row, axis=1))
            Image.fromarray(np.concatenate(rows, axis=0)).save(options.out / f"{name}.png")
    (options.out / "looks.json").write_text(json.dumps([asdict(one) for one in judged], indent=1) + "\n", encoding="utf-8")
    say(f"Sheets, with columns {', '.join(stages)}: {options.out}")
    return [result("pictures", [len(judged)], ""), result("pictures with a fault", [sum(bool(one.faults()) for one in judged)], "", at_most=0)]


def _render(*arguments: object) -> str:
    done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-render"), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise CliError(done.stderr.strip())
    return done.stdout


def _picture(scratch: Path, scan: Path, *arguments: str) -> np.ndarray:
    import numpy as np
    from PIL import Image

    file = scratch / "picture.ppm"
    _render(scan, *arguments, "--out", file)
    return np.asarray(Image.open(file))


def _subject(scratch: Path, scan: Path, *arguments: str) -> np.ndarray:
    """Returns where the scan is, from linear radiance."""
    from .support.picture_judge import read_exr, subject_in

    file = scratch / "picture.exr"
    _render(scan, *arguments, "--samples", "16", "--out", file)
    return subject_in(read_exr(file))
