"""The built files that are needed to run, and a copy of them if the ordinary user cannot access the checkout."""

from __future__ import annotations

import hashlib
import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from . import paths
from .users import RunAs


@dataclass(frozen=True)
class Layout:
    """Read-only inputs of the programs."""

    bin: Path
    static: Path
    migrations: Path
    edge: Path
    studies: Path = Path("studies")                    # the package of the analysis, and its libraries if they are installed
    study_libraries: Path = Path("study-libraries")
    pacs: Path = Path("pacs")                          # the PACS gateway, its libraries if they are installed, and the Python client
    pacs_libraries: Path = Path("pacs-libraries")
    client: Path = Path("src")
    backup: Path = Path("backup")

    def all(self) -> list[Path]:
        return [self.bin, self.static, self.migrations, self.edge, self.studies, self.study_libraries, self.pacs, self.pacs_libraries, self.client, self.backup]


def of_checkout() -> Layout:
    return Layout(
        bin=paths.build_dir() / "bin",
        static=paths.FRONTEND / "dist",
        migrations=paths.REPO / "migrations",
        edge=paths.REPO / "api" / "edge",
        studies=paths.REPO / "studies",
        study_libraries=paths.REPO / ".tools" / "study-libraries",
        pacs=paths.REPO / "pacs",
        pacs_libraries=paths.REPO / ".tools" / "pacs-libraries",
        client=paths.REPO / "clients" / "python" / "src",
        backup=paths.REPO / "backup",
    )


def copy_folder() -> Path:
    """Returns where root keeps the copy of this checkout, which only root may change."""
    name = hashlib.sha256(str(paths.REPO).encode()).hexdigest()[:12]
    return Path("/var/cache/diaphane") / name


def reachable(run_as: RunAs, copy_to: Path) -> Layout:
    """Returns the checkout itself, or a copy below `copy_to` if `run_as` has no access to the checkout."""
    here = of_checkout()
    inside = [path for folder in here.all() if folder.is_dir() for path in _some_files(folder)]
    if run_as.can_read(*inside):
        return here
    copy_to.mkdir(mode=0o755, parents=True, exist_ok=True)
    copied = Layout(*(copy_to / folder.name for folder in here.all()))
    for source, target in zip(here.all(), copied.all()):
        if source.is_dir():
            _mirror(source, target)
    return copied


def copy_study_libraries(into: Path) -> None:
    """Copies the libraries of the analysis to where the programs find them, if that is not the checkout."""
    source = of_checkout().study_libraries
    if into != source:
        _mirror(source, into)


def _some_files(folder: Path) -> list[Path]:
    return [folder, *sorted(p for p in folder.iterdir() if p.is_file())[:3]]


def _mirror(source: Path, target: Path) -> None:
    """Copies changed files and removes deleted ones. Excludes tests, which are large and never run from the copy."""
    target.mkdir(mode=0o755, exist_ok=True)
    needed = {p.name for p in source.iterdir() if not p.name.endswith("_test")}
    for stale in target.iterdir():
        if stale.name not in needed:
            shutil.rmtree(stale) if stale.is_dir() else stale.unlink()
    for name in sorted(needed):
        one, other = source / name, target / name
        if one.is_dir():
            _mirror(one, other)
        elif not _same(one, other):
            # The copy is written to a temporary file and renamed, so that a program running from
            # the old file is not disturbed.
            beside = other.with_name(f".new-{name}")
            shutil.copy2(one, beside)
            os.chmod(beside, 0o755 if os.access(one, os.X_OK) else 0o644)
            os.replace(beside, other)


def _same(one: Path, other: Path) -> bool:
    if not other.exists():
        return False
    a, b = one.stat(), other.stat()
    return (a.st_size, int(a.st_mtime)) == (b.st_size, int(b.st_mtime))
