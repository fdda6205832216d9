"""Pictures of slices with the labels of `diaphane-labels --write` in colour."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

# Tints by label (outside, body, support, metal, brain, bone, lungs, airways, vessels): factors of
# the grey value, and offsets that are added to it.
_TINTS = np.array([[0.2, 0.2, 0.6], [1, 1, 1], [1, 0.25, 0.25], [1, 1, 0], [1, 0.8, 0.7], [1, 0.95, 0.6],
                   [1, 0.5, 0.7], [0.3, 0.7, 1], [1, 0.2, 0.2]])
_FLOORS = np.array([[0, 0, 40], [12, 12, 12], [90, 0, 0], [120, 120, 0], [40, 20, 20], [40, 40, 0],
                    [80, 30, 50], [0, 60, 120], [120, 0, 0]])
_GAP = 4


def write_slices(row: dict[str, Any], folder: Path, to: Path) -> None:
    """Writes NAME.png: three axial, two coronal and two sagittal slices. `row` is a line of diaphane-labels."""
    size = row["size"][::-1]
    values = np.fromfile(folder / f"{row['name']}.i16", "<i2").reshape(size)
    labels = _decoded((folder / f"{row['name']}.labels").read_bytes())
    values, labels, spacing = _upright(row, values, labels)
    low, high = float(values.min()), float(np.percentile(values[::3, ::3, ::3], 99.5))
    if low < -900:          # CT
        low, high = -1024, 400
    depth, height, width = values.shape
    cuts = [(0, int(depth * share)) for share in (0.2, 0.45, 0.7)] + [(1, int(height * share)) for share in (0.5, 0.8)]
    cuts += [(2, int(width * share)) for share in (0.5, 0.75)]
    tiles = []
    for axis, index in cuts:
        grey = np.clip((np.take(values, index, axis).astype(float) - low) / max(high - low, 1), 0, 1) ** 0.6
        label = np.take(labels, index, axis)
        tile = np.clip(grey[..., None] * _TINTS[label] * 200 + _FLOORS[label], 0, 255).astype(np.uint8)
        steps = [max(1, round(step / min(spacing))) for i, step in enumerate(spacing) if i != axis]
        tile = tile.repeat(steps[0], 0).repeat(steps[1], 1)
        tiles.append(tile if axis == 0 else tile[::-1])     # the head is up
    sheet = np.zeros((max(tile.shape[0] for tile in tiles), sum(tile.shape[1] + _GAP for tile in tiles), 3), np.uint8)
    left = 0
    for tile in tiles:
        sheet[:tile.shape[0], left:left + tile.shape[1]] = tile
        left += tile.shape[1] + _GAP
    Image.fromarray(sheet).save(to / f"{row['name'].replace(' ', '-').replace(',', '')}.png")


def _upright(row: dict[str, Any], values: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[float]]:
    """Turns the axes to head, back, left."""
    axes = row["axes"][::-1]
    order = [2 - "xyz".index(axis[1]) for axis in axes]
    back = tuple(i for i, axis in enumerate(axes) if axis[0] == "-")
    spacing = row["spacing"][::-1]
    return np.flip(values.transpose(order), back), np.flip(labels.transpose(order), back), [spacing[i] for i in order]


def _decoded(data: bytes) -> np.ndarray:
    """Reads the format of volume/labels.h."""
    at = 9

    def number() -> int:
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 0x7f) << shift
            shift += 7
            if byte < 0x80:
                return value

    size = [number() for _ in range(3)]
    labels, counts = [], []
    while at < len(data):
        labels.append(data[at])
        at += 1
        counts.append(number())
    return np.repeat(np.array(labels, np.uint8), counts).reshape(size[::-1])
