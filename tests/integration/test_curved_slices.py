"""Curved slices of a worker, compared with an independent curve and a resampling by SciPy."""

from __future__ import annotations

import hashlib
import json
import sys

import harness
import numpy as np
import pytest
from curve_reference import CurveReference
from stream_helpers import ClientMessage, Viewer, open_session, store_ball
from test_slices import values

sys.path.append(str(harness.REPO / ".tools" / "study-libraries"))  # after those of the tests
map_coordinates = pytest.importorskip("scipy.ndimage").map_coordinates

SIZE = (48, 48, 48)  # x, y, z
SPACING = np.array([0.7, 1.1, 2.3])
# A rotation, whose columns are the axes of the voxels.
DIRECTION = np.array([[0.8, -0.36, 0.48], [0.6, 0.48, -0.64], [0, 0.8, 0.6]])
MEAN, MAXIMUM, MINIMUM = 0, 1, 2
LEAST = -1000
POINTS = np.array([[-16.0, -9, -20], [-6, 8, -9], [5, 3, 6], [9, -8, 17], [2, -14, 33]])
PIXEL, ROWS = 0.8, 41


@pytest.fixture(scope="module")
def scan(running, one) -> tuple[str, np.ndarray]:
    """A smooth scan with unequal spacing and oblique axes, with its voxels (z, y, x)."""
    data_set = store_ball(running, one)
    folder = running.data_dir / "volumes" / data_set
    z, y, x = np.mgrid[:SIZE[2], :SIZE[1], :SIZE[0]]
    waves = np.sin(x / 5) + np.sin(y / 4 + 1) * np.cos(z / 3)
    voxels = np.round(1000 * waves + 500).clip(LEAST).astype("<i2")
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


def curved(**changes) -> ClientMessage:
    message = ClientMessage()
    slice_ = message.slices.slices.add().curved
    asked = {"id": 5, "columns": 0, "rows": ROWS, "pixel": PIXEL, "angle": 0, "thickness": 0, "projection": MEAN, "points": POINTS, **changes}
    for point in asked.pop("points"):
        slice_.points.add(x=point[0], y=point[1], z=point[2])
    for name, value in asked.items():
        setattr(slice_, name, value)
    return message


def asked_of(viewer: Viewer, message: ClientMessage):
    """Requests a slice and acknowledges it."""
    message.slices.taken = viewer.taken
    viewer.send(message)
    piece = viewer.until("slice")
    viewer.taken = piece.seq
    return piece


@pytest.mark.parametrize("thickness,projection", [(0, MEAN), (5, MEAN), (5, MAXIMUM), (5, MINIMUM)])
@pytest.mark.parametrize("angle", [0, 35, 180])
def test_curved_slices_equal_a_resampling_by_scipy(viewer, scan, angle, thickness, projection):
    voxels = scan[1].astype(float)
    curve = CurveReference(POINTS)
    piece = asked_of(viewer, curved(angle=angle, thickness=thickness, projection=projection))
    columns = int(curve.length / PIXEL) + 1
    assert (piece.curved, piece.plane, piece.columns, piece.rows) == (5, 0, columns, ROWS)
    places, normals = curve.grid(columns, ROWS, PIXEL, angle)
    layers = 1 + int(np.ceil(thickness / SPACING.min() - 1e-9)) if thickness else 1
    samples, slopes = [], []
    for offset in np.linspace(-thickness / 2, thickness / 2, layers) if thickness else [0.0]:
        index = (places + offset * normals) @ DIRECTION / SPACING + (np.array(SIZE) - 1) / 2
        inside = ((index >= -0.5) & (index <= np.array(SIZE) - 0.5)).all(axis=-1)
        edge = (np.abs(np.concatenate([index + 0.5, index - np.array(SIZE) + 0.5], axis=-1)) < 0.05).any(axis=-1)
        found = map_coordinates(voxels, np.moveaxis(index[..., ::-1], -1, 0), order=1, mode="nearest")
        samples.append(np.where(inside, found, np.nan))
        slopes.append(edge)
    combine = {MEAN: np.nanmean, MAXIMUM: np.nanmax, MINIMUM: np.nanmin}[projection]
    whole = np.array(samples)
    empty = np.isnan(whole).all(axis=0)
    whole[:, empty] = LEAST
    expected = combine(whole, axis=0)
    assert 0.02 < empty.mean() < 0.9, "the slice lies inside and outside"
    # The worker's curve has 64 chords per segment of about 20 mm. Around radii above 8 mm, they are shorter than their arcs by a
    # part of 6e-5, so pixels lie at most 0.005 mm from those of the reference, and at twice that 16 mm across the curve. The
    # steepest slope of the scan is that of the waves along the closest voxels.
    steepest = np.abs(np.diff(voxels, axis=2)).max() / SPACING[0]
    certain = ~np.array(slopes).any(axis=0)
    assert np.abs(values(piece) - expected)[certain].max() <= 0.5 + 0.015 * steepest


@pytest.mark.parametrize("change", [
    {"id": 0}, {"points": POINTS[:1]}, {"points": np.repeat(POINTS, 20, axis=0)}, {"rows": 0}, {"rows": 2049}, {"pixel": 0}, {"pixel": float("nan")},
    {"columns": 2000}, {"angle": float("inf")}, {"thickness": -1}, {"thickness": 1e300}])
def test_an_invalid_curved_slice_is_refused_and_the_session_continues(viewer, change):
    viewer.send(curved(**change))
    refusal = viewer.until("problem")
    assert refusal.code == "invalid" and refusal.field.startswith("slices[0].curved.") and not refusal.fatal
    assert asked_of(viewer, curved()).curved == 5
