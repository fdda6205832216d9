"""What the Python client sends of NIfTI, NRRD and MetaImage files, and of archives: the same as the page."""

from __future__ import annotations

import gzip
import zipfile
import zlib
from pathlib import Path
from typing import Callable

import nibabel
import numpy as np
import pytest
from test_cleaning import CANARY, slice_of, written

from diaphane import UnreadableFile
from diaphane._cleaning import clean_files

SHAPE, STEP = (5, 4, 3, 6), (1.0, 1.5, 2.0)
#: The place of each voxel in NIfTI's space (right, front, head).
AFFINE = np.array([[-1, 0, 0, 7], [0, -1.5, 0, -8], [0, 0, 2, 9], [0, 0, 0, 1.0]])


def moments() -> np.ndarray:
    return np.arange(np.prod(SHAPE), dtype=np.int16).reshape(SHAPE)


def second_nifti(path: Path) -> Path:
    header = nibabel.Nifti2Header(endianness=">")
    header.set_data_dtype(">i2")
    image = nibabel.Nifti2Image(moments(), AFFINE, header)
    image.header.set_xyzt_units("mm", "msec")
    image.header.set_zooms((*STEP, 40))
    image.header["descrip"] = CANARY.encode()
    nibabel.save(image, path.with_suffix(".nii"))
    return path.with_suffix(".nii")


def nrrd(path: Path, first: bool = False, kind: str = "list", encoding: str = "raw", parts: int = SHAPE[3]) -> Path:
    """In LPS, with the phases as the first or the last axis."""
    def placed(axes: list[str], own: str) -> str:
        return " ".join([own, *axes] if first else [*axes, own])

    values = moments()[..., :parts]
    data = (np.moveaxis(values, 3, 0) if first else values).astype(">i2").tobytes(order="F")
    path = path.with_suffix(".nrrd")
    units = placed(['""'] * 3, '"ms"')
    path.write_bytes(
        f"NRRD0004\n# {CANARY}\ntype: short\ndimension: 4\nspace: left-posterior-superior\nsizes: {placed(['5', '4', '3'], str(parts))}\n"
        f"space directions: {placed(['(1,0,0)', '(0,1.5,0)', '(0,0,2)'], 'none')}\nkinds: {placed(['domain'] * 3, kind)}\n"
        f"spacings: {placed(['nan'] * 3, '40')}\nunits: {units}\nendian: big\nencoding: {encoding}\n"
        f"space origin: (-7,8,9)\nPatientName:={CANARY}\n\n".encode() + (gzip.compress(data) if encoding == "gzip" else data))
    return path


def meta_image(path: Path, packed: bool = False, beside: bool = False) -> Path:
    data = moments().astype("<i2").tobytes(order="F")
    data = zlib.compress(data) if packed else data
    path = path.with_suffix(".mhd" if beside else ".mha")
    if beside:
        path.with_suffix(".raw").write_bytes(data)
    path.write_bytes(
        f"ObjectType = Image\nNDims = 4\nComment = {CANARY}\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = {packed}\n"
        "TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nOffset = -7 8 9 0\nElementSpacing = 1 1.5 2 1\nDimSize = 5 4 3 6\n"
        f"ElementType = MET_SHORT\nElementDataFile = {path.with_suffix('.raw').name if beside else 'LOCAL'}\n".encode()
        + (b"" if beside else data))
    return path


FILES: dict[str, Callable[[Path], Path]] = {
    "NIfTI-2": second_nifti,
    "NRRD": nrrd,
    "NRRD, phases first": lambda path: nrrd(path, first=True),
    "NRRD, time": lambda path: nrrd(path, kind="time", encoding="gzip"),
    "MetaImage": meta_image,
    "MetaImage, compressed": lambda path: meta_image(path, packed=True),
    "MetaImage, two files": lambda path: meta_image(path, beside=True),
}


def read(clean: bytes, path: Path) -> nibabel.Nifti1Image:
    path.write_bytes(clean)
    return nibabel.load(path)


@pytest.mark.parametrize("name", FILES)
def test_a_research_file_is_sent_with_all_phases_and_without_texts(name, tmp_path):
    file = FILES[name](tmp_path / "scan")
    clean, = clean_files(file)
    assert CANARY.encode() not in clean and len(clean) == 352 + moments().nbytes
    image = read(clean, tmp_path / "clean.nii")
    assert np.array_equal(np.asarray(image.dataobj), moments())
    assert np.array_equal(image.affine, AFFINE)
    assert image.header["pixdim"][4] == (0 if name.startswith("Meta") else 40)


@pytest.mark.parametrize("name", FILES)
def test_only_the_chosen_phases_are_sent(name, tmp_path):
    file = FILES[name](tmp_path / "scan")
    for phases, step in (((0, 2, 4), 80), ((5, 0, 1), 0), ([3], 0)):
        clean, = clean_files(file, phases=phases)
        image = read(clean, tmp_path / "clean.nii")
        kept = moments()[..., sorted(phases)]
        assert np.array_equal(np.asarray(image.dataobj), kept[..., 0] if len(phases) == 1 else kept)
        assert image.header["pixdim"][4] == (0 if name.startswith("Meta") else step)
    for phases in ([6], [-1], []):
        with pytest.raises(ValueError, match="from 0 to 5"):
            clean_files(file, phases=phases)


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_research_file_is_explained(name, tmp_path):
    file = FILES[name](tmp_path / "scan")
    whole = file.read_bytes()
    for damaged in (whole[:100], b"", b"x" * 600, *([] if "two files" in name else [whole[:-20]])):
        file.write_bytes(damaged)
        with pytest.raises(UnreadableFile, match=file.name):
            clean_files(file)


def test_colours_and_vectors_are_refused(tmp_path):
    for made in (nrrd(tmp_path / "a", first=True, kind="vector"), nrrd(tmp_path / "b", first=True, kind="???", parts=3)):
        with pytest.raises(UnreadableFile, match="single numbers"):
            clean_files(made)


def test_an_archive_is_sent_like_the_folder_in_it(tmp_path):
    folder = tmp_path / "disc"
    folder.mkdir()
    for number in (1, 2):
        written(slice_of(number=number), folder / f"{number}.dcm")
    with zipfile.ZipFile(tmp_path / "disc.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for file in folder.iterdir():
            archive.write(file, f"DICOM/{file.name}")
    assert clean_files(tmp_path / "disc.zip") == clean_files(folder)
    with pytest.raises(ValueError, match="phases"):
        clean_files(folder, phases=[0])
    file = nrrd(tmp_path / "scan")
    with zipfile.ZipFile(tmp_path / "scan.zip", "w") as archive:
        archive.write(file, "heart/scan.nrrd")
    assert clean_files(tmp_path / "scan.zip", phases=[1]) == clean_files(file, phases=[1])
    whole = bytearray((tmp_path / "disc.zip").read_bytes())
    whole[60:90] = bytes(30)
    (tmp_path / "broken.zip").write_bytes(whole)
    with pytest.raises(UnreadableFile, match="broken.zip"):
        clean_files(tmp_path / "broken.zip")
