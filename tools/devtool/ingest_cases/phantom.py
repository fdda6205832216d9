"""Slices through a phantom with known values at every place of the patient, as DICOM files (pydicom).

Places are in mm, in the patient's axes (LPS). The phantom's value changes evenly along every axis, so that any rotation, shift or
scaling shows. It may contain markers, which are small balls at known places."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Callable, Sequence

import numpy as np
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence as Items
from pydicom.uid import ExplicitVRLittleEndian, generate_uid

CT, MR, PT = (f"1.2.840.10008.5.1.4.1.1.{leaf}" for leaf in ("2", "4", "128"))
ENHANCED_CT, ENHANCED_MR = (f"1.2.840.10008.5.1.4.1.1.{leaf}" for leaf in ("2.1", "4.1"))
MODALITY = {CT: "CT", MR: "MR", PT: "PT", ENHANCED_CT: "CT", ENHANCED_MR: "MR"}

AXIAL = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)
SAGITTAL = (0.0, 1.0, 0.0, 0.0, 0.0, -1.0)

Places = np.ndarray   # (..., 3), mm
Values = Callable[[Places], np.ndarray]


def even(places: Places) -> np.ndarray:
    """Returns values that rise by 20, 30 and 50 per mm along x, y and z. In every case below, half
    a voxel makes a difference of 7 or more."""
    return 1000 + 20 * places[..., 0] + 30 * places[..., 1] + 50 * places[..., 2]


def lifted(places: Places) -> np.ndarray:
    """Returns the same values raised to be nowhere below 0, for MR and PET."""
    return even(places) + 3000


def markers(*where: Sequence[float], radius: float = 3.0) -> Values:
    """Returns a phantom of air with a soft ball (a Gaussian of that standard deviation in mm) at
    each place."""
    def values(places: Places) -> np.ndarray:
        total = np.full(places.shape[:-1], -1000.0)
        for place in where:
            distance = ((places - np.asarray(place)) ** 2).sum(-1)
            total += 1500 * np.exp(-distance / (2 * radius ** 2))
        return total
    return values


@dataclass(frozen=True)
class Slice:
    """One image through the phantom."""

    position: tuple[float, float, float]
    orientation: tuple[float, ...] = AXIAL
    pixel: tuple[float, float] = (0.8, 0.7)     # mm between rows, between columns
    rows: int = 20
    columns: int = 24
    slope: float = 1.0
    intercept: float = -8192.0
    uid: str = ""
    extra: dict = field(default_factory=dict)    # elements by keyword; None removes an element

    def places(self) -> Places:
        row, column = np.array(self.orientation[:3]), np.array(self.orientation[3:])
        x = np.arange(self.columns)[None, :, None] * self.pixel[1] * row
        y = np.arange(self.rows)[:, None, None] * self.pixel[0] * column
        return np.array(self.position) + x + y


@dataclass(frozen=True)
class Series:
    """Attributes that all files of a series share."""

    sop_class: str = CT
    values: Values = even
    bits: int = 16
    signed: bool = False
    syntax: str = ExplicitVRLittleEndian
    series_uid: str = ""
    patient: str = "one"
    extra: dict = field(default_factory=dict)

    def stored(self, one: Slice) -> np.ndarray:
        """Returns the pixels as the file stores them, before any packing."""
        numbers = np.round((self.values(one.places()) - one.intercept) / one.slope)
        low, high = (-(1 << self.bits - 1), (1 << self.bits - 1) - 1) if self.signed else (0, (1 << self.bits) - 1)
        if numbers.min() < low or numbers.max() > high:
            raise ValueError(f"the phantom does not fit into {self.bits} bits")
        return numbers.astype(np.int16 if self.signed else np.uint16)


def normal_of(orientation: Sequence[float]) -> np.ndarray:
    return np.cross(orientation[:3], orientation[3:])


def stack(places: Sequence[float] | int = 20, gap: float = 2.0, tilt: float = 0.0, origin=(-9.0, -8.0, -20.0),
          **of_each) -> list[Slice]:
    """Returns slices along the normal, at `places` in mm (or that many, `gap` apart), with the stack tilted by `tilt` degrees
    along the columns."""
    if isinstance(places, int):
        places = [i * gap for i in range(places)]
    one = Slice(position=tuple(origin), **of_each)
    way = normal_of(one.orientation) + math.tan(math.radians(tilt)) * np.array(one.orientation[3:])
    return [replace(one, position=tuple(float(v) for v in np.array(origin) + at * way)) for at in places]


def dataset(series: Series, one: Slice) -> Dataset:
    """Returns one slice as a separate file."""
    ds = _head(series, one.uid or generate_uid())
    ds.ImagePositionPatient = [_ds(v) for v in one.position]
    ds.ImageOrientationPatient = [_ds(v) for v in one.orientation]
    ds.PixelSpacing = [_ds(v) for v in one.pixel]
    ds.SliceThickness = "99"            # wrong, as on many discs
    ds.RescaleSlope, ds.RescaleIntercept = _ds(one.slope), _ds(one.intercept)
    _pixels(ds, series, one.rows, one.columns, series.stored(one).tobytes())
    _change(ds, {**series.extra, **one.extra})
    return ds


def enhanced(series: Series, slices: Sequence[Slice], frames: Sequence[dict] | None = None) -> Dataset:
    """Returns all slices as frames of one enhanced file. `frames` contains the frame types by
    StackID. Frames of one file have the same size."""
    first = slices[0]
    ds = _head(series, generate_uid())
    ds.NumberOfFrames = len(slices)
    kind = "CTImageFrameTypeSequence" if series.sop_class == ENHANCED_CT else "MRImageFrameTypeSequence"
    shared = Dataset()
    shared.PixelMeasuresSequence = _item(PixelSpacing=[_ds(v) for v in first.pixel], SliceThickness="99")
    setattr(shared, kind, _item(FrameType=["ORIGINAL", "PRIMARY", "VOLUME", "NONE"]))
    each = []
    for i, one in enumerate(slices):
        own = (frames or [{}] * len(slices))[i]
        frame = Dataset()
        frame.FrameContentSequence = _item(StackID=str(own.get("stack", 1)), InStackPositionNumber=i + 1,
                                           TemporalPositionIndex=int(own.get("time", 1)))
        frame.PlanePositionSequence = _item(ImagePositionPatient=[_ds(v) for v in one.position])
        frame.PlaneOrientationSequence = _item(ImageOrientationPatient=[_ds(v) for v in one.orientation])
        frame.PixelValueTransformationSequence = _item(RescaleSlope=_ds(one.slope), RescaleIntercept=_ds(one.intercept),
                                                       RescaleType="US")
        each.append(frame)
    ds.SharedFunctionalGroupsSequence, ds.PerFrameFunctionalGroupsSequence = Items([shared]), Items(each)
    _pixels(ds, series, first.rows, first.columns, b"".join(series.stored(one).tobytes() for one in slices))
    _change(ds, series.extra)
    return ds


def write(folder: Path, files: Sequence[Dataset], first_number: int = 1) -> None:
    """Writes the files under names and in an order that carry no information."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, ds in enumerate(files):
        shuffled = (7 * number + 3) % len(files) if len(files) % 7 else number
        ds.save_as(folder / f"IM{first_number + shuffled:05d}", enforce_file_format=True)


def _head(series: Series, uid: str) -> Dataset:
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = series.sop_class, uid
    meta.TransferSyntaxUID = series.syntax
    ds = Dataset()
    ds.file_meta = meta
    ds.SOPClassUID, ds.SOPInstanceUID = series.sop_class, uid
    ds.StudyInstanceUID, ds.SeriesInstanceUID = "2.25.77", series.series_uid or "2.25.78"
    ds.PatientName, ds.PatientID = f"Phantom^{series.patient}", series.patient
    ds.Modality = MODALITY.get(series.sop_class, "OT")
    ds.ImageType = ["ORIGINAL", "PRIMARY", "AXIAL"]
    ds.SeriesDescription = "generated"
    return ds


def _pixels(ds: Dataset, series: Series, rows: int, columns: int, data: bytes) -> None:
    ds.SamplesPerPixel, ds.PhotometricInterpretation = 1, "MONOCHROME2"
    ds.Rows, ds.Columns = rows, columns
    ds.BitsAllocated, ds.BitsStored, ds.HighBit = 16, series.bits, series.bits - 1
    ds.PixelRepresentation = int(series.signed)
    if series.syntax == "1.2.840.10008.1.2.2":
        data = np.frombuffer(data, "<u2").astype(">u2").tobytes()
    ds.PixelData = data
    ds["PixelData"].VR = "OW"


def _change(ds: Dataset, elements: dict) -> None:
    for keyword, value in elements.items():
        if value is not None:
            setattr(ds, keyword, value)
        elif keyword in ds:
            delattr(ds, keyword)


def _item(**elements) -> Items:
    item = Dataset()
    _change(item, elements)
    return Items([item])


def _ds(value: float) -> str:
    """Formats a decimal string of at most 16 characters."""
    for digits in range(15, 5, -1):
        if len(text := f"{value:.{digits}g}") <= 16:
            return text
    return f"{value:.5g}"
