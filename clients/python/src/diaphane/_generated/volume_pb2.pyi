from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class VolumeHeader(_message.Message):
    __slots__ = ["content_hash", "direction", "format", "frame_of_reference", "label_hash", "maximum", "minimum", "modality", "origin", "percentiles", "phases", "repairs", "size", "spacing", "window_center", "window_width"]
    class Modality(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    CONTENT_HASH_FIELD_NUMBER: _ClassVar[int]
    CT: VolumeHeader.Modality
    DIRECTION_FIELD_NUMBER: _ClassVar[int]
    FORMAT_FIELD_NUMBER: _ClassVar[int]
    FRAME_OF_REFERENCE_FIELD_NUMBER: _ClassVar[int]
    LABEL_HASH_FIELD_NUMBER: _ClassVar[int]
    MAXIMUM_FIELD_NUMBER: _ClassVar[int]
    MINIMUM_FIELD_NUMBER: _ClassVar[int]
    MODALITY_FIELD_NUMBER: _ClassVar[int]
    MR: VolumeHeader.Modality
    ORIGIN_FIELD_NUMBER: _ClassVar[int]
    OTHER: VolumeHeader.Modality
    PERCENTILES_FIELD_NUMBER: _ClassVar[int]
    PHASES_FIELD_NUMBER: _ClassVar[int]
    PT: VolumeHeader.Modality
    REPAIRS_FIELD_NUMBER: _ClassVar[int]
    SIZE_FIELD_NUMBER: _ClassVar[int]
    SPACING_FIELD_NUMBER: _ClassVar[int]
    WINDOW_CENTER_FIELD_NUMBER: _ClassVar[int]
    WINDOW_WIDTH_FIELD_NUMBER: _ClassVar[int]
    content_hash: str
    direction: _containers.RepeatedScalarFieldContainer[float]
    format: int
    frame_of_reference: str
    label_hash: str
    maximum: int
    minimum: int
    modality: VolumeHeader.Modality
    origin: _containers.RepeatedScalarFieldContainer[float]
    percentiles: _containers.RepeatedScalarFieldContainer[float]
    phases: _containers.RepeatedCompositeFieldContainer[VolumePhase]
    repairs: _containers.RepeatedScalarFieldContainer[str]
    size: _containers.RepeatedScalarFieldContainer[int]
    spacing: _containers.RepeatedScalarFieldContainer[float]
    window_center: float
    window_width: float
    def __init__(self, format: _Optional[int] = ..., size: _Optional[_Iterable[int]] = ..., spacing: _Optional[_Iterable[float]] = ..., direction: _Optional[_Iterable[float]] = ..., modality: _Optional[_Union[VolumeHeader.Modality, str]] = ..., window_center: _Optional[float] = ..., window_width: _Optional[float] = ..., minimum: _Optional[int] = ..., maximum: _Optional[int] = ..., percentiles: _Optional[_Iterable[float]] = ..., content_hash: _Optional[str] = ..., repairs: _Optional[_Iterable[str]] = ..., origin: _Optional[_Iterable[float]] = ..., frame_of_reference: _Optional[str] = ..., label_hash: _Optional[str] = ..., phases: _Optional[_Iterable[_Union[VolumePhase, _Mapping]]] = ...) -> None: ...

class VolumePhase(_message.Message):
    __slots__ = ["kind", "value"]
    class Kind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    B_VALUE: VolumePhase.Kind
    CYCLE: VolumePhase.Kind
    ECHO: VolumePhase.Kind
    INDEX: VolumePhase.Kind
    KIND_FIELD_NUMBER: _ClassVar[int]
    TIME: VolumePhase.Kind
    VALUE_FIELD_NUMBER: _ClassVar[int]
    kind: VolumePhase.Kind
    value: float
    def __init__(self, kind: _Optional[_Union[VolumePhase.Kind, str]] = ..., value: _Optional[float] = ...) -> None: ...
