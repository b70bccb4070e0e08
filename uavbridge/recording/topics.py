"""The topics of a recording: one table, and the values that the JSON ones carry.

Times are those of the messages, in mission time. Lengths are metres, speeds
m/s, ENU in the mission frame. Each JSON schema is made from the struct here, so
that the two cannot differ. Fields that are not known are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, TypeAlias, TypeVar

import msgspec
import numpy as np
import numpy.typing as npt
from msgspec import UNSET, Struct, UnsetType

from uavbridge.agent.report import AgentReport
from uavbridge.bus.text import read
from uavbridge.recording import foxglove

R = TypeVar("R", bound=Struct)

Triple: TypeAlias = Annotated[list[float], msgspec.Meta(min_length=3, max_length=3)]

# What became of one frame at one receiver, by code.
OUTCOMES = (
    *("delivered", "out of range", "loss", "delay", "bandwidth", "malformed", "other"),
    *("burst", "queue"),
)

HEARD = np.dtype([("sender", "<u4"), ("tick", "<u4"), ("outcome", "u1")])


class MissionRecord(Struct, frozen=True, omit_defaults=True):
    """What was flown: enough to fly it again."""

    text: str  # the mission file, with what the command line changed
    seed: int
    clock: str  # "stepped" or "paced"
    versions: dict[str, str] = {}


class SetpointRecord(Struct, frozen=True):
    """What the vehicle was told, after the safety filter."""

    kind: str  # "velocity" or "position"
    value: Triple  # m/s or m
    yaw: float | UnsetType = UNSET
    wanted: Triple | UnsetType = UNSET  # what the planner wanted, where the filter changed it


class ReadingRecord(Struct, frozen=True):
    """One look of one payload sensor at one cell."""

    column: int
    row: int
    detected: bool
    taken_us: int = 0  # mission time of the look; the message's time is when the agent had it


class SignalRecord(Struct, frozen=True):
    """What one receiver heard of one target."""

    target: int
    strength: float
    arrived: bool
    taken_us: int  # mission time of the signal; the message's time is when the agent had it


class ObstacleRecord(Struct, frozen=True):
    """A column that one agent's detector saw."""

    number: int
    x: float
    y: float
    radius_m: float
    room_m: float
    taken_us: int  # mission time of the look; the message's time is when the agent had it


class AnswerRecord(Struct, frozen=True):
    """What came back for an earlier question of the planner."""

    key: str
    data: str  # base64
    age_s: float


class DecisionRecord(Struct, frozen=True, omit_defaults=True):
    """One decision of a planner: its own state, its goal, and its memory afterwards."""

    tick: int
    position: Triple
    velocity: Triple
    heading: float
    setpoint: str  # "goto", "velocity" or "segment"
    values: list[float]  # of the setpoint: point, velocity, or start and end
    yaw: float | None = None
    speed: float | None = None
    payload: str = ""  # base64
    note: str = ""
    memory: str = ""  # base64 of ``planners.memory.dumps``; empty: it has no such form


class EventRecord(Struct, frozen=True):
    """Something that people should know of."""

    kind: str  # "phase", "declared", "failure", "said", ...
    text: str
    agent: int | UnsetType = UNSET


class ScoreRecord(Struct, frozen=True):
    """How far the mission is, from the union of the agents' maps and the true positions."""

    coverage: float  # share of cells seen
    entropy: float  # bits
    uncertainty: float  # Liu 2022, one-sided
    declared: int  # true targets declared
    separation: float | UnsetType = UNSET  # closest airborne pair; left out with fewer than two


@dataclass(frozen=True, slots=True)
class Topic:
    """How the messages of one topic, or of all topics under it, are to be read."""

    name: str  # "state" stands for state/<agent> too
    encoding: str
    struct: type[Struct] | None = None
    schema_text: str = ""  # for encodings of our own
    digested: bool = True
    package: str = "uavbridge"  # of the schema's name

    def schema(self) -> tuple[str, str, bytes]:
        """MCAP schema: name, encoding, data."""
        if self.struct is None:
            encoding = "jsonschema" if self.encoding == "json" else self.encoding
            return f"{self.package}.{self.name}", encoding, self.schema_text.encode()
        document = _flat_schema(self.struct)
        return f"{self.package}.{self.struct.__name__}", "jsonschema", msgspec.json.encode(document)


FRAME_ENCODING = "uavbridge-frame-v3"
HEARD_ENCODING = "uavbridge-heard-v1"
TRUTH_ENCODING = "uavbridge-truth-v1"
LAYER_ENCODING = "uavbridge-layer-v1"
MAP_ENCODING = "uavbridge-map-v1"


def _seen(name: str, struct: type[Struct]) -> Topic:
    """One of Foxglove's messages: it follows from other topics, so no part of the digest."""
    return Topic(name, "json", struct, digested=False, package="foxglove")


TOPICS: dict[str, Topic] = {
    topic.name: topic
    for topic in (
        Topic("mission", "json", MissionRecord),
        Topic("air", FRAME_ENCODING, schema_text="docs/reference/wire_format.md"),
        Topic(
            "heard",
            HEARD_ENCODING,
            schema_text="records of 9 bytes: u32 sender, u32 tick, u8 outcome; little-endian; "
            + ", ".join(f"{code} {name}" for code, name in enumerate(OUTCOMES)),
        ),
        Topic("obs", "json", ReadingRecord),
        Topic("signal", "json", SignalRecord),
        Topic("obstacle", "json", ObstacleRecord),
        Topic("answer", "json", AnswerRecord),
        Topic("setpoint", "json", SetpointRecord),
        Topic("state", "json", AgentReport),
        Topic("decision", "json", DecisionRecord),
        Topic("truth", TRUTH_ENCODING, schema_text="docs/reference/wire_format.md"),
        Topic("event", "json", EventRecord),
        Topic("score", "json", ScoreRecord),
        Topic("cmd", "json", schema_text='{"type":"object"}'),
        Topic("past", "json", schema_text='{"type":"object"}'),
        Topic("fullmap", MAP_ENCODING, schema_text="docs/reference/wire_format.md"),
        Topic("layer", LAYER_ENCODING, schema_text="docs/reference/wire_format.md"),
        # The summary holds the digest and the wall time, so it is no part of the digest.
        Topic("summary", "json", schema_text='{"type":"object"}', digested=False),
        _seen("pose", foxglove.PoseInFrame),
        _seen("fix", foxglove.LocationFix),
        _seen("grid", foxglove.Grid),
        _seen("scene", foxglove.SceneUpdate),
        _seen("area", foxglove.SceneUpdate),
        _seen("log", foxglove.Log),
    )
}


def topic_kind(topic: str) -> Topic:
    """The table's row for a topic such as ``state/3``. Raises KeyError where there is none."""
    return TOPICS[topic.partition("/")[0]]


_ENCODER = msgspec.json.Encoder()


def encode(record: Struct) -> bytes:
    """A record as JSON in the fixed order of its fields."""
    return _ENCODER.encode(record)


def decode(kind: type[R], data: bytes) -> R:
    """A record from JSON. Raises msgspec.DecodeError for anything else."""
    record: R = read(_decoder(kind), data)
    return record


@cache
def _decoder(kind: type[R]) -> msgspec.json.Decoder[R]:
    return msgspec.json.Decoder(kind)


def known(value: float) -> float | UnsetType:
    """The value, or UNSET where it is not a finite number."""
    return value if math.isfinite(value) else UNSET


def pack_heard(rows: Iterable[tuple[int, int, str]]) -> bytes:
    """(sender, tick, outcome) of the frames that reached one receiver's radio, as bytes."""
    codes = [
        (sender, tick, OUTCOMES.index(outcome if outcome in OUTCOMES else "other"))
        for sender, tick, outcome in rows
    ]
    return np.array(codes, dtype=HEARD).tobytes()


def unpack_heard(data: bytes) -> npt.NDArray[np.void]:
    """Records of dtype HEARD (k,); an incomplete last one is left out."""
    return np.frombuffer(data[: len(data) // HEARD.itemsize * HEARD.itemsize], dtype=HEARD)


def _flat_schema(kind: type[Struct]) -> dict[str, Any]:
    """JSON schema with everything in its place: Foxglove follows no references."""
    (root,), components = msgspec.json.schema_components([kind])
    schema: dict[str, Any] = _inlined(root, components)
    return schema


def _inlined(part: Any, components: dict[str, Any]) -> Any:
    if isinstance(part, list):
        return [_inlined(each, components) for each in part]
    if not isinstance(part, dict):
        return part
    if "$ref" in part:
        return _inlined(components[part["$ref"].rpartition("/")[2]], components)
    choices = [choice for choice in part.get("anyOf", []) if choice != {"type": "null"}]
    if len(choices) == 1:  # a field that may be null, as one of its own type
        return _inlined(choices[0], components)
    return {
        name: _inlined(each, components)
        for name, each in part.items()
        if not (name == "default" and isinstance(each, dict | list))
    }
