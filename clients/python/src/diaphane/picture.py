"""Pictures and slices as the server sends them, with their errors."""

from __future__ import annotations

import base64
import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, PngImagePlugin


class ErrorPoint(NamedTuple):
    """The error after a pass of the renderer."""

    samples: int
    #: Rendering time since the start.
    seconds: float
    #: Estimated relative RMSE.
    error: float


@dataclass(frozen=True)
class Alignment:
    """How a second scan lies in the space of a first one."""

    #: 4 x 4, from the patient coordinates of the second scan to those of the first, in mm (LPS).
    matrix: NDArray[np.float64]
    #: An estimate of the error. None if both scans share a frame of reference.
    residual_mm: float | None
    #: Share of the smaller scan that lies in the other.
    overlap: float | None


@dataclass(frozen=True)
class ErrorCurve:
    """The error of a picture as a function of rendering time and samples per pixel, from the first pass to the last."""

    points: tuple[ErrorPoint, ...]

    @property
    def seconds(self) -> NDArray[np.float64]:
        return np.array([one.seconds for one in self.points])

    @property
    def errors(self) -> NDArray[np.float64]:
        return np.array([one.error for one in self.points])

    @property
    def samples(self) -> NDArray[np.int64]:
        return np.array([one.samples for one in self.points], np.int64)

    def seconds_to(self, error: float) -> float | None:
        """Returns the rendering time until the error was at most `error`, or None if it never was."""
        return next((one.seconds for one in self.points if one.error <= error), None)

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class Picture:
    """A rendered picture without loss and without denoising, and the estimate of its error."""

    image: Image.Image
    #: Estimated relative RMSE compared with the same picture after infinitely many samples: 0.05 means 5%. It is infinite while
    #: there are too few samples for an estimate.
    error: float
    #: Samples per pixel.
    samples: int
    curve: ErrorCurve
    #: The name of the look, or an empty text for any other scene.
    look: str
    #: What rendered it, such as "NVIDIA H200".
    device: str

    @property
    def width(self) -> int:
        return self.image.width

    @property
    def height(self) -> int:
        return self.image.height

    @property
    def caption(self) -> str:
        """Look, error, samples and time as text."""
        seconds = self.curve.points[-1].seconds if len(self.curve) else 0.0
        look = f"{self.look}: " if self.look else ""
        error = f"error {self.error * 100:.2g}%" if math.isfinite(self.error) else "error unknown"
        return f"{look}{error}, {self.samples} samples per pixel, {seconds:.3g} s"

    def array(self) -> NDArray[np.uint8]:
        """Returns the pixels in sRGB, of the shape (height, width, 3)."""
        return np.asarray(self.image, np.uint8)

    def save(self, path: str | Path) -> Path:
        """Saves the picture in the format of the file name. A PNG file also contains the error."""
        path = Path(path)
        if path.suffix.lower() == ".png":
            path.write_bytes(self._png())
        else:
            self.image.save(path)
        return path

    def _png(self) -> bytes:
        texts = PngImagePlugin.PngInfo()
        texts.add_text("Software", "Diaphane")
        texts.add_text("Relative RMSE", repr(self.error))
        texts.add_text("Samples per pixel", str(self.samples))
        out = io.BytesIO()
        self.image.save(out, "PNG", pnginfo=texts)
        return out.getvalue()

    def _repr_html_(self) -> str:
        """Shows the picture with its error in a notebook."""
        data = base64.b64encode(self._png()).decode()
        return (f'<figure style="display:inline-block;margin:0"><img alt="{self.caption}" src="data:image/png;base64,{data}">'
                f"<figcaption>{self.caption}</figcaption></figure>")


@dataclass(frozen=True)
class Slice:
    """The exact voxel values of a slice, seen from below (axial), the front (coronal) or the patient's left (sagittal)."""

    #: The shape is (rows, columns), from the top left. The values of a CT are Hounsfield units.
    values: NDArray[np.int16]
    plane: str
    index: int
    #: Centre of the first pixel, and the steps to the next pixel to the right and below, in mm (docs/scenes.md, world space).
    first: tuple[float, float, float]
    right: tuple[float, float, float]
    down: tuple[float, float, float]
