"""DIMSE: C-FIND to search an archive, and C-GET or C-MOVE to fetch a series (DICOM PS3.7). Only C-MOVE needs the receiver, which the
archive must be able to reach.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pydicom.datadict import dictionary_VR
from pydicom.dataset import Dataset
from pydicom.uid import (
    JPEG2000,
    ExplicitVRBigEndian,
    ExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGBaseline8Bit,
    JPEGExtended12Bit,
    JPEGLossless,
    JPEGLosslessSV1,
    JPEGLSLossless,
    JPEGLSNearLossless,
    RLELossless,
)
from pynetdicom import AE, build_role, evt
from pynetdicom import sop_class as uids
from pynetdicom.association import Association
from pynetdicom.presentation import PresentationContext, build_context

from . import limits, results
from .errors import ArchiveError, faulty
from .moves import MOVES
from .series_file import is_uid
from .settings import DimseArchive

#: The images of which volumes can be built. Devices may send no others.
IMAGE_CLASSES = (
    uids.CTImageStorage, uids.EnhancedCTImageStorage, uids.LegacyConvertedEnhancedCTImageStorage,
    uids.MRImageStorage, uids.EnhancedMRImageStorage, uids.LegacyConvertedEnhancedMRImageStorage,
    uids.PositronEmissionTomographyImageStorage, uids.EnhancedPETImageStorage,
    uids.LegacyConvertedEnhancedPETImageStorage,
)
ENCODINGS = [ExplicitVRLittleEndian, ImplicitVRLittleEndian, ExplicitVRBigEndian, JPEGLosslessSV1, JPEGLossless, JPEGLSLossless,
             JPEGLSNearLossless, JPEG2000Lossless, JPEG2000, RLELossless, JPEGBaseline8Bit, JPEGExtended12Bit]
_FIND, _GET = uids.StudyRootQueryRetrieveInformationModelFind, uids.StudyRootQueryRetrieveInformationModelGet
_MOVE = uids.StudyRootQueryRetrieveInformationModelMove
_UNKNOWN_DESTINATION = 0xA801
_PENDING = (0xFF00, 0xFF01)
_REFUSED_IMAGE = 0xA900


class DimseClient:
    """A connection to one archive. Each request opens an association of its own."""

    def __init__(self, archive: DimseArchive):
        self._archive = archive
        self._idle = archive.timeout

    def close(self) -> None:
        """Has nothing to close, because every association ends with its request."""

    def studies(self, search: results.Search) -> list[dict[str, Any]]:
        return self._find("STUDY", results.STUDY, search.query(), limits.MOST_STUDIES + 1)

    def series(self, study: str) -> list[dict[str, Any]]:
        return self._find("SERIES", results.SERIES, {"StudyInstanceUID": study}, limits.MOST_SERIES)

    def images(self, study: str, series: str) -> list[str]:
        found = self._find("IMAGE", {"00080018": ""}, {"StudyInstanceUID": study, "SeriesInstanceUID": series}, limits.MOST_IMAGES + 1)
        if len(found) > limits.MOST_IMAGES:
            raise faulty("the series has more images than a series may have")
        return [one["00080018"] for one in found if is_uid(one.get("00080018"))]

    def fetch(self, study: str, series: str, take: Callable[[Dataset], object], image: str = "", stopped: threading.Event | None = None) -> None:
        """Calls `take` with each image. An exception of it ends the fetch and is raised here."""
        query = _identifier("IMAGE" if image else "SERIES", {"StudyInstanceUID": study, "SeriesInstanceUID": series})
        if image:
            query.SOPInstanceUID = image
        taker = _Taker(take, stopped)
        if self._archive.move_to:
            self._move(query, taker)
            return
        # The archive sends in the contexts in which this side is the provider of storage.
        contexts = [build_context(_GET), *(build_context(one, ENCODINGS) for one in IMAGE_CLASSES)]
        roles = [build_role(one, scp_role=True) for one in IMAGE_CLASSES]
        with self._association(contexts, roles, [(evt.EVT_C_STORE, lambda event: taker.keep(image_of(event)))]) as association:
            self._follow(association, association.send_c_get(query, _GET), taker)

    def _move(self, query: Dataset, taker: _Taker) -> None:
        archive = self._archive
        # Some archives respond only once they have sent everything, so what counts is when the last image arrived.
        with self._association([build_context(_MOVE)], patient=True) as association, \
                MOVES.expected(archive.ae_title, str(query.StudyInstanceUID), str(query.SeriesInstanceUID), taker.keep), \
                taker.watched(association, self._idle):
            self._follow(association, association.send_c_move(query, archive.move_to, _MOVE), taker)

    def _follow(self, association: Association, responses: Iterator[tuple[Dataset, Dataset | None]], taker: _Taker) -> None:
        """Reads responses to the end. Raises what the taker raised."""
        for status, _ in responses:
            if taker.failure:
                association.abort()
                raise taker.failure[0]
            if taker.abandoned.is_set():
                association.abort()
                return
            taker.touch()
            if status.get("Status") == _UNKNOWN_DESTINATION:
                raise faulty("the archive does not know the AE title of the receiver, to which it must send")
            self._check(status)

    def _find(self, level: str, names: dict[str, str], keys: dict[str, str], most: int) -> list[dict[str, Any]]:
        query = _identifier(level, keys)
        for tag in names:
            if int(tag, 16) not in query:
                query.add_new(int(tag, 16), _vr(tag), "")
        found: list[dict[str, Any]] = []
        deadline = time.monotonic() + limits.SEARCH_SECONDS
        with self._association([build_context(_FIND)]) as association:
            for status, answer in association.send_c_find(query, _FIND):
                self._check(status)
                if time.monotonic() > deadline:
                    association.abort()
                    raise ArchiveError("slow", "the archive took too long")
                if status.Status in _PENDING and answer is not None:
                    found.append(_texts(answer))
                if len(found) >= most:
                    association.abort()
                    break
        return found

    @contextmanager
    def _association(self, contexts: list[PresentationContext], roles: list[Any] | None = None, handlers: list[Any] | None = None,
                     patient: bool = False) -> Iterator[Association]:
        """Opens an association. With `patient`, silence does not end it."""
        ae = AE(self._archive.own_ae_title)
        ae.connection_timeout, ae.acse_timeout = limits.CONNECT_SECONDS, self._idle
        ae.dimse_timeout = ae.network_timeout = limits.FETCH_SECONDS if patient else self._idle
        tls = (self._archive.tls.client(), self._archive.host) if self._archive.tls else None
        association = ae.associate(self._archive.host, self._archive.port, contexts=contexts, ae_title=self._archive.ae_title,
                                   ext_neg=roles, evt_handlers=handlers or [], tls_args=tls)
        if not association.is_established:
            if association.is_rejected:
                raise ArchiveError("unauthorised", "the archive rejected the association")
            raise ArchiveError("unreachable", "the archive cannot be reached")
        if not association.accepted_contexts:
            association.release()
            raise faulty("the archive accepts no searches")
        try:
            yield association
        except (ValueError, RuntimeError) as error:
            raise faulty("the archive does not offer this service") from error
        finally:
            if association.is_established:
                association.release()

    @staticmethod
    def _check(status: Dataset) -> None:
        """Raises ArchiveError unless the response continues, succeeded or was partial."""
        if "Status" not in status:
            raise ArchiveError("slow", "the archive took too long, or ended the connection")
        code = status.Status
        if code == 0x0124:
            raise ArchiveError("unauthorised", "the archive refused the request")
        # 0xB000: some images were not sent. The caller requests them again.
        if code not in (0x0000, 0xB000, *_PENDING):
            raise faulty(f"the archive answered with the status 0x{code:04X}")


class _Taker:
    """Passes the images of a fetch on, one after another, and remembers why it must end. Archives may use several associations."""

    def __init__(self, take: Callable[[Dataset], object], stopped: threading.Event | None):
        self._take, self._stopped = take, stopped
        self.failure: list[Exception] = []
        self.abandoned = threading.Event()
        self._last = time.monotonic()
        self._lock = threading.Lock()

    def touch(self) -> None:
        self._last = time.monotonic()

    def keep(self, image: Dataset) -> int:
        """Returns a status of C-STORE."""
        self.touch()
        if self._is_stopped():
            return _REFUSED_IMAGE
        try:
            with self._lock:
                self._take(image)
        except Exception as error:
            self.failure.append(error)
            return _REFUSED_IMAGE
        return 0

    def _is_stopped(self) -> bool:
        if self._stopped is not None and self._stopped.is_set():
            self.abandoned.set()
        return self.abandoned.is_set()

    @contextmanager
    def watched(self, association: Association, idle: float) -> Iterator[None]:
        """Ends the wait for a response once the fetch is stopped, has failed, or was idle for too long."""
        ended = threading.Event()

        def watch() -> None:
            while not ended.wait(0.2):
                if self._is_stopped() or self.failure or time.monotonic() - self._last > idle:
                    # What pynetdicom itself does when a connection ends.
                    association.dimse.msg_queue.put((None, None))
                    return

        threading.Thread(target=watch, daemon=True).start()
        try:
            yield
        finally:
            ended.set()


def image_of(event: evt.Event) -> Dataset:
    """Returns the image of a C-STORE request."""
    image = event.dataset
    image.file_meta = event.file_meta
    return image


def _identifier(level: str, keys: dict[str, str]) -> Dataset:
    made = Dataset()
    made.SpecificCharacterSet = "ISO_IR 192"
    made.QueryRetrieveLevel = level
    for keyword, value in keys.items():
        setattr(made, keyword, value)
    return made


def _vr(tag: str) -> str:
    return str(dictionary_VR(int(tag, 16)))


def _texts(answer: Dataset) -> dict[str, Any]:
    """Returns a result like results.as_items."""
    try:
        made: dict[str, Any] = {}
        for element in answer:
            values = list(element.value) if element.VM > 1 else [element.value]
            texts = [results.clipped(str(one)) for one in values[:20] if one is not None and str(one)]
            made[f"{int(element.tag):08X}"] = texts[0] if len(texts) == 1 else texts or None
        return made
    except (ValueError, TypeError, NotImplementedError) as error:
        raise faulty("the archive sent a result with invalid values") from error
