"""Uploads by tus 1.0 (https://tus.io), in parts that can be resumed."""

from __future__ import annotations

import base64
import hashlib
import tarfile
import time
from collections.abc import Callable, Sequence
from mmap import mmap

from ._http import Api
from .errors import ApiError, BusyError, ConnectionLost, UploadInterrupted

#: The largest part that a server accepts.
PART = 8 * 1024 * 1024
_TUS = {"Tus-Resumable": "1.0.0"}


#: The end of a bundle.
END = b"\0" * 2 * tarfile.BLOCKSIZE


def member(number: int, data: bytes) -> tuple[bytes, bytes, bytes]:
    """Returns the header, the contents and the padding of a file in a bundle. The first number is 1."""
    info = tarfile.TarInfo(f"{number:05d}.dcm")
    info.size, info.mode = len(data), 0o644
    return info.tobuf(tarfile.USTAR_FORMAT), data, b"\0" * (-len(data) % tarfile.BLOCKSIZE)


def bundle(files: Sequence[bytes]) -> bytes:
    """Returns the tar that the page makes of the same files (docs/contracts.md, "Upload bundle")."""
    return b"".join(piece for number, data in enumerate(files, 1) for piece in member(number, data)) + END


def send(api: Api, scan_id: str, data: bytes | mmap, progress: Callable[[float], object] | None, patience: float) -> None:
    """Sends what the server does not have yet. Raises UploadInterrupted if it was not reachable for `patience` seconds."""
    deadline = time.monotonic() + patience
    offset: int | None = None
    while offset is None or offset < len(data):
        try:
            if offset is None:
                offset = int(api.call("getUploadOffset", upload_id=scan_id, headers=_TUS).headers["Upload-Offset"])
                continue
            offset = _send_part(api, scan_id, data, offset)
        except (ConnectionLost, BusyError) as error:
            if time.monotonic() >= deadline:
                raise UploadInterrupted(scan_id, error) from error
            time.sleep(max(0.2, error.retry_after) if isinstance(error, BusyError) else 0.5)
            offset = None
        except ApiError as error:
            # The response to the previous part was lost, so the server has more than this client knows.
            if error.kind != "offset-mismatch" or time.monotonic() >= deadline:
                raise
            offset = None
        else:
            deadline = time.monotonic() + patience
            if progress is not None:
                progress(offset / len(data))


def _send_part(api: Api, scan_id: str, data: bytes | mmap, offset: int) -> int:
    part = data[offset:offset + PART]
    digest = base64.b64encode(hashlib.sha256(part).digest()).decode()
    answer = api.call("appendToUpload", upload_id=scan_id, content=part, headers={
        **_TUS, "Upload-Offset": str(offset), "Upload-Checksum": f"sha256 {digest}", "Content-Type": "application/offset+octet-stream"})
    return int(answer.headers["Upload-Offset"])
