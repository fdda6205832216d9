"""The results of the server and the browser for a folder of files, in the terms of the table."""

from __future__ import annotations

import json
import subprocess
import tarfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import paths, venv
from ..console import CliError
from .phantom import Values


@dataclass(frozen=True)
class Judged:
    """The result for a folder. `outcome` is "built", "refused: code" or "not listed", or for
    several series that of joined()."""

    outcome: str
    words: str                      # repairs, or the reason for a refusal
    volume: "Volume | None" = None


def joined(outcomes: list[str]) -> str:
    """Joins outcomes in sorted order, independent of the order of the series: "2 x built + refused: scout"."""
    counted = sorted(Counter(outcomes).items())
    return " + ".join(outcome if n == 1 else f"{n} x {outcome}" for outcome, n in counted)


@dataclass(frozen=True)
class Volume:
    phases: np.ndarray              # phase, z, y, x
    spacing: np.ndarray             # mm, x, y, z
    direction: np.ndarray           # 3 x 3, columns are the axes
    origin: np.ndarray              # mm, the centre of the first voxel

    @property
    def voxels(self) -> np.ndarray:
        """Returns the voxels of the first phase."""
        return self.phases[0]

    def places(self) -> np.ndarray:
        """Returns the position of every voxel in mm."""
        z, y, x = np.meshgrid(*(np.arange(n) for n in self.voxels.shape), indexing="ij")
        index = np.stack([x, y, z], -1) * self.spacing
        return self.origin + index @ self.direction.T

    def worst_error(self, truth: Values, unit: float, air: int) -> float:
        """Returns the largest difference of any phase from the phantom, in its values, over the voxels that are not
        air."""
        expected_values = truth(self.places()) / unit
        there = self.phases != air
        if there.mean() < 0.2:
            return float("inf")
        return float(np.abs(self.phases - expected_values)[there].max()) * unit

    def marker(self, near: np.ndarray, radius: float) -> np.ndarray:
        """Returns the centre of the ball near a place in mm, weighted by the excess over air."""
        places = self.places()
        weight = np.clip(self.voxels + 1000.0, 0, None) * (np.linalg.norm(places - near, axis=-1) < radius)
        return (places * weight[..., None]).sum((0, 1, 2)) / max(weight.sum(), 1e-9)


def on_server(folder: Path, scratch: Path, *options: str) -> Judged:
    """Returns the result of `diaphane-scan`, which judges and builds like ingestd."""
    target = scratch / "volume"
    done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-scan"), str(folder), "--json", "--build", str(target),
                           *options], capture_output=True, text=True)
    if done.returncode not in (0, 65):
        raise CliError(f"diaphane-scan failed: {done.stderr.strip()}")
    found = json.loads(done.stdout)
    series = sorted(found["series"], key=lambda one: not one["suitable"])
    if not series:
        return Judged("not listed" if found["upload"]["code"] == "no_slices" else f"refused: {found['upload']['code']}",
                      found["upload"]["text"])
    outcome = joined(["built" if one["suitable"] else f"refused: {one['reason']['code']}" for one in series])
    words = [text for one in series for text in (one["repairs"] if one["suitable"] else [one["reason"]["text"]])]
    words += [text for text in found["upload"]["repairs"] if text not in words]
    if done.returncode == 65 or not series[0]["suitable"]:
        return Judged(outcome if not series[0]["suitable"] else f"not built: {done.stderr.strip()}", "; ".join(words))
    return Judged(outcome, "; ".join(words), _read(target, series))


def _read(target: Path, series: list[dict]) -> Volume:
    header = json.loads((target / "volume.json").read_text())
    size = tuple(header["size"])
    built = max((one for one in series if one["suitable"]), key=lambda one: one["slices"])
    phases = np.fromfile(target / "voxels.i16", "<i2").reshape(max(1, len(header.get("phases", []))), *size[::-1])
    return Volume(phases, np.array(built["spacing_mm"]), np.array(built["direction"]).reshape(3, 3),
                  np.array(built["origin_mm"]))


def in_browser(folders: list[Path], out: Path) -> list[Judged]:
    """Returns the results of the page's own scanner (frontend/src/scan), which Node runs on the
    files of each folder. For a folder with a suitable series, out/<number> contains what the
    page would send, unpacked."""
    script = paths.FRONTEND / "dev" / "judge_folders.mjs"
    out.mkdir()
    done = subprocess.run([str(venv.ensure_node() / "node"), str(script), str(out), *map(str, folders)], cwd=paths.FRONTEND,
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise CliError(f"the page's scanner failed: {done.stderr.strip()}")
    for bundle in out.glob("*.tar"):
        (out / bundle.stem).mkdir()
        with tarfile.open(bundle) as tar:
            for member in tar:
                (out / bundle.stem / member.name).write_bytes(tar.extractfile(member).read())
    return [Judged(joined(one["outcomes"]), one["words"]) for one in json.loads(done.stdout)]
