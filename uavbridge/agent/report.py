"""What an agent says of itself on ``state/<agent>``, once a second, for people and the judge."""

from __future__ import annotations

from msgspec import UNSET, Struct, UnsetType
from msgspec.json import Decoder, Encoder
from msgspec.structs import replace

from uavbridge.bus.text import read


class Clocks(Struct, frozen=True):
    """How the clocks of an agent's machine and of the launcher's differ."""

    offset_s: float  # by which its mission time is ahead: what is not made up for yet
    error_s: float  # of that
    date_offset_s: float  # its date less the launcher's


class AgentReport(Struct, frozen=True, kw_only=True):
    """JSON on the bus. Lengths in m, speeds in m/s, ENU; times in mission time."""

    agent: int
    t_us: int
    phase: str
    mode: str  # the autopilot's own name of its mode
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    heading: float  # rad from east, counter-clockwise
    armed: bool
    in_air: bool
    battery: float | None = None  # 0..1; left out of the JSON where it is not known
    neighbours: int  # others heard over the radio in the last seconds
    note: str  # the planner's state in its own words
    distance_m: float
    declared: list[tuple[int, int, int]]  # column, row, t_us of each target declared
    found: list[tuple[int, int]] = []  # target, t_us of each target reached by its signal
    frames_sent: int = 0
    frames_heard: int = 0
    bytes_offered: int = 0  # to its radio, which had no room for all of them
    bytes_sent: int = 0
    map_bytes_sent: int = 0  # of these, for cells and for finding out who lacks what
    bytes_heard: int = 0
    dropped: dict[str, int] = {}  # frames that did not reach it, by reason; "queue": own ones too
    dropped_bytes: dict[str, int] = {}
    rejected: dict[str, int] = {}  # impossible frames that reached its process, by reason
    beacon_bytes: int = 0  # of the separation beacon, sent and heard
    failure: str = ""
    clocks: Clocks | UnsetType = UNSET  # of an agent in a process of its own


_ENCODER = Encoder()
_DECODER = Decoder(AgentReport)


def encode(report: AgentReport) -> bytes:
    """As JSON."""
    return _ENCODER.encode(replace(report, battery=UNSET) if report.battery is None else report)


def decode(data: bytes) -> AgentReport:
    """From JSON. Raises msgspec.DecodeError for anything else."""
    return read(_DECODER, data)
