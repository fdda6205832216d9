"""Hooks for schemathesis (contract_run.py): bodies that are not JSON, and new users for operations that end their own session."""

from __future__ import annotations

import os
import uuid

import psycopg
import schemathesis
from api_client import CONTRACT
from hypothesis import strategies as st
from schemathesis.transport.requests import REQUESTS_TRANSPORT
from schemathesis.transport.serialization import serialize_binary
from seeds import write_person

#: Operations that need a new user, because they end the session or have a limited number of calls.
BY_SOMEBODY_NEW = ("signOut", "signOutEverywhere", "deleteAccount", "endBrowserSession", "changePassword", "requestExport")


def _example() -> bytes:
    """Returns a valid preset in XML."""
    [operation] = [one for _, _, one in CONTRACT.operations() if one["operationId"] == "importPreset"]
    return operation["requestBody"]["content"]["application/xml"]["example"].encode()


for media in ("application/offset+octet-stream", "application/octet-stream"):
    schemathesis.openapi.media_type(media, st.binary(max_size=2000))
schemathesis.openapi.media_type("application/xml", st.just(_example()) | st.binary(max_size=2000) | st.builds(
    lambda cut, put: _example()[:cut] + put + _example()[cut:], st.integers(0, len(_example())), st.binary(max_size=20)))


@REQUESTS_TRANSPORT.serializer("application/offset+octet-stream", "application/octet-stream", "application/xml")
def as_bytes(context, value) -> dict:
    """Converts any generated value to bytes, including a list in place of a text."""
    return {"data": serialize_binary(value)}


@schemathesis.auth(refresh_interval=None)
class Signed:
    """Signs in as the shared administrator, or as a new user if the operation would end that session."""

    def get(self, case, context) -> tuple[str, str]:
        if case.operation.definition.raw.get("operationId") not in BY_SOMEBODY_NEW:
            return os.environ["DIAPHANE_FUZZ_COOKIE"], os.environ["DIAPHANE_FUZZ_CSRF"]
        with psycopg.connect(os.environ["DIAPHANE_FUZZ_DSN"], autocommit=True) as connection:
            _, token, csrf = write_person(lambda query, *values: connection.execute(query, values), f"fuzz-{uuid.uuid4().hex}@example.org")
        return token, csrf

    def set(self, case, data: tuple[str, str], context) -> None:
        case.cookies = {**(case.cookies or {}), "diaphane": data[0]}
        case.headers = {**(case.headers or {}), "X-CSRF-Token": data[1]}
