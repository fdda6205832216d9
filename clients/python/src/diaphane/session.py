"""A render session: pictures, films and slices of one scan."""

from __future__ import annotations

import contextlib
import time
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self, TypeVar

import numpy as np
from google.protobuf import json_format
from numpy.typing import NDArray

from ._generated import stream_pb2 as pb
from ._generated.scene_pb2 import Overlay, Scene, Vec3
from ._http import Api
from ._stream import FinalPicture, Stream
from .errors import NotFoundError, WaitedTooLong
from .picture import ErrorCurve, ErrorPoint, Picture, Slice

Plane = Literal["axial", "coronal", "sagittal"]
#: A look by its name, a scene, or the scene of a preset as JSON. None is the scan's default.
Look = str | Scene | Mapping[str, Any] | None

#: How a slab combines its samples.
Projection = Literal["mean", "maximum", "minimum"]
Vector = tuple[float, float, float]
_Copied = TypeVar("_Copied", Scene, Overlay)

_PROJECTIONS = {"mean": pb.PROJECTION_MEAN, "maximum": pb.PROJECTION_MAXIMUM, "minimum": pb.PROJECTION_MINIMUM}
_PLANES = {"axial": pb.AXIAL, "coronal": pb.CORONAL, "sagittal": pb.SAGITTAL}


class Session:
    """A connection to the renderer of a scan. Use it as a context manager to render several pictures, because opening one takes
    longer than a small picture.
    """

    def __init__(self, api: Api, scan_id: str, width: int = 512, height: int = 512, timeout: float = 600, over: str | None = None):
        self._api = api
        self._timeout = timeout
        body = {"data_set_id": scan_id} | ({"over": over} if over else {})
        made = api.json("createSession", body=body, wait=timeout, repeatable=True)
        self._id: str = made["session_id"]
        try:
            self._stream = Stream(api.origin, made["stream_url"], width, height, timeout)
        except BaseException:
            self._end()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Ends the session, which frees the renderer for others."""
        self._stream.close()
        self._end()

    def _end(self) -> None:
        # The server may have ended it already.
        with contextlib.suppress(NotFoundError):
            self._api.call("endSession", session_id=self._id)

    @property
    def device(self) -> str:
        """What renders the pictures, such as "NVIDIA H200"."""
        return self._stream.config.device

    @property
    def looks(self) -> dict[str, Scene]:
        """The looks that suit this scan, by name. Each call returns copies, which can be changed and rendered."""
        return {one.name: _copy(one.scene) for one in self._stream.config.presets}

    @property
    def second_looks(self) -> dict[str, Overlay]:
        """The looks of the second scan over the first one, by name. Assign one to `overlay` of a scene. The first is the default."""
        return {one.name: _copy(one.overlay) for one in self._stream.config.second.looks}

    def scene(self, look: Look = None) -> Scene:
        """Returns a copy of the scene of a look."""
        if look is None:
            return _copy(self._stream.config.scene)
        if isinstance(look, Scene):
            return _copy(look)
        if isinstance(look, str):
            looks = self.looks
            if look not in looks:
                raise ValueError(f"this scan has no look {look!r}; it has {', '.join(sorted(looks))}")
            return looks[look]
        # A preset contains its scene as a field.
        scene: Scene = json_format.ParseDict(dict(look.get("scene", look)), Scene(), ignore_unknown_fields=True)
        return scene

    def render(self, look: Look = None, width: int | None = None, height: int | None = None, error: float = 0.05, samples: int = 0) -> Picture:
        """Renders a picture until its estimated relative error is at most `error`, and returns it without loss.

        Every picture gets at least 16 samples per pixel, and its error may be well below the one that was asked for. For a
        rougher picture, `samples` limits the samples per pixel. The server has limits, too, usually an error of 0.01.
        `Picture.error` is always the estimate for the returned picture.
        """
        if not 0 < error <= 1:
            raise ValueError("error is a share between 0 and 1: 0.05 means 5%")
        size = (width or self._stream.viewport[0], height or self._stream.viewport[1])
        final = FinalPicture(self._stream.send_scene(self.scene(look), *size, error, samples))
        deadline = time.monotonic() + self._timeout
        while not final.complete:
            if time.monotonic() > deadline:
                raise WaitedTooLong(f"the picture did not reach the error {error} within {self._timeout:g} s")
            final.add(self._stream.receive(deadline))
        return Picture(image=final.image(), error=final.error, samples=final.samples, curve=self._curve(),
                       look=look if isinstance(look, str) else "", device=self.device)

    def _curve(self) -> ErrorCurve:
        # The renderer refuses more than four queries in a second.
        time.sleep(max(0.0, self._next_curve - time.monotonic()))
        self._next_curve = time.monotonic() + 0.3
        self._stream.send(pb.ClientMessage(error_curve=pb.ErrorCurveQuery()))
        curve = self._stream.until("error_curve")
        return ErrorCurve(tuple(ErrorPoint(one.samples, one.seconds, one.error) for one in curve.points))

    def film(self, path: str | Path, look: Look = None, frames: int = 120, frames_per_second: int = 30, width: int = 512, height: int = 512,
             error: float = 0.05, progress: Callable[[float], object] | None = None) -> Path:
        """Saves a film (MP4) of a full rotation about the vertical axis. `error` applies to each frame.

        `progress` is called with the finished share, from 0 to 1.
        """
        video = pb.Video(path=pb.Video.TURNTABLE, frames=frames, frames_per_second=frames_per_second, width=width, height=height, error=error)
        self._stream.send(pb.ClientMessage(key_view=pb.KeyView(index=0, scene=self.scene(look))))
        self._stream.send(pb.ClientMessage(file=pb.FileRequest(video=video)))
        data = bytearray()
        while True:
            message = self._stream.receive(time.monotonic() + self._timeout)
            kind = message.WhichOneof("body")
            if kind == "file_progress" and progress is not None:
                progress(message.file_progress.done)
            elif kind == "file_part":
                data += message.file_part.data
                self._stream.send(pb.ClientMessage(file_taken=pb.FileTaken(seq=message.file_part.seq)))
                if message.file_part.last:
                    break
        Path(path).write_bytes(data)
        return Path(path)

    def slice(self, plane: Plane = "axial", index: int | None = None) -> Slice:
        """Returns the exact voxel values of one slice, by default of the middle one."""
        stack = self._stack(plane)
        index = stack.slices // 2 if index is None else index
        if not 0 <= index < stack.slices:
            raise IndexError(f"there are {stack.slices} {plane} slices")
        request = pb.SliceRequest(slices=[pb.SliceRequest.At(plane=_PLANES[plane], index=index)], taken=self._taken)
        self._stream.send(pb.ClientMessage(slices=request))
        while True:
            got = self._stream.until("slice")
            self._taken = got.seq
            if got.plane == _PLANES[plane] and got.index == index:
                break
        return Slice(values=pixels_of(got), plane=plane, index=index,
                     first=_triple(stack.first, stack.next, index), right=_triple(stack.right), down=_triple(stack.down))

    def oblique(self, right: Vector, down: Vector, centre: Vector = (0, 0, 0), size: tuple[int, int] = (512, 512), pixel: float = 1,
                thickness: float = 0, projection: Projection = "mean") -> Slice:
        """Returns a plane in any direction, or a slab around it, with trilinear interpolation between voxels.

        `right` and `down` are the perpendicular directions of its rows and columns, and `size` its columns and rows. World
        space is in mm (docs/scenes.md). A slab of `thickness` mm combines samples that are at most the smallest distance of
        voxels apart.
        """
        across, along = (np.asarray(one, float) * pixel / np.linalg.norm(one) for one in (right, down))
        first = np.asarray(centre, float) - (size[0] - 1) / 2 * across - (size[1] - 1) / 2 * along
        self._oblique += 1
        wanted = pb.ObliqueSlice(id=self._oblique, columns=size[0], rows=size[1], first=_vector(first), right=_vector(across),
                                 down=_vector(along), thickness=thickness, projection=_PROJECTIONS[projection])
        self._stream.send(pb.ClientMessage(slices=pb.SliceRequest(
            slices=[pb.SliceRequest.At(plane=pb.AXIAL, oblique=wanted)], taken=self._taken)))
        while True:
            got = self._stream.until("slice")
            self._taken = got.seq
            if got.oblique == self._oblique:
                break
        return Slice(values=pixels_of(got), plane="oblique", index=0,
                     first=_triple(wanted.first), right=_triple(wanted.right), down=_triple(wanted.down))

    def curved(self, points: Sequence[Vector], height: float = 60, pixel: float = 1, angle: float = 0, thickness: float = 0,
               projection: Projection = "mean") -> Slice:
        """Returns a slice that is straightened along a smooth curve through points, such as along a vessel or the jaw.

        The columns follow the arc length from the first point, and the middle row lies on the curve. `angle` turns the slice
        about the curve, in degrees. `first`, `right` and `down` of the result are in mm along and across the curve.
        """
        self._oblique += 1
        rows = 2 * int(height / pixel / 2) + 1
        wanted = pb.CurvedSlice(id=self._oblique, rows=rows, points=[_vector(np.asarray(point, float)) for point in points], pixel=pixel,
                                angle=angle, thickness=thickness, projection=_PROJECTIONS[projection])
        self._stream.send(pb.ClientMessage(slices=pb.SliceRequest(slices=[pb.SliceRequest.At(curved=wanted)], taken=self._taken)))
        while True:
            got = self._stream.until("slice")
            self._taken = got.seq
            if got.curved == self._oblique:
                break
        return Slice(values=pixels_of(got), plane="curved", index=0, first=(0, -(rows - 1) / 2 * pixel, 0), right=(pixel, 0, 0),
                     down=(0, pixel, 0))

    #: ID of the newest oblique or curved slice.
    _oblique = 0
    #: Number of the newest slice, and the earliest time of the next query for a curve.
    _taken = 0
    _next_curve = 0.0

    def slices(self, plane: Plane = "axial") -> Iterator[Slice]:
        """Yields all slices of a plane in order."""
        for index in range(self._stack(plane).slices):
            yield self.slice(plane, index)

    def voxels(self) -> NDArray[np.int16]:
        """Returns all voxel values, of the shape (slices, rows, columns) of the axial slices. Downloads the whole scan."""
        return np.stack([one.values for one in self.slices("axial")])

    def _stack(self, plane: Plane) -> Any:
        for stack in self._stream.config.slice_stacks:
            if stack.plane == _PLANES[plane]:
                return stack
        raise ValueError(f"this scan has no {plane} slices")


def pixels_of(one: pb.ExactSlice) -> NDArray[np.int16]:
    """Returns the values of a slice, which are sent as their low bytes and then their high bytes."""
    planes = np.frombuffer(zlib.decompress(one.data), np.uint8).reshape(2, one.rows, one.columns).astype(np.uint16)
    values: NDArray[np.int16] = (planes[0] | planes[1] << 8).view(np.int16)
    return values


def _vector(vector: NDArray[np.float64]) -> Vec3:
    return Vec3(x=vector[0], y=vector[1], z=vector[2])


def _copy(message: _Copied) -> _Copied:
    copied = type(message)()
    copied.CopyFrom(message)
    return copied


def _triple(vector: Any, step: Any = None, times: int = 0) -> tuple[float, float, float]:
    if step is None:
        return vector.x, vector.y, vector.z
    return vector.x + step.x * times, vector.y + step.y * times, vector.z + step.z * times
