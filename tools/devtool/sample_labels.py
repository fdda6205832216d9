"""Labels of the sample scan, for the pictures of docs/guide.md: the braincase, the bones of the face, and the brain."""

from __future__ import annotations

import io
import json
import struct
import tarfile
import time

from .bench_client import Person
from .stack import Stack

#: Limits in HU: bone is above the first value, and the brain between the others.
BONE, BRAIN = 250, (0, 90)
BRAINCASE, FACE, INSIDE = 1, 2, 3


def add(stack: Stack, person: Person, scan: str) -> None:
    """Adds the labels to a scan of the sample, and waits until it has them."""
    bundle = _bundle(_nifti(stack, scan))
    announced = person.http.post(f"/v1/data-sets/{scan}/labels", json={"bytes": len(bundle)}).raise_for_status().json()
    person.http.patch(announced["upload_url"], content=bundle, headers={
        "Tus-Resumable": "1.0.0", "Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"}).raise_for_status()
    while person.http.get(f"/v1/data-sets/{scan}").raise_for_status().json()["labels"]["placing"]:
        time.sleep(0.2)


def _labels(values):
    """Returns the label of each voxel, in the order of `values`: x runs to the patient's left, y to the back, z to the head."""
    import numpy as np

    bone = values > BONE
    _, size_y, size_z = values.shape
    y, z = np.ogrid[:size_y, :size_z]
    # Inside the braincase, there is bone above and on all four sides in the slice.
    sides = [np.maximum.accumulate(bone, axis) for axis in (0, 1)]
    sides += [np.flip(np.maximum.accumulate(np.flip(bone, axis), axis), axis) for axis in (0, 1, 2)]
    inside = np.logical_and.reduce(sides) & (values > BRAIN[0]) & (values < BRAIN[1]) & (z > size_z // 3)
    # The surface of a look lies between two voxels. Both become bone, so that it has one colour.
    bone = np.logical_or.reduce([bone, *(np.roll(bone, step, axis) for axis in range(3) for step in (-1, 1))])
    face = bone & (y < size_y // 2) & (z < size_z // 2)
    return np.select([face, bone, inside], [FACE, BRAINCASE, INSIDE]).astype(np.uint8)


def _nifti(stack: Stack, scan: str) -> bytes:
    import numpy as np

    folder = stack.data / "volumes" / scan
    volume = json.loads((folder / "volume.json").read_text(encoding="utf-8"))
    values = np.fromfile(folder / "voxels.i16", "<i2").reshape(volume["size"], order="F")
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *volume["size"], 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 2, 8)    # uint8
    struct.pack_into("<4f", header, 76, 1, *volume["spacing"])
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    struct.pack_into("<h", header, 254, 1)
    # The affine matrix in NIfTI's axes (right, front, head), row by row.
    (dx, dy, dz), (left, back, head) = volume["spacing"], volume["origin"]
    struct.pack_into("<12f", header, 280, -dx, 0, 0, -left, 0, -dy, 0, -back, 0, 0, dz, head)
    header[344:347] = b"n+1"
    return bytes(header) + _labels(values).tobytes(order="F")


def _bundle(file: bytes) -> bytes:
    """Returns the archive that a page uploads."""
    archive = io.BytesIO()
    with tarfile.open(fileobj=archive, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        entry = tarfile.TarInfo("00001.dcm")
        entry.size = len(file)
        tar.addfile(entry, io.BytesIO(file))
    return archive.getvalue()
