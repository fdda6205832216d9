"""STOW-RS: receives studies over HTTPS with an API token (DICOM PS3.18, 10.5). Each series becomes a scan of the account."""

from __future__ import annotations

from collections.abc import Iterable
from http import HTTPStatus
from typing import Any

from pydicom.dataset import Dataset

from . import multipart
from .errors import ArchiveError
from .intake import Intake
from .metrics import METRICS
from .series_file import read_image
from .spool import Sender

#: Reasons of the failed images (PS3.18, table I.2-2).
_FAILED = {"full": 0xA700, "no-room": 0xA700, "busy": 0xA700, "invalid": 0xA900, "faulty": 0xC000}


def receive(intake: Intake, token: str, content_type: str, pieces: Iterable[bytes]) -> tuple[HTTPStatus, dict[str, Any]]:
    """Returns the status and the document of the response. Raises ArchiveError if the token permits nothing, and for a malformed
    body. What was stored before stays.
    """
    # The name in the metrics must not tell who sends.
    sender = Sender("stow", "stow", token)
    stored: list[dict[str, Any]] = []
    failed: list[dict[str, Any]] = []
    with intake.connected(sender):
        intake.check(sender)
        for data in multipart.parts(pieces, multipart.boundary_of(content_type)):
            METRICS.count_bytes("stow", len(data))
            image = read_image(data)
            try:
                intake.add(sender, image)
                stored.append(_reference(image))
            except ArchiveError as error:
                if error.kind == "unauthorised":
                    raise
                failed.append({**_reference(image), "00081197": {"vr": "US", "Value": [_FAILED.get(error.kind, 0x0110)]}})
    document = {tag: {"vr": "SQ", "Value": values} for tag, values in (("00081199", stored), ("00081198", failed)) if values}
    if failed:
        return (HTTPStatus.ACCEPTED if stored else HTTPStatus.CONFLICT), document
    return HTTPStatus.OK, document


def _reference(image: Dataset) -> dict[str, Any]:
    try:
        sop_class, uid = str(image.get("SOPClassUID", "")), str(image.get("SOPInstanceUID", ""))
    except (ValueError, TypeError, NotImplementedError) as error:
        raise ArchiveError("faulty", "an image has invalid values") from error
    return {"00081150": {"vr": "UI", "Value": [sop_class]}, "00081155": {"vr": "UI", "Value": [uid]}}
