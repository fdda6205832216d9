"""`diaphane scan`: reports the contents of a folder as text and as JSON. Needs no server."""

from __future__ import annotations

import gzip
import json
import subprocess
from pathlib import Path

import nibabel
import numpy as np
import pytest
from ingest_helpers import CANARY

from harness import REPO  # noqa: F401  (puts tools/ on the path)
from devtool import paths

BIN = paths.build_dir() / "bin"


def scan(*arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([str(BIN / "diaphane-scan"), *arguments], capture_output=True, text=True)


@pytest.fixture(scope="module")
def disc(tmp_path_factory) -> Path:
    """A folder from a hospital: a series, a damaged copy of one slice, and a file that is not an image."""
    folder = tmp_path_factory.mktemp("disc")
    subprocess.run([str(BIN / "diaphane-sample"), "--write-dicom", str(folder / "DICOM" / "S1")], check=True)
    (folder / "README.TXT").write_text("viewer for another system")
    (folder / "AUTORUN.INF").write_bytes(b"\0" * 300)
    first = next((folder / "DICOM" / "S1").iterdir())
    (folder / "DICOM" / "BROKEN").write_bytes(first.read_bytes()[:4000])
    return folder


def test_a_series_is_listed_as_text(disc):
    done = scan(str(disc))
    assert done.returncode == 0 and done.stderr == ""
    assert "111 files, 1 series, 1 suitable" in done.stdout
    for word in ("CT", "axial", "108 slices", "256 x 256 x 108", "0.957 x 0.957 x 1.500 mm", "1 file is damaged",
                 "2 files are not DICOM"):
        assert word in done.stdout, word


def test_a_series_is_listed_as_json(disc):
    done = scan(str(disc), "--json")
    assert done.returncode == 0
    found = json.loads(done.stdout)
    series, = found["series"]
    assert series["suitable"] and series["reason"] is None and series["modality"] == "CT"
    assert series["size"] == [256, 256, 108] and series["slices"] == 108
    assert series["spacing_mm"] == pytest.approx([0.957031, 0.957031, 1.5])
    assert series["direction"] == [1, 0, 0, 0, 1, 0, 0, 0, 1] and series["plane"] == "axial"
    assert found["left_out"] == {"not_dicom": 2, "damaged": 1, "too_large": 0, "unsupported": 0, "not_slices": 0}


def test_the_patient_is_not_shown(disc):
    for arguments in ([], ["--json"]):
        assert CANARY not in scan(str(disc), *arguments).stdout


def test_the_reason_for_an_unsuitable_series_is_reported(disc, tmp_path):
    for number, file in enumerate(sorted((disc / "DICOM" / "S1").iterdir())[:3]):
        (tmp_path / str(number)).write_bytes(file.read_bytes())
    done = scan(str(tmp_path))
    assert done.returncode == 0 and "not suitable, 3 files: Too few slices" in done.stdout
    series, = json.loads(scan(str(tmp_path), "--json").stdout)["series"]
    assert not series["suitable"] and series["reason"]["code"] == "too_few_slices" and series["size"] is None


def test_invalid_folders_and_arguments_have_exit_codes(tmp_path, disc):
    assert scan(str(tmp_path / "nowhere")).returncode == 66
    assert scan(str(disc / "README.TXT")).returncode == 66
    assert scan(str(tmp_path / "nowhere.nii")).returncode == 66
    empty = scan(str(tmp_path))
    assert empty.returncode == 65 and "It contains no files." in empty.stderr
    (tmp_path / "text").write_text("no DICOM")
    assert "It contains no DICOM files." in scan(str(tmp_path)).stderr
    assert scan().returncode == 64
    assert scan("--what").returncode == 64
    assert scan("a", "b").returncode == 64
    assert scan("--help").returncode == 0 and "FOLDER" in scan("--help").stdout


def test_the_sample_tool_reports_errors(tmp_path):
    def sample(*arguments: str) -> subprocess.CompletedProcess:
        return subprocess.run([str(BIN / "diaphane-sample"), *arguments], capture_output=True, text=True)
    assert sample().returncode == 78
    assert sample("--nonsense", "1").returncode == 64
    missing = sample("--cranium", str(tmp_path / "none"), "--mapped-mha", str(tmp_path / "x.mha"))
    assert missing.returncode == 66 and "invesalius-examples" in missing.stderr
    assert sample("--mapped-mha", "/proc/none/x.mha").returncode == 73
    assert sample("--upload", "http://127.0.0.1:9").returncode == 78


#: Size, phases and distances in mm of a research file.
SHAPE, STEP = (20, 18, 16, 5), (1.0, 1.5, 2.0)


def moments() -> np.ndarray:
    """Distinct voxels (left, back, head, phase)."""
    return np.random.default_rng(7).permutation(np.prod(SHAPE)).astype(np.int16).reshape(SHAPE)


def nifti(version: type, order: str, file: Path) -> None:
    """As nibabel writes it, whose axes run to the right and the front."""
    header = version.header_class(endianness=order)
    header.set_data_dtype(np.dtype(np.int16).newbyteorder(order))
    image = version(moments(), np.diag((-STEP[0], -STEP[1], STEP[2], 1)), header)
    image.header.set_xyzt_units("mm", "msec")
    image.header.set_zooms((*STEP, 40))
    image.to_filename(file)


def nrrd(file: Path) -> None:
    """The phases lie beside each other, as 3D Slicer writes them, and the axes of space run to the right and the front."""
    stored = moments()[::-1, ::-1].transpose(3, 0, 1, 2)
    file.write_bytes(
        b"NRRD0005\ntype: int16\ndimension: 4\nspace: right-anterior-superior\nsizes: 5 20 18 16\n"
        b"space directions: none (1,0,0) (0,1.5,0) (0,0,2)\nkinds: list domain domain domain\n"
        b"spacings: 40 nan nan nan\nunits: \"ms\" \"\" \"\" \"\"\nendian: big\nencoding: gzip\n\n"
        + gzip.compress(stored.astype(">i2").tobytes(order="F")))


def meta_image(file: Path) -> None:
    """As SimpleITK writes an image of four dimensions. The format has no unit of time."""
    file.write_bytes(
        b"ObjectType = Image\nNDims = 4\nBinaryData = True\nBinaryDataByteOrderMSB = True\nCompressedData = False\n"
        b"TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nOffset = 0 0 0 0\nCenterOfRotation = 0 0 0 0\n"
        b"ElementSpacing = 1 1.5 2 40\nDimSize = 20 18 16 5\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
        + moments().astype(">i2").tobytes(order="F"))


RESEARCH_FILES = {
    "first.nii": lambda file: nifti(nibabel.Nifti1Image, "<", file),
    "second.nii.gz": lambda file: nifti(nibabel.Nifti2Image, "<", file),
    "big.nii": lambda file: nifti(nibabel.Nifti2Image, ">", file),
    "slicer.nrrd": nrrd,
    "itk.mha": meta_image,
}


@pytest.mark.parametrize("name", RESEARCH_FILES)
def test_every_phase_of_a_research_file_is_read(name, tmp_path):
    file = tmp_path / name
    RESEARCH_FILES[name](file)
    done = scan(str(file), "--json", "--build", str(tmp_path / "built"))
    assert (done.returncode, done.stderr) == (0, "")
    series, = json.loads(done.stdout)["series"]
    assert series["suitable"] and series["size"] == [20, 18, 16] and series["plane"] == "axial"
    assert series["spacing_mm"] == pytest.approx(STEP)
    timed = name != "itk.mha"
    assert series["phases"]["by"] == ("time" if timed else "index")
    assert series["phases"]["values"] == pytest.approx([i * (40 if timed else 1) for i in range(SHAPE[3])])
    header = json.loads((tmp_path / "built" / "volume.json").read_text())
    direction = np.array(header.get("direction", np.eye(3).ravel())).reshape(3, 3)
    ahead = -1 if name == "slicer.nrrd" else 1
    assert np.allclose(direction, np.diag((ahead, ahead, 1)))
    stored = np.fromfile(tmp_path / "built" / "voxels.i16", "<i2").reshape(SHAPE, order="F")
    assert np.array_equal(stored[::ahead, ::ahead], moments())
    assert "5 phases, by" in scan(str(file)).stdout


@pytest.mark.parametrize("options, kept", [(("--every", "2"), [0, 2, 4]), (("--phases", "0,3,4"), [0, 3, 4]), (("--phases", "1"), [1])])
def test_only_the_chosen_phases_are_built(options, kept, tmp_path):
    nrrd(tmp_path / "heart.nrrd")
    assert scan(str(tmp_path / "heart.nrrd"), "--build", str(tmp_path / "built"), *options).returncode == 0
    header = json.loads((tmp_path / "built" / "volume.json").read_text())
    assert [phase["value"] for phase in header.get("phases", [])] == pytest.approx([40 * i for i in kept] if len(kept) > 1 else [])
    stored = np.fromfile(tmp_path / "built" / "voxels.i16", "<i2").reshape((*SHAPE[:3], len(kept)), order="F")
    assert np.array_equal(stored[::-1, ::-1], moments()[..., kept])


def test_bad_choices_of_phases_are_refused(tmp_path):
    nrrd(tmp_path / "heart.nrrd")
    heart, built = str(tmp_path / "heart.nrrd"), str(tmp_path / "built")
    beyond = scan(heart, "--build", built, "--phases", "0,5")
    assert beyond.returncode == 65 and "there is no phase 5; the last one is 4" in beyond.stderr
    for options in (("--phases", "a"), ("--every", "0"), ("--phases", "1", "--every", "2"), ("--phases",)):
        assert scan(heart, "--build", built, *options).returncode == 64
    assert scan(heart, "--every", "2").returncode == 64, "there is nothing to build"
    assert not (tmp_path / "built").exists()


@pytest.mark.parametrize("name", RESEARCH_FILES)
def test_a_damaged_research_file_is_refused(name, tmp_path):
    file = tmp_path / name
    RESEARCH_FILES[name](file)
    whole = file.read_bytes()
    for damaged in (whole[:-40], whole[:200], b"", b"x" * 600):
        file.write_bytes(damaged)
        done = scan(str(file), "--build", str(tmp_path / "built"))
        assert done.returncode == 65 and done.stdout == "" and done.stderr.startswith("diaphane-scan: ")
        assert not (tmp_path / "built").exists()
