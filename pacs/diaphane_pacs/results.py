"""Searches and their results, which are the same for DICOMweb and DIMSE."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from . import limits
from .errors import ArchiveError, faulty
from .series_file import is_uid

#: Keywords of the attributes in a result, by tag.
STUDY = {"0020000D": "study", "00100010": "patient_name", "00100020": "patient_id", "00100030": "birth_date", "00100040": "sex",
         "00080020": "date", "00080050": "accession", "00081030": "description", "00080061": "modalities", "00201206": "series",
         "00201208": "images"}
SERIES = {"0020000E": "series", "00080060": "modality", "0008103E": "description", "00180015": "body_part", "00180050": "thickness",
          "00200011": "number", "00201209": "images"}
_MODALITIES = ("CT", "MR", "PT")


@dataclass(frozen=True)
class Search:
    """What to search for. Empty fields match any study."""

    patient_name: str = ""
    patient_id: str = ""
    accession: str = ""
    modality: str = ""
    since: str = ""      # YYYY-MM-DD
    until: str = ""

    @classmethod
    def of(cls, body: dict[str, Any]) -> Search:
        def text(name: str, most: int = 64) -> str:
            value = body.get(name, "")
            # A backslash separates values in DICOM.
            if not isinstance(value, str) or len(value) > most or re.search(r"[\x00-\x1f\\]", value):
                raise ArchiveError("invalid", f"{name} has an invalid value")
            return value.strip()

        def date(name: str) -> str:
            value = text(name, 10)
            if value and not re.fullmatch(r"\d{4}-\d\d-\d\d", value):
                raise ArchiveError("invalid", f"{name} must be a date")
            return value

        return cls(text("patient_name"), text("patient_id"), text("accession", 16), text("modality", 2), date("from"), date("until"))

    def query(self) -> dict[str, str]:
        """Returns the matching keys by keyword. A name matches from its start, as people type only a part of it."""
        name = self.patient_name.replace(" ", "*").replace(",", "*")
        found = {"PatientName": name if not name or name.endswith("*") else name + "*", "PatientID": self.patient_id,
                 "AccessionNumber": self.accession, "ModalitiesInStudy": self.modality}
        if self.since or self.until:
            found["StudyDate"] = f"{self.since.replace('-', '')}-{self.until.replace('-', '')}"
        return {key: value for key, value in found.items() if value}


def as_items(document: object) -> list[dict[str, Any]]:
    """Returns the results of a DICOM JSON document, by tag, each with its first value or a list of them as texts."""
    if not isinstance(document, list) or not all(isinstance(one, dict) for one in document):
        raise faulty("the archive answered a search with another document")
    return [{tag.upper(): _value(element) for tag, element in one.items() if isinstance(tag, str)} for one in document]


def _value(element: object) -> Any:
    values = element.get("Value", []) if isinstance(element, dict) else []
    texts = []
    for one in values[:20] if isinstance(values, list) else []:
        text = one.get("Alphabetic", "") if isinstance(one, dict) else one
        if isinstance(text, str | int | float) and not isinstance(text, bool):
            texts.append(clipped(str(text)))
    return texts[0] if len(texts) == 1 else texts or None


def clipped(text: str) -> str:
    """Returns a text without control characters that has a limited length."""
    return re.sub(r"[\x00-\x1f\x7f]", " ", text).strip()[:limits.LONGEST_VALUE]


def studies(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Returns the studies with a CT, MR or PET series, newest first."""
    items = []
    for one in found[:limits.MOST_STUDIES]:
        if not is_uid(one.get("0020000D")):
            continue
        item = _named(one, STUDY)
        modalities = one.get("00080061") or []
        item["modalities"] = [modalities] if isinstance(modalities, str) else modalities
        item["date"], item["birth_date"] = _date(item["date"]), _date(item["birth_date"])
        item["patient_name"] = " ".join(part for part in re.split(r"[\^=]+", item["patient_name"]) if part)
        item["series"], item["images"] = _count(item["series"]), _count(item["images"])
        if not item["modalities"] or set(item["modalities"]) & set(_MODALITIES):
            items.append(item)
    items.sort(key=lambda item: item["date"] or "", reverse=True)
    return {"items": items, "more": len(found) > limits.MOST_STUDIES}


def series(found: list[dict[str, Any]], study: str) -> dict[str, Any]:
    """Returns the series of a study, with the recommended one first: the one with the most slices."""
    items = []
    for one in found[:limits.MOST_SERIES]:
        if (of := one.get("0020000D")) is not None and of != study:
            raise faulty("the archive listed series of another study")
        if not is_uid(one.get("0020000E")):
            continue
        item = _named(one, SERIES)
        item["number"], item["images"] = _count(item["number"]), _count(item["images"])
        item["suitable"] = item["modality"] in _MODALITIES and item["images"] != 0
        item["thickness"] = _thickness(item["thickness"])
        item["recommended"] = False
        items.append(item)
    items.sort(key=lambda item: (not item["suitable"], -(item["images"] or 0), item["number"] or 0))
    # A single suitable series needs no recommendation, and a few images are an overview.
    if len(items) > 1 and items[0]["suitable"] and items[1]["suitable"] and (items[0]["images"] or 0) >= 10:
        items[0]["recommended"] = True
    return {"items": items}


def _named(one: dict[str, Any], names: dict[str, str]) -> dict[str, Any]:
    def text(value: object) -> str:
        return value if isinstance(value, str) else str(value[0]) if isinstance(value, list) and value else ""

    return {name: text(one.get(tag)) for tag, name in names.items()}


def _date(text: str) -> str | None:
    return f"{text[:4]}-{text[4:6]}-{text[6:]}" if re.fullmatch(r"\d{8}", text) else None


def _count(text: str) -> int | None:
    return int(text) if re.fullmatch(r"\d{1,7}", text) else None


def _thickness(text: str) -> float | None:
    return round(float(text), 2) if re.fullmatch(r"\d{1,3}(\.\d+)?", text) else None
