"""Receives images by C-STORE. Each AE title belongs to an account, or to an archive of which a user fetches; others are rejected."""

from __future__ import annotations

import sys
from typing import Any

from pynetdicom import AE, evt
from pynetdicom import sop_class as uids

from . import limits
from .dimse import ENCODINGS, IMAGE_CLASSES, image_of
from .errors import ArchiveError
from .intake import Intake
from .metrics import METRICS
from .moves import MOVES
from .settings import Receiver
from .spool import Sender

_SUCCESS, _NO_RESOURCES, _NOT_UNDERSTOOD = 0x0000, 0xA700, 0xC000
#: DICOM PS3.4, B.2.3, and PS3.7, annex C.
_STATUS = {"unauthorised": 0x0124, "full": _NO_RESOURCES, "no-room": _NO_RESOURCES, "busy": _NO_RESOURCES, "invalid": 0xA900}


class StoreReceiver:
    """A C-STORE provider."""

    def __init__(self, settings: Receiver, intake: Intake):
        self._settings, self._intake = settings, intake
        self._server: Any = None

    def start(self) -> None:
        ae = AE(self._settings.ae_title)
        ae.require_called_aet = True
        ae.require_calling_aet = [*self._settings.callers, *self._settings.movers]
        ae.maximum_associations = limits.MOST_ASSOCIATIONS
        ae.acse_timeout = ae.dimse_timeout = ae.network_timeout = limits.IDLE_SECONDS
        ae.add_supported_context(uids.Verification)
        for one in IMAGE_CLASSES:
            ae.add_supported_context(one, ENCODINGS)
        handlers = [(evt.EVT_C_STORE, self._store), (evt.EVT_ACCEPTED, self._accepted), (evt.EVT_CONN_CLOSE, self._closed),
                    (evt.EVT_REJECTED, self._rejected)]
        self._server = ae.start_server((self._settings.address, self._settings.port), block=False, evt_handlers=handlers,
                                       ssl_context=self._settings.tls.server() if self._settings.tls else None)

    def stop(self) -> None:
        if self._server is not None:
            self._server.shutdown()

    def _sender(self, event: evt.Event) -> Sender:
        """Returns a sender without a token for an archive that may only send what is fetched."""
        caller = str(event.assoc.requestor.ae_title).strip()
        return Sender("dimse", caller, self._settings.callers.get(caller, ""))

    def _accepted(self, event: evt.Event) -> None:
        event.assoc.diaphane_sender = self._sender(event)
        self._intake.connect(event.assoc.diaphane_sender, 1)

    def _closed(self, event: evt.Event) -> None:
        if (sender := getattr(event.assoc, "diaphane_sender", None)) is not None:
            event.assoc.diaphane_sender = None
            self._intake.connect(sender, -1)

    def _rejected(self, _event: evt.Event) -> None:
        print("an association was rejected", file=sys.stderr, flush=True)
        with METRICS.measure("unknown", "dimse") as measured:
            measured.failed = "rejected"

    def _store(self, event: evt.Event) -> int:
        sender = self._sender(event)
        try:
            size = event.request.DataSet.getbuffer().nbytes
            if size > limits.MOST_IMAGE_BYTES:
                raise ArchiveError("full", "an image is larger than images may be")
            METRICS.count_bytes(sender.name, size)
            image = image_of(event)
            if sender.name in self._settings.movers and (status := MOVES.offer(sender.name, image)) is not None:
                return status
            if not sender.token:
                raise ArchiveError("unauthorised", "no fetch waits for the image")
            self._intake.add(sender, image)
            return _SUCCESS
        except ArchiveError as error:
            return self._refused(sender, str(error), error.kind, _STATUS.get(error.kind, _NOT_UNDERSTOOD))
        except OSError:
            return self._refused(sender, "the disk is full", "full", _NO_RESOURCES)
        except Exception as error:   # a value of the image that pydicom decodes only now
            return self._refused(sender, type(error).__name__, "invalid", _NOT_UNDERSTOOD)

    @staticmethod
    def _refused(sender: Sender, why: str, kind: str, status: int) -> int:
        print(f"an image was refused: {why}", file=sys.stderr, flush=True)
        with METRICS.measure(sender.name, "dimse") as measured:
            measured.failed = kind
        return status
