from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Iterable as _Iterable, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class BoxLight(_message.Message):
    __slots__ = ["corner", "radiance", "texture", "u", "v", "w"]
    CORNER_FIELD_NUMBER: _ClassVar[int]
    RADIANCE_FIELD_NUMBER: _ClassVar[int]
    TEXTURE_FIELD_NUMBER: _ClassVar[int]
    U_FIELD_NUMBER: _ClassVar[int]
    V_FIELD_NUMBER: _ClassVar[int]
    W_FIELD_NUMBER: _ClassVar[int]
    corner: Vec3
    radiance: Rgb
    texture: Texture
    u: Vec3
    v: Vec3
    w: Vec3
    def __init__(self, corner: _Optional[_Union[Vec3, _Mapping]] = ..., u: _Optional[_Union[Vec3, _Mapping]] = ..., v: _Optional[_Union[Vec3, _Mapping]] = ..., w: _Optional[_Union[Vec3, _Mapping]] = ..., radiance: _Optional[_Union[Rgb, _Mapping]] = ..., texture: _Optional[_Union[Texture, _Mapping]] = ...) -> None: ...

class Camera(_message.Message):
    __slots__ = ["aperture_radius", "eye", "focal_distance", "orthographic_height", "target", "up", "vertical_fov_degrees"]
    APERTURE_RADIUS_FIELD_NUMBER: _ClassVar[int]
    EYE_FIELD_NUMBER: _ClassVar[int]
    FOCAL_DISTANCE_FIELD_NUMBER: _ClassVar[int]
    ORTHOGRAPHIC_HEIGHT_FIELD_NUMBER: _ClassVar[int]
    TARGET_FIELD_NUMBER: _ClassVar[int]
    UP_FIELD_NUMBER: _ClassVar[int]
    VERTICAL_FOV_DEGREES_FIELD_NUMBER: _ClassVar[int]
    aperture_radius: float
    eye: Vec3
    focal_distance: float
    orthographic_height: float
    target: Vec3
    up: Vec3
    vertical_fov_degrees: float
    def __init__(self, eye: _Optional[_Union[Vec3, _Mapping]] = ..., target: _Optional[_Union[Vec3, _Mapping]] = ..., up: _Optional[_Union[Vec3, _Mapping]] = ..., vertical_fov_degrees: _Optional[float] = ..., orthographic_height: _Optional[float] = ..., aperture_radius: _Optional[float] = ..., focal_distance: _Optional[float] = ...) -> None: ...

class Channel(_message.Message):
    __slots__ = ["diffuse", "disabled", "emission", "gloss", "name", "opacity", "specular"]
    DIFFUSE_FIELD_NUMBER: _ClassVar[int]
    DISABLED_FIELD_NUMBER: _ClassVar[int]
    EMISSION_FIELD_NUMBER: _ClassVar[int]
    GLOSS_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    OPACITY_FIELD_NUMBER: _ClassVar[int]
    SPECULAR_FIELD_NUMBER: _ClassVar[int]
    diffuse: Rgb
    disabled: bool
    emission: Rgb
    gloss: float
    name: str
    opacity: _containers.RepeatedCompositeFieldContainer[OpacityPoint]
    specular: Rgb
    def __init__(self, name: _Optional[str] = ..., opacity: _Optional[_Iterable[_Union[OpacityPoint, _Mapping]]] = ..., diffuse: _Optional[_Union[Rgb, _Mapping]] = ..., disabled: bool = ..., specular: _Optional[_Union[Rgb, _Mapping]] = ..., gloss: _Optional[float] = ..., emission: _Optional[_Union[Rgb, _Mapping]] = ...) -> None: ...

class Clip(_message.Message):
    __slots__ = ["box_high", "box_low", "cuts_light", "planes"]
    class Plane(_message.Message):
        __slots__ = ["normal", "point"]
        NORMAL_FIELD_NUMBER: _ClassVar[int]
        POINT_FIELD_NUMBER: _ClassVar[int]
        normal: Vec3
        point: Vec3
        def __init__(self, point: _Optional[_Union[Vec3, _Mapping]] = ..., normal: _Optional[_Union[Vec3, _Mapping]] = ...) -> None: ...
    BOX_HIGH_FIELD_NUMBER: _ClassVar[int]
    BOX_LOW_FIELD_NUMBER: _ClassVar[int]
    CUTS_LIGHT_FIELD_NUMBER: _ClassVar[int]
    PLANES_FIELD_NUMBER: _ClassVar[int]
    box_high: Vec3
    box_low: Vec3
    cuts_light: bool
    planes: _containers.RepeatedCompositeFieldContainer[Clip.Plane]
    def __init__(self, box_low: _Optional[_Union[Vec3, _Mapping]] = ..., box_high: _Optional[_Union[Vec3, _Mapping]] = ..., planes: _Optional[_Iterable[_Union[Clip.Plane, _Mapping]]] = ..., cuts_light: bool = ...) -> None: ...

class DiskLight(_message.Message):
    __slots__ = ["centre", "normal", "radiance", "radius", "texture"]
    CENTRE_FIELD_NUMBER: _ClassVar[int]
    NORMAL_FIELD_NUMBER: _ClassVar[int]
    RADIANCE_FIELD_NUMBER: _ClassVar[int]
    RADIUS_FIELD_NUMBER: _ClassVar[int]
    TEXTURE_FIELD_NUMBER: _ClassVar[int]
    centre: Vec3
    normal: Vec3
    radiance: Rgb
    radius: float
    texture: Texture
    def __init__(self, centre: _Optional[_Union[Vec3, _Mapping]] = ..., normal: _Optional[_Union[Vec3, _Mapping]] = ..., radius: _Optional[float] = ..., radiance: _Optional[_Union[Rgb, _Mapping]] = ..., texture: _Optional[_Union[Texture, _Mapping]] = ...) -> None: ...

class Display(_message.Message):
    __slots__ = ["automatic_exposure", "background", "background_edge", "curve", "exposure", "show_environment"]
    class Curve(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    AUTOMATIC_EXPOSURE_FIELD_NUMBER: _ClassVar[int]
    BACKGROUND_EDGE_FIELD_NUMBER: _ClassVar[int]
    BACKGROUND_FIELD_NUMBER: _ClassVar[int]
    CURVE_FIELD_NUMBER: _ClassVar[int]
    EXPOSURE_FIELD_NUMBER: _ClassVar[int]
    FILMIC: Display.Curve
    LINEAR: Display.Curve
    SHOW_ENVIRONMENT_FIELD_NUMBER: _ClassVar[int]
    automatic_exposure: bool
    background: Rgb
    background_edge: Rgb
    curve: Display.Curve
    exposure: float
    show_environment: bool
    def __init__(self, exposure: _Optional[float] = ..., show_environment: bool = ..., background: _Optional[_Union[Rgb, _Mapping]] = ..., background_edge: _Optional[_Union[Rgb, _Mapping]] = ..., curve: _Optional[_Union[Display.Curve, str]] = ..., automatic_exposure: bool = ...) -> None: ...

class EnvironmentLight(_message.Message):
    __slots__ = ["radiance", "rotation_degrees", "stored", "texture"]
    RADIANCE_FIELD_NUMBER: _ClassVar[int]
    ROTATION_DEGREES_FIELD_NUMBER: _ClassVar[int]
    STORED_FIELD_NUMBER: _ClassVar[int]
    TEXTURE_FIELD_NUMBER: _ClassVar[int]
    radiance: Rgb
    rotation_degrees: float
    stored: str
    texture: Texture
    def __init__(self, radiance: _Optional[_Union[Rgb, _Mapping]] = ..., texture: _Optional[_Union[Texture, _Mapping]] = ..., stored: _Optional[str] = ..., rotation_degrees: _Optional[float] = ...) -> None: ...

class Highlight(_message.Message):
    __slots__ = ["centre", "colour", "radius", "strength"]
    CENTRE_FIELD_NUMBER: _ClassVar[int]
    COLOUR_FIELD_NUMBER: _ClassVar[int]
    RADIUS_FIELD_NUMBER: _ClassVar[int]
    STRENGTH_FIELD_NUMBER: _ClassVar[int]
    centre: Vec3
    colour: Rgb
    radius: float
    strength: float
    def __init__(self, centre: _Optional[_Union[Vec3, _Mapping]] = ..., radius: _Optional[float] = ..., colour: _Optional[_Union[Rgb, _Mapping]] = ..., strength: _Optional[float] = ...) -> None: ...

class LabelLook(_message.Message):
    __slots__ = ["colour", "number", "opacity", "solo"]
    COLOUR_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    OPACITY_FIELD_NUMBER: _ClassVar[int]
    SOLO_FIELD_NUMBER: _ClassVar[int]
    colour: Rgb
    number: int
    opacity: float
    solo: bool
    def __init__(self, number: _Optional[int] = ..., colour: _Optional[_Union[Rgb, _Mapping]] = ..., opacity: _Optional[float] = ..., solo: bool = ...) -> None: ...

class Light(_message.Message):
    __slots__ = ["box", "camera_locked", "disabled", "disk", "environment", "intensity", "name", "rectangle", "sphere"]
    BOX_FIELD_NUMBER: _ClassVar[int]
    CAMERA_LOCKED_FIELD_NUMBER: _ClassVar[int]
    DISABLED_FIELD_NUMBER: _ClassVar[int]
    DISK_FIELD_NUMBER: _ClassVar[int]
    ENVIRONMENT_FIELD_NUMBER: _ClassVar[int]
    INTENSITY_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    RECTANGLE_FIELD_NUMBER: _ClassVar[int]
    SPHERE_FIELD_NUMBER: _ClassVar[int]
    box: BoxLight
    camera_locked: bool
    disabled: bool
    disk: DiskLight
    environment: EnvironmentLight
    intensity: float
    name: str
    rectangle: RectangleLight
    sphere: SphereLight
    def __init__(self, name: _Optional[str] = ..., camera_locked: bool = ..., rectangle: _Optional[_Union[RectangleLight, _Mapping]] = ..., environment: _Optional[_Union[EnvironmentLight, _Mapping]] = ..., disk: _Optional[_Union[DiskLight, _Mapping]] = ..., sphere: _Optional[_Union[SphereLight, _Mapping]] = ..., box: _Optional[_Union[BoxLight, _Mapping]] = ..., disabled: bool = ..., intensity: _Optional[float] = ...) -> None: ...

class OpacityPoint(_message.Message):
    __slots__ = ["opacity", "value"]
    OPACITY_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    opacity: float
    value: float
    def __init__(self, value: _Optional[float] = ..., opacity: _Optional[float] = ...) -> None: ...

class Overlay(_message.Message):
    __slots__ = ["mode", "share", "split", "transfer_function"]
    class Mode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    MIXED: Overlay.Mode
    MODE_FIELD_NUMBER: _ClassVar[int]
    SHARE_FIELD_NUMBER: _ClassVar[int]
    SPLIT: Overlay.Mode
    SPLIT_FIELD_NUMBER: _ClassVar[int]
    TRANSFER_FUNCTION_FIELD_NUMBER: _ClassVar[int]
    mode: Overlay.Mode
    share: float
    split: float
    transfer_function: TransferFunction
    def __init__(self, transfer_function: _Optional[_Union[TransferFunction, _Mapping]] = ..., share: _Optional[float] = ..., mode: _Optional[_Union[Overlay.Mode, str]] = ..., split: _Optional[float] = ...) -> None: ...

class OverlayLook(_message.Message):
    __slots__ = ["name", "overlay"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    OVERLAY_FIELD_NUMBER: _ClassVar[int]
    name: str
    overlay: Overlay
    def __init__(self, name: _Optional[str] = ..., overlay: _Optional[_Union[Overlay, _Mapping]] = ...) -> None: ...

class Phase(_message.Message):
    __slots__ = ["g"]
    G_FIELD_NUMBER: _ClassVar[int]
    g: float
    def __init__(self, g: _Optional[float] = ...) -> None: ...

class Preset(_message.Message):
    __slots__ = ["name", "scene"]
    NAME_FIELD_NUMBER: _ClassVar[int]
    SCENE_FIELD_NUMBER: _ClassVar[int]
    name: str
    scene: Scene
    def __init__(self, name: _Optional[str] = ..., scene: _Optional[_Union[Scene, _Mapping]] = ...) -> None: ...

class RectangleLight(_message.Message):
    __slots__ = ["corner", "radiance", "texture", "u", "v"]
    CORNER_FIELD_NUMBER: _ClassVar[int]
    RADIANCE_FIELD_NUMBER: _ClassVar[int]
    TEXTURE_FIELD_NUMBER: _ClassVar[int]
    U_FIELD_NUMBER: _ClassVar[int]
    V_FIELD_NUMBER: _ClassVar[int]
    corner: Vec3
    radiance: Rgb
    texture: Texture
    u: Vec3
    v: Vec3
    def __init__(self, corner: _Optional[_Union[Vec3, _Mapping]] = ..., u: _Optional[_Union[Vec3, _Mapping]] = ..., v: _Optional[_Union[Vec3, _Mapping]] = ..., radiance: _Optional[_Union[Rgb, _Mapping]] = ..., texture: _Optional[_Union[Texture, _Mapping]] = ...) -> None: ...

class Rgb(_message.Message):
    __slots__ = ["b", "g", "r"]
    B_FIELD_NUMBER: _ClassVar[int]
    G_FIELD_NUMBER: _ClassVar[int]
    R_FIELD_NUMBER: _ClassVar[int]
    b: float
    g: float
    r: float
    def __init__(self, r: _Optional[float] = ..., g: _Optional[float] = ..., b: _Optional[float] = ...) -> None: ...

class Scene(_message.Message):
    __slots__ = ["bounces", "camera", "clip", "display", "highlight", "labels", "lights", "overlay", "phase", "shading", "show_table", "slices", "transfer_function", "volume_phase"]
    BOUNCES_FIELD_NUMBER: _ClassVar[int]
    CAMERA_FIELD_NUMBER: _ClassVar[int]
    CLIP_FIELD_NUMBER: _ClassVar[int]
    DISPLAY_FIELD_NUMBER: _ClassVar[int]
    HIGHLIGHT_FIELD_NUMBER: _ClassVar[int]
    LABELS_FIELD_NUMBER: _ClassVar[int]
    LIGHTS_FIELD_NUMBER: _ClassVar[int]
    OVERLAY_FIELD_NUMBER: _ClassVar[int]
    PHASE_FIELD_NUMBER: _ClassVar[int]
    SHADING_FIELD_NUMBER: _ClassVar[int]
    SHOW_TABLE_FIELD_NUMBER: _ClassVar[int]
    SLICES_FIELD_NUMBER: _ClassVar[int]
    TRANSFER_FUNCTION_FIELD_NUMBER: _ClassVar[int]
    VOLUME_PHASE_FIELD_NUMBER: _ClassVar[int]
    bounces: int
    camera: Camera
    clip: Clip
    display: Display
    highlight: Highlight
    labels: _containers.RepeatedCompositeFieldContainer[LabelLook]
    lights: _containers.RepeatedCompositeFieldContainer[Light]
    overlay: Overlay
    phase: Phase
    shading: Shading
    show_table: bool
    slices: Slices
    transfer_function: TransferFunction
    volume_phase: int
    def __init__(self, transfer_function: _Optional[_Union[TransferFunction, _Mapping]] = ..., lights: _Optional[_Iterable[_Union[Light, _Mapping]]] = ..., camera: _Optional[_Union[Camera, _Mapping]] = ..., phase: _Optional[_Union[Phase, _Mapping]] = ..., display: _Optional[_Union[Display, _Mapping]] = ..., shading: _Optional[_Union[Shading, _Mapping]] = ..., clip: _Optional[_Union[Clip, _Mapping]] = ..., slices: _Optional[_Union[Slices, _Mapping]] = ..., bounces: _Optional[int] = ..., show_table: bool = ..., labels: _Optional[_Iterable[_Union[LabelLook, _Mapping]]] = ..., highlight: _Optional[_Union[Highlight, _Mapping]] = ..., volume_phase: _Optional[int] = ..., overlay: _Optional[_Union[Overlay, _Mapping]] = ...) -> None: ...

class Shading(_message.Message):
    __slots__ = ["gradient_scale", "mode"]
    class Mode(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    GRADIENT_SCALE_FIELD_NUMBER: _ClassVar[int]
    HYBRID: Shading.Mode
    MODE_FIELD_NUMBER: _ClassVar[int]
    PHASE: Shading.Mode
    SURFACE: Shading.Mode
    gradient_scale: float
    mode: Shading.Mode
    def __init__(self, mode: _Optional[_Union[Shading.Mode, str]] = ..., gradient_scale: _Optional[float] = ...) -> None: ...

class Slices(_message.Message):
    __slots__ = ["alone", "axial", "colouring", "coronal", "sagittal", "window_centre", "window_width"]
    class Colouring(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
        __slots__ = []
    class Slice(_message.Message):
        __slots__ = ["position", "shown"]
        POSITION_FIELD_NUMBER: _ClassVar[int]
        SHOWN_FIELD_NUMBER: _ClassVar[int]
        position: float
        shown: bool
        def __init__(self, shown: bool = ..., position: _Optional[float] = ...) -> None: ...
    ALONE_FIELD_NUMBER: _ClassVar[int]
    AXIAL_FIELD_NUMBER: _ClassVar[int]
    COLOURING_FIELD_NUMBER: _ClassVar[int]
    CORONAL_FIELD_NUMBER: _ClassVar[int]
    GREY: Slices.Colouring
    SAGITTAL_FIELD_NUMBER: _ClassVar[int]
    TRANSFER: Slices.Colouring
    WINDOW_CENTRE_FIELD_NUMBER: _ClassVar[int]
    WINDOW_WIDTH_FIELD_NUMBER: _ClassVar[int]
    alone: bool
    axial: Slices.Slice
    colouring: Slices.Colouring
    coronal: Slices.Slice
    sagittal: Slices.Slice
    window_centre: float
    window_width: float
    def __init__(self, sagittal: _Optional[_Union[Slices.Slice, _Mapping]] = ..., coronal: _Optional[_Union[Slices.Slice, _Mapping]] = ..., axial: _Optional[_Union[Slices.Slice, _Mapping]] = ..., colouring: _Optional[_Union[Slices.Colouring, str]] = ..., window_centre: _Optional[float] = ..., window_width: _Optional[float] = ..., alone: bool = ...) -> None: ...

class SphereLight(_message.Message):
    __slots__ = ["centre", "radiance", "radius", "texture"]
    CENTRE_FIELD_NUMBER: _ClassVar[int]
    RADIANCE_FIELD_NUMBER: _ClassVar[int]
    RADIUS_FIELD_NUMBER: _ClassVar[int]
    TEXTURE_FIELD_NUMBER: _ClassVar[int]
    centre: Vec3
    radiance: Rgb
    radius: float
    texture: Texture
    def __init__(self, centre: _Optional[_Union[Vec3, _Mapping]] = ..., radius: _Optional[float] = ..., radiance: _Optional[_Union[Rgb, _Mapping]] = ..., texture: _Optional[_Union[Texture, _Mapping]] = ...) -> None: ...

class Texture(_message.Message):
    __slots__ = ["picture", "projection_degrees"]
    PICTURE_FIELD_NUMBER: _ClassVar[int]
    PROJECTION_DEGREES_FIELD_NUMBER: _ClassVar[int]
    picture: bytes
    projection_degrees: float
    def __init__(self, picture: _Optional[bytes] = ..., projection_degrees: _Optional[float] = ...) -> None: ...

class TransferFunction(_message.Message):
    __slots__ = ["channels", "extinction_per_mm"]
    CHANNELS_FIELD_NUMBER: _ClassVar[int]
    EXTINCTION_PER_MM_FIELD_NUMBER: _ClassVar[int]
    channels: _containers.RepeatedCompositeFieldContainer[Channel]
    extinction_per_mm: float
    def __init__(self, channels: _Optional[_Iterable[_Union[Channel, _Mapping]]] = ..., extinction_per_mm: _Optional[float] = ...) -> None: ...

class Vec3(_message.Message):
    __slots__ = ["x", "y", "z"]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    z: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...
