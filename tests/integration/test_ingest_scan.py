"""`diaphane scan`: reports the contents of a folder as text and as JSON. Needs no server."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

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
