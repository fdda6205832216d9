"""Uploads a series through the REST API, as the page does, so that quotas, the virus scan and the audit log apply."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from diaphane._http import Api
from diaphane._upload import send
from diaphane.errors import ApiError, BusyError, ConnectionLost, DiaphaneError, UploadInterrupted

from .errors import Cancelled
from .series_file import SeriesFile

TIMEOUT = 60.0
TUS = {"Tus-Resumable": "1.0.0"}


def upload(url: str, token: str, title: str, file: SeriesFile, progress: Callable[[float], object] | None = None, patience: float = 120) -> str:
    """Returns the ID of the scan. An upload that fails or is cancelled is removed."""
    api = Api(url, token, TIMEOUT)
    try:
        with file.finish() as data:
            made = api.json("createDataSet", body={"title": title, "bytes": len(data)}, wait=patience, repeatable=True)
            scan_id = str(made["data_set"]["id"])
            try:
                send(api, scan_id, data, progress, patience)
            except (DiaphaneError, Cancelled):
                remove(api, scan_id)
                raise
            return scan_id
    finally:
        api.close()


def deliver(url: str, token: str, title: str, file: SeriesFile, key: str) -> None:
    """Uploads a series that is kept if this fails. A later call with the same key continues, also in another process."""
    api = Api(url, token, TIMEOUT)
    try:
        with file.finish() as data:
            made = api.json("createDataSet", body={"title": title, "bytes": len(data)}, headers={"Idempotency-Key": key})
            send(api, str(made["data_set"]["id"]), data, None, patience=0)
    finally:
        api.close()


def remove(api: Api, scan_id: str) -> None:
    """Removes an incomplete upload. If that fails, it expires."""
    with contextlib.suppress(DiaphaneError):
        api.call("terminateUpload", upload_id=scan_id, headers=TUS)


def code_of(error: DiaphaneError) -> str:
    """Returns why an upload failed: a kind of problem of the REST API."""
    if isinstance(error, UploadInterrupted | ConnectionLost):
        return "unavailable"
    if isinstance(error, BusyError):
        return error.kind
    return error.kind if isinstance(error, ApiError) else "internal"
