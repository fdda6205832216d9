"""Section 6.2 of the thesis: the canonical views of a region, from the views that participants chose."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy import stats
from scipy.cluster import hierarchy
from scipy.spatial.distance import pdist, squareform
from sklearn.mixture import GaussianMixture

from . import export

#: The probability of claiming several views, or one, where there are none. A claim of several views must be made against
#: each of three crowds without clusters, so that its probability is at most this.
SIGNIFICANCE = 0.01
_DRAWN = 99
#: Cuts of the dendrogram that the test of several views tries. More would only cost time.
_MOST_CUTS = 10
#: With fewer views, nothing is claimed.
FEWEST = 8


@dataclass(frozen=True, eq=False)
class Views:
    """Views relative to a region: directions from its centre in the body's axes (left, back, up), and distances in its radii."""

    numbers: np.ndarray
    directions: np.ndarray
    distances: np.ndarray
    targets: np.ndarray
    ups: np.ndarray
    centre: np.ndarray
    radius: float

    def features(self) -> np.ndarray:
        """Returns the coordinates in which outliers are far away: twice the distance is as far as 40° of direction."""
        return np.column_stack([self.directions, np.log(self.distances)])

    def subset(self, kept: np.ndarray) -> Views:
        return Views(self.numbers[kept], self.directions[kept], self.distances[kept], self.targets[kept], self.ups[kept], self.centre, self.radius)


@dataclass(frozen=True, eq=False)
class Cluster:
    members: np.ndarray        # indices of the kept views
    direction: np.ndarray
    distance: float
    target: np.ndarray
    up: np.ndarray
    spread: float              # root mean square of the angles to the direction, in degrees


@dataclass(frozen=True, eq=False)
class Result:
    step: str
    views: Views               # all views
    kept: np.ndarray           # indices of the views that are not outliers
    linkage: np.ndarray | None # of all views
    bound: float               # height above which a single view was an outlier, in the first round
    p_several: float
    p_one: float
    silhouettes: dict[int, float] = field(default_factory=dict)
    clusters: list[Cluster] = field(default_factory=list)    # in the order of the tour

    @property
    def several(self) -> bool:
        return len(self.clusters) > 1


def unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1)


def views_of(document: dict[str, Any], step: dict[str, Any]) -> Views | None:
    answers = export.answers(document, step["id"])
    cameras = {number: {name: np.array(value["camera"][name], float) for name in ("eye", "target", "up")} for number, value in answers.items()}
    if not cameras:
        return None
    region = (step.get("view") or {}).get("region")
    eyes, targets, ups = (np.array([camera[name] for camera in cameras.values()]) for name in ("eye", "target", "up"))
    if region:
        centre, radius = np.array(region["centre"], float), float(region["radius"])
    else:                                  # the whole scan: its middle is where the cameras look
        centre = np.median(targets, axis=0)
        radius = float(np.median(np.linalg.norm(eyes - centre, axis=1)))
    if not radius > 0:
        return None
    away = (eyes - centre) / radius
    distances = np.linalg.norm(away, axis=1)
    # A camera in the centre itself, or at no number, shows no side of the region.
    usable = (distances > 1e-6) & np.isfinite(distances)
    found = Views(np.array(list(cameras)), unit(away), distances, (targets - centre) / radius, unit(ups), centre, radius)
    return found.subset(np.flatnonzero(usable)) if usable.any() else None


# Outliers

def linkage_of(features: np.ndarray) -> np.ndarray:
    return hierarchy.linkage(features, "average")


def bound_of(linkage: np.ndarray) -> float:
    low, high = np.quantile(linkage[:, 2], [0.25, 0.75])
    return float(high + 3 * (high - low))


def without_outliers(features: np.ndarray) -> np.ndarray:
    """Removes the single view that joins others at the greatest height, while this height is an outlier of all heights: more
    than three interquartile ranges above the third quartile. Returns the indices of the views that stay.
    """
    kept = np.arange(len(features))
    while len(kept) >= FEWEST:
        linkage = linkage_of(features[kept])
        heights = np.zeros(len(kept))
        for one, other, height, _ in linkage:
            for leaf in (one, other):
                if leaf < len(kept):
                    heights[int(leaf)] = height
        if heights.max() <= bound_of(linkage):
            break
        kept = np.delete(kept, heights.argmax())
    return kept


# Number of clusters

def _silhouette(distances: np.ndarray, labels: np.ndarray) -> float:
    """Returns the mean silhouette (Rousseeuw 1987). scikit-learn's takes twenty times as long for so few points."""
    members = (labels[:, None] == np.unique(labels)).astype(float)
    sizes = members.sum(axis=0)
    if len(sizes) < 2:
        return -1.0
    sums = distances @ members
    own = members.astype(bool)
    size = (members @ sizes)
    inside = sums[own] / np.maximum(size - 1, 1)
    nearest = np.where(own, np.inf, sums / sizes).min(axis=1)
    values = np.where(size > 1, (nearest - inside) / np.maximum(np.maximum(nearest, inside), 1e-12), 0)
    return float(values.mean())


def structure(points: np.ndarray) -> float:
    """Returns how well points fall into clusters: the greatest silhouette of the cuts of the dendrogram into 2 to 10."""
    condensed = pdist(points)
    linkage, distances = hierarchy.linkage(condensed, "average"), squareform(condensed)
    return max(_silhouette(distances, hierarchy.fcluster(linkage, k, "maxclust")) for k in range(2, min(_MOST_CUTS, len(points) // 2) + 1))


def _uniform(n: int, rng: np.random.Generator) -> np.ndarray:
    return unit(rng.normal(size=(n, 3)))


@functools.lru_cache(maxsize=64)
def _uniform_structure(n: int) -> tuple[float, ...]:
    rng = np.random.default_rng(n)
    return tuple(sorted(structure(_uniform(n, rng)) for _ in range(_DRAWN)))


def _ring(directions: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Turns each direction at random about the axis along which the directions differ least."""
    _, axes = np.linalg.eigh(directions.T @ directions)
    along = directions @ axes[:, 0]
    across, angle = np.sqrt(np.maximum(1 - along ** 2, 0)), rng.uniform(0, 2 * np.pi, len(directions))
    return np.column_stack([along, across * np.cos(angle), across * np.sin(angle)])


def p_several(directions: np.ndarray, rng: np.random.Generator) -> float:
    """Returns the p-value of several clusters, by Monte Carlo tests against three crowds without clusters: uniform directions, one
    Gaussian with the crowd's mean and covariance, and a ring. It is the greatest of the three.
    """
    n = len(directions)
    own = structure(directions)
    exceeding = sum(value >= own for value in _uniform_structure(n))
    mean, covariance = directions.mean(axis=0), np.cov(directions.T) + 1e-12 * np.eye(3)
    most = int(SIGNIFICANCE * (_DRAWN + 1))
    for draw in (lambda: rng.multivariate_normal(mean, covariance, n), lambda: _ring(directions, rng)):
        count = 0
        for _ in range(_DRAWN):
            if max(count, exceeding) >= most:      # no claim, whatever the other draws are
                break
            count += structure(draw()) >= own
        exceeding = max(exceeding, count)
    return (1 + exceeding) / (_DRAWN + 1)


def p_one(directions: np.ndarray) -> float:
    """Returns the p-value of a common direction (Rayleigh's test on the sphere)."""
    n = len(directions)
    return float(stats.chi2.sf(3 * n * float(np.sum(directions.mean(axis=0) ** 2)), 3))


def mixtures(directions: np.ndarray) -> tuple[dict[int, float], np.ndarray]:
    """Returns the silhouette of each number of clusters from 2 to n/2, and the labels of the best. The Gaussian mixtures start at
    the clusters of the dendrogram, so that they are the same each time.
    """
    condensed = pdist(directions)
    linkage, distances = hierarchy.linkage(condensed, "average"), squareform(condensed)
    silhouettes, best = {}, np.zeros(len(directions), int)
    for k in range(2, len(directions) // 2 + 1):
        start = hierarchy.fcluster(linkage, k, "maxclust") - 1
        if start.max() + 1 < k:            # equal heights, as of views that are the same
            continue
        centres = np.array([directions[start == label].mean(axis=0) for label in range(k)])
        shares = np.bincount(start, minlength=k) / len(start)
        spread = np.array([max(directions[start == label].var(axis=0).mean(), 1e-2) for label in range(k)])
        mixture = GaussianMixture(k, covariance_type="spherical", reg_covar=1e-3, means_init=centres, weights_init=shares,
                                  precisions_init=1 / spread, max_iter=200, random_state=0, init_params="random_from_data")
        labels = mixture.fit_predict(directions)
        silhouettes[k] = _silhouette(distances, labels)
        if silhouettes[k] >= max(silhouettes.values()):
            best = labels
    return silhouettes, best


def _cluster(views: Views, members: np.ndarray) -> Cluster:
    directions = views.directions[members]
    direction = unit(directions.mean(axis=0))
    angles = np.degrees(np.arccos(np.clip(directions @ direction, -1, 1)))
    up = views.ups[members].mean(axis=0)
    up = up - (up @ direction) * direction
    if np.linalg.norm(up) < 1e-6:
        up = np.cross(direction, [1.0, 0, 0] if abs(direction[0]) < 0.9 else [0, 1.0, 0])
    return Cluster(members, direction, float(np.exp(np.log(views.distances[members]).mean())), np.median(views.targets[members], axis=0),
                   unit(up), float(np.sqrt((angles ** 2).mean())))


def in_order(clusters: list[Cluster]) -> list[Cluster]:
    """Orders clusters by the angle about their mean, in the plane in which they differ most."""
    if len(clusters) < 3:
        return clusters
    centres = np.array([one.direction for one in clusters])
    away = centres - centres.mean(axis=0)
    plane = np.linalg.svd(away, full_matrices=False)[2][:2]
    plane *= np.where(plane[np.arange(2), np.abs(plane).argmax(axis=1)] < 0, -1, 1)[:, None]    # the same sign each time
    flat = away @ plane.T
    return [clusters[i] for i in np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))]


def analyse(step: str, views: Views, rng: np.random.Generator | None = None) -> Result:
    rng = rng or np.random.default_rng(1)
    n = len(views.numbers)
    linkage = linkage_of(views.features()) if n > 1 else None
    bound = bound_of(linkage) if linkage is not None else float("nan")
    kept = without_outliers(views.features())
    if len(kept) < FEWEST:
        return Result(step, views, kept, linkage, bound, 1.0, 1.0)
    left = views.subset(kept)
    several, one = p_several(left.directions, rng), p_one(left.directions)
    if several <= SIGNIFICANCE:
        silhouettes, labels = mixtures(left.directions)
        clusters = [_cluster(left, np.flatnonzero(labels == label)) for label in np.unique(labels)]
        return Result(step, views, kept, linkage, bound, several, one, silhouettes, in_order(clusters))
    clusters = [_cluster(left, np.arange(len(kept)))] if one <= SIGNIFICANCE else []
    return Result(step, views, kept, linkage, bound, several, one, {}, clusters)
