"""The files that are uploaded: voxels with a new header of only what a volume needs.

The rules are those of the page (frontend/src/scan/clean_file.ts): an element that the list does not name, or whose value does not have
the expected form, is not sent. So names, dates, ID numbers, comments and private elements never leave this computer.
"""

from __future__ import annotations

import hashlib
import io
import re
import tempfile
import zipfile
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pydicom
from pydicom.dataelem import DataElement
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.errors import InvalidDicomError
from pydicom.sequence import Sequence as DicomSequence
from pydicom.uid import UID

from ._research import clean_research_file, is_research_file
from .errors import UnreadableFile

#: The most bytes of an unpacked ZIP archive.
MOST_UNPACKED = 8 << 30

#: The elements that may be sent, by the form of their values.
KEPT_TAGS: dict[int, str] = {
    0x00080008: "image_type",
    0x00080016: "class",
    0x00080060: "modality",
    **dict.fromkeys((0x00180050, 0x00180081, 0x00180086, 0x00181060, 0x00189082, 0x00189087, 0x00200012), "number"),
    **dict.fromkeys((0x00200013, 0x00200032, 0x00200037), "number"),
    0x00200052: "frame",
    0x00200100: "number",
    0x00209128: "count",
    0x00209153: "number",
    0x00209241: "float",
    0x0020930D: "number",
    0x00280002: "us",
    0x00280004: "photometric",
    0x00280006: "us",
    0x00280008: "number",
    **dict.fromkeys((0x00280010, 0x00280011), "us"),
    **dict.fromkeys((0x00280030, 0x00280034), "number"),
    **dict.fromkeys((0x00280100, 0x00280101, 0x00280102, 0x00280103, 0x00280106, 0x00280107, 0x00280120, 0x00280121), "us"),
    0x00282110: "lossy",
    **dict.fromkeys((0x00281050, 0x00281051, 0x00281052, 0x00281053), "number"),
    0x00281054: "rescale_type",
    0x7FE00001: "offsets",
}
IMAGE_WORDS = frozenset((
    "ORIGINAL", "DERIVED", "MIXED", "PRIMARY", "SECONDARY", "AXIAL", "LOCALIZER", "REFORMATTED", "MPR", "AVERAGE", "RESAMPLED", "VOLUME",
    "HELIX", "NORM", "M", "P", "R", "I", "ND", "NONE", "DIFFUSION", "ADC", "TRACEW", "FFE", "SE", "M_FFE", "M_SE", "STATIC",
))
#: The elements of each functional group of an enhanced file that may be sent.
GROUPED_TAGS: dict[int, tuple[int, ...]] = {
    0x00189114: (0x00189082,),
    0x00189117: (0x00189087,),
    0x00189118: (0x00209153, 0x00209241),
    0x00209111: (0x00209056, 0x00209128),
    0x00209310: (0x0020930D,),
    0x00209113: (0x00200032,),
    0x00209116: (0x00200037,),
    0x00289110: (0x00280030,),
    0x00289132: (0x00281050, 0x00281051),
    0x00289145: (0x00281052, 0x00281053),
    0x00189226: (0x00089007,),
    0x00189329: (0x00089007,),
    0x00189751: (0x00089007,),
}
_SHARED, _PER_FRAME, _PIXELS = 0x52009229, 0x52009230, 0x7FE00010
_VR = {"count": "UL", "float": "FL", "offsets": "OV"}
_FORMS: dict[str, tuple[str, str]] = {
    "modality": ("CS", r"(CT|MR|PT)"),
    "photometric": ("CS", r"MONOCHROME[12]"),
    "rescale_type": ("LO", r"(HU|US|BQML|SUV)"),
    "lossy": ("CS", r"0[01]"),
    "class": ("UI", r"[0-9.]{1,64}"),
}


def disguised_uid(uid: str) -> str:
    """Returns a hash of a UID, which shows whether two files belong together, but not which examination they come from."""
    if not uid or uid.startswith("2.25."):
        return uid
    return f"2.25.{int.from_bytes(hashlib.sha256(uid.encode()).digest()[:16], 'big')}"


def kept_element(element: DataElement) -> DataElement | None:
    """Returns the element as it may be sent, or None."""
    form = KEPT_TAGS.get(int(element.tag))
    if form is None or element.value is None:
        return None
    text = "\\".join(map(str, element.value)) if element.VM > 1 else str(element.value)
    if form == "us":
        return element if element.VR in ("US", "SS") and element.VM == 1 else None
    if form in _VR:
        return element if str(element.VR) == _VR[form] and (element.VM == 1 or form == "offsets") else None
    if form == "number":
        return element if element.VR in ("FD", "FL") or (element.VR in ("DS", "IS") and re.fullmatch(r"[-+0-9.eE \\]*", text)) else None
    if form == "image_type":
        return DataElement(element.tag, "CS", _image_words(text))
    if form == "frame":
        return DataElement(element.tag, "UI", disguised_uid(text)) if re.fullmatch(r"[0-9.]{1,64}", text) else None
    vr, pattern = _FORMS[form]
    return DataElement(element.tag, vr, text) if re.fullmatch(pattern, text) else None


def _image_words(text: str) -> list[str]:
    return [word if word in IMAGE_WORDS else "OTHER" for word in (one.strip().upper() for one in text.split("\\"))]


def _grouped(item: Dataset) -> dict[tuple[int, int], DataElement]:
    """Returns the elements of the functional groups of a frame that may be sent, by group and tag."""
    found: dict[tuple[int, int], DataElement] = {}
    for group, tags in GROUPED_TAGS.items():
        inner = item[group].value[0] if group in item and item[group].value else Dataset()
        for tag in (one for one in tags if one in inner):
            element = inner[tag]
            if tag == 0x00209056:
                # The name of a stack can be any text. Its hash keeps equal names equal and others different.
                name = str(element.value).strip()
                found[group, tag] = DataElement(tag, "SH", hashlib.sha256(name.encode()).hexdigest()[:8])
            elif tag == 0x00089007:
                found[group, tag] = DataElement(tag, "CS", _image_words("\\".join(element.value) if element.VM > 1 else str(element.value)))
            elif (kept := kept_element(element)) is not None:
                found[group, tag] = kept
    return found


def _frame_groups(source: Dataset) -> DicomSequence | None:
    shared = source[_SHARED].value[0] if _SHARED in source and source[_SHARED].value else None
    frames = list(source[_PER_FRAME].value) if _PER_FRAME in source else []
    if shared is None and not frames:
        return None
    count = len(frames) or int(source.get("NumberOfFrames", 1) or 1)
    common = _grouped(shared) if shared is not None else {}
    items = []
    for frame in range(count):
        item, groups = Dataset(), {**common, **(_grouped(frames[frame]) if frames else {})}
        for group in sorted({group for group, _ in groups}):
            inner = Dataset()
            for (of, _), element in groups.items():
                if of == group:
                    inner.add(element)
            item.add(DataElement(group, "SQ", DicomSequence([inner])))
        items.append(item)
    return DicomSequence(items)


def clean_dicom(source: Dataset, number: int) -> bytes:
    """Returns the file to upload. `number` is its position in the bundle, from 1, which replaces the identifiers."""
    if _PIXELS not in source:
        raise UnreadableFile(f"file {number} of the series contains no pixels")
    own = f"2.25.{1000 + number}"
    meta = FileMetaDataset()
    meta.MediaStorageSOPInstanceUID = UID(own)
    meta.TransferSyntaxUID = source.file_meta.TransferSyntaxUID
    meta.ImplementationClassUID = UID("2.25.3")
    clean = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
    for tag in KEPT_TAGS:
        if tag in source and (element := kept_element(source[tag])) is not None:
            clean.add(element)
    # Taken from the clean elements, which contain the class only if it has the form of one.
    clean.file_meta.MediaStorageSOPClassUID = UID(str(clean.get("SOPClassUID", "")))
    clean.SOPInstanceUID, clean.StudyInstanceUID, clean.SeriesInstanceUID = UID(own), UID("2.25.1"), UID("2.25.2")
    if (groups := _frame_groups(source)) is not None:
        clean.add(DataElement(_PER_FRAME, "SQ", groups))
    pixels = source[_PIXELS]
    copied = DataElement(_PIXELS, pixels.VR, pixels.value)
    copied.is_undefined_length = pixels.is_undefined_length
    clean.add(copied)
    out = io.BytesIO()
    pydicom.dcmwrite(out, clean, enforce_file_format=False)
    return out.getvalue()


@dataclass(frozen=True)
class Series:
    """The files of one series of a folder. `uid` stays on this computer."""

    uid: str
    files: tuple[Path, ...]

    def __str__(self) -> str:
        return f"{self.uid} ({len(self.files)} files)"


def series_in(paths: Iterable[Path]) -> list[Series]:
    """Returns the series of slices among the files, largest first. Other files are left out."""
    found: dict[str, list[Path]] = {}
    for path in paths:
        try:
            header = pydicom.dcmread(path, stop_before_pixels=True, specific_tags=["SeriesInstanceUID", "Modality", "Rows"])
        except (InvalidDicomError, OSError, EOFError):
            continue
        if str(header.get("Modality", "")) in ("CT", "MR", "PT") and "Rows" in header:
            found.setdefault(str(header.get("SeriesInstanceUID", "")), []).append(path)
    return sorted((Series(uid, tuple(files)) for uid, files in found.items()), key=lambda one: -len(one.files))


def clean_files(path: str | Path, series: str | None = None, phases: Sequence[int] | None = None) -> list[bytes]:
    """Returns the files of a scan without personal data, ready to upload. `phases`: those to keep of a research file."""
    path = Path(path)
    if not path.exists():
        raise UnreadableFile(f"{path} does not exist")
    if path.is_file() and is_research_file(path):
        return [clean_research_file(path, phases)]
    if path.is_file() and zipfile.is_zipfile(path):
        with tempfile.TemporaryDirectory(prefix="diaphane-") as folder:
            return _clean_folder(path, _unpacked(path, Path(folder)), series, phases)
    return _clean_folder(path, [path] if path.is_file() else sorted(one for one in path.rglob("*") if one.is_file()), series, phases)


def _unpacked(path: Path, folder: Path) -> list[Path]:
    """Unpacks a ZIP archive, and returns its files in order."""
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(one.file_size for one in archive.infolist()) > MOST_UNPACKED:
                raise UnreadableFile(f"{path} is larger than {MOST_UNPACKED >> 30} GB when unpacked")
            archive.extractall(folder)
    except (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError, OSError) as error:
        raise UnreadableFile(f"{path} cannot be unpacked: it is damaged or protected by a password") from error
    return sorted(one for one in folder.rglob("*") if one.is_file())


def _clean_folder(path: Path, files: list[Path], series: str | None, phases: Sequence[int] | None) -> list[bytes]:
    found = series_in(files)
    images = [one for one in files if is_research_file(one)]
    if not found and len(images) == 1:
        return [clean_research_file(images[0], phases)]
    if series is not None:
        found = [one for one in found if one.uid == series]
    if not found:
        raise UnreadableFile(f"{path} contains no slices of a CT, MR or PET scan")
    if len(found) > 1:
        raise UnreadableFile(f"{path} contains {len(found)} series; choose one with series=: {', '.join(map(str, found))}")
    if phases is not None:
        raise ValueError("phases can be chosen for NIfTI, NRRD and MetaImage only; the server sorts DICOM files into phases")
    return [clean_dicom(pydicom.dcmread(file), number) for number, file in enumerate(found[0].files, 1)]
