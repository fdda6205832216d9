"""The parts that ingest finds in a CT, from the upload to the labels of a session and the export of one of them."""

from __future__ import annotations

import numpy
import pytest
import trimesh
from api_client import person
from stream_helpers import ClientMessage, Viewer, open_session
from test_brain import scan_file
from test_labels import bundle, kinds_with_depth
from test_scan_exports import download, request

SIZE, SPACING = (160, 112, 120), 2.2
BONE, LUNGS, AIRWAYS, VESSELS = range(0xFFFFFF05, 0xFFFFFF09)     # kFoundParts in volume/labels.h


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "gateway", "edge", "ingestd", "renderd"))
    yield stack
    all_stacks.shut(stack)


def chest(blood: int) -> tuple[bytes, dict[int, float]]:
    """Returns a NIfTI file of a chest in Hounsfield units, and the volumes of its parts in mm3."""
    x, y, z = numpy.meshgrid(*[(numpy.arange(n) - n / 2) * SPACING for n in SIZE], indexing="ij")
    values = numpy.full(SIZE, -1000)
    values[(x / 155) ** 2 + (y / 105) ** 2 < 1] = 50
    lungs = (((abs(x) - 72) / 56) ** 2 + (y / 72) ** 2 + ((z + 15) / 105) ** 2 < 1) & (abs(x) > 20)
    radius = numpy.hypot(x, y + 55)
    aorta = numpy.hypot(x - 4, y + 20) < 11
    windpipe = numpy.hypot(x, y - 8) < 8
    windpipe &= z > 10
    for side in (-1, 1):        # from the end of the windpipe into each lung
        along = numpy.clip((10 - z) / 40, 0, 1)
        windpipe |= (numpy.hypot(x - side * 45 * along, y - 8) < 7) & (z <= 12) & (z > -30)
    parts = {BONE: radius < 18, LUNGS: lungs & ~windpipe, AIRWAYS: windpipe, VESSELS: aorta}
    values[lungs] = -860
    values[numpy.isclose(radius, 18, atol=4)] = 700
    values[radius < 14] = 170
    values[(radius < 18) & (abs(z) > 120)] = 700       # the ends of the spine enclose its marrow
    values[aorta], values[windpipe] = blood, -1000
    values = values + numpy.random.default_rng(1).normal(0, 15, SIZE)
    volumes = {part: float(mask.sum()) * SPACING**3 for part, mask in parts.items()}
    return scan_file(numpy.maximum(values, -1024).astype(numpy.int16), SPACING, b"CT"), volumes


def labels_of(running, owner, file: bytes) -> tuple[str, Viewer, dict[int, float]]:
    scan = owner.upload(bundle(file))["id"]
    running.wait_until(lambda: owner.http.get(f"/v1/data-sets/{scan}").json()["state"] == "ready", what="the scan")
    _, url = open_session(owner, scan)
    viewer = Viewer(running.url, url)
    return scan, viewer, {label.number: label.volume for label in viewer.until("labels").labels}


def test_a_chest_lists_its_parts_and_each_can_be_named_and_exported(running, tmp_path):
    owner = person(running)
    file, volumes = chest(blood=320)
    scan, viewer, found = labels_of(running, owner, file)
    assert set(found) == {BONE, LUNGS, AIRWAYS, VESSELS}
    for part, volume in volumes.items():
        assert found[part] == pytest.approx(volume, rel=0.15), hex(part)
    assert not viewer.config.scene.labels, "the first picture is that of a scan without labels"
    assert not any(preset.scene.labels for preset in viewer.config.presets)
    viewer.frame()
    update = ClientMessage()
    update.scene.input_seq = viewer.input_seq + 1
    update.scene.scene.CopyFrom(next(preset.scene for preset in viewer.config.presets if preset.name == "bone"))
    update.scene.scene.labels.add(number=0, opacity=0)      # hides all else
    viewer.send(update)
    viewer.frame(condition=lambda frame: frame.input_seq == update.scene.input_seq)
    assert kinds_with_depth(viewer)[1] in found, "what is pressed in the picture"
    viewer.leave()
    assert request(owner, scan, format="stl", label=LUNGS)["state"] == "ready"
    mesh = trimesh.load(download(owner, scan, "surface.stl", tmp_path), force="mesh")
    assert mesh.volume == pytest.approx(volumes[LUNGS], rel=0.15)


def test_blood_without_contrast_medium_gets_no_label(running):
    owner = person(running)
    scan, viewer, found = labels_of(running, owner, chest(blood=45)[0])
    assert set(found) == {BONE, LUNGS, AIRWAYS}
    viewer.leave()
    made = request(owner, scan, format="stl", label=VESSELS)
    assert (made["state"], made["problem"]["code"]) == ("failed", "nothing_inside")
