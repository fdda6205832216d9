"""ingestd aligns two stored scans: the motion that it finds, why it refuses, and what it does with a row of a scan that is gone."""

from __future__ import annotations

import math

import nibabel
import numpy as np
import pytest
from ingest_helpers import enqueue, wait_end
from seeds import bundle

SPACING = 4.0


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "ingestd"))
    yield stack
    all_stacks.shut(stack)


def turned(degrees: float, shift: tuple[float, float, float]) -> np.ndarray:
    """A turn about z and a shift, in RAS."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    motion = np.eye(4)
    motion[:2, :2] = [[c, -s], [s, c]]
    motion[:3, 3] = shift
    return motion


def head(values: tuple[int, ...], motion: np.ndarray, seed: int) -> bytes:
    """A head without symmetry, scanned at its place and then moved with its scanner, so that its voxels stay the same apart from
    noise. The values are those of air, scalp, skull, brain and two kernels."""
    shape = (44, 52, 46)
    x, y, z = (SPACING * (axis - n / 2) for axis, n in zip(np.meshgrid(*map(np.arange, shape), indexing="ij"), shape))
    inside = lambda a, b, c, cx=0.0, cy=0.0, cz=0.0: ((x - cx) / a) ** 2 + ((y - cy) / b) ** 2 + ((z - cz) / c) ** 2 < 1
    voxels = np.full(shape, values[0], np.float64)
    for value, where in zip(values[1:], (inside(70, 85, 78), inside(64, 79, 72), inside(57, 72, 65), inside(14, 20, 12, 22, 30, 18),
                                         inside(10, 26, 9, -20, -12, 25))):
        voxels[where] = value
    voxels += np.random.default_rng(seed).normal(0, 4, shape)
    place = np.diag([SPACING, SPACING, SPACING, 1])
    place[:3, 3] = [-SPACING * n / 2 for n in shape]
    image = nibabel.Nifti1Image(voxels.astype(np.int16), motion @ place)
    return image.to_bytes()


def stored(running, image: bytes) -> str:
    scan = enqueue(running, bundle([image]))
    assert wait_end(running, scan)[0] == "ready"
    return scan


def align(running, fixed: str, moving: str) -> dict:
    running.psql("INSERT INTO alignments (fixed, moving) VALUES (%s, %s)", fixed, moving)

    def ended() -> dict | None:
        state, matrix, residual, overlap, reason, leased = running.psql(
            "SELECT state, matrix, residual_mm, overlap, reason, leased_by FROM alignments WHERE fixed = %s AND moving = %s", fixed, moving)[0]
        if state in ("waiting", "running"):
            return None
        assert leased is None
        return {"state": state, "matrix": matrix, "residual_mm": residual, "overlap": overlap, "reason": reason}
    return running.wait_until(ended, 240, "the alignment")


CT = (-1000, 20, 900, 40, 60, 5)
MR = (0, 300, 30, 430, 520, 60)


def test_scans_of_two_kinds_are_aligned(running):
    motion = turned(9, (18, -12, 25))
    fixed, moving = stored(running, head(CT, np.eye(4), 1)), stored(running, head(MR, motion, 2))
    found = align(running, fixed, moving)
    assert (found["state"], found["reason"]) == ("ready", None)
    assert found["overlap"] > 0.95
    assert 0 < found["residual_mm"] < SPACING / 2
    # The matrix maps places (LPS) of the moving scan to those of the fixed one. All places of the head are met to half a voxel.
    flip = np.diag([-1, -1, 1, 1])
    matrix = np.array(found["matrix"]).reshape(4, 4)
    places = np.vstack([np.random.default_rng(3).uniform(-60, 60, (3, 200)), np.ones(200)])
    off = np.linalg.norm((matrix @ flip @ motion @ places - flip @ places)[:3], axis=0)
    assert off.max() < SPACING / 2


def test_what_cannot_be_aligned_fails_with_a_reason(running):
    noise = np.random.default_rng(5).normal(0, 200, (40, 40, 40)).astype(np.int16)
    fixed = stored(running, head(CT, np.eye(4), 1))
    moving = stored(running, nibabel.Nifti1Image(noise, np.diag([SPACING, SPACING, SPACING, 1])).to_bytes())
    found = align(running, fixed, moving)
    # Noise has no best place, so the search may also drift until the scans hardly meet.
    assert (found["state"], found["matrix"]) == ("failed", None)
    assert found["reason"] in ("not_converged", "little_overlap")


def test_a_scan_whose_volume_is_missing_fails_alone(running):
    fixed, moving = stored(running, head(CT, np.eye(4), 1)), stored(running, head(CT, np.eye(4), 7))
    (running.data_dir / "volumes" / moving / "volume.json").unlink()
    assert align(running, fixed, moving)["reason"] == "internal"
    assert align(running, fixed, stored(running, head(CT, np.eye(4), 8)))["state"] == "ready"
