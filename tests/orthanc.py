"""A real PACS for tests: Debian's Orthanc with its DICOMweb plugin, in a temporary folder and on free ports."""

from __future__ import annotations

import glob
import json
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
from harness import StackFactory, free_port

USER, PASSWORD = "diaphane", "secret-of-the-archive"
AE_TITLE = "ORTHANC"
BINARY = Path("/usr/sbin/Orthanc")


class Orthanc:
    """A running Orthanc with an empty store. Use `with`."""

    def __init__(self, factory: StackFactory, modalities: dict[str, list] | None = None, ae_title: str = AE_TITLE,
                 servers: dict[str, dict] | None = None):
        self.folder = factory.folder()
        self.http_port, self.dicom_port = free_port(), free_port()
        settings = {
            "Name": "Orthanc", "StorageDirectory": str(self.folder / "store"), "IndexDirectory": str(self.folder / "store"),
            "HttpPort": self.http_port, "DicomPort": self.dicom_port, "DicomAet": ae_title, "DicomCheckCalledAet": True,
            "RemoteAccessAllowed": False, "AuthenticationEnabled": True, "RegisteredUsers": {USER: PASSWORD},
            "DicomAlwaysAllowFind": True, "DicomAlwaysAllowGet": True, "DicomAlwaysAllowMove": True, "DicomAlwaysAllowStore": True, "DicomModalities": modalities or {},
            "Plugins": glob.glob("/usr/lib/orthanc/libOrthancDicomWeb.so*"), "DicomWeb": {"Enable": True, "Root": "/dicom-web/", "Servers": servers or {}}}
        path = self.folder / "orthanc.json"
        path.write_text(json.dumps(settings), encoding="utf-8")
        factory.run_as.own(path)
        self.receiver_port = 0
        self._log = (self.folder / "orthanc.log").open("wb")
        self.process = subprocess.Popen([BINARY, path], stdout=self._log, stderr=subprocess.STDOUT, cwd="/", **factory.run_as.popen())
        self.http = httpx.Client(base_url=f"http://127.0.0.1:{self.http_port}", auth=(USER, PASSWORD), timeout=60, trust_env=False)
        self._wait()

    @property
    def web_url(self) -> str:
        return f"http://127.0.0.1:{self.http_port}/dicom-web"

    def _wait(self) -> None:
        deadline = time.monotonic() + 60
        while True:
            try:
                if self.http.get("/system").is_success:
                    return
            except httpx.TransportError:
                pass
            assert self.process.poll() is None and time.monotonic() < deadline, (self.folder / "orthanc.log").read_text(errors="replace")
            time.sleep(0.1)

    def store(self, *folders: Path) -> None:
        """Stores all files of the folders."""
        files = [path for folder in folders for path in sorted(folder.glob("*.dcm"))]

        def one(path: Path) -> None:
            self.http.post("/instances", content=path.read_bytes()).raise_for_status()

        with ThreadPoolExecutor(4) as pool:
            list(pool.map(one, files))

    def stop(self) -> None:
        if self.process.poll() is None:
            self.process.terminate()
            self.process.wait(30)

    def __enter__(self) -> Orthanc:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self.http.close()
        self._log.close()
