"""Oblique slices and slabs of a worker, compared with a resampling by SciPy."""

from __future__ import annotations

import hashlib
import json
import sys

import harness
import numpy as np
import pytest
from stream_helpers import ClientMessage, Viewer, open_session, store_ball
from test_slices import AXIAL, CORONAL, values

sys.path.append(str(harness.REPO / ".tools" / "study-libraries"))  # after those of the tests
map_coordinates = pytest.importorskip("scipy.ndimage").map_coordinates

SIZE = (48, 48, 48)  # x, y, z
SPACING = np.array([0.7, 1.1, 2.3])
# A rotation, whose columns are the axes of the voxels.
DIRECTION = np.array([[0.8, -0.36, 0.48], [0.6, 0.48, -0.64], [0, 0.8, 0.6]])
MEAN, MAXIMUM, MINIMUM = 0, 1, 2
LEAST = -1000


@pytest.fixture(scope="module")
def scan(running, one) -> tuple[str, np.ndarray]:
    """A scan of noise with unequal spacing and oblique axes, with its voxels (z, y, x)."""
    data_set = store_ball(running, one)
    folder = running.data_dir / "volumes" / data_set
    voxels = np.random.default_rng(5).integers(LEAST, 3000, SIZE[::-1]).astype("<i2")
    voxels[0, 0, 0] = LEAST
    (folder / "voxels.i16").write_bytes(voxels.tobytes())
    header = json.loads((folder / "volume.json").read_text())
    assert header["size"] == list(SIZE)
    header.update(spacing=SPACING.tolist(), direction=DIRECTION.ravel().tolist(), minimum=LEAST, maximum=int(voxels.max()),
                  contentHash="blake2b:" + hashlib.blake2b(voxels.tobytes(), digest_size=32).hexdigest())
    (folder / "volume.json").write_text(json.dumps(header))
    return data_set, voxels


@pytest.fixture(scope="module")
def viewer(running, one, scan) -> Viewer:
    _, url = open_session(one, scan[0])
    opened = Viewer(running.url, url)
    opened.taken = 0
    yield opened
    opened.leave()


def slice_of(viewer: Viewer, message: ClientMessage):
    """Requests a slice and acknowledges it."""
    message.slices.taken = viewer.taken
    viewer.send(message)
    piece = viewer.until("slice")
    viewer.taken = piece.seq
    return piece


def direction(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns two perpendicular unit vectors."""
    basis, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 2)))
    return basis[:, 0], basis[:, 1]


def places_of(first: np.ndarray, right: np.ndarray, down: np.ndarray, columns: int, rows: int) -> np.ndarray:
    row, column = np.mgrid[:rows, :columns]
    return first + column[..., None] * right + row[..., None] * down


def reference(voxels: np.ndarray, places: np.ndarray, offsets: np.ndarray, projection: int) -> np.ndarray:
    """Interpolates at world places, shifted by each offset, and combines what lies inside the volume."""
    samples = []
    for offset in offsets:
        index = (places + offset) @ DIRECTION / SPACING + (np.array(SIZE) - 1) / 2
        inside = ((index >= -0.5) & (index <= np.array(SIZE) - 0.5)).all(axis=-1)
        found = map_coordinates(voxels.astype(float), np.moveaxis(index[..., ::-1], -1, 0), order=1, mode="nearest")
        samples.append(np.where(inside, found, np.nan))
    combine = {MEAN: np.nanmean, MAXIMUM: np.nanmax, MINIMUM: np.nanmin}[projection]
    whole = np.array(samples)
    empty = np.isnan(whole).all(axis=0)
    whole[:, empty] = LEAST
    return combine(whole, axis=0)


@pytest.mark.parametrize("thickness,projection", [(0, MEAN), (5, MEAN), (5, MAXIMUM), (5, MINIMUM), (0.2, MAXIMUM)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_oblique_slices_equal_a_resampling_by_scipy(viewer, scan, seed, thickness, projection):
    voxels = scan[1]
    right, down = (vector * step for vector, step in zip(direction(seed), (0.9, 1.3), strict=True))
    columns, rows = 90, 70
    # Off the centre, so that some pixels lie outside.
    first = -(columns - 1) / 2 * right - (rows - 1) / 2 * down + np.array([3.0, -2.0, 1.0])
    message = ClientMessage()
    oblique = message.slices.slices.add(plane=CORONAL).oblique
    oblique.id, oblique.columns, oblique.rows, oblique.thickness, oblique.projection = 77 + seed, columns, rows, thickness, projection
    for vector, to in ((first, oblique.first), (right, oblique.right), (down, oblique.down)):
        to.x, to.y, to.z = vector
    piece = slice_of(viewer, message)
    assert (piece.oblique, piece.plane, piece.columns, piece.rows) == (77 + seed, CORONAL, columns, rows)
    normal = np.cross(right, down)
    normal /= np.linalg.norm(normal)
    # Samples lie on both faces, and at most the smallest spacing apart.
    layers = 1 + int(np.ceil(thickness / SPACING.min() - 1e-9)) if thickness else 1
    offsets = np.linspace(-thickness / 2, thickness / 2, layers)[:, None] * normal if thickness else np.zeros((1, 3))
    expected = reference(voxels, places_of(first, right, down, columns, rows), offsets, projection)
    got = values(piece)
    assert 0.1 < (expected == LEAST).mean() < 0.9, "the plane lies inside and outside"
    # The worker rounds to whole numbers, and both compute positions with rounding errors far below 1e-3.
    assert np.abs(got - expected).max() <= 0.5 + 1e-3


@pytest.mark.parametrize("change", [
    {"columns": 0}, {"rows": 2049}, {"id": 0}, {"thickness": -1}, {"thickness": float("nan")}, {"thickness": 1e300},
    {"columns": 2048, "rows": 2048, "thickness": 30}, {"right": (0, 0, 0)}, {"right": (0, 1, 0)}, {"first": (float("inf"), 0, 0)}])
def test_an_invalid_oblique_slice_is_refused_and_the_session_continues(viewer, change):
    message = ClientMessage()
    oblique = message.slices.slices.add(plane=AXIAL).oblique
    asked = {"id": 1, "columns": 5, "rows": 5, "first": (0, 0, 0), "right": (1, 0, 0), "down": (0, 1, 0), "thickness": 0, **change}
    for name in ("id", "columns", "rows", "thickness"):
        setattr(oblique, name, asked[name])
    for name in ("first", "right", "down"):
        to = getattr(oblique, name)
        to.x, to.y, to.z = asked[name]
    viewer.send(message)
    refusal = viewer.until("problem")
    assert refusal.code == "invalid" and refusal.field.startswith("slices[0].oblique.") and not refusal.fatal
    message.Clear()
    message.slices.slices.add(plane=AXIAL, index=3)
    assert slice_of(viewer, message).index == 3
