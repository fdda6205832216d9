"""A place in the patient is at the same place in the volume: small balls at known positions (mm, LPS), through every slice
geometry that ingest corrects, to within half a voxel along each axis."""

from __future__ import annotations

import json
import math
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from harness import REPO  # noqa: F401  (puts tools/ on the path)
from devtool import paths
from devtool.ingest_cases.judge import on_server
from devtool.ingest_cases.phantom import AXIAL, ENHANCED_CT, Series, dataset, enhanced, markers, stack, write
from devtool.ingest_cases.table import oblique

SIZE = {"rows": 44, "columns": 48, "intercept": -2000.0}      # 35 x 34 mm
BALLS = ((-7.0, -4.0, -3.0), (8.0, 5.0, 9.0), (-3.0, 8.0, 21.0))
CORNER = (-16.8, -17.2, -14.0)


def turned(place, orientation) -> tuple[float, ...]:
    """Returns the same place in a frame rotated like the slices, so that it stays inside them."""
    row, column = np.array(orientation[:3]), np.array(orientation[3:])
    return tuple(place[0] * row + place[1] * column + place[2] * np.cross(row, column))


def without(n: int, gap: float, missing: set[int]) -> list[float]:
    return [i * gap for i in range(n) if i not in missing]


GEOMETRIES = {
    "regular": (AXIAL, 24, 2.0, 0.0),
    "jitter": (AXIAL, [2.0 * i + (0.03 if 0 < i < 23 and i % 2 else 0) for i in range(24)], 2.0, 0.0),
    "oblique": (oblique(), 24, 2.0, 0.0),
    "tilt": (AXIAL, 24, 2.0, 18.5),
    "tilt the other way": (AXIAL, 24, 2.0, -18.5),
    "oblique tilt": (oblique(), 24, 2.0, 11.0),
    "gaps": (AXIAL, without(48, 1.0, {17, 18}), 1.0, 0.0),
    "gaps and tilt": (AXIAL, without(48, 1.0, {17, 30}), 1.0, 14.0),
    "varying": (AXIAL, [1.5 * i for i in range(12)] + [18 + 2.7 * i for i in range(12)], 1.5, 0.0),
    "varying and oblique tilt": (oblique(), [1.5 * i for i in range(12)] + [18 + 3 * i for i in range(11)], 1.5, -9.0),
    "rows from the right": ((-1.0, 0.0, 0.0, 0.0, 1.0, 0.0), 24, 2.0, 0.0),
    "columns from below": ((1.0, 0.0, 0.0, 0.0, -1.0, 0.0), 24, 2.0, 0.0),
    "coronal": ((1.0, 0.0, 0.0, 0.0, 0.0, -1.0), 24, 2.0, 0.0),
    "sagittal": ((0.0, 1.0, 0.0, 0.0, 0.0, -1.0), 24, 2.0, 0.0),
}


@pytest.mark.parametrize("packed", [False, True], ids=["a file a slice", "enhanced"])
@pytest.mark.parametrize("name", GEOMETRIES)
def test_markers_keep_their_positions_in_the_volume(tmp_path, name, packed):
    orientation, places, gap, tilt = GEOMETRIES[name]
    balls = [turned(ball, orientation) for ball in BALLS]
    slices = stack(places, gap, tilt, origin=turned(CORNER, orientation), orientation=orientation, **SIZE)
    if tilt:    # the tilted stack extends beyond its box, so it starts further back
        lean = math.tan(math.radians(tilt)) * 24 * np.array(orientation[3:])
        slices = [replace(one, position=tuple(np.array(one.position) - lean / 2), rows=56) for one in slices]
    series = Series(ENHANCED_CT if packed else "1.2.840.10008.5.1.4.1.1.2", values=markers(*balls))
    write(tmp_path / "disc", [enhanced(series, slices)] if packed else [dataset(series, one) for one in slices])
    volume = on_server(tmp_path / "disc", tmp_path).volume
    assert volume is not None
    assert np.linalg.det(volume.direction) == pytest.approx(1), "else the picture is mirrored"
    found = [volume.marker(np.array(ball), radius=9.0) for ball in balls]
    for ball, place in zip(balls, found):
        off = volume.direction.T @ (place - np.array(ball))
        assert (np.abs(off) < volume.spacing / 2).all(), f"{off} mm along the axes of voxels of {volume.spacing}"
    # Also the vector between the balls, which does not depend on the origin of the volume.
    between = volume.direction.T @ ((found[1] - found[0]) - (np.array(balls[1]) - np.array(balls[0])))
    assert (np.abs(between) < volume.spacing / 2).all()


def picture(folder, scene: dict, out) -> np.ndarray:
    """Returns brightness, row by row from the top, rendered by the CPU engine."""
    (folder / "scene.json").write_text(json.dumps(scene))
    subprocess.run([str(paths.build_dir() / "bin" / "diaphane-render"), str(folder / "disc"), "--scene", str(folder / "scene.json"),
                    "--size", "64x64", "--samples", "8", "--engine", "cpu", "--quiet", "--out", str(out)], check=True)
    head, _, pixels = out.read_bytes().partition(b"\n255\n")
    assert head.split() == [b"P6", b"64", b"64"]
    return np.frombuffer(pixels, np.uint8).reshape(64, 64, 3).sum(-1).astype(float)


def seen_from(eye: tuple[float, float, float]) -> dict:
    return {"transferFunction": {"channels": [{"name": "ball", "diffuse": {"r": 0.9, "g": 0.9, "b": 0.9},
                                               "opacity": [{"value": -200, "opacity": 0}, {"value": 100, "opacity": 1}]}],
                                 "extinctionPerMm": 1},
            "lights": [{"name": "sky", "environment": {"radiance": {"r": 1, "g": 1, "b": 1}}}],
            "camera": {"eye": dict(zip("xyz", eye)), "target": {"x": 0, "y": 0, "z": 0}, "up": {"x": 0, "y": 0, "z": 1},
                       "orthographicHeight": 44},
            "display": {"exposure": 0, "showEnvironment": False}}


@pytest.mark.parametrize("name", ["regular", "tilt", "oblique tilt", "gaps", "rows from the right", "columns from below",
                                  "coronal", "sagittal"])
def test_the_picture_is_not_mirrored(tmp_path, name):
    """A ball at the patient's left (+x), in front (-y) and above (+z) of the centre, seen from three sides."""
    orientation, places, gap, tilt = GEOMETRIES[name]
    ball = np.array((9.0, -8.0, 7.0))
    slices = stack(places, gap, tilt, origin=(0.0, 0.0, 0.0), orientation=orientation, **SIZE)
    corners = [one.places().reshape(-1, 3) for one in (slices[0], slices[-1])]
    middle = np.concatenate(corners).mean(0)
    slices = [replace(one, position=tuple(np.array(one.position) - middle)) for one in slices]
    series = Series(values=markers(ball))
    write(tmp_path / "disc", [dataset(series, one) for one in slices])
    wanted = {"front": ((0, -200, 0), ball[0], ball[2]),       # the patient's left is at the right
              "his left": ((200, 0, 0), ball[1], ball[2]),     # their front is at the left
              "behind": ((0, 200, 0), -ball[0], ball[2])}
    for side, (eye, right, up) in wanted.items():
        seen = picture(tmp_path, seen_from(eye), tmp_path / "picture.ppm")
        assert seen.max() > 100, f"{side}: nothing is seen"
        weight = np.where(seen > seen.max() / 2, 1.0, 0.0)
        y, x = np.mgrid[:64, :64]
        place = [((weight * at).sum() / weight.sum() - 31.5) * 44 / 64 for at in (x, -y + 63.0)]
        assert place == pytest.approx([right, up], abs=1.5), side
