"""A small CT scan of a made-up patient: a skull around a brain, as a folder of DICOM slices."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian

#: Every text in the files contains this name, which must not reach the server.
NAME = "Phantasia^Canary"
SIDE, SLICES, SPACING = 64, 40, 2.0


def values() -> np.ndarray:
    """Returns the Hounsfield units, of the shape (slices, rows, columns), from the feet to the head."""
    z, y, x = np.ogrid[:SLICES, :SIDE, :SIDE]
    middle = (SIDE - 1) / 2
    far = np.sqrt((x - middle) ** 2 + (y - middle) ** 2 + ((z - (SLICES - 1) / 2) * 1.6) ** 2)
    return np.select([far < 20, far < 24, far < 27], [40, 1100, -60], -1000).astype(np.int16)


def slice_file(number: int, pixels: np.ndarray, study: str = "1.2", series: str = "1.2.3", spacing: float = SPACING) -> bytes:
    """Returns a slice of a CT scan as a DICOM file. The first number is 1."""
    uid = f"{series}.{number}"
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.TransferSyntaxUID, meta.MediaStorageSOPInstanceUID = CTImageStorage, ExplicitVRLittleEndian, uid
    made = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    made.SOPClassUID, made.SOPInstanceUID, made.StudyInstanceUID, made.SeriesInstanceUID = CTImageStorage, uid, study, series
    made.PatientName, made.PatientID, made.SeriesDescription, made.StudyDate = NAME, NAME, NAME, "20200101"
    made.Modality, made.ImageType, made.InstanceNumber = "CT", ["ORIGINAL", "PRIMARY", "AXIAL"], number
    made.ImagePositionPatient, made.ImageOrientationPatient = [0, 0, number * spacing], [1, 0, 0, 0, 1, 0]
    made.PixelSpacing, made.SliceThickness = [spacing, spacing], spacing
    made.Rows, made.Columns, made.SamplesPerPixel, made.PhotometricInterpretation = *pixels.shape, 1, "MONOCHROME2"
    made.BitsAllocated, made.BitsStored, made.HighBit, made.PixelRepresentation = 16, 16, 15, 1
    made.RescaleSlope, made.RescaleIntercept, made.RescaleType = 1, 0, "HU"
    made.PixelData = pixels.tobytes()
    out = io.BytesIO()
    pydicom.dcmwrite(out, made, enforce_file_format=False)
    return out.getvalue()


def write(folder: Path) -> Path:
    """Writes the slices and returns the folder."""
    for number, pixels in enumerate(values(), 1):
        (folder / f"{number:03d}.dcm").write_bytes(slice_file(number, pixels))
    return folder
