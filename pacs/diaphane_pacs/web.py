"""DICOMweb: QIDO-RS to search an archive and WADO-RS to fetch a series (DICOM PS3.18)."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import quote

import httpx

from . import limits, multipart
from .errors import ArchiveError, faulty
from .results import Search, as_items
from .series_file import is_uid
from .settings import WebArchive

_JSON = ("application/dicom+json", "application/json")
#: The original encoding, because Diaphane reads all usual ones.
_IMAGES = 'multipart/related; type="application/dicom"; transfer-syntax=*'
_PAGE = 1000


class WebClient:
    """A connection to one archive. Use it in one thread."""

    def __init__(self, archive: WebArchive):
        auth = httpx.BasicAuth(archive.user, archive.secret) if archive.user else None
        headers = {"Accept-Encoding": "identity", "User-Agent": "diaphane"}
        if archive.secret and not archive.user:
            headers["Authorization"] = f"Bearer {archive.secret}"
        self._url = archive.url
        # Redirects are not followed, so that an archive cannot send the gateway and its credentials to other hosts.
        self._http = httpx.Client(auth=auth, headers=headers, follow_redirects=False, trust_env=False,
                                  verify=archive.tls.client() if archive.url.startswith("https:") else False,
                                  timeout=httpx.Timeout(archive.timeout, connect=limits.CONNECT_SECONDS))

    def close(self) -> None:
        self._http.close()

    def studies(self, search: Search) -> list[dict[str, Any]]:
        query = [*search.query().items(), ("limit", str(limits.MOST_STUDIES + 1)), ("includefield", "00081030"), ("includefield", "00201208")]
        return self._search("/studies", query)

    def series(self, study: str) -> list[dict[str, Any]]:
        fields = [("includefield", tag) for tag in ("00080060", "0008103E", "00180015", "00180050", "00200011", "00201209")]
        return self._search(f"/studies/{study}/series", [*fields, ("limit", str(limits.MOST_SERIES))])

    def images(self, study: str, series: str) -> list[str]:
        """Returns the SOPInstanceUIDs of a series, in pages, because many archives limit a response."""
        found: dict[str, None] = {}
        while len(found) <= limits.MOST_IMAGES:
            page = self._search(f"/studies/{study}/series/{series}/instances",
                                [("limit", str(_PAGE)), ("offset", str(len(found)))], limits.MOST_RESULT_BYTES * 4)
            before = len(found)
            for one in page:
                if (of := one.get("0020000E")) is not None and of != series:
                    raise faulty("the archive listed images of another series")
                if is_uid(uid := one.get("00080018")):
                    found[str(uid)] = None
            # An archive that ignores `offset` sends the same page again.
            if len(page) < _PAGE or len(found) == before:
                break
        if len(found) > limits.MOST_IMAGES:
            raise faulty("the series has more images than a series may have")
        return list(found)

    def fetch(self, study: str, series: str, check: Callable[[], None], image: str = "") -> Iterator[bytes]:
        """Yields the files of a series, or one of them, as they arrive. Calls `check` for each piece, and ends with its exception."""
        path = f"/studies/{study}/series/{series}" + (f"/instances/{image}" if image else "")
        with self._get(path, [], _IMAGES) as response:
            boundary = multipart.boundary_of(response.headers.get("content-type", ""))
            yield from multipart.parts(_checked(response.iter_bytes(), check), boundary)

    def _search(self, path: str, query: list[tuple[str, str]], most: int = limits.MOST_RESULT_BYTES) -> list[dict[str, Any]]:
        deadline = time.monotonic() + limits.SEARCH_SECONDS
        with self._get(path, query, "application/dicom+json") as response:
            if response.status_code == httpx.codes.NO_CONTENT:
                return []
            if response.headers.get("content-type", "").partition(";")[0].strip().lower() not in _JSON:
                raise faulty("the archive answered a search with something else than JSON")
            body = bytearray()
            for piece in response.iter_bytes():
                body += piece
                if len(body) > most:
                    raise faulty("the archive answered a search with too many bytes")
                if time.monotonic() > deadline:
                    raise ArchiveError("slow", "the archive took too long")
        try:
            return as_items(json.loads(body))
        except (ValueError, RecursionError) as error:
            raise faulty("the archive answered a search with invalid JSON") from error

    @contextmanager
    def _get(self, path: str, query: list[tuple[str, str]], accept: str) -> Iterator[httpx.Response]:
        try:
            with self._http.stream("GET", self._url + path + _encoded(query), headers={"Accept": accept}) as response:
                _check(response)
                yield response
        except httpx.TimeoutException as error:
            kind = "unreachable" if isinstance(error, httpx.ConnectTimeout) else "slow"
            raise ArchiveError(kind, "the archive took too long") from error
        except httpx.ConnectError as error:
            raise ArchiveError("unreachable", "the archive cannot be reached") from error
        except (httpx.HTTPError, httpx.InvalidURL, httpx.StreamError) as error:
            raise ArchiveError("unreachable", "the connection to the archive was lost") from error


def _encoded(query: list[tuple[str, str]]) -> str:
    """Returns the query with plain wildcards, because Orthanc's plugin does not decode them (RFC 3986 needs no escapes there)."""
    return "?" + "&".join(f"{name}={quote(value, safe='*?:,')}" for name, value in query) if query else ""


def _checked(pieces: Iterable[bytes], check: Callable[[], None]) -> Iterator[bytes]:
    for piece in pieces:
        check()
        yield piece


def _check(response: httpx.Response) -> None:
    code = response.status_code
    if code in (401, 403, 407):
        raise ArchiveError("unauthorised", "the archive refused the credentials")
    if code in (404, 410):
        raise ArchiveError("not-found", "the archive does not have this")
    if code in (429, 503, 504):
        raise ArchiveError("unreachable", "the archive is overloaded or being maintained")
    if 300 <= code < 400:
        raise faulty("the archive redirected the request, which is not followed")
    if code not in (200, 204, 206):
        raise faulty(f"the archive answered with the status {code}")
    # Compressed content was not requested, and may be a bomb.
    if response.headers.get("content-encoding", "identity").lower() != "identity":
        raise faulty("the archive sent compressed content")
