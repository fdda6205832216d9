"""What can go wrong with an archive. The texts name no patient and quote nothing that an archive sent."""

from __future__ import annotations

#: HTTP status of the gateway's response, by kind of error. api turns the kinds into problems (api/pacs/archives.cpp).
STATUS = {"invalid": 400, "not-found": 404, "busy": 429, "unreachable": 502, "slow": 502, "unauthorised": 502, "faulty": 502}


class ArchiveError(Exception):
    """A failure of an archive or of a transfer. `kind` is stable, and the text says why."""

    def __init__(self, kind: str, text: str):
        super().__init__(text)
        self.kind = kind


def faulty(text: str) -> ArchiveError:
    return ArchiveError("faulty", text)


class Cancelled(Exception):
    """The user cancelled a fetch."""
