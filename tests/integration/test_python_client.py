"""The Python client against the whole of Diaphane, and the notebook that uses it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import nbclient
import nbformat
import nibabel
import numpy as np
import phantom
import pytest
import trimesh
from api_client import PASSWORD, Person, person
from diaphane import AuthenticationError, Diaphane, ForbiddenError, NotFoundError, ScanError, StreamError
from google.protobuf import json_format
from harness import REPO, TestStack, contents_below
from PIL import Image

NOTEBOOK = REPO / "docs" / "notebooks" / "error-and-looks.ipynb"


@pytest.fixture(scope="module")
def owner(stack: TestStack) -> Person:
    return person(stack)


def token_of(who: Person, *scopes: str) -> str:
    given = {"name": "Test", "scopes": list(scopes), "days": 1, "password": PASSWORD}
    return who.http.post("/v1/me/tokens", json=given).json()["token"]


@pytest.fixture(scope="module")
def server(stack, owner):
    with Diaphane(stack.url, token_of(owner, "read", "write")) as made:
        yield made


@pytest.fixture(scope="module")
def scan(server, tmp_path_factory):
    shares: list[float] = []
    made = server.upload(phantom.write(tmp_path_factory.mktemp("scan")), title="Phantom", progress=shares.append)
    assert shares[-1] == 1
    yield made.wait()
    made.delete()


def test_an_upload_becomes_a_scan_without_a_name(stack, server, scan):
    assert scan.state == "ready" and scan.data["volume"]["modality"] == "CT"
    assert scan.data["volume"]["size"] == [phantom.SIDE, phantom.SIDE, phantom.SLICES]
    assert scan.id in [one.id for one in server.scans()] and server.scan(scan.id).title == "Phantom"
    assert scan.rename("Head").title == "Head"
    kept = [path for path, data in contents_below(stack.data_dir / "volumes", stack.data_dir / "uploads") if b"Canary" in data]
    assert kept == []


def test_pictures_have_the_error_that_was_asked_for(scan):
    with scan.session(96, 64) as session:
        assert {"bone", "skin"} <= set(session.looks)
        rough, fine = session.render("bone", samples=2), session.render("bone", error=0.05)
        best = session.render("bone", error=0.01).array().astype(float)
        other = session.render("skin", samples=2)
    for picture in (rough, fine, other):
        assert picture.array().shape == (64, 96, 3)
        assert picture.curve.points[-1].error == pytest.approx(picture.error, rel=0.5)
        assert (np.diff(picture.curve.seconds) > 0).all() and (np.diff(picture.curve.samples) > 0).all()
    assert 0 < fine.error <= 0.05 < rough.error < np.inf and rough.samples == 2 < fine.samples
    assert np.std(rough.array() - best) > np.std(fine.array() - best), "a smaller error is closer to the finished picture"
    assert np.std(other.array() - best) > np.std(rough.array() - best), "another look is another picture"


def test_a_changed_scene_is_rendered_and_a_wrong_one_is_explained(scan):
    with scan.session(32, 32) as session:
        scene = session.looks["bone"]
        for channel in scene.transfer_function.channels:
            channel.disabled = True
        empty = session.render(scene, error=0.5).array()
        assert np.std(empty) < np.std(session.render("bone", error=0.5).array())
        scene.camera.vertical_fov_degrees = 200
        with pytest.raises(StreamError) as caught:
            session.render(scene)
        assert caught.value.field == "camera.verticalFovDegrees"
        assert session.render("bone", error=1, width=48).width == 48, "the session continues"


def test_slices_are_the_voxels_of_the_files(scan):
    with scan.session() as session:
        middle = session.slice("axial")
        voxels = session.voxels()
    truth = phantom.values()
    assert voxels.shape == truth.shape and voxels.dtype == np.int16
    assert any(np.array_equal(voxels, one) for one in (truth, truth[::-1])), "in the order of the axial slices"
    assert np.array_equal(middle.values, voxels[phantom.SLICES // 2]) and middle.right == (phantom.SPACING, 0, 0)


def test_films_and_presets(server, scan, tmp_path):
    with scan.session(32, 32) as session:
        film = session.film(tmp_path / "turn.mp4", "bone", frames=2, frames_per_second=10, width=32, height=32, error=1)
        look = session.looks["muscle"]
    assert film.read_bytes()[4:8] == b"ftyp"
    look.camera.vertical_fov_degrees = 20
    server.api.call("createPreset", data_set_id=scan.id, body={"name": "Mine", "scene": json_format.MessageToDict(look)})
    [saved] = scan.presets()
    with scan.session(32, 32) as session:
        assert session.scene(saved).camera.vertical_fov_degrees == 20
        picture = session.render(saved, error=1)
    with Image.open(picture.save(tmp_path / "mine.png")) as read:
        assert float(read.info["Relative RMSE"]) == picture.error


def test_a_nifti_file_can_be_uploaded(server, tmp_path):
    image = nibabel.Nifti1Image(phantom.values().transpose(2, 1, 0), np.diag([-2.0, -2.0, 2.0, 1.0]))
    image.header["descrip"] = b"Canary"
    nibabel.save(image, tmp_path / "scan.nii.gz")
    made = server.upload(tmp_path / "scan.nii.gz").wait()
    assert made.data["volume"]["size"] == [phantom.SIDE, phantom.SIDE, phantom.SLICES]
    assert made.slice("axial", 20).values.max() == 1100
    made.delete()


def test_chosen_phases_of_a_file_in_an_archive_can_be_uploaded(server, tmp_path):
    values = np.arange(6 * 20 ** 3).reshape(6, 20, 20, 20) % 997
    header = ("NRRD0004\ntype: uint16\ndimension: 4\nspace: left-posterior-superior\nsizes: 6 20 20 20\nencoding: raw\nendian: little\n"
              "space directions: none (2,0,0) (0,2,0) (0,0,2)\nkinds: list domain domain domain\n\n")
    with zipfile.ZipFile(tmp_path / "heart.zip", "w") as archive:
        archive.writestr("heart.nrrd", header.encode() + values.astype("<u2").tobytes(order="F"))
    heart = server.upload(tmp_path / "heart.zip", phases=[1, 3, 5]).wait()
    assert heart.data["volume"]["phases"] == 3 and heart.data["volume"]["size"] == [20, 20, 20]
    image = nibabel.load(heart.export(tmp_path / "heart.nii.gz"))
    heart.delete()
    assert np.array_equal(np.asarray(image.dataobj), np.moveaxis(values[1::2], 0, -1))


def test_a_scan_can_be_exported(scan, tmp_path):
    image = nibabel.load(scan.export(tmp_path / "scan.nii.gz"))
    # The voxels are stored with x fastest, and the phantom has z first.
    assert np.array_equal(np.asarray(image.dataobj).transpose(2, 1, 0), phantom.values())
    assert trimesh.load(scan.export(tmp_path / "bone.glb", above=500), force="mesh").is_watertight
    with pytest.raises(ScanError) as caught:
        scan.export(tmp_path / "nothing.stl", above=32000)
    assert caught.value.code == "nothing_inside" and not (tmp_path / "nothing.stl").exists()
    with pytest.raises(ValueError, match="must end with"):
        scan.export(tmp_path / "scan.obj")


def test_a_refused_scan_says_why(server, tmp_path):
    folder = phantom.write(tmp_path)
    for file in sorted(folder.iterdir())[1:]:
        file.unlink()
    made = server.upload(folder)
    with pytest.raises(ScanError) as caught:
        made.wait()
    assert caught.value.code and str(caught.value).endswith(".")
    made.delete()
    with pytest.raises(NotFoundError):
        made.refresh()


def test_a_token_without_the_scope_or_without_validity_is_refused(stack, owner, scan):
    with Diaphane(stack.url, token_of(owner, "share")) as sharing:
        with pytest.raises(ForbiddenError, match="scope read"):
            next(sharing.scans())
        assert sharing.api.json("listPeople", data_set_id=scan.id)["items"] == []
    with Diaphane(stack.url, "diaphane_" + "0" * 64) as nobody, pytest.raises(AuthenticationError):
        next(nobody.scans())


def test_the_notebook_shows_each_picture_with_its_error(stack, owner, tmp_path, monkeypatch):
    monkeypatch.setenv("DIAPHANE_URL", stack.url)
    monkeypatch.setenv("DIAPHANE_TOKEN", token_of(owner, "read", "write"))
    (tmp_path / "scan").mkdir()
    monkeypatch.setenv("DIAPHANE_SCAN", str(phantom.write(tmp_path / "scan")))
    monkeypatch.setenv("DIAPHANE_SIDE", "128")
    monkeypatch.setenv("PYTHONPATH", str(REPO / "clients" / "python" / "src"))
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    book = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(book)
    assert all(not cell.get("outputs") for cell in book.cells), "its outputs are not committed"
    done = nbclient.NotebookClient(book, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    if folder := os.environ.get("DIAPHANE_PICTURES"):
        nbformat.write(done, Path(folder) / NOTEBOOK.name)
    data = [output.data for cell in done.cells for output in cell.get("outputs", []) if "data" in output]
    shown = [html for one in data for html in re.findall(r"<figure.*?</figure>", one.get("text/html", ""), re.S)]
    errors = [float(found[1]) for html in shown if (found := re.search(r"<figcaption>\w+: error ([\d.e-]+)%", html))]
    assert len(errors) == len(shown) >= 5, "each picture has an error"
    assert errors[:3] == sorted(errors[:3], reverse=True)
    assert sum("image/png" in one for one in data) >= 2, "the plot of the error and the slice"
    with Image.open(tmp_path / "bone.png") as read:
        assert float(read.info["Relative RMSE"]) <= 0.05


def test_the_package_builds_and_installs(tmp_path):
    """`pip install ./clients/python` works without network for its build."""
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index", "-w", tmp_path, REPO / "clients" / "python"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    [wheel] = tmp_path.glob("diaphane-*-py3-none-any.whl")
    listed = subprocess.run([sys.executable, "-m", "zipfile", "-l", str(wheel)], capture_output=True, text=True, check=True).stdout
    assert "diaphane/py.typed" in listed and "diaphane/_generated/stream_pb2.py" in listed and "diaphane/client.py" in listed
