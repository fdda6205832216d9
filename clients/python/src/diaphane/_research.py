"""Scans in research formats: NIfTI, NRRD and MetaImage, as the NIfTI-1 file that is uploaded.

The rules are those of the page (frontend/src/scan/image): only voxels, their size and place, and the time between phases are sent. All
texts of the headers, which may name the patient, stay on this computer.
"""

from __future__ import annotations

import gzip
import re
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nibabel
import numpy as np
from nibabel.filebasedimages import ImageFileError

from .errors import UnreadableFile

#: The codes of NIfTI for the types of voxels.
_TYPES = {"uint8": 2, "int16": 4, "int32": 8, "float32": 16, "float64": 64, "int8": 256, "uint16": 512, "uint32": 768}
#: The longest side that NIfTI-1 can have.
_MOST_SIDE = 32767
#: The longest header of an NRRD or MetaImage.
_LONGEST_HEADER = 1 << 16
_DAMAGED = (ImageFileError, AttributeError, OSError, EOFError, ValueError, KeyError, IndexError, TypeError, zlib.error)


@dataclass(frozen=True)
class Image:
    """Voxels by x, y, z and perhaps the phase, and how they lie in the patient."""

    voxels: np.ndarray
    spacing: Sequence[float]
    #: Three rows of four numbers, in mm in NIfTI's space (right, front, head). None if the file does not state it.
    affine: np.ndarray | None
    step_ms: float = 0
    slope: float = 1
    intercept: float = 0
    modality: str = ""


def is_research_file(path: Path) -> bool:
    return path.name.lower().endswith((".nii", ".nii.gz", ".nrrd", ".mha", ".mhd"))


def clean_research_file(path: Path, phases: Sequence[int] | None = None) -> bytes:
    """Returns the file to upload: unpacked voxels and a new header (ingest/build/nifti.h), with only these `phases`."""
    name = path.name.lower()
    kind, read = next((kind, read) for endings, kind, read in _READERS if name.endswith(endings))
    try:
        image = read(path)
    except _DAMAGED as error:
        raise UnreadableFile(f"{path.name} is not a {kind} file, or it is damaged") from error
    if image is None or image.voxels.ndim not in (3, 4) or image.voxels.dtype.newbyteorder("=").name not in _TYPES:
        raise UnreadableFile(f"{path.name} must contain volumes of single numbers")
    if max(image.voxels.shape) > _MOST_SIDE:
        raise UnreadableFile(f"{path.name} is too large")
    return _canonical(image if phases is None else _with_phases(image, phases))


def _with_phases(image: Image, phases: Sequence[int]) -> Image:
    count = image.voxels.shape[3] if image.voxels.ndim == 4 else 1
    kept = sorted(set(phases))
    if not kept or kept[0] < 0 or kept[-1] >= count:
        raise ValueError(f"phases must be numbers from 0 to {count - 1}")
    if count == 1:
        return image
    distances = set(np.diff(kept))
    # The format knows only equal times between phases.
    step = image.step_ms * int(distances.pop()) if len(distances) == 1 else 0
    voxels = image.voxels[..., kept]
    return Image(voxels[..., 0] if len(kept) == 1 else voxels, image.spacing, image.affine, step, image.slope, image.intercept, image.modality)


def _canonical(image: Image) -> bytes:
    voxels = image.voxels
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, voxels.ndim, *voxels.shape, *[1] * (7 - voxels.ndim))
    struct.pack_into("<2h", header, 70, _TYPES[voxels.dtype.newbyteorder("=").name], 8 * voxels.dtype.itemsize)
    timed = voxels.ndim == 4 and image.step_ms > 0
    struct.pack_into("<5f", header, 76, 1, *image.spacing, image.step_ms if timed else 0)
    struct.pack_into("<3f", header, 108, 352, image.slope, image.intercept)
    header[123] = 2 | (16 if timed else 0)  # mm and ms
    if image.affine is not None:
        struct.pack_into("<h", header, 254, 1)
        struct.pack_into("<12f", header, 280, *image.affine.ravel())
    header[328:328 + len(image.modality)] = image.modality.encode()
    header[344:348] = b"n+1\0"
    return bytes(header) + voxels.astype(voxels.dtype.newbyteorder("<")).tobytes(order="F")


def _read_nifti(path: Path) -> Image:
    image: Any = nibabel.load(path)
    voxels = np.asarray(image.dataobj.get_unscaled())
    while voxels.ndim > 3 and voxels.shape[-1] == 1:
        voxels = voxels[..., 0]
    # Units that are not stated are mm, in most files.
    stated = int(image.header["xyzt_units"])
    mm = {1: 1000.0, 3: 0.001}.get(stated & 7, 1.0)
    ms = {8: 1000.0, 16: 1.0, 24: 0.001}.get(stated & 0x38, 0.0)
    zooms = [float(one) for one in image.header.get_zooms()]
    has_axes = int(image.header["sform_code"]) > 0 or int(image.header["qform_code"]) > 0
    return Image(voxels, [one * mm for one in zooms[:3]], np.asarray(image.affine)[:3] * mm if has_axes else None,
                 zooms[3] * ms if voxels.ndim == 4 else 0, image.dataobj.slope, image.dataobj.inter)


def _numbers(text: str) -> list[float]:
    return [float(one) for one in re.split(r"[\s,()]+", text) if one]


def _affine(axes: np.ndarray, origin: Sequence[float], signs: Sequence[float]) -> np.ndarray:
    """`axes` are columns. `signs` convert their space to that of NIfTI."""
    placed: np.ndarray = np.diag(signs) @ np.column_stack((axes, origin))
    return placed


#: Whether the coordinates of a space point against those of NIfTI.
_SPACES = {"left-posterior-superior": (-1, -1, 1), "lps": (-1, -1, 1), "right-anterior-superior": (1, 1, 1), "ras": (1, 1, 1),
           "left-anterior-superior": (-1, 1, 1), "las": (-1, 1, 1)}
_NRRD_TYPES = {"char": "i1", "signed char": "i1", "int8": "i1", "int8_t": "i1", "uchar": "u1", "unsigned char": "u1", "uint8": "u1",
               "uint8_t": "u1", "short": "i2", "short int": "i2", "signed short": "i2", "int16": "i2", "int16_t": "i2", "ushort": "u2",
               "unsigned short": "u2", "uint16": "u2", "uint16_t": "u2", "int": "i4", "signed int": "i4", "int32": "i4", "int32_t": "i4",
               "uint": "u4", "unsigned int": "u4", "uint32": "u4", "uint32_t": "u4", "float": "f4", "double": "f8"}
_MS = {**dict.fromkeys(("s", "sec", "second", "seconds"), 1000.0), **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), 1.0),
       **dict.fromkeys(("us", "usec", "microsecond", "microseconds"), 0.001)}
#: Kinds of axes that may run through space.
_SPATIAL = ("", "???", "none", "domain", "space")
#: Programs that write no kinds put the parts of a vector or a colour in front.
_MOST_PARTS = 4


def _read_nrrd(path: Path) -> Image | None:
    text, data = _header(path, rb"\r?\n\r?\n")
    if not text.startswith("NRRD"):
        raise ValueError("not an NRRD")
    fields = {key.strip().lower(): value.strip() for key, value in re.findall(r"^([^:#\n]+): (.*)$", text, re.M)}
    sizes = [int(one) for one in fields["sizes"].split()]
    kinds = (fields.get("kinds", "").lower().split() + [""] * len(sizes))[:len(sizes)]
    found = re.findall(r"none|\([^)]*\)", fields.get("space directions", ""))
    steps = [None if one == "none" else _numbers(one) for one in found] or None
    spatial = [i for i in range(len(sizes)) if (any((steps[i] or [])[:3]) if steps else kinds[i] in _SPATIAL)]
    if len(spatial) == 4 and len(sizes) == 4:
        spatial.pop()  # nothing tells time from space
    others = [i for i in range(len(sizes)) if i not in spatial and sizes[i] != 1]
    if len(spatial) != 3 or len(others) > 1:
        return None
    outer = others[0] if others else None
    if outer is not None and not (kinds[outer] in ("time", "list", "domain", "space")
                                  or (kinds[outer] in _SPATIAL and (outer > 0 or sizes[outer] > _MOST_PARTS))):
        return None
    big = ">" if fields.get("endian", "").lower() == "big" else "<"
    dtype = np.dtype(big + _NRRD_TYPES[fields["type"].lower()])
    file = fields.get("data file", fields.get("datafile"))
    packed = data if file is None else _beside(path, file)
    if {"raw": False, "gzip": True, "gz": True}[fields["encoding"].lower()]:
        packed = gzip.decompress(packed)
    raw = np.frombuffer(packed, dtype, count=int(np.prod(sizes))).reshape(sizes, order="F")
    order = [*spatial, *others, *(i for i in range(len(sizes)) if i not in spatial and i not in others)]
    voxels = raw.transpose(order).reshape([sizes[i] for i in (*spatial, *others)], order="F")
    spacings = _numbers(fields["spacings"]) if "spacings" in fields else []
    signs = _SPACES.get(re.sub(r"(-time|t)$", "", fields.get("space", "").lower()))
    axes = np.array([(steps[i] or [])[:3] for i in spatial]).T if steps else None
    spacing = list(np.linalg.norm(axes, axis=0)) if axes is not None else [spacings[i] if spacings else 1 for i in spatial]
    origin = _numbers(fields.get("space origin", "0 0 0"))[:3]
    affine = _affine(axes, origin, signs) if signs and axes is not None else None
    return Image(voxels, spacing, affine, _nrrd_step(fields, steps, spacings, outer))


def _nrrd_step(fields: dict[str, str], steps: list[list[float] | None] | None, spacings: list[float], axis: int | None) -> float:
    """Returns the time between phases in ms, or 0 if the file does not state it."""
    step: list[float] | None = steps[axis] if steps and axis is not None else None
    if step:
        value, unit, at = step[3], "space units", 3
    elif axis is not None and spacings:
        value, unit, at = spacings[axis], "units", axis
    else:
        return 0
    units = re.findall(r'"([^"]*)"', fields.get(unit, ""))
    ms = value * _MS.get(units[at] if at < len(units) else "", 0)
    return ms if np.isfinite(ms) else 0


_META_TYPES = {"MET_CHAR": "i1", "MET_UCHAR": "u1", "MET_SHORT": "i2", "MET_USHORT": "u2", "MET_INT": "i4", "MET_UINT": "u4",
               "MET_FLOAT": "f4", "MET_DOUBLE": "f8"}


def _read_meta_image(path: Path) -> Image | None:
    text, data = _header(path, rb"(?<=\n)(?=ElementDataFile)|$")
    line, _, data = data.partition(b"\n")
    fields: dict[str, str] = dict(re.findall(r"^\s*(\w+)\s*=\s*(.*?)\s*$", text, re.M))
    sizes = [int(one) for one in fields["DimSize"].split()]
    if len(sizes) > 4 or int(fields.get("ElementNumberOfChannels", 1)) != 1 or fields["ElementType"] not in _META_TYPES:
        return None
    file = line.split(b"=", 1)[1].strip().decode()
    packed = data if file.upper() == "LOCAL" else _beside(path, file)
    if fields.get("CompressedData", "False").lower() == "true":
        packed = zlib.decompress(packed)
    big = fields.get("BinaryDataByteOrderMSB", fields.get("ElementByteOrderMSB", "False")).lower() == "true"
    dtype = np.dtype((">" if big else "<") + _META_TYPES[fields["ElementType"]])
    voxels = np.frombuffer(packed, dtype, count=int(np.prod(sizes))).reshape(sizes, order="F")
    spacing = [abs(one) for one in _numbers(fields.get("ElementSpacing", fields.get("ElementSize", "1 1 1")))][:3]
    matrix = next((fields[key] for key in ("TransformMatrix", "Rotation", "Orientation") if key in fields), None)
    affine = None
    if matrix is not None:
        # Each row of the file's matrix is the direction of an axis.
        rows = np.array(_numbers(matrix)).reshape(len(sizes), len(sizes))[:3, :3]
        offset = next((fields[key] for key in ("Offset", "Position", "Origin") if key in fields), "0 0 0")
        affine = _affine(rows.T * spacing, _numbers(offset)[:3], (-1, -1, 1))
    modality = {"MET_MOD_CT": "CT", "MET_MOD_MR": "MR"}.get(fields.get("Modality", ""), "")
    return Image(voxels if sizes[3:] != [1] else voxels[..., 0], spacing, affine, modality=modality)


def _header(path: Path, end: bytes) -> tuple[str, bytes]:
    """Returns the text before the match of `end`, and what follows."""
    data = path.read_bytes()
    found = re.search(end, data[:_LONGEST_HEADER])
    at, after = found.span() if found else (len(data), len(data))
    return data[:at].decode("latin-1"), data[after:]


def _beside(path: Path, file: str) -> bytes:
    """Returns the voxels in a second file, which is in the folder of the header."""
    if Path(file).name != file or file.startswith("LIST") or "%" in file:
        raise ValueError("only one file in the same folder is supported")
    return (path.parent / file).read_bytes()


_READERS: tuple[tuple[tuple[str, ...], str, Callable[[Path], Image | None]], ...] = (
    ((".nii", ".nii.gz"), "NIfTI", _read_nifti), ((".nrrd",), "NRRD", _read_nrrd), ((".mha", ".mhd"), "MetaImage", _read_meta_image))
