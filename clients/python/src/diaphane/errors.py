"""The exceptions of this package. All derive from DiaphaneError."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import httpx

_KIND = "urn:diaphane:problem:"


class DiaphaneError(Exception):
    """Base of all exceptions of this package."""


class ApiError(DiaphaneError):
    """The server refused a request.

    `kind` is stable, such as "not-found" (see Problem in the API contract). `detail` is a sentence for people. `errors` lists the
    invalid fields of a request. Administrators can find the request in their logs by `request_id`.
    """

    def __init__(self, status: int, kind: str, detail: str, request_id: str = "", errors: list[dict[str, str]] | None = None, retry_after: float = 0):
        fields = "".join(f" ({one['field']}: {one['message']})" for one in errors or [])
        super().__init__(f"{detail or kind}{fields}")
        self.status = status
        self.kind = kind
        self.detail = detail
        self.request_id = request_id
        self.errors = errors or []
        self.retry_after = retry_after


class AuthenticationError(ApiError):
    """The token is missing, invalid, expired or revoked."""


class ForbiddenError(ApiError):
    """The token lacks the scope for this, or tokens can never do it."""


class NotFoundError(ApiError):
    """There is nothing with this ID, or it belongs to someone else."""


class InvalidError(ApiError):
    """The request contains invalid values. `errors` lists them."""


class QuotaError(ApiError):
    """The storage, the number of scans or the rendering time of the account is used up."""


class BusyError(ApiError):
    """The server has no room at the moment, or limits the rate of requests. Try again after `retry_after` seconds."""


class ScanError(DiaphaneError):
    """The server refused a scan after the upload. `code` is stable, and the text says why."""

    def __init__(self, code: str, text: str):
        super().__init__(text)
        self.code = code


class UploadInterrupted(DiaphaneError):
    """The connection was lost during an upload. Pass `scan_id` as `resume` with the same files to continue it."""

    def __init__(self, scan_id: str, cause: Exception):
        super().__init__(f"the upload was interrupted ({cause}); continue it with resume={scan_id!r}")
        self.scan_id = scan_id


class StreamError(DiaphaneError):
    """The renderer refused a request. `field` names the invalid part of a scene, such as "camera.verticalFovDegrees"."""

    def __init__(self, code: str, message: str, field: str = ""):
        super().__init__(f"{message} ({field})" if field and field not in message else message)
        self.code = code
        self.field = field


class ConnectionLost(DiaphaneError):
    """The connection to the server could not be opened or was lost."""


class WaitedTooLong(DiaphaneError, TimeoutError):
    """Something did not happen within the given time."""


class UnreadableFile(DiaphaneError, ValueError):
    """A file or folder does not contain a scan that can be uploaded."""


_BY_KIND: dict[str, type[ApiError]] = {
    "over-quota": QuotaError,
    "too-many-data-sets": QuotaError,
    "render-time-spent": QuotaError,
    "no-worker": BusyError,
    "busy": BusyError,
    "unavailable": BusyError,
    "storage-full": BusyError,
}
_BY_STATUS: dict[int, type[ApiError]] = {
    401: AuthenticationError,
    403: ForbiddenError,
    404: NotFoundError,
    422: InvalidError,
    429: BusyError,
    503: BusyError,
}


def error_of(response: httpx.Response) -> ApiError:
    """Returns the exception for a response that is not a success."""
    problem: dict[str, Any] = {}
    if response.headers.get("content-type", "").startswith("application/problem+json"):
        problem = response.json()
    kind = str(problem.get("type", "")).removeprefix(_KIND) or "unknown"
    detail = str(problem.get("detail") or problem.get("title") or f"the server returned the status {response.status_code}")
    made = _BY_KIND.get(kind) or _BY_STATUS.get(response.status_code, ApiError)
    try:
        retry_after = float(response.headers.get("retry-after", "0"))
    except ValueError:
        retry_after = 0.0
    return made(response.status_code, kind, detail, str(problem.get("request_id", "")), problem.get("errors"), retry_after)
