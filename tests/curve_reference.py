"""A curve through points, computed independently of volume/curve.h: by the recursion of Barry and Goldman, in fine steps."""

from __future__ import annotations

import numpy as np

#: Steps per segment. Their chords are shorter than the curve by less than 1e-6.
STEPS = 2000
#: The directions across the curve at its start, in the order in which the first of equally good ones is taken.
DIRECTIONS = np.array([[0, 0, -1], [1, 0, 0], [0, 1, 0]], float)


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


class CurveReference:
    """A centripetal Catmull-Rom spline with frames that are projected from step to step."""

    def __init__(self, points: np.ndarray):
        knots = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
        pieces = [self._segment(knots[i - 1:i + 3]) for i in range(1, len(knots) - 2)]
        self.places = np.vstack([*(piece[:-1] for piece in pieces), points[-1]])
        chords = np.diff(self.places, axis=0)
        lengths = np.linalg.norm(chords, axis=1)
        self.arcs = np.concatenate([[0], np.cumsum(lengths)])
        self.length = self.arcs[-1]
        self.along = unit(np.gradient(self.places, axis=0))
        parallel = ((chords @ DIRECTIONS.T) ** 2 / lengths[:, None]).sum(axis=0)
        across = DIRECTIONS[np.argmin(np.round(parallel, 6))]
        frames = []
        for tangent in self.along:
            across = unit(across - (across @ tangent) * tangent)
            frames.append(across)
        self.across = np.array(frames)

    @staticmethod
    def _segment(p: np.ndarray) -> np.ndarray:
        t = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1) ** 0.5)])
        x = np.linspace(t[1], t[2], STEPS + 1)[:, None]

        def mix(a: np.ndarray, b: np.ndarray, begin: float, end: float) -> np.ndarray:
            return ((end - x) * a + (x - begin) * b) / (end - begin)

        a = [mix(p[k], p[k + 1], t[k], t[k + 1]) for k in range(3)]
        b = [mix(a[k], a[k + 1], t[k], t[k + 2]) for k in range(2)]
        return mix(b[0], b[1], t[1], t[2])

    def at(self, arcs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Returns the places, the tangents and the directions across at arc lengths."""
        return tuple(np.stack([np.interp(arcs, self.arcs, values[:, k]) for k in range(3)], axis=-1)
                     for values in (self.places, self.along, self.across))

    def grid(self, columns: int, rows: int, pixel: float, degrees: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns the place of each pixel (row, column) and the normal of each column."""
        place, along, across = self.at(np.arange(columns) * pixel)
        angle = np.radians(degrees)
        down = np.cos(angle) * across + np.sin(angle) * np.cross(along, across)
        offsets = (np.arange(rows) - (rows - 1) / 2) * pixel
        return place[None] + offsets[:, None, None] * down[None], np.cross(along, down)
