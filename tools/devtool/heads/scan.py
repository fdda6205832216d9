"""A volume in memory, its stored form, and transformations that multiply the real ones."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from pathlib import Path

import nibabel
import numpy as np

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Scan:
    voxels: np.ndarray              # int16, z, y, x
    spacing: Vector                 # mm, x, y, z
    direction: np.ndarray           # 3 x 3, columns are the axes of x, y, z (LPS)
    modality: str                   # CT, MR, OTHER

    @property
    def air(self) -> int:
        return -1000 if self.modality == "CT" else 0


def write(scan: Scan, folder: Path) -> Path:
    """Writes the scan as in the volume store (docs/contracts.md)."""
    folder.mkdir(parents=True)
    voxels = np.ascontiguousarray(scan.voxels, "<i2")
    (folder / "voxels.i16").write_bytes(voxels.tobytes())
    (folder / "volume.json").write_text(json.dumps({
        "format": 1, "size": list(voxels.shape[::-1]), "spacing": list(scan.spacing),
        "direction": [float(v) for v in scan.direction.reshape(-1)], "modality": scan.modality,
        "minimum": int(voxels.min()), "maximum": int(voxels.max()),
        "percentiles": np.percentile(voxels, [1, 10, 25, 50, 75, 90, 99, 99.9]).tolist(),
        "contentHash": "blake2b:" + hashlib.blake2b(voxels, digest_size=32).hexdigest()}))
    return folder


def read(folder: Path) -> Scan:
    header = json.loads((folder / "volume.json").read_text())
    voxels = np.fromfile(folder / "voxels.i16", "<i2").reshape(header["size"][::-1])
    return Scan(voxels, tuple(header["spacing"]), np.array(header["direction"]).reshape(3, 3), header.get("modality", "OTHER"))


def read_nifti(file: Path, modality: str, scale_to: float | None = None) -> Scan:
    """Reads NIfTI without sheared axes. Scales floats to the maximum `scale_to`, if it is given."""
    image = nibabel.load(file)
    values = np.nan_to_num(image.get_fdata(dtype=np.float32)).T
    if scale_to is not None:
        values = values * (scale_to / values.max())
    axes = np.diag([-1.0, -1.0, 1.0]) @ image.affine[:3, :3]     # columns; from RAS
    spacing = np.linalg.norm(axes, axis=0)
    direction = axes / spacing
    if np.linalg.det(direction) < 0:
        direction, values = direction @ np.diag([-1.0, 1.0, 1.0]), values[:, :, ::-1]
    return Scan(np.clip(np.round(values), -32768, 32767).astype(np.int16), tuple(float(s) for s in spacing), direction, modality)


def turning(pitch: float = 0, yaw: float = 0, roll: float = 0) -> np.ndarray:
    """Returns a rotation by degrees about x (nodding), z (looking aside) and y (leaning towards a shoulder)."""
    p, w, r = np.radians([pitch, yaw, roll])
    about_x = np.array([[1, 0, 0], [0, np.cos(p), -np.sin(p)], [0, np.sin(p), np.cos(p)]])
    about_z = np.array([[np.cos(w), -np.sin(w), 0], [np.sin(w), np.cos(w), 0], [0, 0, 1]])
    about_y = np.array([[np.cos(r), 0, np.sin(r)], [0, 1, 0], [-np.sin(r), 0, np.cos(r)]])
    return about_z @ about_y @ about_x


def turned(scan: Scan, **degrees: float) -> Scan:
    """Rotates the patient in the scanner, and the box of the image with them."""
    return replace(scan, direction=turning(**degrees) @ scan.direction)


def mirrored(scan: Scan) -> Scan:
    return replace(scan, voxels=scan.voxels[:, :, ::-1])


def cropped(scan: Scan, axis: int, low: float, high: float) -> Scan:
    """Crops the scan along a patient's axis (0 to the left, 1 to the back, 2 to the head). `low`
    and `high` are fractions of its length."""
    along = int(np.argmax(np.abs(scan.direction[axis])))
    if scan.direction[axis, along] < 0:
        low, high = 1 - high, 1 - low
    n = scan.voxels.shape[2 - along]
    cut = [slice(None)] * 3
    cut[2 - along] = slice(round(low * n), max(round(high * n), round(low * n) + 8))
    return replace(scan, voxels=scan.voxels[tuple(cut)])


def thick(scan: Scan, factor: int) -> Scan:
    """Averages groups of `factor` slices into thick ones."""
    n = scan.voxels.shape[0] // factor * factor
    means = scan.voxels[:n].reshape(-1, factor, *scan.voxels.shape[1:]).mean(1)
    x, y, z = scan.spacing
    return replace(scan, voxels=np.round(means).astype(np.int16), spacing=(x, y, z * factor))


def scaled(scan: Scan, factor: float) -> Scan:
    return replace(scan, spacing=tuple(factor * s for s in scan.spacing))


def noisy(scan: Scan, sigma: float, seed: int = 1) -> Scan:
    rng = np.random.default_rng(seed)
    values = scan.voxels + rng.normal(0, sigma, scan.voxels.shape)
    if scan.modality != "CT":
        values = np.hypot(values, rng.normal(0, sigma, scan.voxels.shape))      # Rician noise of a magnitude
    return replace(scan, voxels=np.clip(np.round(values), -32768, 32767).astype(np.int16))


def inverted(scan: Scan) -> Scan:
    """Inverts the brightness of the body in an MR scan and keeps the air."""
    high = np.percentile(scan.voxels, 99.5)
    body = scan.voxels > 0.08 * high
    values = np.where(body, np.clip(1.15 * high - scan.voxels, 0.1 * high, None), scan.voxels)
    return replace(scan, voxels=np.round(values).astype(np.int16))


def shaded(scan: Scan, strength: float) -> Scan:
    """Simulates a coil that fades by that share towards the feet and the back."""
    nz, ny, _ = scan.voxels.shape
    fade = 1 - strength * (np.linspace(1, 0, nz)[:, None, None] + np.linspace(0, 1, ny)[None, :, None]) / 2
    return replace(scan, voxels=np.round(scan.voxels * fade).astype(np.int16))


def as_sagittal(scan: Scan) -> Scan:
    """Stores the same body in sagittal slices."""
    order = [1, 2, 0]       # y, z, x become the new x, y, z
    voxels = scan.voxels.transpose(2, 0, 1)
    return Scan(voxels, tuple(scan.spacing[i] for i in order), scan.direction[:, order], scan.modality)


def places(scan: Scan) -> np.ndarray:
    """Returns the position of every voxel in world space: mm, the centre of the volume at 0, as (z, y, x, 3)."""
    n = scan.voxels.shape[::-1]
    z, y, x = np.meshgrid(*(np.arange(m, dtype=np.float32) + 0.5 - m / 2 for m in n[::-1]), indexing="ij")
    return np.stack([x * scan.spacing[0], y * scan.spacing[1], z * scan.spacing[2]], -1) @ scan.direction.T.astype(np.float32)
