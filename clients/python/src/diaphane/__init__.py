"""Renders CT and MR scans photo-realistically on a Diaphane server. Each picture comes with an estimate of its error."""

from ._generated.scene_pb2 import Overlay, Scene
from .client import Diaphane, Scan
from .errors import (
    ApiError,
    AuthenticationError,
    BusyError,
    ConnectionLost,
    DiaphaneError,
    ForbiddenError,
    InvalidError,
    NotFoundError,
    QuotaError,
    ScanError,
    StreamError,
    UnreadableFile,
    UploadInterrupted,
    WaitedTooLong,
)
from .picture import Alignment, ErrorCurve, ErrorPoint, Picture, Slice
from .session import Session

__version__ = "1.0.0"
__all__ = [
    "Alignment",
    "ApiError",
    "AuthenticationError",
    "BusyError",
    "ConnectionLost",
    "Diaphane",
    "DiaphaneError",
    "ErrorCurve",
    "ErrorPoint",
    "ForbiddenError",
    "InvalidError",
    "NotFoundError",
    "Overlay",
    "Picture",
    "QuotaError",
    "Scan",
    "ScanError",
    "Scene",
    "Session",
    "Slice",
    "StreamError",
    "UnreadableFile",
    "UploadInterrupted",
    "WaitedTooLong",
]
