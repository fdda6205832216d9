"""The client of a Diaphane server, and the scans on it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self, cast

import httpx
import numpy as np

from ._cleaning import clean_files
from ._generated import models
from ._http import Api
from ._upload import bundle, send
from .errors import DiaphaneError, ScanError, WaitedTooLong
from .picture import Alignment, Picture, Slice
from .session import Look, Plane, Session

_FINAL = ("ready", "refused", "expired")


class Diaphane:
    """A Diaphane server, used with an API token of an account.

    Create a token on your account page, and pass it as `token` or in DIAPHANE_TOKEN. It needs the scope `read` to list and
    render scans, `write` to upload, change and delete them, and `share` to decide who may see them.
    """

    def __init__(self, url: str, token: str | None = None, timeout: float = 60, http: httpx.Client | None = None):
        token = token or os.environ.get("DIAPHANE_TOKEN", "")
        if not token:
            raise ValueError("an API token is required: pass token= or set DIAPHANE_TOKEN")
        #: Sends any operation of the API contract that tokens can use, for what this class does not offer.
        self.api = Api(url, token, timeout, http)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        self.api.close()

    def scans(self) -> Iterator[Scan]:
        """Yields your scans, those shared with you and the samples."""
        cursor: str | None = None
        while True:
            page = self.api.json("listDataSets", query={"limit": 100, **({"cursor": cursor} if cursor else {})}, wait=30)
            for item in page["items"]:
                yield Scan(self.api, item)
            cursor = page["next_cursor"]
            if cursor is None:
                return

    def scan(self, scan_id: str) -> Scan:
        """Returns the scan with this ID."""
        return Scan(self.api, self.api.json("getDataSet", data_set_id=scan_id, wait=30))

    def upload(self, path: str | Path, title: str = "", series: str | None = None, resume: str | None = None,
               progress: Callable[[float], object] | None = None, patience: float = 60, phases: Sequence[int] | None = None) -> Scan:
        """Uploads a scan, and returns it while the server prepares it.

        `path` is a folder of DICOM slices, a DICOM file, a ZIP archive of either, or a NIfTI, NRRD or MetaImage file. Of these last
        three, `phases` chooses the phases to send by their numbers, from 0, such as range(0, 20, 2).

        The patient's name, dates, ID numbers and comments are removed before anything is sent, by the rules of the web page.
        A folder with several series needs `series`, a SeriesInstanceUID. If the connection is lost for longer than `patience`
        seconds, UploadInterrupted names the scan to pass as `resume`.
        """
        data = bundle(clean_files(path, series, phases))
        if resume is None:
            made = self.api.json("createDataSet", body={"title": title, "bytes": len(data)}, wait=patience, repeatable=True)
            scan_id = made["data_set"]["id"]
        else:
            scan_id = resume
        send(self.api, scan_id, data, progress, patience)
        return self.scan(scan_id)


class Scan:
    """A scan of the account, or one that is shared with it."""

    def __init__(self, api: Api, data: models.DataSet):
        self._api = api
        #: What the server said about the scan when it was last asked (DataSet in the API contract).
        self.data = data

    def __repr__(self) -> str:
        return f"<Scan {self.id} {self.title!r} {self.state}>"

    @property
    def id(self) -> str:
        return self.data["id"]

    @property
    def title(self) -> str:
        return self.data["title"]

    @property
    def state(self) -> str:
        """One of uploading, queued, building, ready, refused and expired."""
        return self.data["state"]

    def refresh(self) -> Self:
        """Asks the server again, and returns the scan."""
        self.data = cast("models.DataSet", self._api.json("getDataSet", data_set_id=self.id, wait=30))
        return self

    def wait(self, timeout: float = 600, interval: float = 0.5) -> Self:
        """Waits until the server has prepared the scan. Raises ScanError if the server refuses it."""
        deadline = time.monotonic() + timeout
        while self.refresh().state not in _FINAL:
            if time.monotonic() >= deadline:
                raise WaitedTooLong(f"the scan is still {self.state} after {timeout:g} s")
            time.sleep(interval)
        if self.state == "ready":
            return self
        refusal: Any = self.data["refusal"] or {}
        raise ScanError(refusal.get("code", self.state), refusal.get("text", f"the upload has {self.state}"))

    def rename(self, title: str) -> Self:
        self.data = cast("models.DataSet", self._api.json("describeDataSet", data_set_id=self.id, body={"title": title}))
        return self

    def delete(self) -> None:
        """Deletes the scan and everything saved with it. This cannot be undone."""
        self._api.call("deleteDataSet", data_set_id=self.id)

    def export(self, path: str | Path, label: int | None = None, above: int | None = None, timeout: float = 600,
               interval: float = 0.5) -> Path:
        """Saves the scan as a file for other programs, and returns its path.

        The name decides the format. `.nii.gz` contains all voxels. `.stl` and `.glb` contain the surface of a label, by its
        number, or of all voxels with at least the value `above`. The file may identify a person: a surface of the skin shows
        the face.
        """
        path = Path(path)
        name = path.name.lower()
        formats = [kind for ending, kind in ((".nii.gz", "nifti"), (".stl", "stl"), (".glb", "glb")) if name.endswith(ending)]
        if not formats:
            raise ValueError("the file's name must end with .nii.gz, .stl or .glb")
        order = {"format": formats[0], "label": label, "above": above}
        self._api.json("requestScanExport", data_set_id=self.id, body=order)
        deadline = time.monotonic() + timeout
        while (made := self._api.json("getScanExport", data_set_id=self.id, wait=30))["state"] == "queued":
            if time.monotonic() >= deadline:
                raise WaitedTooLong(f"the export is not ready after {timeout:g} s")
            time.sleep(interval)
        if made["problem"]:
            raise ScanError(made["problem"]["code"], made["problem"]["text"])
        path.write_bytes(self._api.call("downloadScanExport", data_set_id=self.id, wait=30).content)
        self._api.call("deleteScanExport", data_set_id=self.id)
        return path

    def session(self, width: int = 512, height: int = 512, timeout: float = 600, over: Scan | None = None) -> Session:
        """Opens a session, in which several pictures are rendered faster.

        `over` is a scan to show over this one. Both must share a frame of reference, or be aligned (see align).
        """
        if self.state != "ready":
            raise DiaphaneError(f"the scan is {self.state}; call wait() first")
        return Session(self._api, self.id, width, height, timeout, over.id if over else None)

    def align(self, second: Scan, timeout: float = 1800, interval: float = 1) -> Alignment:
        """Aligns another scan with this one, unless they are aligned, and returns how it lies in the space of this one."""
        found = self._api.json("requestAlignment", data_set_id=self.id, second_data_set_id=second.id)
        deadline = time.monotonic() + timeout
        while found["state"] in ("waiting", "running"):
            if time.monotonic() >= deadline:
                raise WaitedTooLong(f"the scans are not aligned after {timeout:g} s")
            time.sleep(interval)
            found = self._api.json("getAlignment", data_set_id=self.id, second_data_set_id=second.id, wait=30)
        if found["state"] != "ready":
            raise ScanError(found["reason"] or "failed", "the scans could not be aligned")
        return Alignment(np.array(found["matrix"]).reshape(4, 4), found["residual_mm"], found["overlap"])

    def looks(self) -> list[str]:
        """Returns the names of the looks that suit this scan."""
        with self.session() as session:
            return list(session.looks)

    def presets(self) -> list[dict[str, Any]]:
        """Returns the views that were saved with this scan. Each can be rendered as a look."""
        found = self._api.json("listPresets", data_set_id=self.id, wait=30)
        return [self._api.json("getPreset", preset_id=one["id"], wait=30) for one in found["items"]]

    def render(self, look: Look = None, width: int = 512, height: int = 512, error: float = 0.05, samples: int = 0,
               timeout: float = 600) -> Picture:
        """Renders one picture in a session of its own (see Session.render)."""
        with self.session(width, height, timeout) as session:
            return session.render(look, error=error, samples=samples)

    def film(self, path: str | Path, look: Look = None, timeout: float = 3600, **options: Any) -> Path:
        """Saves a film of a full rotation (see Session.film)."""
        with self.session(timeout=timeout) as session:
            return session.film(path, look, **options)

    def slice(self, plane: Plane = "axial", index: int | None = None) -> Slice:
        """Returns the exact voxel values of a slice (see Session.slice)."""
        with self.session() as session:
            return session.slice(plane, index)
