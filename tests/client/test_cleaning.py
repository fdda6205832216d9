"""What the Python client sends of a file: the same as the page."""

from __future__ import annotations

import io
import re
import tarfile
from pathlib import Path

import nibabel
import numpy as np
import pydicom
import pytest
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian

from diaphane import UnreadableFile
from diaphane._cleaning import GROUPED_TAGS, IMAGE_WORDS, KEPT_TAGS, clean_dicom, clean_files, disguised_uid
from diaphane._upload import bundle

REPO = Path(__file__).resolve().parents[2]
CANARY = "Canary"


def slice_of(series: str = "1.2.3", number: int = 1) -> FileDataset:
    """Returns a slice with the canary word wherever a word fits."""
    meta = FileMetaDataset()
    meta.TransferSyntaxUID, meta.MediaStorageSOPClassUID = ExplicitVRLittleEndian, CTImageStorage
    made = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    made.SOPClassUID, made.SOPInstanceUID, made.StudyInstanceUID, made.SeriesInstanceUID = CTImageStorage, f"{series}.{number}", "1.2", series
    made.FrameOfReferenceUID = "1.2.840.99.7"
    made.PatientName, made.PatientID, made.PatientBirthDate, made.StudyDate = CANARY, CANARY, "19700101", "20200101"
    made.ImageComments = made.SeriesDescription = made.InstitutionName = CANARY
    made.Modality, made.ImageType, made.RescaleType = "CT", ["ORIGINAL", "PRIMARY", CANARY.upper()], "HU"
    made.ImagePositionPatient, made.ImageOrientationPatient, made.PixelSpacing = [0, 0, number], [1, 0, 0, 0, 1, 0], ["0.50", "0.50"]
    made.Rows = made.Columns = 2
    made.SamplesPerPixel, made.PhotometricInterpretation = 1, "MONOCHROME2"
    made.BitsAllocated = made.BitsStored = 16
    made.HighBit, made.PixelRepresentation, made.InstanceNumber = 15, 1, number
    made.RescaleSlope, made.RescaleIntercept = 1, -1024
    made.add_new(0x00091001, "LO", CANARY)
    made.PixelData = np.array([1, 2, 3, 4 + number], "<i2").tobytes()
    return made


def written(made: Dataset, path: Path) -> Path:
    pydicom.dcmwrite(path, made, enforce_file_format=False)
    return path


def test_the_lists_are_those_of_the_page():
    """A tag that one of the two starts or stops sending must change in the other, too."""
    page = (REPO / "frontend" / "src" / "scan" / "clean_file.ts").read_text(encoding="utf-8")
    kept = re.search(r"> = \{(.*?)\};\n\nexport const wantedTags", page, re.S)
    assert kept and {int(tag, 16): form for tag, form in re.findall(r'x(\w{8}): "(\w+)"', kept[1])} == KEPT_TAGS
    words = re.search(r"imageWords = new Set\(\[(.*?)\]\)", page, re.S)
    assert words and set(re.findall(r'"(\w+)"', words[1])) == IMAGE_WORDS
    grouped = re.search(r"groupedTags:.*?= \{(.*?)\};", page, re.S)
    assert grouped and GROUPED_TAGS == {int(group, 16): tuple(int(tag, 16) for tag in re.findall(r"x(\w{8})", tags))
                                        for group, tags in re.findall(r"x(\w{8}): \[(.*?)\]", grouped[1])}


def test_nothing_personal_is_left_and_the_voxels_are():
    made = slice_of()
    clean = clean_dicom(made, 7)
    assert CANARY.lower().encode() not in clean.lower() and b"19700101" not in clean and b"1.2.840.99.7" not in clean
    read = pydicom.dcmread(io.BytesIO(clean))
    assert read.PixelData == made.PixelData and read.PixelSpacing == made.PixelSpacing and read.RescaleIntercept == -1024
    assert list(read.ImageType) == ["ORIGINAL", "PRIMARY", "OTHER"]
    assert read.SOPInstanceUID == "2.25.1007" and read.FrameOfReferenceUID == disguised_uid("1.2.840.99.7")
    assert "PatientName" not in read and not any(element.tag.is_private for element in read)


def test_a_value_of_another_form_is_left_out():
    made = slice_of()
    made.Modality, made.RescaleType, made.FrameOfReferenceUID = CANARY, CANARY, CANARY
    read = pydicom.dcmread(io.BytesIO(clean_dicom(made, 1)))
    assert not {"Modality", "RescaleType", "FrameOfReferenceUID"} & set(read.dir())


def test_frames_of_an_enhanced_file_keep_only_their_geometry():
    made = slice_of()
    made.NumberOfFrames = 2
    made.PixelData = made.PixelData * 2
    shared, spacing = Dataset(), Dataset()
    spacing.PixelSpacing, spacing.SliceThickness = [1, 1], 2
    shared.PixelMeasuresSequence = [spacing]
    made.SharedFunctionalGroupsSequence = [shared]
    frames = []
    for number in range(2):
        frame, content, position = Dataset(), Dataset(), Dataset()
        content.StackID, content.FrameComments = CANARY, CANARY
        position.ImagePositionPatient = [0, 0, number]
        frame.FrameContentSequence, frame.PlanePositionSequence = [content], [position]
        frames.append(frame)
    made.PerFrameFunctionalGroupsSequence = frames
    clean = clean_dicom(made, 1)
    assert CANARY.encode() not in clean
    read = pydicom.dcmread(io.BytesIO(clean))
    second = read.PerFrameFunctionalGroupsSequence[1]
    assert second.PlanePositionSequence[0].ImagePositionPatient == [0, 0, 1]
    assert second.PixelMeasuresSequence[0].PixelSpacing == [1, 1] and "SharedFunctionalGroupsSequence" not in read
    assert second.FrameContentSequence[0].StackID == "bd6617f0"


def test_a_folder_with_several_series_needs_a_choice(tmp_path):
    for number in range(3):
        written(slice_of("1.2.3", number), tmp_path / f"a{number}")
    written(slice_of("1.2.4"), tmp_path / "b")
    (tmp_path / "notes.txt").write_text("nothing")
    with pytest.raises(UnreadableFile, match="1.2.3 \\(3 files\\)"):
        clean_files(tmp_path)
    assert len(clean_files(tmp_path, "1.2.3")) == 3
    assert len(clean_files(tmp_path / "b")) == 1
    with pytest.raises(UnreadableFile, match="no slices"):
        clean_files(tmp_path / "notes.txt")
    with pytest.raises(UnreadableFile, match="does not exist"):
        clean_files(tmp_path / "gone")


@pytest.mark.parametrize("suffix", [".nii", ".nii.gz"])
def test_a_nifti_file_gets_a_new_header(tmp_path, suffix):
    affine = np.array([[-2, 0, 0, 10], [0, 3, 0, 20], [0, 0, 4, 30], [0, 0, 0, 1.0]])
    image = nibabel.Nifti1Image(np.arange(24, dtype=np.int16).reshape(2, 3, 4, 1), affine)
    image.header["descrip"] = image.header["db_name"] = image.header["aux_file"] = CANARY.encode()
    image.header.extensions.append(nibabel.nifti1.Nifti1Extension("comment", CANARY.encode()))
    image.header.set_slope_inter(2, -5)
    nibabel.save(image, tmp_path / f"scan{suffix}")
    [clean] = clean_files(tmp_path / f"scan{suffix}")
    assert CANARY.encode() not in clean
    (tmp_path / "clean.nii").write_bytes(clean)
    read = nibabel.load(tmp_path / "clean.nii")
    assert np.array_equal(read.affine, affine) and read.shape == (2, 3, 4)
    assert np.array_equal(read.get_fdata(), nibabel.load(tmp_path / f"scan{suffix}").get_fdata()[..., 0])


@pytest.mark.parametrize("unit, step", [("sec", 2000), ("msec", 2), ("unknown", 0)])
def test_a_nifti_file_keeps_its_phases_and_the_time_between_them(tmp_path, unit, step):
    image = nibabel.Nifti1Image(np.arange(120, dtype=np.int16).reshape(2, 3, 4, 5), np.eye(4))
    image.header.set_zooms((1, 1, 1, 2))
    image.header.set_xyzt_units("mm", unit)
    nibabel.save(image, tmp_path / "scan.nii")
    (tmp_path / "clean.nii").write_bytes(*clean_files(tmp_path / "scan.nii"))
    read = nibabel.load(tmp_path / "clean.nii")
    assert np.array_equal(np.asarray(read.dataobj), np.asarray(image.dataobj))
    assert read.header["pixdim"][4] == step and read.header.get_xyzt_units() == ("mm", "msec" if step else "unknown")


def test_what_tells_phases_apart_is_kept_in_its_form_alone():
    made = slice_of()
    made.add_new(0x00209128, "UL", 3)
    made.add_new(0x00209241, "FL", 12.5)
    made.add_new(0x00189087, "FD", 1000.0)
    made.AcquisitionTime = "101112"
    read = pydicom.dcmread(io.BytesIO(clean_dicom(made, 1)))
    assert (read[0x00209128].value, read[0x00209241].value, read[0x00189087].value) == (3, 12.5, 1000)
    assert "AcquisitionTime" not in read
    made[0x00209128].VR, made[0x00209128].value = "LO", CANARY
    assert 0x00209128 not in pydicom.dcmread(io.BytesIO(clean_dicom(made, 1)))


def test_a_broken_nifti_file_is_explained(tmp_path):
    (tmp_path / "a.nii").write_bytes(b"nothing")
    with pytest.raises(UnreadableFile, match="a.nii"):
        clean_files(tmp_path / "a.nii")
    nibabel.save(nibabel.Nifti1Image(np.zeros((2, 2, 2, 5, 3), np.int16), np.eye(4)), tmp_path / "vectors.nii")
    with pytest.raises(UnreadableFile, match="single numbers"):
        clean_files(tmp_path / "vectors.nii")


def test_the_bundle_is_the_one_of_the_page():
    files = [b"first", b"x" * 512, b""]
    made = bundle(files)
    assert len(made) == (512 + 512) * 2 + 512 + 1024, "as bundleSize of the page says"
    with tarfile.open(fileobj=io.BytesIO(made)) as tar:
        members = tar.getmembers()
        assert [one.name for one in members] == ["00001.dcm", "00002.dcm", "00003.dcm"]
        assert {(one.mode, one.uid, one.gid, one.mtime, one.uname) for one in members} == {(0o644, 0, 0, 0, "")}
    assert made == bundle(files), "the same bytes each time, so that an upload can be resumed"
