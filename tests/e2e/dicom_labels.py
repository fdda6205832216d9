"""Segmentations (SEG) and structure sets (RTSTRUCT) as other programs write them, for scans of `devtool.ingest_cases.phantom`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sequence import Sequence as Items
from pydicom.uid import ExplicitVRLittleEndian, generate_uid

from devtool.ingest_cases.phantom import Slice

SEG, RTSTRUCT = "1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.481.3"


def _item(**values: object) -> Dataset:
    made = Dataset()
    for keyword, value in values.items():
        setattr(made, keyword, value)
    return made


def _head(sop_class: str, modality: str, frame_of_reference: str, patient: str) -> Dataset:
    ds = _item(SOPClassUID=sop_class, SOPInstanceUID=generate_uid(), StudyInstanceUID=generate_uid(), SeriesInstanceUID=generate_uid(),
               Modality=modality, FrameOfReferenceUID=frame_of_reference, PatientName=patient, PatientID=patient, ContentDescription=patient)
    ds.file_meta = FileMetaDataset()
    ds.file_meta.TransferSyntaxUID, ds.file_meta.MediaStorageSOPClassUID = ExplicitVRLittleEndian, sop_class
    ds.file_meta.MediaStorageSOPInstanceUID = ds.SOPInstanceUID
    return ds


def segmentation(path: Path, slices: Sequence[Slice], segments: Mapping[str, np.ndarray], frame_of_reference: str, patient: str) -> None:
    """Writes binary segments by name. Each is an array of bool (slices, rows, columns); slices without it get no frame."""
    first = slices[0]
    ds = _head(SEG, "SEG", frame_of_reference, patient)
    ds.ImageType, ds.SegmentationType = ["DERIVED", "PRIMARY"], "BINARY"
    ds.SegmentSequence = Items([_item(SegmentNumber=number, SegmentLabel=name, SegmentAlgorithmType="MANUAL")
                                for number, name in enumerate(segments, 1)])
    ds.SharedFunctionalGroupsSequence = Items([_item(
        PixelMeasuresSequence=Items([_item(PixelSpacing=list(first.pixel), SliceThickness=2.0)]),
        PlaneOrientationSequence=Items([_item(ImageOrientationPatient=list(first.orientation))]))])
    frames, bits = [], []
    for number, mask in enumerate(segments.values(), 1):
        for one, plane in zip(slices, mask, strict=True):
            if plane.any():
                frames.append(_item(SegmentIdentificationSequence=Items([_item(ReferencedSegmentNumber=number)]),
                                    PlanePositionSequence=Items([_item(ImagePositionPatient=list(one.position))])))
                bits.append(plane.ravel())
    ds.PerFrameFunctionalGroupsSequence, ds.NumberOfFrames = Items(frames), len(frames)
    ds.Rows, ds.Columns, ds.SamplesPerPixel, ds.PhotometricInterpretation = first.rows, first.columns, 1, "MONOCHROME2"
    ds.BitsAllocated, ds.BitsStored, ds.HighBit, ds.PixelRepresentation = 1, 1, 0, 0
    # Frames follow each other without padding, the first pixel in the lowest bit (PS3.5, 8.1.1).
    packed = np.packbits(np.concatenate(bits), bitorder="little").tobytes()
    ds.PixelData = packed + b"\0" * (len(packed) % 2)
    ds.save_as(path, enforce_file_format=True)


def structure_set(path: Path, outlines: Mapping[str, Sequence[Sequence[Sequence[float]]]], frame_of_reference: str, patient: str) -> None:
    """Writes closed contours by the name of their structure, as places in mm."""
    ds = _head(RTSTRUCT, "RTSTRUCT", frame_of_reference, patient)
    ds.StructureSetLabel = patient
    ds.ReferencedFrameOfReferenceSequence = Items([_item(FrameOfReferenceUID=frame_of_reference)])
    ds.StructureSetROISequence = Items([_item(ROINumber=number, ReferencedFrameOfReferenceUID=frame_of_reference, ROIName=name,
                                              ROIGenerationAlgorithm="MANUAL") for number, name in enumerate(outlines, 1)])
    ds.ROIContourSequence = Items([_item(ReferencedROINumber=number, ROIDisplayColor=[220, 40, 40], ContourSequence=Items(
        [_item(ContourGeometricType="CLOSED_PLANAR", NumberOfContourPoints=len(contour), ContourData=[round(v, 4) for place in contour for v in place])
         for contour in contours])) for number, contours in enumerate(outlines.values(), 1)])
    ds.save_as(path, enforce_file_format=True)
