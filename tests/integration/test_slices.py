"""Exact slices through edge, gateway and renderd: the stored voxels, and the results of invalid requests."""

from __future__ import annotations

import json
import zlib
from pathlib import Path

import numpy as np
import pytest
from stream_helpers import ClientMessage, Viewer, open_session

AXIAL, CORONAL, SAGITTAL = 1, 2, 3


def wish(viewer: Viewer, *slices: tuple[int, int], taken: int = 0) -> None:
    message = ClientMessage()
    message.slices.taken = taken
    for plane, index in slices:
        message.slices.slices.add(plane=plane, index=index)
    viewer.send(message)


def values(piece) -> np.ndarray:
    """Decodes a slice as the protocol defines it."""
    low, high = np.frombuffer(zlib.decompress(piece.data), np.uint8).reshape(2, piece.rows, piece.columns).astype(np.uint16)
    return (low + 256 * high).astype(np.int16)


def stored(folder: Path) -> np.ndarray:
    size = json.loads((folder / "volume.json").read_text())["size"]
    return np.fromfile(folder / "voxels.i16", "<i2").reshape(size[::-1])  # z, y, x


def test_slices_equal_the_stored_voxels_while_frames_continue(running, one, ball):
    _, url = open_session(one, ball)
    viewer = Viewer(running.url, url)
    voxels = stored(running.data_dir / "volumes" / ball)
    assert [(one.plane, one.columns, one.rows, one.slices) for one in viewer.config.slice_stacks] == [
        (plane, 48, 48, 48) for plane in (AXIAL, CORONAL, SAGITTAL)]
    expected = {AXIAL: voxels[7], CORONAL: voxels[::-1, 9, :], SAGITTAL: voxels[::-1, :, 11]}
    wish(viewer, (AXIAL, 7), (CORONAL, 9), (SAGITTAL, 11))
    for _ in range(3):
        piece = viewer.until("slice")
        assert np.array_equal(values(piece), expected.pop(piece.plane))
    assert not expected
    # A picture that has converged meanwhile gets no more frames until something changes.
    seq = viewer.turn(10)
    viewer.frame(condition=lambda frame: frame.input_seq >= seq)
    viewer.leave()


@pytest.mark.parametrize("slices", [[(AXIAL, 48)], [(AXIAL, 2**32 - 1)], [(0, 1)], [(9, 1)], [(AXIAL, 1), (AXIAL, 2)],
                                    [(AXIAL, 0)] * 8000])
def test_an_invalid_slice_is_refused_and_the_session_continues(running, one, ball, slices):
    _, url = open_session(one, ball)
    viewer = Viewer(running.url, url)
    wish(viewer, *slices)
    refusal = viewer.until("problem")
    assert refusal.code == "invalid" and refusal.field.startswith("slices[") and not refusal.fatal
    wish(viewer, (AXIAL, 3), taken=2**63)
    assert viewer.until("slice").index == 3
    seq = viewer.turn(30)
    viewer.frame(condition=lambda frame: frame.input_seq >= seq)
    viewer.leave()


def test_slices_in_flight_and_per_second_are_limited(running, one, ball):
    _, url = open_session(one, ball)
    viewer = Viewer(running.url, url)
    for index in range(400):
        wish(viewer, (AXIAL, index % 48))
    seq = viewer.turn(10)
    got, answered = 0, False
    # The frame proves that all requests were read. It may overtake the first slice, for which the voxels are loaded first.
    while not (answered and got):
        message = viewer.receive()
        kind = message.WhichOneof("body")
        got += kind == "slice"
        answered |= kind == "frame" and message.frame.input_seq >= seq
    assert 1 <= got <= 3
    viewer.leave()
