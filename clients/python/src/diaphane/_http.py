"""Requests to the REST API by the operations of its contract."""

from __future__ import annotations

import time
import uuid
from typing import Any
from urllib.parse import quote, urlsplit

import httpx

from ._generated.operations import OPERATIONS
from .errors import BusyError, ConnectionLost, error_of

_SAFE = ("GET", "HEAD", "OPTIONS")


class Api:
    """Sends the operations of api/openapi.yaml with an API token."""

    def __init__(self, url: str, token: str, timeout: float, http: httpx.Client | None = None):
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.netloc:
            raise ValueError(f"not the URL of a server: {url!r} (expected https://HOST)")
        #: Scheme, host and port, which the stream requires as the Origin header.
        self.origin = f"{parts.scheme}://{parts.netloc}".lower()
        self._http = http or httpx.Client(timeout=timeout)
        self._headers = {"Authorization": f"Bearer {token}", "User-Agent": "diaphane-python"}

    def close(self) -> None:
        self._http.close()

    def call(self, operation: str, *, query: dict[str, Any] | None = None, body: Any = None, content: bytes | None = None,
             headers: dict[str, str] | None = None, wait: float = 0, repeatable: bool = False, **parameters: str) -> httpx.Response:
        """Sends an operation and returns its response. Raises an exception of errors.py for any error.

        Repeats a request that only reads for at most `wait` seconds while the server is busy or cannot be reached.
        `repeatable` sends an Idempotency-Key, so that a request that creates something can be repeated, too.
        """
        method, path, _ = OPERATIONS[operation]
        for name, value in parameters.items():
            path = path.replace("{" + name + "}", quote(value, safe=""))
        sent = {**self._headers, **(headers or {})}
        if repeatable:
            sent["Idempotency-Key"] = uuid.uuid4().hex
        deadline = time.monotonic() + (wait if repeatable or method in _SAFE else 0)
        while True:
            try:
                response = self._http.request(method, self.origin + path, params=query, json=body, content=content, headers=sent)
            except httpx.TransportError as error:
                if time.monotonic() >= deadline:
                    raise ConnectionLost(f"the server {self.origin} cannot be reached: {error}") from error
                time.sleep(0.5)
                continue
            if response.is_success:
                return response
            failed = error_of(response)
            if not isinstance(failed, BusyError) or time.monotonic() + failed.retry_after >= deadline:
                raise failed
            time.sleep(max(0.2, failed.retry_after))

    def json(self, operation: str, **arguments: Any) -> Any:
        """Like call(), but returns the decoded body."""
        return self.call(operation, **arguments).json()
