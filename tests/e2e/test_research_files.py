"""Scans in research formats: NIfTI, NRRD and MetaImage, chosen in the page and built by the server."""

from __future__ import annotations

import gzip
import json
import struct
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from harness import TestStack
from person import Person
from devtool.ingest_cases.phantom import Series, dataset, stack

#: Voxels towards the patient's left, back and head, and their distances in mm.
SIZE = (48, 40, 32)
STEP = np.array((1.0, 1.5, 2.0))
#: Voxels (left, back, head) with their own values: a place, and others to the left of it, behind it and above it.
MARKS = {2001: (10, 20, 8), 2002: (30, 20, 8), 2003: (10, 32, 8), 2004: (10, 20, 25)}
#: As a careless program writes it into a header.
CANARY = "Jane Canary"


def phantom() -> np.ndarray:
    """A block of soft tissue in air, with the marks. The axes run to the left, the back and the head."""
    values = np.full(SIZE, -1000, np.int16)
    values[6:42, 6:34, 4:28] = 60
    for mark, place in MARKS.items():
        values[place] = mark
    return values


def nifti(values: np.ndarray) -> bytes:
    """The axes of the file run to the feet, to the left and to the front: an orientation that no scanner uses."""
    stored = values.transpose(2, 0, 1)[::-1, :, ::-1]
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *stored.shape, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 4, 16)
    struct.pack_into("<4f", header, 76, 1, STEP[2], STEP[0], STEP[1])
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[148:148 + len(CANARY)] = CANARY.encode()
    struct.pack_into("<h", header, 254, 1)
    # In the frame of NIfTI (right, front, head), row by row.
    struct.pack_into("<12f", header, 280, 0, -STEP[0], 0, 0, 0, 0, STEP[1], 0, -STEP[2], 0, 0, 0)
    header[344:347] = b"n+1"
    return bytes(header) + stored.tobytes(order="F")


def nrrd(values: np.ndarray) -> bytes:
    """The axes of the file run to the right, to the back and to the head, in a left-handed space."""
    stored = values[::-1]
    header = (f"NRRD0004\n# {CANARY}\ntype: short\ndimension: 3\nspace: left-anterior-superior\nsizes: {' '.join(map(str, SIZE))}\n"
              f"space directions: ({-STEP[0]},0,0) (0,{-STEP[1]},0) (0,0,{STEP[2]})\nencoding: gzip\nendian: little\n"
              f"PatientName:={CANARY}\n\n")
    return header.encode() + gzip.compress(stored.tobytes(order="F"))


def meta_image(values: np.ndarray, folder: Path) -> list[Path]:
    """A header and a file with the voxels, from head to feet."""
    (folder / "scan.raw").write_bytes(values[:, :, ::-1].tobytes(order="F"))
    (folder / "scan.mhd").write_text(
        f"ObjectType = Image\nNDims = 3\nComment = {CANARY}\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
        f"TransformMatrix = 1 0 0 0 1 0 0 0 -1\nElementSpacing = {' '.join(map(str, STEP))}\nDimSize = {' '.join(map(str, SIZE))}\n"
        "Modality = MET_MOD_CT\nElementType = MET_SHORT\nElementDataFile = scan.raw\n")
    return [folder / "scan.mhd", folder / "scan.raw"]


def place(header: dict, voxels: np.ndarray, value: int) -> np.ndarray:
    """Returns where a voxel lies in the patient, in mm from the first voxel."""
    direction = np.array(header.get("direction", np.eye(3))).reshape(3, 3)
    found = np.argwhere(voxels == value)
    assert len(found) == 1
    return direction @ (found[0] * np.array(header["spacing"]))


@pytest.fixture
def person(stack: TestStack, visit) -> Person:
    return Person.arrives(stack, visit(), "nils")


def choose(person: Person, files: list[Path]) -> None:
    person.page.goto(person.stack.url + "/add")
    person.page.get_by_label("Choose files").set_input_files(files)


def test_files_of_all_formats_show_the_same_patient(person: Person, tmp_path: Path, pictures: Path | None):
    page, stack = person.page, person.stack
    values = phantom()
    (tmp_path / f"{CANARY}.nii.gz").write_bytes(gzip.compress(nifti(values)))
    (tmp_path / "scan.nrrd").write_bytes(nrrd(values))
    choose(person, [tmp_path / f"{CANARY}.nii.gz", tmp_path / "scan.nrrd", *meta_image(values, tmp_path)])
    expect(page.get_by_role("heading", name="3 image series can be shown")).to_be_visible()
    if pictures:
        page.screenshot(path=pictures / "research-files.png", full_page=True)
    expect(page.get_by_role("heading", name=f"{CANARY}.nii.gz")).to_be_visible()
    for i, title in enumerate(("packed", "nrrd", "meta")):
        page.get_by_label("Your name for this scan").nth(i).fill(title)
    page.get_by_role("button", name="Upload all 3").click()
    expect(page.get_by_text("The upload has started.")).to_have_count(3)
    page.get_by_role("link", name="My scans").first.click()
    places = []
    for title in ("packed", "nrrd", "meta"):
        expect(person.card(title)).to_have_attribute("data-state", "ready")
        folder = stack.data_dir / "volumes" / person.card(title).get_attribute("data-id")
        stored = (folder / "volume.json").read_text()
        assert CANARY not in stored
        assert ("CT" in person.card(title).locator(".chip").all_inner_texts()) == (title == "meta"), "only this file says its kind"
        header = json.loads(stored)
        voxels = np.frombuffer((folder / "voxels.i16").read_bytes(), "<i2").reshape(header["size"], order="F")
        assert sorted(header["size"]) == sorted(SIZE) and (voxels == 60).sum() == (values == 60).sum()
        start = place(header, voxels, 2001)
        places.append([place(header, voxels, mark) - start for mark in (2002, 2003, 2004)])
    assert np.allclose(places, [np.diag((20, 12, 17)) * STEP] * 3, atol=1e-3)
    person.open_scan("meta")
    if pictures:
        page.screenshot(path=pictures / "research-file-picture.png")


def test_a_header_without_its_voxels_is_refused_with_a_message(person: Person, tmp_path: Path):
    header, voxels = meta_image(phantom(), tmp_path)
    choose(person, [header])
    expect(person.page.get_by_text("The image data is in a second file. Choose both files together.")).to_be_visible()
    choose(person, [voxels, header])
    expect(person.page.get_by_role("heading", name="1 image series can be shown")).to_be_visible()


PHASES = 6


def moments() -> np.ndarray:
    """The block in six moments, 40 ms apart, which becomes denser."""
    return np.stack([np.where(phantom() == 60, 60 + 10 * phase, phantom()) for phase in range(PHASES)]).astype(np.int16)


def nrrd_of_moments() -> bytes:
    """The moments of a voxel lie beside each other, as 3D Slicer writes them."""
    header = (f"NRRD0005\n# {CANARY}\ntype: int16\ndimension: 4\nspace: left-posterior-superior\nkinds: list domain domain domain\n"
              f"sizes: {PHASES} {' '.join(map(str, SIZE))}\nspacings: 40 nan nan nan\nunits: \"ms\" \"\" \"\" \"\"\n"
              f"space directions: none ({STEP[0]},0,0) (0,{STEP[1]},0) (0,0,{STEP[2]})\nencoding: raw\nendian: big\n\n")
    return header.encode() + moments().astype(">i2").tobytes(order="F")


def dicom_of_moments(folder: Path) -> list[Path]:
    """Returns the slices of the moments, told apart by their trigger times."""
    places = stack([STEP[2] * z for z in range(SIZE[2])], rows=SIZE[1], columns=SIZE[0])
    series, files = Series(), []
    for phase, values in enumerate(moments()):
        for z, place_of_slice in enumerate(places):
            made = dataset(series, place_of_slice)
            made.BitsStored = made.BitsAllocated = 16
            made.HighBit, made.PixelRepresentation, made.RescaleIntercept, made.RescaleSlope = 15, 1, 0, 1
            made.PixelData, made.TriggerTime = values[:, :, z].tobytes(order="F"), 40 * phase
            files.append(folder / f"{phase}-{z}.dcm")
            made.save_as(files[-1], enforce_file_format=True)
    return files


@pytest.mark.parametrize("source", ["nrrd", "dicom"])
def test_only_the_chosen_phases_are_uploaded(source, person: Person, tmp_path: Path, pictures: Path | None):
    page = person.page
    if source == "nrrd":
        (tmp_path / "heart.nrrd").write_bytes(nrrd_of_moments())
    choose(person, [tmp_path / "heart.nrrd"] if source == "nrrd" else dicom_of_moments(tmp_path))
    expect(page.get_by_text("6 phases over 200 ms")).to_be_visible()
    page.get_by_label("Phases to upload").select_option("Only one")
    page.get_by_label("Phase", exact=True).select_option("5 of 6")
    if pictures:
        page.screenshot(path=pictures / f"phases-to-upload-{source}.png", full_page=True)
    page.get_by_label("Phases to upload").select_option("Every fourth (2)")
    page.get_by_label("Your name for this scan").fill("heart")
    with page.expect_request(lambda request: request.method == "POST" and request.url.endswith("/v1/data-sets")) as announced:
        page.get_by_role("button", name="Upload", exact=True).click()
    expect(person.card("heart")).to_have_attribute("data-state", "ready")
    folder = person.stack.data_dir / "volumes" / person.card("heart").get_attribute("data-id")
    header = json.loads((folder / "volume.json").read_text())
    assert [(phase["kind"], round(phase["value"], 3)) for phase in header["phases"]] == [("TIME", 0), ("TIME", 160)]
    voxels = np.frombuffer((folder / "voxels.i16").read_bytes(), "<i2").reshape((*SIZE, 2), order="F")
    assert np.array_equal(voxels, np.moveaxis(moments()[::4], 0, -1))
    # Each of the 32 DICOM files of a moment has a header of less than 2 KB, and so has each file of a bundle.
    assert voxels.nbytes < announced.value.post_data_json["bytes"] < voxels.nbytes + 2 * SIZE[2] * 2048
