"""`diaphane export`: other programs' libraries (nibabel, trimesh) read what it writes. Needs no server."""

from __future__ import annotations

import itertools
import subprocess
from pathlib import Path

import nibabel
import numpy as np
import pytest
import trimesh

from harness import REPO  # noqa: F401  (puts tools/ on the path)
from devtool import paths
from devtool.ingest_cases.judge import on_server
from devtool.ingest_cases.phantom import Series, dataset, markers, stack, write
from devtool.ingest_cases.table import oblique

SHAPE = (19, 23, 28)
SPACING = (0.5, 0.75, 1.5)
SPHERE = 22.0     # mm


def export(*arguments: object, code: int = 0) -> str:
    done = subprocess.run([str(paths.build_dir() / "bin" / "diaphane-export"), *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done.stderr


def image(values: np.ndarray, affine: np.ndarray, path: Path) -> Path:
    nibabel.save(nibabel.Nifti1Image(values, affine), path)
    return path


def affine_of(permutation: tuple[int, ...], signs: tuple[int, ...]) -> np.ndarray:
    affine = np.eye(4)
    affine[:3, :3] = 0
    for axis, (to, sign) in enumerate(zip(permutation, signs)):
        affine[to, axis] = sign * SPACING[axis]
    affine[:3, 3] = (-31.5, 12.25, 107.75)
    return affine


@pytest.mark.parametrize("permutation", itertools.permutations(range(3)), ids=str)
def test_nifti_keeps_every_voxel_and_its_place_in_all_orientations(tmp_path, permutation):
    values = np.random.default_rng(7).integers(-32768, 32767, SHAPE, dtype=np.int16, endpoint=True)
    for signs in itertools.product((1, -1), repeat=3):
        original = image(values, affine_of(permutation, signs), tmp_path / "original.nii")
        for name in ("again.nii", "again.nii.gz"):
            export(original, tmp_path / name, "--force")
            again = nibabel.load(tmp_path / name)
            assert again.header.get_xyzt_units()[0] == "mm" and again.get_data_dtype() == np.int16
            assert np.allclose(again.get_qform(), again.get_sform(), atol=1e-5)
            # A left-handed grid is stored with one axis reversed, so both are compared in one orientation. That changes no voxel.
            one, two = (nibabel.as_closest_canonical(each) for each in (nibabel.load(original), again))
            assert np.array_equal(np.asarray(one.dataobj), np.asarray(two.dataobj))
            assert np.allclose(one.affine, two.affine, atol=1e-5)


@pytest.mark.parametrize("orientation", [(1, 0, 0, 0, 1, 0), (-1, 0, 0, 0, 1, 0), (1, 0, 0, 0, 0, -1), (0, 1, 0, 0, 0, -1), oblique()],
                         ids=["axial", "from the right", "coronal", "sagittal", "oblique"])
def test_nifti_places_the_markers_of_a_dicom_series(tmp_path, orientation):
    row, column = np.array(orientation[:3], float), np.array(orientation[3:], float)
    axes = np.stack([row, column, np.cross(row, column)], axis=1)
    balls = [axes @ np.array(ball) for ball in ((-7.0, -4.0, -3.0), (8.0, 5.0, 9.0), (-3.0, 8.0, 21.0))]
    slices = stack(24, 2.0, 0.0, origin=tuple(axes @ (-16.8, -17.2, -14.0)), orientation=tuple(map(float, orientation)),
                   rows=44, columns=48, intercept=-2000.0)
    series = Series("1.2.840.10008.5.1.4.1.1.2", values=markers(*balls))
    write(tmp_path / "disc", [dataset(series, one) for one in slices])
    export(tmp_path / "disc", tmp_path / "scan.nii.gz")
    exported = nibabel.load(tmp_path / "scan.nii.gz")
    values = np.asarray(exported.dataobj).astype(float) + 1000
    voxels = np.stack(np.meshgrid(*map(np.arange, values.shape), indexing="ij"), axis=-1)
    lps = nibabel.affines.apply_affine(exported.affine, voxels) * (-1, -1, 1)
    for ball in balls:
        near = ((lps - ball) ** 2).sum(-1) < 9.0 ** 2
        centre = (lps[near] * values[near, None]).sum(0) / values[near].sum()
        # Half a voxel along its longest side, as in test_ingest_phantom.py.
        assert np.linalg.norm(centre - ball) < 1.0
    assert exported.header["intent_name"].item() == b"CT"


def test_nifti_of_a_stored_volume_has_its_bytes(tmp_path):
    slices = stack(24, 2.0, 0.0, rows=44, columns=48, intercept=-2000.0)
    write(tmp_path / "disc", [dataset(Series("1.2.840.10008.5.1.4.1.1.2", values=markers((5.0, 5.0, 20.0))), one) for one in slices])
    assert on_server(tmp_path / "disc", tmp_path).volume is not None
    stored, = tmp_path.glob("*/voxels.i16")
    export(stored.parent, tmp_path / "scan.nii.gz")
    values = np.asarray(nibabel.load(tmp_path / "scan.nii.gz").dataobj)
    assert values.astype("<i2").tobytes(order="F") == stored.read_bytes()


@pytest.fixture(scope="module")
def sphere(tmp_path_factory):
    """A scan with a sphere, and its label file: the sphere is 5, and the half of it that is beyond the first slice is cut away."""
    folder = tmp_path_factory.mktemp("sphere")
    shape = (96, 64, 40)
    affine = np.diag([-0.6, -0.9, 1.4, 1.0])
    affine[:3, 3] = (40.0, 90.0, -300.0)
    voxels = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    places = nibabel.affines.apply_affine(affine, voxels)
    centre = nibabel.affines.apply_affine(affine, (48, 32, 20))
    distance = np.linalg.norm(places - centre, axis=-1)
    cut = np.linalg.norm(places - nibabel.affines.apply_affine(affine, (20, 32, 0)), axis=-1) < 11
    values = np.clip(1000 - 40 * distance, -500, 1000).round().astype(np.int16)
    labels = np.where(distance <= SPHERE, 5, np.where(cut, 9, 0)).astype(np.uint8)
    return image(values, affine, folder / "scan.nii"), image(labels, affine, folder / "labels.nii"), centre * (-1, -1, 1), labels


def loaded(path: Path) -> trimesh.Trimesh:
    return trimesh.load(path, force="mesh")


@pytest.mark.parametrize("label", [5, 9], ids=["inside the scan", "cut by its border"])
def test_a_surface_of_a_label_is_closed_and_as_large_as_the_label(tmp_path, sphere, label):
    scan, labels, _, voxels = sphere
    export(scan, tmp_path / "part.stl", "--labels", labels, "--label", label)
    mesh = loaded(tmp_path / "part.stl")
    assert mesh.is_watertight and mesh.is_winding_consistent
    expected = (voxels == label).sum() * 0.6 * 0.9 * 1.4
    # Smoothing rounds the rim where the border cuts the smaller part, which has a tenth of the volume.
    assert mesh.volume == pytest.approx(expected, rel=0.01 if label == 5 else 0.04)


def test_stl_is_in_millimetres_and_gltf_in_metres_with_the_head_up(tmp_path, sphere):
    scan, labels, centre, _ = sphere
    for name in ("part.stl", "part.glb"):
        export(scan, tmp_path / name, "--labels", labels, "--label", 5)
    stl, glb = loaded(tmp_path / "part.stl"), loaded(tmp_path / "part.glb")
    # The smallest voxel is 0.6 mm; the sphere is symmetric to a quarter of it.
    assert np.allclose(stl.bounds.mean(axis=0), centre, atol=0.3)
    left, back, head = stl.bounds.mean(axis=0) / 1000
    assert np.allclose(glb.bounds.mean(axis=0), (left, head, -back), atol=1e-6)
    assert glb.is_watertight and glb.volume == pytest.approx(stl.volume / 1e9, rel=1e-4)
    assert len(glb.faces) == len(stl.faces)
    normals = glb.vertex_normals
    outwards = glb.vertices - glb.bounds.mean(axis=0)
    assert ((normals * outwards).sum(axis=1) > 0).all(), "the normals of a sphere point outwards"


def test_a_surface_of_a_threshold_lies_at_the_value(tmp_path, sphere):
    scan, _, centre, _ = sphere
    export(scan, tmp_path / "part.stl", "--above", 400)
    mesh = loaded(tmp_path / "part.stl")
    assert mesh.is_watertight
    # The value falls by 40 per mm, so it is 399.5 at 15.0125 mm. Interpolation over a voxel of at most 1.4 mm is off by at most
    # 1.4² / (8 * 15) mm, rounding by 0.5 / 40 mm, and the values closest to the threshold are moved by at most 900 / 1500 / 40 mm.
    distance = np.linalg.norm(mesh.vertices - centre, axis=1)
    assert np.abs(distance - 15.0125).max() < 1.4 ** 2 / 120 + 0.5 / 40 + 900 / 1500 / 40


def test_a_surface_has_at_most_the_given_number_of_triangles(tmp_path, sphere):
    scan, _, _, _ = sphere
    export(scan, tmp_path / "part.stl", "--above", 400, "--triangles", 2000)
    mesh = loaded(tmp_path / "part.stl")
    assert mesh.is_watertight and 500 < len(mesh.faces) <= 2000


def test_mistakes_are_named_and_change_no_file(tmp_path, sphere):
    scan, labels, _, _ = sphere
    target = tmp_path / "part.stl"
    assert "no label 'liver'; it has:\n  5" in export(scan, target, "--labels", labels, "--label", "liver", code=65)
    assert "no voxel has a value this high" in export(scan, target, "--above", 3000, code=65)
    assert "either --label or --above" in export(scan, target, code=64)
    assert "either --label or --above" in export(scan, target, "--label", 5, "--above", 3, code=64)
    assert "whole number" in export(scan, target, "--above", "1.5", code=64)
    assert "whole scan" in export(scan, tmp_path / "scan.nii", "--above", 3, code=64)
    assert "must end with" in export(scan, tmp_path / "scan.obj", "--above", 3, code=64)
    assert "--triangles" in export(scan, target, "--above", 3, "--triangles", 5, code=64)
    assert "unknown option --deep" in export(scan, target, "--deep", 3, code=64)
    assert "no such file" in export(tmp_path / "absent", target, "--above", 3, code=66)
    assert "cannot write" in export(scan, tmp_path / "absent" / "part.stl", "--above", 3, code=73)
    assert list(tmp_path.iterdir()) == []
    target.write_text("mine")
    assert "already exists" in export(scan, target, "--above", 400, code=73)
    assert target.read_text() == "mine"
    export(scan, target, "--above", 400, "--force")
    assert loaded(target).is_watertight
    target.unlink()
    unfinished = target.with_name(target.name + ".part")
    unfinished.write_text("mine")
    assert f"{unfinished}: already exists" in export(scan, target, "--above", 400, code=73)
    assert unfinished.read_text() == "mine" and not target.exists()
    export(scan, target, "--above", 400, "--force")
    assert loaded(target).is_watertight and not unfinished.exists()
