"""The brain of an MR scan, from the upload to the looks and labels of a session."""

from __future__ import annotations

import struct

import numpy
import pytest
from api_client import person
from stream_helpers import ClientMessage, Viewer, open_session
from test_labels import bundle

SIDE, SPACING = 72, 2.9
BRAIN = 0xFFFFFF04      # kBrainNumber in volume/labels.h
ELLIPSOID = (64, 80, 66)        # half axes of the brain in mm


@pytest.fixture(scope="module")
def running(all_stacks):
    stack = all_stacks.open(only=("postgres", "redis", "api", "gateway", "edge", "ingestd", "renderd"))
    yield stack
    all_stacks.shut(stack)


def head(with_brain: bool) -> bytes:
    """Returns a NIfTI file of a head as in a T1 scan (a brain, dark fluid and bone, and bright fat), or of a bright ball without a brain."""
    x, y, z = numpy.meshgrid(*[(numpy.arange(SIDE) - SIDE / 2) * SPACING] * 3, indexing="ij")

    def within(a: float, b: float, c: float) -> numpy.ndarray:
        return (x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2 < 1

    values = numpy.random.default_rng(1).integers(0, 30, (SIDE, SIDE, SIDE)).astype(numpy.int16)
    values[within(82, 98, 84)] += 800
    if with_brain:
        values[within(75, 91, 77)] -= 740
        values[within(*ELLIPSOID)] += 480
    return scan_file(values, SPACING, b"MR")


def scan_file(values: numpy.ndarray, spacing: float, modality: bytes) -> bytes:
    """Returns 16-bit values as a NIfTI file with cubic voxels, as the page uploads it."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *values.shape, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 4, 16)
    struct.pack_into("<4f", header, 76, 1, spacing, spacing, spacing)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, spacing, 0, 0, 0, 0, spacing, 0, 0, 0, 0, spacing, 0)
    header[328:330] = modality
    header[344:347] = b"n+1"
    return bytes(header) + values.tobytes(order="F")


def session(running, with_brain: bool) -> Viewer:
    owner = person(running)
    scan = owner.upload(bundle(head(with_brain)))["id"]
    running.wait_until(lambda: owner.http.get(f"/v1/data-sets/{scan}").json()["state"] == "ready", what="the scan")
    _, url = open_session(owner, scan)
    return Viewer(running.url, url)


def test_a_head_shows_its_brain_first_and_lists_it_as_a_label(running):
    viewer = session(running, with_brain=True)
    looks = {preset.name: preset.scene for preset in viewer.config.presets}
    assert list(looks)[:2] == ["brain", "through"]
    assert [(look.number, look.opacity) for look in viewer.config.scene.labels] == [(0, 0.0)], "the rest is hidden"
    [label] = viewer.until("labels").labels
    brain = 4 / 3 * numpy.pi * numpy.prod(ELLIPSOID)
    assert label.number == BRAIN and brain < label.volume < 1.4 * brain     # with the fluid around it
    viewer.frame()
    update = ClientMessage()
    update.scene.input_seq = viewer.input_seq + 1
    update.scene.scene.CopyFrom(looks["through"])
    viewer.send(update)
    viewer.frame(condition=lambda frame: frame.input_seq == update.scene.input_seq)
    viewer.leave()


def test_a_scan_without_a_brain_has_neither(running):
    viewer = session(running, with_brain=False)
    assert "brain" not in {preset.name for preset in viewer.config.presets}
    assert not viewer.config.scene.labels
    viewer.leave()
