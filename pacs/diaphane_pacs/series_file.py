"""The upload of a series: its cleaned images in a tar on disk. What identifies the patient is never written."""

from __future__ import annotations

import io
import mmap
import tempfile
import zlib
from dataclasses import dataclass
from typing import BinaryIO, cast

import pydicom
from pydicom.dataset import Dataset
from pydicom.errors import InvalidDicomError
from pydicom.filereader import _read_file_meta_info, read_preamble

from diaphane._cleaning import clean_dicom
from diaphane._upload import END, member

from . import limits
from .errors import ArchiveError, faulty

_MODALITIES = ("CT", "MR", "PT")
_DEFLATED = "1.2.840.10008.1.2.1.99"


def is_uid(text: object) -> bool:
    return isinstance(text, str) and 0 < len(text) <= 64 and all(c in "0123456789." for c in text)


def read_image(data: bytes) -> Dataset:
    """Reads a DICOM file from an archive. Raises ArchiveError if it is not one."""
    if len(data) > limits.MOST_IMAGE_BYTES:
        raise faulty("an image is larger than images may be")
    try:
        _check_deflated(data)
        return pydicom.dcmread(io.BytesIO(data))
    except ArchiveError:
        raise
    except (InvalidDicomError, OSError, EOFError, ValueError, KeyError, TypeError, AttributeError, NotImplementedError, zlib.error,
            RecursionError) as error:
        raise faulty("an image is not a valid DICOM file") from error


def _check_deflated(data: bytes) -> None:
    """Inflates a deflated file with a limit, because pydicom has none."""
    file = io.BytesIO(data)
    if read_preamble(file, force=False) is None:
        raise faulty("an image is not a valid DICOM file")
    meta = _read_file_meta_info(file)
    if str(meta.get("TransferSyntaxUID", "")) != _DEFLATED:
        return
    inflater = zlib.decompressobj(-zlib.MAX_WBITS)
    inflater.decompress(data[file.tell():], limits.MOST_IMAGE_BYTES)
    if inflater.unconsumed_tail:
        raise faulty("a compressed image is larger than images may be")


@dataclass(frozen=True)
class ImageIds:
    study: str
    series: str
    uid: str
    modality: str


def ids_of(image: Dataset) -> ImageIds:
    """Raises ArchiveError if no volume can be built of the image."""
    try:
        study, series, uid = (str(image.get(name, "")) for name in ("StudyInstanceUID", "SeriesInstanceUID", "SOPInstanceUID"))
        modality = str(image.get("Modality", ""))
    except (ValueError, TypeError, NotImplementedError) as error:
        raise faulty("an image has invalid values") from error
    if not (is_uid(study) and is_uid(series) and is_uid(uid)):
        raise faulty("an image has no valid UIDs")
    if modality not in _MODALITIES or "PixelData" not in image or "Rows" not in image:
        raise ArchiveError("invalid", "an image is not a slice of a CT, MR or PET scan")
    return ImageIds(study, series, uid, modality)


class SeriesFile:
    """Collects the images of one series. Without `file`, it has no name, so that not even a kill leaves it behind."""

    def __init__(self, study: str = "", series: str = "", file: BinaryIO | None = None):
        self.study, self.series, self.modality = study, series, ""
        self.images: set[str] = set()
        self.frames = 0
        self._file = file or cast(BinaryIO, tempfile.TemporaryFile(prefix="diaphane-pacs-"))   # noqa: SIM115 close() closes it
        self.bytes = 0

    def code(self, uid: str) -> str:
        """Returns what `images` has for a SOPInstanceUID."""
        return uid

    def add(self, image: Dataset) -> None:
        """Adds an image. One that is there already is ignored.

        Raises ArchiveError if it belongs to another series, or if no volume can be built of it.
        """
        ids = ids_of(image)
        if self.series and (self.study, self.series) != (ids.study, ids.series):
            raise faulty("an image belongs to another series than the requested one")
        if (code := self.code(ids.uid)) in self.images:
            return
        if len(self.images) >= limits.MOST_IMAGES:
            raise faulty("the series has more images than a series may have")
        data = clean(image, len(self.images) + 1)
        try:
            frames = int(image.get("NumberOfFrames", 1) or 1)
        except (ValueError, TypeError) as error:
            raise faulty("an image has invalid values") from error
        self.study, self.series, self.modality = ids.study, ids.series, ids.modality
        self._write(data, code, frames)
        self.images.add(code)
        self.frames += frames

    def _write(self, data: bytes, image: str, frames: int) -> None:
        self.bytes += len(data)
        if self.bytes > limits.MOST_SERIES_BYTES:
            raise faulty("the series is larger than a series may be")
        for piece in member(len(self.images) + 1, data):
            self._file.write(piece)

    def finish(self) -> mmap.mmap:
        """Returns the complete tar. Its pages come from the disk as they are read."""
        self._file.write(END)
        self._file.flush()
        return mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)

    def close(self) -> None:
        self._file.close()


def clean(image: Dataset, number: int) -> bytes:
    try:
        return clean_dicom(image, number)
    except ArchiveError:
        raise
    except Exception as error:   # a value of the file that pydicom decodes only now
        raise faulty("an image has invalid values") from error
