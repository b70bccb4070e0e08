"""What page and server tell each other over the websocket.

Server to page: JSON, one of the structs below with its name as ``kind``, and cells of
maps as binary: little-endian u32 words, first the agent (0: the union of all maps) and
the number of pairs that follow, flat cell and value. A map comes whole after a ``Mission``.
A value is P(target) in its low byte, 0..255, and in the rest the second of mission
time of the newest look at the cell plus 1; 0 there: never seen.

Page to server: JSON, ``Ask``.
"""

from __future__ import annotations

from msgspec import Struct


class Mission(Struct, frozen=True, tag="mission", tag_field="kind"):
    """All that does not change, and the past; whatever the page knew before is void."""

    name: str
    recording: bool
    orders: list[str]  # verbs that may be given; none: this one cannot be told anything
    t_s: float
    planner: str = ""
    seed: int | None = None
    clock: str = ""
    duration_s: float | None = None  # time limit
    end_s: float | None = None  # of a recording
    grid: tuple[float, float, float, int, int] | None = None  # west, south, cell, columns, rows
    prior: float = 0.5
    range_m: float | None = None  # of the radio; None: unlimited, or not known
    range_known: bool = False
    radio: str = ""  # what is emulated of it
    separation_m: float | None = None
    coverage_goal: float | None = None
    targets: list[tuple[float, float]] | None = None  # the true ones; None: nobody told
    by_signal: bool = False  # targets are found by their signals: no cells are looked at
    columns: list[tuple[float, float, float]] = []  # where nobody may fly: x, y, radius
    tracks: dict[int, list[float]] = {}  # x, y, x, y, ... of each agent so far
    points: list[list[float | None]] = []
    version: str = ""


class Ground(Struct, frozen=True, tag="ground", tag_field="kind"):
    """Numbers over the ground: the terrain, or the layer that the page asked for."""

    name: str
    t_s: float
    grid: tuple[float, float, float, int, int]  # west, south, cell, columns, rows
    low: float  # the least and the greatest number; 0 and 255 in ``values``
    high: float
    values: str  # base64, a byte a cell, cell (c, r) at c * rows + r
    shade: str = ""  # of terrain: the same, how bright it is


class Row(Struct, frozen=True):
    """What an agent says of itself."""

    id: int
    phase: str
    mode: str
    armed: bool
    in_air: bool
    battery: float | None
    neighbours: int
    note: str
    failure: str
    alive: bool | None
    distance_m: float
    bytes_sent: int
    bytes_heard: int
    declared: list[tuple[int, int]]
    bytes_offered: int = 0
    dropped: dict[str, int] = {}  # frames that it did not hear, by reason
    rejected: dict[str, int] = {}  # that no honest agent sends, of its whole process
    clock_ms: tuple[float, float, float] | None = None  # offset, its error, offset of the date


class Event(Struct, frozen=True):
    """One line of the log."""

    t_s: float
    agent: int | None
    sort: str
    text: str


class Update(Struct, frozen=True, tag="update", tag_field="kind", omit_defaults=True):
    """What changed since the last one; None: nothing did."""

    t_s: float
    # id, x, y, z, east and north speed, heading (rad from east, counter-clockwise)
    vehicles: list[tuple[int, float, float, float, float, float, float]]
    connected: bool = True  # to the router
    silent: bool = False  # nothing was heard for some seconds
    rows: list[Row] | None = None  # those that changed
    links: list[tuple[int, int]] | None = None
    tracks: dict[int, list[float]] | None = None  # what was flown since: x, y, x, y, ...
    points: list[list[float | None]] | None = None  # new ones, see ``POINT``
    events: list[Event] | None = None  # new ones
    groups: list[tuple[int, int, bool]] | None = None  # agent, its group, whether it leads
    layers: list[str] | None = None  # names of those that can be asked for
    declared: list[tuple[int, int, float, int]] | None = None  # column, row, when, by whom
    seen_by: int = 0  # the agent whose view is told; 0: none
    hears: list[int] | None = None  # whom that agent hears
    playing: bool | None = None  # of recordings
    speed: float | None = None
    seeking: bool = False


POINT = ("t_s", "coverage", "entropy", "declared", "found", "separation_m", "bytes", "frames")


class Answer(Struct, frozen=True, tag="answer", tag_field="kind"):
    """What became of an order."""

    ask: int
    verb: str
    done: list[int]
    refused: list[tuple[int, str]]
    took_s: float = 0.0
    fault: str = ""


class Ask(Struct, frozen=True):
    """What the page wants; only the fields it means are there."""

    ask: int = 0  # its number, for the answer
    order: str | None = None
    agent: int | None = None  # None: all
    to: tuple[float, float] | None = None  # of a goto
    seen_by: int | None = None
    layer: str | None = None  # to be told of from now on; empty: none
    play: bool | None = None
    speed: float | None = None
    seek_s: float | None = None
