from diaphane._generated import scene_pb2 as _scene_pb2
from diaphane._generated import volume_pb2 as _volume_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

ANATOMICAL_PLANE_UNSPECIFIED: AnatomicalPlane
AXIAL: AnatomicalPlane
CODEC_UNSPECIFIED: Codec
CORONAL: AnatomicalPlane
DESCRIPTOR: _descriptor.FileDescriptor
FRAME_QUALITY_UNSPECIFIED: FrameQuality
H264: Codec
JPEG: Codec
MOVING: FrameQuality
MPEG1: Codec
PNG: StillFormat
PROJECTION_MAXIMUM: Projection
PROJECTION_MEAN: Projection
PROJECTION_MINIMUM: Projection
SAGITTAL: AnatomicalPlane
SETTLED: FrameQuality
SLICE_ACCESS_CLIPPED: SliceAccess
SLICE_ACCESS_NONE: SliceAccess
SLICE_ACCESS_SHOWN: SliceAccess
SLICE_ACCESS_WHOLE: SliceAccess
STILL_FORMAT_UNSPECIFIED: StillFormat
WEBP: StillFormat

class Ack(_message.Message):
    __slots__ = ["decoded_us", "epoch", "presented_us", "queue", "received_us", "seq"]
    DECODED_US_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    PRESENTED_US_FIELD_NUMBER: _ClassVar[int]
    QUEUE_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_US_FIELD_NUMBER: _ClassVar[int]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    decoded_us: int
    epoch: int
    presented_us: int
    queue: int
    received_us: int
    seq: int
    def __init__(self, seq: _Optional[int] = ..., epoch: _Optional[int] = ..., received_us: _Optional[int] = ..., decoded_us: _Optional[int] = ..., presented_us: _Optional[int] = ..., queue: _Optional[int] = ...) -> None: ...

class Annotations(_message.Message):
    __slots__ = ["marks", "measurements"]
    MARKS_FIELD_NUMBER: _ClassVar[int]
    MEASUREMENTS_FIELD_NUMBER: _ClassVar[int]
    marks: Marks
    measurements: Measurements
    def __init__(self, marks: _Optional[_Union[Marks, _Mapping]] = ..., measurements: _Optional[_Union[Measurements, _Mapping]] = ...) -> None: ...

class Audience(_message.Message):
    __slots__ = ["downloads", "guest_pointers", "guest_slices", "participants", "presenter", "sets_guest_slices", "slices", "you"]
    DOWNLOADS_FIELD_NUMBER: _ClassVar[int]
    GUEST_POINTERS_FIELD_NUMBER: _ClassVar[int]
    GUEST_SLICES_FIELD_NUMBER: _ClassVar[int]
    PARTICIPANTS_FIELD_NUMBER: _ClassVar[int]
    PRESENTER_FIELD_NUMBER: _ClassVar[int]
    SETS_GUEST_SLICES_FIELD_NUMBER: _ClassVar[int]
    SLICES_FIELD_NUMBER: _ClassVar[int]
    YOU_FIELD_NUMBER: _ClassVar[int]
    downloads: bool
    guest_pointers: bool
    guest_slices: bool
    participants: _containers.RepeatedCompositeFieldContainer[Participant]
    presenter: str
    sets_guest_slices: bool
    slices: SliceAccess
    you: str
    def __init__(self, you: _Optional[str] = ..., participants: _Optional[_Iterable[_Union[Participant, _Mapping]]] = ..., presenter: _Optional[str] = ..., slices: _Optional[_Union[SliceAccess, str]] = ..., guest_slices: bool = ..., sets_guest_slices: bool = ..., guest_pointers: bool = ..., downloads: bool = ...) -> None: ...

class ClientMessage(_message.Message):
    __slots__ = ["ack", "depth_query", "error_curve", "file", "file_mark", "file_taken", "free_camera", "good_views", "guest_pointers", "guest_slices", "handover", "hello", "kernel", "key_view", "mark_sight", "marks", "measurements", "need_key", "pointer", "raise_hand", "scene", "shared_taken", "slice_view", "slices", "visibility"]
    ACK_FIELD_NUMBER: _ClassVar[int]
    DEPTH_QUERY_FIELD_NUMBER: _ClassVar[int]
    ERROR_CURVE_FIELD_NUMBER: _ClassVar[int]
    FILE_FIELD_NUMBER: _ClassVar[int]
    FILE_MARK_FIELD_NUMBER: _ClassVar[int]
    FILE_TAKEN_FIELD_NUMBER: _ClassVar[int]
    FREE_CAMERA_FIELD_NUMBER: _ClassVar[int]
    GOOD_VIEWS_FIELD_NUMBER: _ClassVar[int]
    GUEST_POINTERS_FIELD_NUMBER: _ClassVar[int]
    GUEST_SLICES_FIELD_NUMBER: _ClassVar[int]
    HANDOVER_FIELD_NUMBER: _ClassVar[int]
    HELLO_FIELD_NUMBER: _ClassVar[int]
    KERNEL_FIELD_NUMBER: _ClassVar[int]
    KEY_VIEW_FIELD_NUMBER: _ClassVar[int]
    MARKS_FIELD_NUMBER: _ClassVar[int]
    MARK_SIGHT_FIELD_NUMBER: _ClassVar[int]
    MEASUREMENTS_FIELD_NUMBER: _ClassVar[int]
    NEED_KEY_FIELD_NUMBER: _ClassVar[int]
    POINTER_FIELD_NUMBER: _ClassVar[int]
    RAISE_HAND_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    SHARED_TAKEN_FIELD_NUMBER: _ClassVar[int]
    SLICES_FIELD_NUMBER: _ClassVar[int]
    SLICE_VIEW_FIELD_NUMBER: _ClassVar[int]
    VISIBILITY_FIELD_NUMBER: _ClassVar[int]
    ack: Ack
    depth_query: DepthQuery
    error_curve: ErrorCurveQuery
    file: FileRequest
    file_mark: FileMark
    file_taken: FileTaken
    free_camera: FreeCamera
    good_views: GoodViewsQuery
    guest_pointers: GuestPointers
    guest_slices: GuestSlices
    handover: Handover
    hello: Hello
    kernel: KernelQuery
    key_view: KeyView
    mark_sight: MarkSightQuery
    marks: Marks
    measurements: Measurements
    need_key: NeedKey
    pointer: PointerMove
    raise_hand: RaiseHand
    scene: SceneUpdate
    shared_taken: SharedTaken
    slice_view: SliceView
    slices: SliceRequest
    visibility: Visibility
    def __init__(self, hello: _Optional[_Union[Hello, _Mapping]] = ..., scene: _Optional[_Union[SceneUpdate, _Mapping]] = ..., ack: _Optional[_Union[Ack, _Mapping]] = ..., need_key: _Optional[_Union[NeedKey, _Mapping]] = ..., visibility: _Optional[_Union[Visibility, _Mapping]] = ..., handover: _Optional[_Union[Handover, _Mapping]] = ..., free_camera: _Optional[_Union[FreeCamera, _Mapping]] = ..., depth_query: _Optional[_Union[DepthQuery, _Mapping]] = ..., slices: _Optional[_Union[SliceRequest, _Mapping]] = ..., key_view: _Optional[_Union[KeyView, _Mapping]] = ..., file: _Optional[_Union[FileRequest, _Mapping]] = ..., file_taken: _Optional[_Union[FileTaken, _Mapping]] = ..., kernel: _Optional[_Union[KernelQuery, _Mapping]] = ..., guest_slices: _Optional[_Union[GuestSlices, _Mapping]] = ..., error_curve: _Optional[_Union[ErrorCurveQuery, _Mapping]] = ..., slice_view: _Optional[_Union[SliceView, _Mapping]] = ..., measurements: _Optional[_Union[Measurements, _Mapping]] = ..., pointer: _Optional[_Union[PointerMove, _Mapping]] = ..., guest_pointers: _Optional[_Union[GuestPointers, _Mapping]] = ..., shared_taken: _Optional[_Union[SharedTaken, _Mapping]] = ..., marks: _Optional[_Union[Marks, _Mapping]] = ..., mark_sight: _Optional[_Union[MarkSightQuery, _Mapping]] = ..., raise_hand: _Optional[_Union[RaiseHand, _Mapping]] = ..., file_mark: _Optional[_Union[FileMark, _Mapping]] = ..., good_views: _Optional[_Union[GoodViewsQuery, _Mapping]] = ...) -> None: ...

class Config(_message.Message):
    __slots__ = ["codec", "device", "engine", "follower", "histogram", "input_seq", "presets", "protocol", "scene", "second", "session_id", "slice_stacks", "treatment", "volume"]
    CODEC_FIELD_NUMBER: _ClassVar[int]
    DEVICE_FIELD_NUMBER: _ClassVar[int]
    ENGINE_FIELD_NUMBER: _ClassVar[int]
    FOLLOWER_FIELD_NUMBER: _ClassVar[int]
    HISTOGRAM_FIELD_NUMBER: _ClassVar[int]
    INPUT_SEQ_FIELD_NUMBER: _ClassVar[int]
    PRESETS_FIELD_NUMBER: _ClassVar[int]
    PROTOCOL_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    SESSION_ID_FIELD_NUMBER: _ClassVar[int]
    SLICE_STACKS_FIELD_NUMBER: _ClassVar[int]
    TREATMENT_FIELD_NUMBER: _ClassVar[int]
    VOLUME_FIELD_NUMBER: _ClassVar[int]
    codec: Codec
    device: str
    engine: str
    follower: bool
    histogram: Histogram
    input_seq: int
    presets: _containers.RepeatedCompositeFieldContainer[_scene_pb2.Preset]
    protocol: int
    scene: _scene_pb2.Scene
    second: SecondVolume
    session_id: str
    slice_stacks: _containers.RepeatedCompositeFieldContainer[SliceStack]
    treatment: Treatment
    volume: _volume_pb2.VolumeHeader
    def __init__(self, protocol: _Optional[int] = ..., session_id: _Optional[str] = ..., codec: _Optional[_Union[Codec, str]] = ..., engine: _Optional[str] = ..., device: _Optional[str] = ..., volume: _Optional[_Union[_volume_pb2.VolumeHeader, _Mapping]] = ..., scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., input_seq: _Optional[int] = ..., presets: _Optional[_Iterable[_Union[_scene_pb2.Preset, _Mapping]]] = ..., follower: bool = ..., histogram: _Optional[_Union[Histogram, _Mapping]] = ..., slice_stacks: _Optional[_Iterable[_Union[SliceStack, _Mapping]]] = ..., treatment: _Optional[_Union[Treatment, _Mapping]] = ..., second: _Optional[_Union[SecondVolume, _Mapping]] = ...) -> None: ...

class CurvedSlice(_message.Message):
    __slots__ = ["angle", "columns", "id", "pixel", "points", "projection", "rows", "thickness"]
    ANGLE_FIELD_NUMBER: _ClassVar[int]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    PIXEL_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    PROJECTION_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    THICKNESS_FIELD_NUMBER: _ClassVar[int]
    angle: float
    columns: int
    id: int
    pixel: float
    points: _containers.RepeatedCompositeFieldContainer[_scene_pb2.Vec3]
    projection: Projection
    rows: int
    thickness: float
    def __init__(self, id: _Optional[int] = ..., columns: _Optional[int] = ..., rows: _Optional[int] = ..., points: _Optional[_Iterable[_Union[_scene_pb2.Vec3, _Mapping]]] = ..., pixel: _Optional[float] = ..., angle: _Optional[float] = ..., thickness: _Optional[float] = ..., projection: _Optional[_Union[Projection, str]] = ...) -> None: ...

class Depth(_message.Message):
    __slots__ = ["distance", "found", "id", "label", "place"]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    FOUND_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    LABEL_FIELD_NUMBER: _ClassVar[int]
    PLACE_FIELD_NUMBER: _ClassVar[int]
    distance: float
    found: bool
    id: int
    label: int
    place: _scene_pb2.Vec3
    def __init__(self, id: _Optional[int] = ..., found: bool = ..., distance: _Optional[float] = ..., place: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., label: _Optional[int] = ...) -> None: ...

class DepthQuery(_message.Message):
    __slots__ = ["id", "x", "y"]
    ID_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    id: int
    x: float
    y: float
    def __init__(self, id: _Optional[int] = ..., x: _Optional[float] = ..., y: _Optional[float] = ...) -> None: ...

class Effort(_message.Message):
    __slots__ = ["moving_scale", "stop_error", "stop_samples"]
    MOVING_SCALE_FIELD_NUMBER: _ClassVar[int]
    STOP_ERROR_FIELD_NUMBER: _ClassVar[int]
    STOP_SAMPLES_FIELD_NUMBER: _ClassVar[int]
    moving_scale: float
    stop_error: float
    stop_samples: int
    def __init__(self, stop_error: _Optional[float] = ..., stop_samples: _Optional[int] = ..., moving_scale: _Optional[float] = ...) -> None: ...

class ErrorCurve(_message.Message):
    __slots__ = ["epoch", "points"]
    class Point(_message.Message):
        __slots__ = ["error", "samples", "seconds"]
        ERROR_FIELD_NUMBER: _ClassVar[int]
        SAMPLES_FIELD_NUMBER: _ClassVar[int]
        SECONDS_FIELD_NUMBER: _ClassVar[int]
        error: float
        samples: int
        seconds: float
        def __init__(self, samples: _Optional[int] = ..., seconds: _Optional[float] = ..., error: _Optional[float] = ...) -> None: ...
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    epoch: int
    points: _containers.RepeatedCompositeFieldContainer[ErrorCurve.Point]
    def __init__(self, epoch: _Optional[int] = ..., points: _Optional[_Iterable[_Union[ErrorCurve.Point, _Mapping]]] = ...) -> None: ...

class ErrorCurveQuery(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class ExactSlice(_message.Message):
    __slots__ = ["columns", "curved", "data", "index", "labels", "oblique", "plane", "rows", "second", "seq"]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    CURVED_FIELD_NUMBER: _ClassVar[int]
    DATA_FIELD_NUMBER: _ClassVar[int]
    INDEX_FIELD_NUMBER: _ClassVar[int]
    LABELS_FIELD_NUMBER: _ClassVar[int]
    OBLIQUE_FIELD_NUMBER: _ClassVar[int]
    PLANE_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    columns: int
    curved: int
    data: bytes
    index: int
    labels: bytes
    oblique: int
    plane: AnatomicalPlane
    rows: int
    second: bytes
    seq: int
    def __init__(self, seq: _Optional[int] = ..., plane: _Optional[_Union[AnatomicalPlane, str]] = ..., index: _Optional[int] = ..., columns: _Optional[int] = ..., rows: _Optional[int] = ..., data: _Optional[bytes] = ..., oblique: _Optional[int] = ..., curved: _Optional[int] = ..., second: _Optional[bytes] = ..., labels: _Optional[bytes] = ...) -> None: ...

class FileMark(_message.Message):
    __slots__ = ["label", "mark"]
    class Label(_message.Message):
        __slots__ = ["baseline", "coverage", "height", "margin", "scale", "width"]
        BASELINE_FIELD_NUMBER: _ClassVar[int]
        COVERAGE_FIELD_NUMBER: _ClassVar[int]
        HEIGHT_FIELD_NUMBER: _ClassVar[int]
        MARGIN_FIELD_NUMBER: _ClassVar[int]
        SCALE_FIELD_NUMBER: _ClassVar[int]
        WIDTH_FIELD_NUMBER: _ClassVar[int]
        baseline: float
        coverage: bytes
        height: int
        margin: float
        scale: float
        width: int
        def __init__(self, width: _Optional[int] = ..., height: _Optional[int] = ..., coverage: _Optional[bytes] = ..., scale: _Optional[float] = ..., margin: _Optional[float] = ..., baseline: _Optional[float] = ...) -> None: ...
    LABEL_FIELD_NUMBER: _ClassVar[int]
    MARK_FIELD_NUMBER: _ClassVar[int]
    label: FileMark.Label
    mark: Mark
    def __init__(self, mark: _Optional[_Union[Mark, _Mapping]] = ..., label: _Optional[_Union[FileMark.Label, _Mapping]] = ...) -> None: ...

class FilePart(_message.Message):
    __slots__ = ["data", "last", "seq"]
    DATA_FIELD_NUMBER: _ClassVar[int]
    LAST_FIELD_NUMBER: _ClassVar[int]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    data: bytes
    last: bool
    seq: int
    def __init__(self, seq: _Optional[int] = ..., data: _Optional[bytes] = ..., last: bool = ...) -> None: ...

class FileProgress(_message.Message):
    __slots__ = ["done"]
    DONE_FIELD_NUMBER: _ClassVar[int]
    done: float
    def __init__(self, done: _Optional[float] = ...) -> None: ...

class FileRequest(_message.Message):
    __slots__ = ["mark_unit", "picture", "video"]
    MARK_UNIT_FIELD_NUMBER: _ClassVar[int]
    PICTURE_FIELD_NUMBER: _ClassVar[int]
    VIDEO_FIELD_NUMBER: _ClassVar[int]
    mark_unit: float
    picture: LargePicture
    video: Video
    def __init__(self, video: _Optional[_Union[Video, _Mapping]] = ..., picture: _Optional[_Union[LargePicture, _Mapping]] = ..., mark_unit: _Optional[float] = ...) -> None: ...

class FileTaken(_message.Message):
    __slots__ = ["seq"]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    seq: int
    def __init__(self, seq: _Optional[int] = ...) -> None: ...

class Frame(_message.Message):
    __slots__ = ["codec", "data", "decoder", "denoised", "encode_us", "epoch", "error", "height", "input_seq", "iteration", "key", "quality", "render_us", "seq", "stops", "volume_phase", "width"]
    CODEC_FIELD_NUMBER: _ClassVar[int]
    DATA_FIELD_NUMBER: _ClassVar[int]
    DECODER_FIELD_NUMBER: _ClassVar[int]
    DENOISED_FIELD_NUMBER: _ClassVar[int]
    ENCODE_US_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    INPUT_SEQ_FIELD_NUMBER: _ClassVar[int]
    ITERATION_FIELD_NUMBER: _ClassVar[int]
    KEY_FIELD_NUMBER: _ClassVar[int]
    QUALITY_FIELD_NUMBER: _ClassVar[int]
    RENDER_US_FIELD_NUMBER: _ClassVar[int]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    STOPS_FIELD_NUMBER: _ClassVar[int]
    VOLUME_PHASE_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    codec: Codec
    data: bytes
    decoder: str
    denoised: bool
    encode_us: int
    epoch: int
    error: float
    height: int
    input_seq: int
    iteration: int
    key: bool
    quality: FrameQuality
    render_us: int
    seq: int
    stops: float
    volume_phase: int
    width: int
    def __init__(self, codec: _Optional[_Union[Codec, str]] = ..., key: bool = ..., epoch: _Optional[int] = ..., seq: _Optional[int] = ..., input_seq: _Optional[int] = ..., iteration: _Optional[int] = ..., error: _Optional[float] = ..., width: _Optional[int] = ..., height: _Optional[int] = ..., render_us: _Optional[int] = ..., encode_us: _Optional[int] = ..., data: _Optional[bytes] = ..., denoised: bool = ..., decoder: _Optional[str] = ..., quality: _Optional[_Union[FrameQuality, str]] = ..., stops: _Optional[float] = ..., volume_phase: _Optional[int] = ...) -> None: ...

class FreeCamera(_message.Message):
    __slots__ = ["on"]
    ON_FIELD_NUMBER: _ClassVar[int]
    on: bool
    def __init__(self, on: bool = ...) -> None: ...

class GoodViews(_message.Message):
    __slots__ = ["high", "low", "views"]
    class View(_message.Message):
        __slots__ = ["azimuth", "elevation", "entropy"]
        AZIMUTH_FIELD_NUMBER: _ClassVar[int]
        ELEVATION_FIELD_NUMBER: _ClassVar[int]
        ENTROPY_FIELD_NUMBER: _ClassVar[int]
        azimuth: float
        elevation: float
        entropy: float
        def __init__(self, azimuth: _Optional[float] = ..., elevation: _Optional[float] = ..., entropy: _Optional[float] = ...) -> None: ...
    HIGH_FIELD_NUMBER: _ClassVar[int]
    LOW_FIELD_NUMBER: _ClassVar[int]
    VIEWS_FIELD_NUMBER: _ClassVar[int]
    high: _scene_pb2.Vec3
    low: _scene_pb2.Vec3
    views: _containers.RepeatedCompositeFieldContainer[GoodViews.View]
    def __init__(self, views: _Optional[_Iterable[_Union[GoodViews.View, _Mapping]]] = ..., low: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., high: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ...) -> None: ...

class GoodViewsQuery(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class GuestPointers(_message.Message):
    __slots__ = ["on"]
    ON_FIELD_NUMBER: _ClassVar[int]
    on: bool
    def __init__(self, on: bool = ...) -> None: ...

class GuestSlices(_message.Message):
    __slots__ = ["on"]
    ON_FIELD_NUMBER: _ClassVar[int]
    on: bool
    def __init__(self, on: bool = ...) -> None: ...

class Handover(_message.Message):
    __slots__ = ["to"]
    TO_FIELD_NUMBER: _ClassVar[int]
    to: str
    def __init__(self, to: _Optional[str] = ...) -> None: ...

class Hello(_message.Message):
    __slots__ = ["codecs", "pixel_ratio", "protocol", "stills", "viewport"]
    CODECS_FIELD_NUMBER: _ClassVar[int]
    PIXEL_RATIO_FIELD_NUMBER: _ClassVar[int]
    PROTOCOL_FIELD_NUMBER: _ClassVar[int]
    STILLS_FIELD_NUMBER: _ClassVar[int]
    VIEWPORT_FIELD_NUMBER: _ClassVar[int]
    codecs: _containers.RepeatedScalarFieldContainer[Codec]
    pixel_ratio: float
    protocol: int
    stills: _containers.RepeatedScalarFieldContainer[StillFormat]
    viewport: Viewport
    def __init__(self, protocol: _Optional[int] = ..., codecs: _Optional[_Iterable[_Union[Codec, str]]] = ..., pixel_ratio: _Optional[float] = ..., viewport: _Optional[_Union[Viewport, _Mapping]] = ..., stills: _Optional[_Iterable[_Union[StillFormat, str]]] = ...) -> None: ...

class Histogram(_message.Message):
    __slots__ = ["counts", "minimum", "width"]
    COUNTS_FIELD_NUMBER: _ClassVar[int]
    MINIMUM_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    counts: _containers.RepeatedScalarFieldContainer[int]
    minimum: float
    width: float
    def __init__(self, minimum: _Optional[float] = ..., width: _Optional[float] = ..., counts: _Optional[_Iterable[int]] = ...) -> None: ...

class KernelQuery(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class KernelReport(_message.Message):
    __slots__ = ["compile_milliseconds", "compiled_in", "empty_cells", "from_cache", "left_out", "origin", "registers"]
    class Origin(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    AHEAD_OF_TIME: KernelReport.Origin
    COMPILED_IN_FIELD_NUMBER: _ClassVar[int]
    COMPILE_MILLISECONDS_FIELD_NUMBER: _ClassVar[int]
    EMPTY_CELLS_FIELD_NUMBER: _ClassVar[int]
    FOR_THIS_SCENE: KernelReport.Origin
    FROM_CACHE_FIELD_NUMBER: _ClassVar[int]
    GENERAL: KernelReport.Origin
    LEFT_OUT_FIELD_NUMBER: _ClassVar[int]
    ORIGIN_FIELD_NUMBER: _ClassVar[int]
    ORIGIN_UNSPECIFIED: KernelReport.Origin
    REGISTERS_FIELD_NUMBER: _ClassVar[int]
    compile_milliseconds: float
    compiled_in: _containers.RepeatedScalarFieldContainer[str]
    empty_cells: float
    from_cache: bool
    left_out: _containers.RepeatedScalarFieldContainer[str]
    origin: KernelReport.Origin
    registers: int
    def __init__(self, compiled_in: _Optional[_Iterable[str]] = ..., left_out: _Optional[_Iterable[str]] = ..., origin: _Optional[_Union[KernelReport.Origin, str]] = ..., compile_milliseconds: _Optional[float] = ..., from_cache: bool = ..., registers: _Optional[int] = ..., empty_cells: _Optional[float] = ...) -> None: ...

class KeyView(_message.Message):
    __slots__ = ["index", "scene"]
    INDEX_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    index: int
    scene: _scene_pb2.Scene
    def __init__(self, index: _Optional[int] = ..., scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ...) -> None: ...

class Labels(_message.Message):
    __slots__ = ["labels"]
    class Label(_message.Message):
        __slots__ = ["colour", "deviation", "maximum", "mean", "minimum", "name", "number", "volume"]
        COLOUR_FIELD_NUMBER: _ClassVar[int]
        DEVIATION_FIELD_NUMBER: _ClassVar[int]
        MAXIMUM_FIELD_NUMBER: _ClassVar[int]
        MEAN_FIELD_NUMBER: _ClassVar[int]
        MINIMUM_FIELD_NUMBER: _ClassVar[int]
        NAME_FIELD_NUMBER: _ClassVar[int]
        NUMBER_FIELD_NUMBER: _ClassVar[int]
        VOLUME_FIELD_NUMBER: _ClassVar[int]
        colour: int
        deviation: float
        maximum: int
        mean: float
        minimum: int
        name: str
        number: int
        volume: float
        def __init__(self, number: _Optional[int] = ..., name: _Optional[str] = ..., colour: _Optional[int] = ..., volume: _Optional[float] = ..., mean: _Optional[float] = ..., deviation: _Optional[float] = ..., minimum: _Optional[int] = ..., maximum: _Optional[int] = ...) -> None: ...
    LABELS_FIELD_NUMBER: _ClassVar[int]
    labels: _containers.RepeatedCompositeFieldContainer[Labels.Label]
    def __init__(self, labels: _Optional[_Iterable[_Union[Labels.Label, _Mapping]]] = ...) -> None: ...

class LargePicture(_message.Message):
    __slots__ = ["error", "height", "width"]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    error: float
    height: int
    width: int
    def __init__(self, width: _Optional[int] = ..., height: _Optional[int] = ..., error: _Optional[float] = ...) -> None: ...

class Look(_message.Message):
    __slots__ = ["input_seq", "scene"]
    INPUT_SEQ_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    input_seq: int
    scene: _scene_pb2.Scene
    def __init__(self, scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., input_seq: _Optional[int] = ...) -> None: ...

class Mark(_message.Message):
    __slots__ = ["colour", "end", "id", "kind", "place", "radius", "tail", "text"]
    class Kind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    ANGLE: Mark.Kind
    ARROW: Mark.Kind
    CIRCLE: Mark.Kind
    COLOUR_FIELD_NUMBER: _ClassVar[int]
    END_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    KIND_UNSPECIFIED: Mark.Kind
    PLACE_FIELD_NUMBER: _ClassVar[int]
    RADIUS_FIELD_NUMBER: _ClassVar[int]
    RULER: Mark.Kind
    TAIL_FIELD_NUMBER: _ClassVar[int]
    TEXT: Mark.Kind
    TEXT_FIELD_NUMBER: _ClassVar[int]
    colour: int
    end: _scene_pb2.Vec3
    id: int
    kind: Mark.Kind
    place: _scene_pb2.Vec3
    radius: float
    tail: _scene_pb2.Vec3
    text: str
    def __init__(self, id: _Optional[int] = ..., kind: _Optional[_Union[Mark.Kind, str]] = ..., colour: _Optional[int] = ..., text: _Optional[str] = ..., place: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., tail: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., radius: _Optional[float] = ..., end: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ...) -> None: ...

class MarkSight(_message.Message):
    __slots__ = ["hidden"]
    class Hidden(_message.Message):
        __slots__ = ["ids", "number"]
        IDS_FIELD_NUMBER: _ClassVar[int]
        NUMBER_FIELD_NUMBER: _ClassVar[int]
        ids: _containers.RepeatedScalarFieldContainer[int]
        number: int
        def __init__(self, number: _Optional[int] = ..., ids: _Optional[_Iterable[int]] = ...) -> None: ...
    HIDDEN_FIELD_NUMBER: _ClassVar[int]
    hidden: _containers.RepeatedCompositeFieldContainer[MarkSight.Hidden]
    def __init__(self, hidden: _Optional[_Iterable[_Union[MarkSight.Hidden, _Mapping]]] = ...) -> None: ...

class MarkSightQuery(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class Marks(_message.Message):
    __slots__ = ["items"]
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    items: _containers.RepeatedCompositeFieldContainer[Mark]
    def __init__(self, items: _Optional[_Iterable[_Union[Mark, _Mapping]]] = ...) -> None: ...

class Measurements(_message.Message):
    __slots__ = ["items"]
    class Kind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    class Measurement(_message.Message):
        __slots__ = ["kind", "plane", "points", "slice"]
        KIND_FIELD_NUMBER: _ClassVar[int]
        PLANE_FIELD_NUMBER: _ClassVar[int]
        POINTS_FIELD_NUMBER: _ClassVar[int]
        SLICE_FIELD_NUMBER: _ClassVar[int]
        kind: Measurements.Kind
        plane: AnatomicalPlane
        points: _containers.RepeatedCompositeFieldContainer[_scene_pb2.Vec3]
        slice: int
        def __init__(self, kind: _Optional[_Union[Measurements.Kind, str]] = ..., plane: _Optional[_Union[AnatomicalPlane, str]] = ..., slice: _Optional[int] = ..., points: _Optional[_Iterable[_Union[_scene_pb2.Vec3, _Mapping]]] = ...) -> None: ...
    ANGLE: Measurements.Kind
    ELLIPSE: Measurements.Kind
    ITEMS_FIELD_NUMBER: _ClassVar[int]
    KIND_UNSPECIFIED: Measurements.Kind
    RULER: Measurements.Kind
    items: _containers.RepeatedCompositeFieldContainer[Measurements.Measurement]
    def __init__(self, items: _Optional[_Iterable[_Union[Measurements.Measurement, _Mapping]]] = ...) -> None: ...

class NeedKey(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class ObliqueSlice(_message.Message):
    __slots__ = ["columns", "down", "first", "id", "projection", "right", "rows", "thickness"]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    DOWN_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    PROJECTION_FIELD_NUMBER: _ClassVar[int]
    RIGHT_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    THICKNESS_FIELD_NUMBER: _ClassVar[int]
    columns: int
    down: _scene_pb2.Vec3
    first: _scene_pb2.Vec3
    id: int
    projection: Projection
    right: _scene_pb2.Vec3
    rows: int
    thickness: float
    def __init__(self, id: _Optional[int] = ..., columns: _Optional[int] = ..., rows: _Optional[int] = ..., first: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., right: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., down: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., thickness: _Optional[float] = ..., projection: _Optional[_Union[Projection, str]] = ...) -> None: ...

class Participant(_message.Message):
    __slots__ = ["free_camera", "hand", "id", "name", "number", "owner", "presenter"]
    FREE_CAMERA_FIELD_NUMBER: _ClassVar[int]
    HAND_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    PRESENTER_FIELD_NUMBER: _ClassVar[int]
    free_camera: bool
    hand: int
    id: str
    name: str
    number: int
    owner: bool
    presenter: bool
    def __init__(self, id: _Optional[str] = ..., name: _Optional[str] = ..., owner: bool = ..., presenter: bool = ..., free_camera: bool = ..., number: _Optional[int] = ..., hand: _Optional[int] = ...) -> None: ...

class PointerMove(_message.Message):
    __slots__ = ["picture", "slice"]
    class InPicture(_message.Message):
        __slots__ = ["x", "y"]
        X_FIELD_NUMBER: _ClassVar[int]
        Y_FIELD_NUMBER: _ClassVar[int]
        x: float
        y: float
        def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ...) -> None: ...
    class InSlice(_message.Message):
        __slots__ = ["place", "plane"]
        PLACE_FIELD_NUMBER: _ClassVar[int]
        PLANE_FIELD_NUMBER: _ClassVar[int]
        place: _scene_pb2.Vec3
        plane: AnatomicalPlane
        def __init__(self, plane: _Optional[_Union[AnatomicalPlane, str]] = ..., place: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ...) -> None: ...
    PICTURE_FIELD_NUMBER: _ClassVar[int]
    SLICE_FIELD_NUMBER: _ClassVar[int]
    picture: PointerMove.InPicture
    slice: PointerMove.InSlice
    def __init__(self, picture: _Optional[_Union[PointerMove.InPicture, _Mapping]] = ..., slice: _Optional[_Union[PointerMove.InSlice, _Mapping]] = ...) -> None: ...

class Problem(_message.Message):
    __slots__ = ["code", "fatal", "field", "input_seq", "message"]
    CODE_FIELD_NUMBER: _ClassVar[int]
    FATAL_FIELD_NUMBER: _ClassVar[int]
    FIELD_FIELD_NUMBER: _ClassVar[int]
    INPUT_SEQ_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    code: str
    fatal: bool
    field: str
    input_seq: int
    message: str
    def __init__(self, code: _Optional[str] = ..., message: _Optional[str] = ..., field: _Optional[str] = ..., input_seq: _Optional[int] = ..., fatal: bool = ...) -> None: ...

class RaiseHand(_message.Message):
    __slots__ = ["of", "on"]
    OF_FIELD_NUMBER: _ClassVar[int]
    ON_FIELD_NUMBER: _ClassVar[int]
    of: str
    on: bool
    def __init__(self, on: bool = ..., of: _Optional[str] = ...) -> None: ...

class SceneUpdate(_message.Message):
    __slots__ = ["effort", "input_seq", "raw", "rest", "scene", "viewport"]
    EFFORT_FIELD_NUMBER: _ClassVar[int]
    INPUT_SEQ_FIELD_NUMBER: _ClassVar[int]
    RAW_FIELD_NUMBER: _ClassVar[int]
    REST_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    VIEWPORT_FIELD_NUMBER: _ClassVar[int]
    effort: Effort
    input_seq: int
    raw: bool
    rest: bool
    scene: _scene_pb2.Scene
    viewport: Viewport
    def __init__(self, input_seq: _Optional[int] = ..., scene: _Optional[_Union[_scene_pb2.Scene, _Mapping]] = ..., viewport: _Optional[_Union[Viewport, _Mapping]] = ..., raw: bool = ..., rest: bool = ..., effort: _Optional[_Union[Effort, _Mapping]] = ...) -> None: ...

class SecondVolume(_message.Message):
    __slots__ = ["histogram", "looks", "volume"]
    HISTOGRAM_FIELD_NUMBER: _ClassVar[int]
    LOOKS_FIELD_NUMBER: _ClassVar[int]
    VOLUME_FIELD_NUMBER: _ClassVar[int]
    histogram: Histogram
    looks: _containers.RepeatedCompositeFieldContainer[_scene_pb2.OverlayLook]
    volume: _volume_pb2.VolumeHeader
    def __init__(self, volume: _Optional[_Union[_volume_pb2.VolumeHeader, _Mapping]] = ..., histogram: _Optional[_Union[Histogram, _Mapping]] = ..., looks: _Optional[_Iterable[_Union[_scene_pb2.OverlayLook, _Mapping]]] = ...) -> None: ...

class ServerMessage(_message.Message):
    __slots__ = ["audience", "config", "depth", "error_curve", "file_part", "file_progress", "frame", "good_views", "kernel", "labels", "look", "mark_sight", "problem", "shared", "slice", "slices_stale", "state", "stats", "still", "volume_phases"]
    AUDIENCE_FIELD_NUMBER: _ClassVar[int]
    CONFIG_FIELD_NUMBER: _ClassVar[int]
    DEPTH_FIELD_NUMBER: _ClassVar[int]
    ERROR_CURVE_FIELD_NUMBER: _ClassVar[int]
    FILE_PART_FIELD_NUMBER: _ClassVar[int]
    FILE_PROGRESS_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    GOOD_VIEWS_FIELD_NUMBER: _ClassVar[int]
    KERNEL_FIELD_NUMBER: _ClassVar[int]
    LABELS_FIELD_NUMBER: _ClassVar[int]
    LOOK_FIELD_NUMBER: _ClassVar[int]
    MARK_SIGHT_FIELD_NUMBER: _ClassVar[int]
    PROBLEM_FIELD_NUMBER: _ClassVar[int]
    SHARED_FIELD_NUMBER: _ClassVar[int]
    SLICES_STALE_FIELD_NUMBER: _ClassVar[int]
    SLICE_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    STATS_FIELD_NUMBER: _ClassVar[int]
    STILL_FIELD_NUMBER: _ClassVar[int]
    VOLUME_PHASES_FIELD_NUMBER: _ClassVar[int]
    audience: Audience
    config: Config
    depth: Depth
    error_curve: ErrorCurve
    file_part: FilePart
    file_progress: FileProgress
    frame: Frame
    good_views: GoodViews
    kernel: KernelReport
    labels: Labels
    look: Look
    mark_sight: MarkSight
    problem: Problem
    shared: SharedState
    slice: ExactSlice
    slices_stale: SlicesStale
    state: State
    stats: Stats
    still: Still
    volume_phases: VolumePhases
    def __init__(self, config: _Optional[_Union[Config, _Mapping]] = ..., frame: _Optional[_Union[Frame, _Mapping]] = ..., still: _Optional[_Union[Still, _Mapping]] = ..., state: _Optional[_Union[State, _Mapping]] = ..., stats: _Optional[_Union[Stats, _Mapping]] = ..., problem: _Optional[_Union[Problem, _Mapping]] = ..., audience: _Optional[_Union[Audience, _Mapping]] = ..., look: _Optional[_Union[Look, _Mapping]] = ..., depth: _Optional[_Union[Depth, _Mapping]] = ..., slice: _Optional[_Union[ExactSlice, _Mapping]] = ..., file_progress: _Optional[_Union[FileProgress, _Mapping]] = ..., file_part: _Optional[_Union[FilePart, _Mapping]] = ..., kernel: _Optional[_Union[KernelReport, _Mapping]] = ..., slices_stale: _Optional[_Union[SlicesStale, _Mapping]] = ..., error_curve: _Optional[_Union[ErrorCurve, _Mapping]] = ..., shared: _Optional[_Union[SharedState, _Mapping]] = ..., mark_sight: _Optional[_Union[MarkSight, _Mapping]] = ..., labels: _Optional[_Union[Labels, _Mapping]] = ..., good_views: _Optional[_Union[GoodViews, _Mapping]] = ..., volume_phases: _Optional[_Union[VolumePhases, _Mapping]] = ...) -> None: ...

class SharedState(_message.Message):
    __slots__ = ["marks", "measurements", "pointers", "seq", "slice_view"]
    class ParticipantMarks(_message.Message):
        __slots__ = ["marks", "number"]
        MARKS_FIELD_NUMBER: _ClassVar[int]
        NUMBER_FIELD_NUMBER: _ClassVar[int]
        marks: Marks
        number: int
        def __init__(self, number: _Optional[int] = ..., marks: _Optional[_Union[Marks, _Mapping]] = ...) -> None: ...
    class Pointer(_message.Message):
        __slots__ = ["number", "plane", "shown", "x", "y", "z"]
        NUMBER_FIELD_NUMBER: _ClassVar[int]
        PLANE_FIELD_NUMBER: _ClassVar[int]
        SHOWN_FIELD_NUMBER: _ClassVar[int]
        X_FIELD_NUMBER: _ClassVar[int]
        Y_FIELD_NUMBER: _ClassVar[int]
        Z_FIELD_NUMBER: _ClassVar[int]
        number: int
        plane: AnatomicalPlane
        shown: bool
        x: float
        y: float
        z: float
        def __init__(self, number: _Optional[int] = ..., shown: bool = ..., plane: _Optional[_Union[AnatomicalPlane, str]] = ..., x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...
    MARKS_FIELD_NUMBER: _ClassVar[int]
    MEASUREMENTS_FIELD_NUMBER: _ClassVar[int]
    POINTERS_FIELD_NUMBER: _ClassVar[int]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    SLICE_VIEW_FIELD_NUMBER: _ClassVar[int]
    marks: _containers.RepeatedCompositeFieldContainer[SharedState.ParticipantMarks]
    measurements: Measurements
    pointers: _containers.RepeatedCompositeFieldContainer[SharedState.Pointer]
    seq: int
    slice_view: SliceView
    def __init__(self, seq: _Optional[int] = ..., slice_view: _Optional[_Union[SliceView, _Mapping]] = ..., measurements: _Optional[_Union[Measurements, _Mapping]] = ..., pointers: _Optional[_Iterable[_Union[SharedState.Pointer, _Mapping]]] = ..., marks: _Optional[_Iterable[_Union[SharedState.ParticipantMarks, _Mapping]]] = ...) -> None: ...

class SharedTaken(_message.Message):
    __slots__ = ["seq"]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    seq: int
    def __init__(self, seq: _Optional[int] = ...) -> None: ...

class SliceRequest(_message.Message):
    __slots__ = ["slices", "taken"]
    class At(_message.Message):
        __slots__ = ["curved", "index", "oblique", "plane"]
        CURVED_FIELD_NUMBER: _ClassVar[int]
        INDEX_FIELD_NUMBER: _ClassVar[int]
        OBLIQUE_FIELD_NUMBER: _ClassVar[int]
        PLANE_FIELD_NUMBER: _ClassVar[int]
        curved: CurvedSlice
        index: int
        oblique: ObliqueSlice
        plane: AnatomicalPlane
        def __init__(self, plane: _Optional[_Union[AnatomicalPlane, str]] = ..., index: _Optional[int] = ..., oblique: _Optional[_Union[ObliqueSlice, _Mapping]] = ..., curved: _Optional[_Union[CurvedSlice, _Mapping]] = ...) -> None: ...
    SLICES_FIELD_NUMBER: _ClassVar[int]
    TAKEN_FIELD_NUMBER: _ClassVar[int]
    slices: _containers.RepeatedCompositeFieldContainer[SliceRequest.At]
    taken: int
    def __init__(self, slices: _Optional[_Iterable[_Union[SliceRequest.At, _Mapping]]] = ..., taken: _Optional[int] = ...) -> None: ...

class SliceStack(_message.Message):
    __slots__ = ["columns", "down", "first", "next", "plane", "right", "rows", "slices"]
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    DOWN_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    NEXT_FIELD_NUMBER: _ClassVar[int]
    PLANE_FIELD_NUMBER: _ClassVar[int]
    RIGHT_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    SLICES_FIELD_NUMBER: _ClassVar[int]
    columns: int
    down: _scene_pb2.Vec3
    first: _scene_pb2.Vec3
    next: _scene_pb2.Vec3
    plane: AnatomicalPlane
    right: _scene_pb2.Vec3
    rows: int
    slices: int
    def __init__(self, plane: _Optional[_Union[AnatomicalPlane, str]] = ..., columns: _Optional[int] = ..., rows: _Optional[int] = ..., slices: _Optional[int] = ..., first: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., right: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., down: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., next: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ...) -> None: ...

class SliceView(_message.Message):
    __slots__ = ["crosshair", "labels", "layout", "overlay", "placings", "plane", "projection", "slab", "smooth", "tilts", "window_centre", "window_width"]
    class Layout(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    class Placing(_message.Message):
        __slots__ = ["column", "plane", "row", "zoom"]
        COLUMN_FIELD_NUMBER: _ClassVar[int]
        PLANE_FIELD_NUMBER: _ClassVar[int]
        ROW_FIELD_NUMBER: _ClassVar[int]
        ZOOM_FIELD_NUMBER: _ClassVar[int]
        column: float
        plane: AnatomicalPlane
        row: float
        zoom: float
        def __init__(self, plane: _Optional[_Union[AnatomicalPlane, str]] = ..., zoom: _Optional[float] = ..., column: _Optional[float] = ..., row: _Optional[float] = ...) -> None: ...
    class Tilt(_message.Message):
        __slots__ = ["down", "plane", "right"]
        DOWN_FIELD_NUMBER: _ClassVar[int]
        PLANE_FIELD_NUMBER: _ClassVar[int]
        RIGHT_FIELD_NUMBER: _ClassVar[int]
        down: _scene_pb2.Vec3
        plane: AnatomicalPlane
        right: _scene_pb2.Vec3
        def __init__(self, plane: _Optional[_Union[AnatomicalPlane, str]] = ..., right: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., down: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ...) -> None: ...
    CROSSHAIR_FIELD_NUMBER: _ClassVar[int]
    FOUR: SliceView.Layout
    LABELS_FIELD_NUMBER: _ClassVar[int]
    LAYOUT_FIELD_NUMBER: _ClassVar[int]
    LAYOUT_UNSPECIFIED: SliceView.Layout
    OVERLAY_FIELD_NUMBER: _ClassVar[int]
    PICTURE: SliceView.Layout
    PLACINGS_FIELD_NUMBER: _ClassVar[int]
    PLANE_FIELD_NUMBER: _ClassVar[int]
    PROJECTION_FIELD_NUMBER: _ClassVar[int]
    SLAB_FIELD_NUMBER: _ClassVar[int]
    SLICE: SliceView.Layout
    SMOOTH_FIELD_NUMBER: _ClassVar[int]
    TILTS_FIELD_NUMBER: _ClassVar[int]
    WINDOW_CENTRE_FIELD_NUMBER: _ClassVar[int]
    WINDOW_WIDTH_FIELD_NUMBER: _ClassVar[int]
    crosshair: _scene_pb2.Vec3
    labels: float
    layout: SliceView.Layout
    overlay: float
    placings: _containers.RepeatedCompositeFieldContainer[SliceView.Placing]
    plane: AnatomicalPlane
    projection: Projection
    slab: float
    smooth: bool
    tilts: _containers.RepeatedCompositeFieldContainer[SliceView.Tilt]
    window_centre: float
    window_width: float
    def __init__(self, layout: _Optional[_Union[SliceView.Layout, str]] = ..., plane: _Optional[_Union[AnatomicalPlane, str]] = ..., crosshair: _Optional[_Union[_scene_pb2.Vec3, _Mapping]] = ..., window_centre: _Optional[float] = ..., window_width: _Optional[float] = ..., smooth: bool = ..., overlay: _Optional[float] = ..., placings: _Optional[_Iterable[_Union[SliceView.Placing, _Mapping]]] = ..., tilts: _Optional[_Iterable[_Union[SliceView.Tilt, _Mapping]]] = ..., slab: _Optional[float] = ..., projection: _Optional[_Union[Projection, str]] = ..., labels: _Optional[float] = ...) -> None: ...

class SlicesStale(_message.Message):
    __slots__ = []
    def __init__(self) -> None: ...

class State(_message.Message):
    __slots__ = ["biased", "converged", "epoch", "lossless"]
    BIASED_FIELD_NUMBER: _ClassVar[int]
    CONVERGED_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    LOSSLESS_FIELD_NUMBER: _ClassVar[int]
    biased: bool
    converged: bool
    epoch: int
    lossless: bool
    def __init__(self, epoch: _Optional[int] = ..., converged: bool = ..., lossless: bool = ..., biased: bool = ...) -> None: ...

class Stats(_message.Message):
    __slots__ = ["dropped_samples", "frames_skipped", "samples_per_second", "sessions"]
    DROPPED_SAMPLES_FIELD_NUMBER: _ClassVar[int]
    FRAMES_SKIPPED_FIELD_NUMBER: _ClassVar[int]
    SAMPLES_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    SESSIONS_FIELD_NUMBER: _ClassVar[int]
    dropped_samples: int
    frames_skipped: int
    samples_per_second: float
    sessions: int
    def __init__(self, samples_per_second: _Optional[float] = ..., sessions: _Optional[int] = ..., dropped_samples: _Optional[int] = ..., frames_skipped: _Optional[int] = ...) -> None: ...

class Still(_message.Message):
    __slots__ = ["data", "epoch", "error", "format", "hash", "height", "iteration", "seq", "tile", "tiles", "width", "x", "y"]
    DATA_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    ERROR_FIELD_NUMBER: _ClassVar[int]
    FORMAT_FIELD_NUMBER: _ClassVar[int]
    HASH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    ITERATION_FIELD_NUMBER: _ClassVar[int]
    SEQ_FIELD_NUMBER: _ClassVar[int]
    TILES_FIELD_NUMBER: _ClassVar[int]
    TILE_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    data: bytes
    epoch: int
    error: float
    format: StillFormat
    hash: bytes
    height: int
    iteration: int
    seq: int
    tile: int
    tiles: int
    width: int
    x: int
    y: int
    def __init__(self, epoch: _Optional[int] = ..., tile: _Optional[int] = ..., tiles: _Optional[int] = ..., x: _Optional[int] = ..., y: _Optional[int] = ..., width: _Optional[int] = ..., height: _Optional[int] = ..., data: _Optional[bytes] = ..., hash: _Optional[bytes] = ..., format: _Optional[_Union[StillFormat, str]] = ..., seq: _Optional[int] = ..., iteration: _Optional[int] = ..., error: _Optional[float] = ...) -> None: ...

class Treatment(_message.Message):
    __slots__ = ["has_support", "slices_per_stored"]
    HAS_SUPPORT_FIELD_NUMBER: _ClassVar[int]
    SLICES_PER_STORED_FIELD_NUMBER: _ClassVar[int]
    has_support: bool
    slices_per_stored: int
    def __init__(self, slices_per_stored: _Optional[int] = ..., has_support: bool = ...) -> None: ...

class Video(_message.Message):
    __slots__ = ["error", "frames", "frames_per_second", "height", "path", "phase_cycles", "width"]
    class Path(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    ERROR_FIELD_NUMBER: _ClassVar[int]
    FRAMES_FIELD_NUMBER: _ClassVar[int]
    FRAMES_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    PATH_FIELD_NUMBER: _ClassVar[int]
    PATH_UNSPECIFIED: Video.Path
    PHASE_CYCLES_FIELD_NUMBER: _ClassVar[int]
    STANDING: Video.Path
    TOUR: Video.Path
    TURNTABLE: Video.Path
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    error: float
    frames: int
    frames_per_second: int
    height: int
    path: Video.Path
    phase_cycles: int
    width: int
    def __init__(self, path: _Optional[_Union[Video.Path, str]] = ..., frames: _Optional[int] = ..., frames_per_second: _Optional[int] = ..., width: _Optional[int] = ..., height: _Optional[int] = ..., error: _Optional[float] = ..., phase_cycles: _Optional[int] = ...) -> None: ...

class Viewport(_message.Message):
    __slots__ = ["height", "width"]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    height: int
    width: int
    def __init__(self, width: _Optional[int] = ..., height: _Optional[int] = ...) -> None: ...

class Visibility(_message.Message):
    __slots__ = ["visible"]
    VISIBLE_FIELD_NUMBER: _ClassVar[int]
    visible: bool
    def __init__(self, visible: bool = ...) -> None: ...

class VolumePhases(_message.Message):
    __slots__ = ["fit", "loaded"]
    FIT_FIELD_NUMBER: _ClassVar[int]
    LOADED_FIELD_NUMBER: _ClassVar[int]
    fit: bool
    loaded: int
    def __init__(self, loaded: _Optional[int] = ..., fit: bool = ...) -> None: ...

class Codec(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class FrameQuality(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class StillFormat(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class AnatomicalPlane(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class Projection(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []

class SliceAccess(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = []
