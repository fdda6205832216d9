"""The results of `diaphane-head` on samples, the part of the face that its cut leaves, and the table of all results."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable, Sequence

import numpy as np

from .. import paths
from ..console import CliError
from . import scan as scans
from .real import Face
from .scan import Scan
from .table import Sample


@dataclass(frozen=True)
class Judged:
    kind: str
    name: str
    is_head: bool | None
    found: bool
    sign: str
    seconds: float
    proposed: bool
    # share of the face's surface that the cut leaves; None: the face is unknown, or no cut was proposed
    face_left: float | None

    @property
    def wrong(self) -> bool:
        return self.is_head is not None and self.is_head != self.found


def judge(samples: Iterable[Sample], scratch: Path) -> list[Judged]:
    judged = []
    for sample in samples:
        folder = scans.write(sample.scan, scratch / "volume")
        done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-head"), str(folder)], capture_output=True, text=True)
        if done.returncode != 0:
            raise CliError(f"diaphane-head: {done.stderr.strip()}")
        result = json.loads(done.stdout)
        left = face_left(sample.scan, sample.face, result["proposal"]) if sample.face and result["proposal"] else None
        judged.append(Judged(sample.kind, sample.name, sample.is_head, result["found"], result["sign"], result["seconds"],
                             result["proposal"] is not None, left))
        shutil.rmtree(folder)
    return judged


def face_surface(scan: Scan, face: Face) -> np.ndarray:
    """Returns the outermost voxels of the body as seen from the front, from the chin to the brow and in front of the ears, as (n,
    3) in world space. A face that was rotated with its scan is measured in its rotated position."""
    upright = _own_axes(scan)
    at = scans.places(upright)
    matter = scan.voxels > (-300 if scan.modality == "CT" else 0.15 * np.percentile(scan.voxels, 99.5))
    # Three consecutive voxels are skin. Fewer are noise.
    front = matter if at[0, 0, 0, 1] < at[0, -1, 0, 1] else matter[:, ::-1]
    solid = front.copy()
    for step in (1, 2):
        solid[:, :-step] &= front[:, step:]
    first = solid.argmax(1)
    if front is not matter:
        first = matter.shape[1] - 1 - first
    z, x = np.nonzero(solid.any(1))
    y = first[z, x]
    own = at[z, y, x]
    there = (own[:, 2] >= face.chin) & (own[:, 2] <= face.brow) & (own[:, 1] < face.ears)
    return scans.places(scan)[z[there], y[there], x[there]]


def _own_axes(scan: Scan) -> Scan:
    """Returns the scan without rotation: its axes become the nearest of the patient's."""
    nearest = np.zeros((3, 3))
    for column in range(3):
        row = int(np.argmax(np.abs(scan.direction[:, column])))
        nearest[row, column] = np.sign(scan.direction[row, column])
    return Scan(scan.voxels, scan.spacing, nearest, scan.modality)


def face_left(scan: Scan, face: Face, proposal: dict) -> float:
    skin = face_surface(scan, face)
    kept = np.ones(len(skin), bool)
    for plane in proposal["planes"]:
        kept &= (skin - np.array(plane["point"])) @ np.array(plane["normal"]) <= 0
    return float(kept.mean())


def wilson(hits: int, of: int) -> tuple[float, float]:
    """Returns the 95% interval of a share (Wilson 1927)."""
    if of == 0:
        return 0.0, 1.0
    z, p = 1.96, hits / of
    middle = (p + z * z / (2 * of)) / (1 + z * z / of)
    half = z * math.sqrt(p * (1 - p) / of + z * z / (4 * of * of)) / (1 + z * z / of)
    return max(0.0, middle - half), min(1.0, middle + half)


@dataclass(frozen=True)
class Share:
    """The share of the samples of one kind that got the right answer."""

    kind: str
    is_head: bool | None
    n: int
    said_head: int

    @property
    def right(self) -> int | None:
        return None if self.is_head is None else self.said_head if self.is_head else self.n - self.said_head

    def words(self) -> str:
        if self.right is None:
            return "not counted"
        low, high = wilson(self.right, self.n)
        name = "sensitivity" if self.is_head else "specificity"
        return f"{name} {self.right / self.n:.2f} ({low:.2f} to {high:.2f})"


def shares(judged: Sequence[Judged]) -> list[Share]:
    kinds = dict.fromkeys((one.kind, one.is_head) for one in judged)
    return [share(kind, is_head, [one for one in judged if (one.kind, one.is_head) == (kind, is_head)]) for kind, is_head in kinds]


def share(kind: str, is_head: bool | None, judged: Sequence[Judged]) -> Share:
    return Share(kind, is_head, len(judged), sum(one.found for one in judged))


def table(rows: Sequence[Share]) -> list[str]:
    lines = [("", "n", "head", "none", "")]
    lines += [(row.kind, str(row.n), str(row.said_head), str(row.n - row.said_head), row.words()) for row in rows]
    widths = [max(len(line[i]) for line in lines) for i in range(4)]
    return ["  ".join([line[0].ljust(widths[0]), *(line[i].rjust(widths[i]) for i in (1, 2, 3)), line[4]]).rstrip() for line in lines]
