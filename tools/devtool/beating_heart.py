"""A synthetic CT of a chest with a beating heart, like bench/renderer/synthetic_heart.cpp, as a NIfTI file with phases.

    python -m tools.devtool.beating_heart heart.nii.gz [voxels per axis] [phases]
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

EXTENT = 300.0     # mm
AIR, LUNG, TISSUE, MUSCLE, BLOOD, BONE = -1000, -850, 40, 110, 380, 700


def beating_heart(n: int, phases: int) -> Any:
    """Returns an int16 array of Hounsfield units with the axes x (to the left), y (to the back), z (to the head) and
    phase."""
    import numpy as np

    along = (EXTENT * ((np.arange(n) + 0.5) / n - 0.5)).astype(np.float32)
    x, y, z = np.meshgrid(along, along, along, indexing="ij", sparse=True)

    def ellipsoid(a: Any, b: Any, c: Any, radii: tuple[float, float, float]) -> Any:
        return (a / radii[0]) ** 2 + (b / radii[1]) ** 2 + (c / radii[2]) ** 2 < 1

    chest = np.full((n, n, n), TISSUE, np.float32)
    chest[ellipsoid(np.abs(x) - 62, y, z, (52, 72, 130))] = LUNG
    bone = (np.hypot(x, y - 72) < 16) | ((np.abs(np.hypot(x / 125, y / 90) - 0.97) < 0.03)
                                         & (np.sin((z + 0.2 * np.abs(x)) / 4.5) > 0.4))
    chest[np.broadcast_to(bone, chest.shape)] = BONE
    chest[np.broadcast_to(np.hypot(x / 135, y / 100) > 1, chest.shape)] = AIR
    u, v, w = 0.75 * x - 0.45 * y - 0.48 * z, 0.51 * x + 0.86 * y, 0.41 * x - 0.25 * y + 0.88 * z
    random = np.random.default_rng(1)
    beats = np.empty((n, n, n, phases), np.int16)
    for phase in range(phases):
        squeeze = np.sin(np.pi * phase / phases) ** 2
        cavity, outside = 1 - 0.45 * squeeze, 1 - 0.12 * squeeze
        now = chest.copy()
        now[(np.hypot(u + 45, v) < 13) & (w > 0) & (w < 90)] = BLOOD     # aorta
        for part, radii, value in (((u, v + 34, w), (43 * outside, 25 * outside, 33 * outside), MUSCLE),
                                   ((u, v + 34, w), (38 * cavity, 20 * cavity, 28 * cavity), 0.6 * BLOOD),
                                   ((u - 18, v, w), (54 * outside, 36 * outside, 36 * outside), MUSCLE),
                                   ((u - 18, v, w), (42 * cavity, 24 * cavity, 24 * cavity), BLOOD)):
            now[ellipsoid(*part, radii)] = value
        beats[..., phase] = np.rint(now + 30 * (random.random(now.shape, np.float32) - 0.5))
    return beats


def write_beating_heart(path: Path, n: int = 64, phases: int = 20, seconds: float = 1.0) -> None:
    """Writes a NIfTI file of one heartbeat that takes `seconds`."""
    import nibabel
    import numpy as np

    step = EXTENT / n
    # NIfTI's x points to the right and its y to the front.
    affine = np.diag([-step, -step, step, 1])
    affine[:3, 3] = [EXTENT / 2, EXTENT / 2, -EXTENT / 2]
    image = nibabel.Nifti1Image(beating_heart(n, phases), affine)
    image.header.set_zooms((step, step, step, seconds / phases))
    image.header.set_xyzt_units("mm", "sec")
    nibabel.save(image, path)


if __name__ == "__main__":
    write_beating_heart(Path(sys.argv[1]), *(int(word) for word in sys.argv[2:4]))
