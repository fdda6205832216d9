"""Reads multipart/related (RFC 2387) piece by piece, with a limit on each part."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from . import limits
from .errors import faulty


def boundary_of(content_type: str) -> bytes:
    """Returns the boundary of a Content-Type header. Raises ArchiveError for another type. Some have more than the 70 characters of
    RFC 2046.
    """
    kind, _, rest = content_type.partition(";")
    found = re.search(r'(?:^|;)\s*boundary=(?:"([^"]{1,200})"|([^\s;"]{1,200}))', rest, re.IGNORECASE)
    if kind.strip().lower() != "multipart/related" or not found:
        raise faulty("the content is not multipart/related")
    return (found[1] or found[2]).encode("ascii", "replace")


def parts(pieces: Iterable[bytes], boundary: bytes, most: int = limits.MOST_IMAGE_BYTES, total: int = limits.MOST_SERIES_BYTES) -> Iterator[bytes]:
    """Yields the bodies of the parts. Raises ArchiveError for a part of another type than DICOM, and for one that is too large or cut
    off. The parts before it were complete.
    """
    marker = b"\r\n--" + boundary
    # The first boundary may be at the very start.
    buffer, seen, begun = bytearray(b"\r\n"), 0, False
    for piece in pieces:
        seen += len(piece)
        if seen > total:
            raise faulty("the content is larger than a series may be")
        # A boundary, with the two bytes after it, may begin in what was searched already.
        start = max(0, len(buffer) - len(marker) - 2)
        buffer += piece
        while (at := buffer.find(marker, start)) >= 0 and len(buffer) >= at + len(marker) + 2:
            if at > most + limits.MOST_PART_HEADER:
                break
            if begun:
                yield _body(bytes(buffer[:at]))
            begun = True
            end = at + len(marker)
            if buffer[end:end + 2] == b"--":
                return
            del buffer[:end]
            start = 0
        if len(buffer) > most + limits.MOST_PART_HEADER:
            raise faulty("a part is larger than an image may be")
    raise faulty("the content was cut off")


def _body(part: bytes) -> bytes:
    """Returns the body of a part, which begins after its header."""
    head, separator, body = part.partition(b"\r\n\r\n")
    if not separator or len(head) > limits.MOST_PART_HEADER:
        raise faulty("a part has no valid header")
    kind = re.search(rb"(?:^|\r\n)content-type:\s*([^\s;]+)", head, re.IGNORECASE)
    if kind and kind[1].lower() != b"application/dicom":
        raise faulty("a part is not a DICOM file")
    return body
