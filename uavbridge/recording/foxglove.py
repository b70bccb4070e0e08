"""Foxglove's standard messages, as far as we write them, field by field as their schemas say.

https://docs.foxglove.dev/docs/sdk/schemas, encoded as JSON. Units there: metres, degrees for places
on Earth, seconds and nanoseconds of Unix time; the frame ``FRAME`` is the mission's, east-north-up.
"""

from __future__ import annotations

from math import cos, sin
from typing import Any

from msgspec import Struct, field

FRAME = "mission"
UINT8, FLOAT32 = 1, 7  # of PackedElementField.type
LINE_LOOP, LINE_LIST = 1, 2  # of LinePrimitive.type
INFO, WARNING, ERROR = 2, 3, 4  # of Log.level


class Time(Struct, frozen=True):
    """Unix time, or a duration."""

    sec: int
    nsec: int

    @staticmethod
    def of(date_ns: int) -> Time:
        """From nanoseconds."""
        return Time(*divmod(date_ns, 1_000_000_000))


class Vector2(Struct, frozen=True):
    """In the plane."""

    x: float
    y: float


class Vector3(Struct, frozen=True):
    """A place, a direction, or sides."""

    x: float
    y: float
    z: float


class Quaternion(Struct, frozen=True):
    """A rotation."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0

    @staticmethod
    def of_yaw(yaw_rad: float) -> Quaternion:
        """Counter-clockwise from east, level."""
        return Quaternion(0.0, 0.0, sin(yaw_rad / 2), cos(yaw_rad / 2))


class Pose(Struct, frozen=True):
    """Where and how turned."""

    position: Vector3
    orientation: Quaternion = Quaternion()


class PoseInFrame(Struct, frozen=True):
    """A pose at a time."""

    timestamp: Time
    frame_id: str
    pose: Pose


class LocationFix(Struct, frozen=True):
    """A place on Earth."""

    timestamp: Time
    frame_id: str
    latitude: float  # degrees
    longitude: float
    altitude: float  # m
    position_covariance: list[float]  # 9 numbers; all 0: not known
    position_covariance_type: int = 0


class PackedElementField(Struct, frozen=True):
    """One number of a cell of a grid."""

    name: str
    offset: int  # bytes from the cell's first
    type: int


class Grid(Struct, frozen=True):
    """Cells in rows from the corner at ``pose``, along its x axis."""

    timestamp: Time
    frame_id: str
    pose: Pose
    column_count: int
    cell_size: Vector2
    row_stride: int
    cell_stride: int
    fields: list[PackedElementField]
    data: bytes


class Log(Struct, frozen=True):
    """A line of a log."""

    timestamp: Time
    level: int
    message: str
    name: str
    file: str = ""
    line: int = 0


class Color(Struct, frozen=True):
    """Parts from 0 to 1."""

    r: float
    g: float
    b: float
    a: float = 1.0


class KeyValuePair(Struct, frozen=True):
    """For people who click on an entity."""

    key: str
    value: str


class ArrowPrimitive(Struct, frozen=True):
    """From the pose along its x axis; m."""

    pose: Pose
    shaft_length: float
    shaft_diameter: float
    head_length: float
    head_diameter: float
    color: Color


class SolidPrimitive(Struct, frozen=True):
    """A cube or a sphere; m."""

    pose: Pose
    size: Vector3
    color: Color


class LinePrimitive(Struct, frozen=True):
    """Lines between points, in pixels when ``scale_invariant``."""

    type: int
    pose: Pose
    thickness: float
    scale_invariant: bool
    points: list[Vector3]
    color: Color
    colors: list[Color] = []
    indices: list[int] = []


class TextPrimitive(Struct, frozen=True):
    """A text that faces the onlooker."""

    pose: Pose
    billboard: bool
    font_size: float  # pixels when ``scale_invariant``
    scale_invariant: bool
    color: Color
    text: str


class SceneEntity(Struct, frozen=True, kw_only=True):
    """Shapes that belong together; a later one of the same id takes its place."""

    timestamp: Time
    frame_id: str
    id: str
    lifetime: Time = Time(0, 0)  # for ever
    frame_locked: bool = False
    metadata: list[KeyValuePair] = []
    arrows: list[ArrowPrimitive] = []
    cubes: list[SolidPrimitive] = []
    spheres: list[SolidPrimitive] = []
    cylinders: list[dict[str, Any]] = []
    lines: list[LinePrimitive] = []
    triangles: list[dict[str, Any]] = []
    texts: list[TextPrimitive] = []
    models: list[dict[str, Any]] = []


class SceneUpdate(Struct, frozen=True):
    """What is seen from now on."""

    deletions: list[dict[str, Any]] = field(default_factory=list)
    entities: list[SceneEntity] = field(default_factory=list)
