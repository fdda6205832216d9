"""A tour through canonical views: the order of the views, a closed curve through them, and cameras for the viewer."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from .viewpoints import Cluster, Result, unit

#: Between two views that are further apart, the curve passes a point between them on the sphere.
_WIDEST = np.radians(60)


def curve(directions: np.ndarray, distances: np.ndarray, samples: int = 240) -> np.ndarray:
    """Returns eyes on a closed curve through the views, in radii from the centre. It never comes closer than the closest view:
    directions follow a periodic cubic spline on the sphere, and distances a monotone one.
    """
    if len(directions) < 2:
        return directions * distances[:, None]
    points, lengths = [], []
    for i, direction in enumerate(directions):
        following = directions[(i + 1) % len(directions)]
        pieces = max(1, int(np.ceil(np.arccos(np.clip(direction @ following, -1, 1)) / _WIDEST)))
        for piece in range(pieces):
            points.append(_between(direction, following, piece / pieces))
            lengths.append(np.exp(np.log(distances[i]) + piece / pieces * np.log(distances[(i + 1) % len(distances)] / distances[i])))
    way, scales = np.array([*points, points[0]]), np.array([*lengths, lengths[0]])
    steps = np.maximum(np.linalg.norm(np.diff(way, axis=0), axis=1), 1e-3)
    along = np.concatenate([[0], np.cumsum(steps)])
    where = np.linspace(0, along[-1], samples)
    return unit(CubicSpline(along, way, bc_type="periodic")(where)) * PchipInterpolator(along, scales)(where)[:, None]


def _between(one: np.ndarray, other: np.ndarray, part: float) -> np.ndarray:
    """Interpolates on the sphere. Opposite directions are joined about the body's long axis, or across it."""
    angle = np.arccos(np.clip(one @ other, -1, 1))
    if angle > np.pi - 1e-3:
        axis = np.array([0.0, 0, 1]) if abs(one[2]) < 0.9 else np.array([1.0, 0, 0])
        across = unit(np.cross(axis, one))
        return np.cos(part * np.pi) * one + np.sin(part * np.pi) * across
    if angle < 1e-6:
        return one
    return (np.sin((1 - part) * angle) * one + np.sin(part * angle) * other) / np.sin(angle)


def length_of(eyes: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(eyes, axis=0), axis=1).sum())


def cameras(result: Result) -> list[dict[str, list[float]]]:
    """Returns the views of the tour for the viewer, in millimetres of the patient's axes."""
    closest = float(result.views.distances[result.kept].min()) if len(result.kept) else 0.0
    return [_camera(result, one, closest) for one in result.clusters]


def _camera(result: Result, cluster: Cluster, closest: float) -> dict[str, list[float]]:
    centre, radius = result.views.centre, result.views.radius
    eye = centre + radius * max(cluster.distance, closest) * cluster.direction
    return {"eye": _rounded(eye), "target": _rounded(centre + radius * cluster.target), "up": _rounded(cluster.up, 5)}


def _rounded(vector: np.ndarray, digits: int = 2) -> list[float]:
    return [round(float(value), digits) + 0.0 for value in vector]
