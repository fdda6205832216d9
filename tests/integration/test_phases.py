"""Scans with several phases: from the upload to the store, and what the API, anonymising and exports make of them."""

from __future__ import annotations

import io
import json
from pathlib import Path

import nibabel
import numpy as np
import pytest
from api_client import Person, person
from cut_helpers import hash_of, order
from ingest_helpers import enqueue, volume_path, wait_end
from seeds import bundle
from test_scan_exports import download, request

from devtool.beating_heart import EXTENT, beating_heart, write_beating_heart
from devtool.ingest_cases.phantom import Series, dataset, stack

SIDE, PHASES = 32, 6


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "edge", "ingestd"))
    yield stack
    all_stacks.shut(stack)


@pytest.fixture(scope="module")
def owner(running) -> Person:
    return person(running)


@pytest.fixture(scope="module")
def heart() -> np.ndarray:
    """Returns the voxels as stored: phase, z, y, x."""
    return beating_heart(SIDE, PHASES).transpose(3, 2, 1, 0)


@pytest.fixture
def scan(running, owner, tmp_path) -> str:
    """Returns a beating heart that was uploaded as NIfTI."""
    file = tmp_path / "heart.nii"
    write_beating_heart(file, SIDE, PHASES, seconds=0.9)
    data_set = enqueue(running, bundle([file.read_bytes()]))
    running.psql("UPDATE data_sets SET owner_id = %s WHERE id = %s", owner.id, data_set)
    assert wait_end(running, data_set) == ("ready", None, None)
    return data_set


def stored(stack, data_set: str) -> tuple[dict, np.ndarray]:
    folder = volume_path(stack, data_set)
    header = json.loads((folder / "volume.json").read_text())
    voxels = np.fromfile(folder / "voxels.i16", "<i2")
    assert header["contentHash"] == hash_of(voxels.tobytes())
    return header, voxels.reshape(-1, *header["size"][::-1])


def test_every_phase_of_a_nifti_file_is_stored(running, owner, scan, heart):
    header, voxels = stored(running, scan)
    assert np.array_equal(voxels, heart)
    assert [phase["kind"] for phase in header["phases"]] == ["TIME"] * PHASES
    assert [phase["value"] for phase in header["phases"]] == pytest.approx([150 * i for i in range(PHASES)], rel=1e-6)
    assert (header["minimum"], header["maximum"]) == (heart.min(), heart.max())
    shown = owner.http.get(f"/v1/data-sets/{scan}").json()["volume"]
    assert (shown["phases"], shown["size"], shown["bytes"]) == (PHASES, [SIDE] * 3, heart.nbytes)


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_nifti_file_of_the_second_version_is_built_like_the_first(running, heart, order):
    header = nibabel.Nifti2Header(endianness=order)
    header.set_data_dtype(np.dtype(np.int16).newbyteorder(order))
    step = EXTENT / SIDE
    image = nibabel.Nifti2Image(heart.transpose(3, 2, 1, 0), np.diag([-step, -step, step, 1]), header)
    image.header.set_xyzt_units("mm", "sec")
    image.header.set_zooms((step, step, step, 0.15))
    data_set = enqueue(running, bundle([image.to_bytes()]))
    assert wait_end(running, data_set) == ("ready", None, None)
    header, voxels = stored(running, data_set)
    assert np.array_equal(voxels, heart)
    assert [phase["value"] for phase in header["phases"]] == pytest.approx([150 * i for i in range(PHASES)], rel=1e-6)


def dicom_series(values: np.ndarray, kept=lambda phase, z: True, **attributes) -> list[bytes]:
    """Returns a series with these phases in no order. `attributes`: values by phase."""
    files = []
    step = EXTENT / SIDE
    slices = stack([step * z for z in range(SIDE)], rows=SIDE, columns=SIDE)
    for phase, volume in enumerate(values):
        for z, picture in enumerate(volume):
            made = dataset(Series(), slices[z])
            made.BitsStored = made.BitsAllocated = 16
            made.HighBit, made.PixelRepresentation, made.RescaleIntercept, made.RescaleSlope = 15, 1, 0, 1
            made.PixelData = picture.tobytes()
            for name, value in attributes.items():
                setattr(made, name, value(phase))
            made.InstanceNumber = 1 + (phase * 7919 + z * 31) % 997
            out = io.BytesIO()
            made.save_as(out, enforce_file_format=True)
            if kept(phase, z):
                files.append(out.getvalue())
    return [files[(i * 7919) % len(files)] for i in range(len(files))]


def test_a_cardiac_series_is_split_by_its_trigger_times(running, heart):
    data_set = enqueue(running, bundle(dicom_series(heart, TriggerTime=lambda phase: 75 * phase)))
    assert wait_end(running, data_set) == ("ready", None, None)
    header, voxels = stored(running, data_set)
    assert np.array_equal(voxels, heart)
    assert [phase["value"] for phase in header["phases"]] == [75 * i for i in range(PHASES)]


def test_an_incomplete_phase_is_left_out_and_said(running, heart):
    files = dicom_series(heart, lambda phase, z: phase < PHASES - 1 or z < 20,
                         AcquisitionTime=lambda phase: f"1000{10 + phase}")
    data_set = enqueue(running, bundle(files))
    assert wait_end(running, data_set) == ("ready", None, None)
    header, voxels = stored(running, data_set)
    assert np.array_equal(voxels, heart[:-1])
    assert header["repairs"] == ["1 phase was incomplete and left out"]
    assert running.psql("SELECT phases FROM data_sets WHERE id = %s", data_set) == [(PHASES - 1,)]


def test_anonymising_cuts_every_phase(running, scan, heart):
    content = stored(running, scan)[0]["contentHash"]
    keep = {"box": {"low": [-150, -150, -150], "high": [150, 150, 0]}, "planes": []}
    order(running, scan, content, keep)
    running.wait_until(lambda: running.psql("SELECT state FROM data_sets WHERE id = %s", scan) == [("ready",)],
                       what="the end of the cut")
    header, voxels = stored(running, scan)
    assert len(header["phases"]) == PHASES
    assert np.array_equal(voxels, heart[:, :SIDE // 2])
    assert running.psql("SELECT volume_bytes, phases FROM data_sets WHERE id = %s", scan) == [(voxels.nbytes, PHASES)]


def test_nifti_exports_every_phase(running, owner, scan, heart, tmp_path: Path):
    assert request(owner, scan, format="nifti")["state"] == "ready"
    image = nibabel.load(download(owner, scan, "scan.nii.gz", tmp_path))
    assert np.array_equal(np.asarray(image.dataobj), heart.transpose(3, 2, 1, 0))
    assert image.header.get_zooms()[3] == pytest.approx(150)
    assert image.header.get_xyzt_units() == ("mm", "msec")


def test_a_surface_is_that_of_the_chosen_phase(running, owner, scan, tmp_path: Path):
    import trimesh

    volumes = {}
    for phase in (0, PHASES // 2):
        made = request(owner, scan, format="stl", above=330, phase=phase)
        assert (made["state"], made["phase"]) == ("ready", phase)
        # Bone stays, and the blood in the ventricles becomes less.
        volumes[phase] = trimesh.load(download(owner, scan, "surface.stl", tmp_path)).volume
    assert volumes[PHASES // 2] < volumes[0]
    beyond = request(owner, scan, format="stl", above=330, phase=PHASES)
    assert (beyond["state"], beyond["problem"]["code"]) == ("failed", "nothing_inside")
    assert "no such phase" in beyond["problem"]["text"]
    assert owner.http.post(f"/v1/data-sets/{scan}/export", json={"format": "nifti", "phase": 2}).status_code == 422
