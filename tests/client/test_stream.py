"""How the Python client talks to a renderer. A small server in this process stands in for it."""

from __future__ import annotations

import io
import math
import threading
import time
import zlib

import httpx
import numpy as np
import pytest
from diaphane import Diaphane, Scan, Scene, StreamError, WaitedTooLong
from diaphane._generated import stream_pb2 as pb
from diaphane._stream import FinalPicture
from diaphane.picture import ErrorCurve, ErrorPoint, Picture
from diaphane.session import pixels_of
from PIL import Image
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

READY = {"id": "7", "title": "Head", "state": "ready", "refusal": None}


def png(width: int, height: int, colour: tuple[int, int, int]) -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (width, height), colour).save(out, "PNG")
    return out.getvalue()


def message(**body) -> pb.ServerMessage:
    return pb.ServerMessage(**body)


class Renderer:
    """Answers each scene with a grainy frame and two tiles of the final picture."""

    def __init__(self):
        self.scenes: list[pb.SceneUpdate] = []
        self.acknowledged: list[int] = []
        self.seq = self.epoch = 0
        self.silent = False
        self.asked = 0.0
        self.origins: list[str] = []

    def __call__(self, socket) -> None:
        self.origins.append(socket.request.headers["Origin"])
        self.socket = socket
        try:
            for data in socket:
                self.answer(pb.ClientMessage.FromString(data))
        except ConnectionClosed:
            pass

    def say(self, **body) -> None:
        self.socket.send(message(**body).SerializeToString())

    def answer(self, asked: pb.ClientMessage) -> None:
        kind = asked.WhichOneof("body")
        if kind == "hello":
            bone = Scene(bounces=3)
            self.say(config=pb.Config(protocol=1, device="a test", input_seq=4, scene=Scene(bounces=1), presets=[{"name": "bone", "scene": bone}], slice_stacks=[
                pb.SliceStack(plane=pb.AXIAL, columns=3, rows=2, slices=4, first={"x": 1}, right={"x": 2}, down={"y": 2}, next={"z": 5})]))
        elif kind == "ack":
            self.acknowledged.append(asked.ack.seq)
        elif kind == "scene" and not self.silent:
            self.scenes.append(asked.scene)
            if asked.scene.scene.bounces == 99:
                self.say(problem=pb.Problem(code="invalid", message="It is wrong.", field="bounces", input_seq=asked.scene.input_seq))
            else:
                self.render(asked.scene)
        elif kind == "error_curve" and time.monotonic() < self.asked + 0.25:
            self.say(problem=pb.Problem(code="too-many", message="Too many requests for the error curve."))
        elif kind == "error_curve":
            self.asked = time.monotonic()
            self.say(error_curve=pb.ErrorCurve(epoch=self.epoch, points=[{"samples": 1, "seconds": 0.1, "error": 0.4}, {"samples": 9, "seconds": 0.9, "error": 0.04}]))
        elif kind == "slices":
            at = asked.slices.slices[0]
            values = np.arange(6, dtype="<i2") - 3 + 1000 * at.index
            planes = values.view(np.uint8).reshape(6, 2).T.tobytes()
            self.oblique, self.curved = at.oblique, at.curved
            self.say(slice=pb.ExactSlice(seq=asked.slices.taken + 1, plane=at.plane, index=at.index, columns=3, rows=2,
                                         data=zlib.compress(planes), oblique=at.oblique.id, curved=at.curved.id))
        elif kind == "file":
            assert asked.file.video.frames == 10
            self.say(file_progress=pb.FileProgress(done=0.5))
            self.say(file_part=pb.FilePart(seq=1, data=b"first "))
            self.say(file_part=pb.FilePart(seq=2, data=b"last", last=True))

    def render(self, update: pb.SceneUpdate) -> None:
        width, height = update.viewport.width, update.viewport.height
        # A late frame of the scene before comes first, as it may with a real renderer.
        for input_seq, epoch in ((update.input_seq - 1, self.epoch), (update.input_seq, self.epoch + 1)):
            self.seq += 1
            self.say(frame=pb.Frame(codec=pb.JPEG, seq=self.seq, epoch=epoch, input_seq=input_seq, error=0.4, iteration=1))
        self.epoch += 1
        for tile in range(2):
            self.seq += 1
            self.say(still=pb.Still(epoch=self.epoch, seq=self.seq, tile=tile, tiles=2, x=tile * width // 2, width=width // 2, height=height, format=pb.PNG,
                                    data=png(width // 2, height, (255 * tile, 0, 10)), iteration=9, error=0.04))
        self.say(state=pb.State(epoch=self.epoch, converged=True, lossless=True))


@pytest.fixture
def renderer():
    return Renderer()


@pytest.fixture
def scan(renderer):
    calls: list[str] = []

    def rest(request: httpx.Request) -> httpx.Response:
        calls.append(request.method)
        return httpx.Response(201, json={"session_id": "5", "stream_url": "/stream?ticket=1"}) if request.method == "POST" else httpx.Response(204)

    with serve(renderer, "127.0.0.1", 0, subprotocols=["diaphane.v1"]) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        with Diaphane(f"http://127.0.0.1:{server.socket.getsockname()[1]}", "diaphane_x", http=httpx.Client(transport=httpx.MockTransport(rest))) as client:
            yield Scan(client.api, READY)
        server.shutdown()
        thread.join()
    assert calls.count("POST") == calls.count("DELETE"), "each session was ended"


def test_a_picture_comes_with_its_error_and_curve(scan, renderer):
    picture = scan.render("bone", width=8, height=4, error=0.05)
    assert picture.array().shape == (4, 8, 3)
    assert picture.array()[0, 0].tolist() == [0, 0, 10] and picture.array()[0, 7].tolist() == [255, 0, 10]
    assert (picture.error, picture.samples, picture.look, picture.device) == (0.04, 9, "bone", "a test")
    assert picture.curve.errors.tolist() == [0.4, 0.04] and picture.curve.seconds_to(0.05) == 0.9 and picture.curve.seconds_to(0.01) is None
    [update] = renderer.scenes
    assert (update.scene.bounces, update.input_seq, update.raw, update.effort.stop_error) == (3, 5, True, 0.05)
    assert renderer.origins == [scan._api.origin]


def test_every_frame_and_tile_is_acknowledged(scan, renderer):
    with scan.session(8, 4) as session:
        session.render()
        session.render(Scene(bounces=7), width=16, height=2)
        session.slice("axial", 0)
    assert renderer.acknowledged == list(range(1, 9))
    assert [one.scene.bounces for one in renderer.scenes] == [1, 7]
    assert (renderer.scenes[1].viewport.width, renderer.scenes[1].viewport.height) == (16, 2)


def test_a_refused_scene_names_the_wrong_part(scan):
    with pytest.raises(StreamError, match="It is wrong") as caught:
        scan.render({"bounces": 99})
    assert (caught.value.code, caught.value.field) == ("invalid", "bounces")


def test_looks_are_copies_and_unknown_ones_are_explained(scan):
    with scan.session() as session:
        session.looks["bone"].bounces = 50
        assert session.scene("bone").bounces == 3
        assert session.scene({"name": "a preset", "scene": {"bounces": 5}}).bounces == 5
        with pytest.raises(ValueError, match="no look 'skin'; it has bone"):
            session.render("skin")
        with pytest.raises(ValueError, match="5%"):
            session.render(error=5)


def test_a_silent_renderer_is_not_waited_for_without_limit(scan, renderer):
    renderer.silent = True
    with pytest.raises(WaitedTooLong):
        scan.render(timeout=0.5)


def test_slices_have_exact_values_and_places(scan):
    with scan.session() as session:
        third = session.slice("axial", 3)
        assert third.values.tolist() == [[2997, 2998, 2999], [3000, 3001, 3002]] and third.first == (1, 0, 15)
        assert session.voxels().shape == (4, 2, 3) and session.voxels()[0, 0, 0] == -3
        with pytest.raises(IndexError, match="4 axial"):
            session.slice("axial", 4)
        with pytest.raises(ValueError, match="coronal"):
            session.slice("coronal")


def test_an_oblique_slice_is_requested_by_its_directions(scan, renderer):
    with scan.session() as session:
        tilted = session.oblique(right=(3, 0, 4), down=(0, -2, 0), centre=(1, 1, 1), size=(3, 2), pixel=0.5, thickness=4, projection="maximum")
    asked = renderer.oblique
    assert (asked.columns, asked.rows, asked.thickness, asked.projection) == (3, 2, 4, pb.PROJECTION_MAXIMUM)
    assert tilted.right == pytest.approx((0.3, 0, 0.4)) and tilted.down == pytest.approx((0, -0.5, 0))
    assert tilted.first == pytest.approx((1 - 0.3, 1 + 0.25, 1 - 0.4))
    assert tilted.values.shape == (2, 3)


def test_a_curved_slice_is_requested_by_its_points(scan, renderer):
    with scan.session() as session:
        straightened = session.curved([(0, 0, 0), (5, 1, 0), (9, 0, 2)], height=4, pixel=0.5, angle=30, thickness=2, projection="minimum")
    asked = renderer.curved
    assert [(one.x, one.y, one.z) for one in asked.points] == [(0, 0, 0), (5, 1, 0), (9, 0, 2)]
    assert (asked.columns, asked.rows, asked.pixel, asked.angle, asked.thickness, asked.projection) == (0, 9, 0.5, 30, 2, pb.PROJECTION_MINIMUM)
    assert straightened.plane == "curved" and straightened.first == (0, -2, 0) and straightened.right == (0.5, 0, 0)
    assert straightened.values.shape == (2, 3)


def test_a_film_is_saved_with_its_progress(scan, tmp_path):
    done: list[float] = []
    saved = scan.film(tmp_path / "film.mp4", "bone", frames=10, progress=done.append)
    assert saved.read_bytes() == b"first last" and done == [0.5]


def test_a_saved_picture_contains_its_error(scan, tmp_path):
    picture = scan.render(width=8, height=4)
    with Image.open(picture.save(tmp_path / "a.png")) as read:
        assert read.size == (8, 4) and float(read.info["Relative RMSE"]) == picture.error
    with Image.open(picture.save(tmp_path / "a.jpg")) as read:
        assert read.format == "JPEG"
    assert "error 4%, 9 samples per pixel, 0.9 s" in picture._repr_html_()


def test_tiles_of_an_older_picture_are_dropped():
    final = FinalPicture(2)
    for body in (message(frame=pb.Frame(epoch=1, input_seq=2)), message(still=pb.Still(epoch=1, tile=0, tiles=1, iteration=4)),
                 message(frame=pb.Frame(epoch=2, input_seq=2)), message(state=pb.State(epoch=1, converged=True, lossless=True))):
        final.add(body)
    assert not final.complete
    final.add(message(still=pb.Still(epoch=2, tile=0, tiles=1, iteration=5, error=0.5)))
    final.add(message(state=pb.State(epoch=2, converged=True, lossless=False)))
    assert not final.complete
    final.add(message(state=pb.State(epoch=2, converged=True, lossless=True)))
    assert final.complete and final.samples == 5


def test_negative_values_of_slices_survive():
    values = np.array([[-32768, -1], [0, 32767]], "<i2")
    one = pb.ExactSlice(rows=2, columns=2, data=zlib.compress(values.view(np.uint8).reshape(4, 2).T.tobytes()))
    assert np.array_equal(pixels_of(one), values)


def test_a_picture_with_one_sample_has_no_estimate():
    picture = Picture(Image.new("RGB", (1, 1)), math.inf, 1, ErrorCurve(()), "bone", "a test")
    assert picture.caption == "bone: error unknown, 1 samples per pixel, 0 s"


def test_a_curve_without_points_has_no_time():
    assert ErrorCurve(()).seconds_to(1) is None and len(ErrorCurve(())) == 0
    assert ErrorCurve((ErrorPoint(1, 0.1, math.inf),)).seconds_to(0.5) is None
