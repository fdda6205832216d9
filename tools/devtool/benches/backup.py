"""Backups: how long they take, which bounds what a failure loses, and how long it takes until a lost installation shows pictures
again."""

from __future__ import annotations

import secrets
import shutil
import subprocess
import time
import uuid
from pathlib import Path

from .. import backup, ports, supervise
from ..bench import Result, result
from ..bench_stack import folder, prepared
from ..stack import Stack
from ..users import RunAs, ordinary_user

ABOUT = "time for the first backup, for the next one with one new scan, and from a restore to the first picture"

SCANS, QUICK_SCANS = 20, 3
_PATIENCE = 300.0


def measure(quick: bool) -> list[Result]:
    import httpx

    times: dict[str, list[float]] = {"first backup": [], "next backup, with one new scan": [], "from the restore to the first picture": []}
    run_as = ordinary_user()
    scans, scan_bytes = QUICK_SCANS if quick else SCANS, 0
    for _ in range(1 if quick else 3):
        with folder(run_as) as base:
            place, key = base / "backups", base / "key"
            for path in (place, base / "other"):
                path.mkdir()
                run_as.own(path)
            key.write_text(secrets.token_hex(32), encoding="ascii")
            run_as.own(key)
            source = prepared(base)
            with source:
                supervise.load_sample(source)
                [sample] = _rows(source, "SELECT id FROM data_sets WHERE state = 'ready' LIMIT 1")
                scan_bytes = sum(path.stat().st_size for path in (source.data / "volumes" / sample).rglob("*") if path.is_file())
                for _ in range(scans - 1):
                    _copy(source, sample, run_as)
                times["first backup"].append(_run(source, "save", place, key, run_as))
                _copy(source, sample, run_as)
                times["next backup, with one new scan"].append(_run(source, "save", place, key, run_as))
            ports.give_back(source.ports.values())
            began = time.monotonic()
            with prepared(base / "other", only=("postgres",)) as empty:
                _run(empty, "restore", place, key, run_as)
            ports.give_back(empty.ports.values())
            with prepared(base / "other") as restored:
                picture = f"{restored.settings.url}/v1/data-sets/{sample}/thumbnails/bone"
                while httpx.get(picture, trust_env=False, timeout=30).status_code != 200:
                    assert time.monotonic() < began + _PATIENCE, "no picture"
                    time.sleep(0.1)
                times["from the restore to the first picture"].append(time.monotonic() - began)
            ports.give_back(restored.ports.values())
    size = f"{scans} scans of {scan_bytes / 1e6:.0f} MB"
    return [result(f"{name}, {size}", taken, "s") for name, taken in times.items()]


def _run(stack: Stack, command: str, place: Path, key: Path, run_as: RunAs) -> float:
    began = time.monotonic()
    code = backup.run_package([command], stack.layout.backup, stack.data, str(place), key, stack.settings.dsn, run_as)
    assert code == 0, f"{command} failed"
    return time.monotonic() - began


def _copy(stack: Stack, scan: str, run_as: RunAs) -> None:
    """Adds a scan like the first one, but with other noise, so that nothing is stored only once."""
    import numpy as np

    made = str(uuid.uuid4())
    volumes = stack.data / "volumes"
    shutil.copytree(volumes / scan, volumes / made)
    rng = np.random.default_rng(int(made[:8], 16))
    for path in (volumes / made).rglob("*"):
        if path.is_file() and path.stat().st_size > 1 << 20:
            voxels = np.fromfile(path, np.uint8)
            voxels[::2] ^= rng.integers(0, 8, len(voxels[::2]), np.uint8)
            voxels.tofile(path)
    if run_as.uid >= 0:
        subprocess.run(["chown", "-R", f"{run_as.uid}:{run_as.gid}", volumes / made], check=True)
    columns = _rows(stack, "SELECT column_name FROM information_schema.columns WHERE table_name = 'data_sets' AND is_generated = 'NEVER' AND column_name <> 'id'")
    named = ", ".join(f'"{name}"' for name in columns)
    _rows(stack, f"INSERT INTO data_sets (id, {named}) SELECT '{made}', {named} FROM data_sets WHERE id = '{scan}' RETURNING id")


def _rows(stack: Stack, query: str) -> list[str]:
    import psycopg

    with psycopg.connect(stack.settings.dsn, autocommit=True) as database:
        return [str(row[0]) for row in database.execute(query).fetchall()]
