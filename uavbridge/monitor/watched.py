"""What an onlooker knows of agents, and of the mission at one second: plain values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import nan

import numpy as np

from uavbridge.agent.report import AgentReport
from uavbridge.bus.wire import Frame, Vector
from uavbridge.clock import to_us
from uavbridge.monitor.past import PastPoint
from uavbridge.radio.radio import Radio

RECENT_S = 3.0  # a sender that was silent for longer is heard by nobody


@dataclass(frozen=True, slots=True)
class Happening:
    """Something that people should know of."""

    t_us: int
    agent: int | None
    kind: str  # "phase", "declared", "failure", "order", "link", or what was told
    text: str


@dataclass(frozen=True, slots=True)
class Point:
    """The mission in numbers at one second; NaN where a number is not known."""

    t_us: int
    coverage: float
    entropy: float  # bits
    uncertainty: float  # Liu 2022, one-sided
    declared: int  # cells that some agent declared
    found: int  # of them, cells with a true target
    separation_m: float  # closest airborne pair
    bytes_sent: int  # by all agents over the radio so far
    bytes_heard: int
    frames_sent: int
    frames_heard: int


@dataclass(frozen=True, slots=True)
class Declared:
    """A cell in which some agent holds a target to be."""

    cell: tuple[int, int]
    t_us: int
    by: int


@dataclass(slots=True, eq=False)
class Watched:
    """One agent, as far as it is known."""

    id: int
    report: AgentReport | None = None
    position: Vector | None = None  # ENU m: the true one where the world tells, else its own word
    velocity: Vector = (0.0, 0.0, 0.0)
    heading: float = nan  # rad from east, counter-clockwise
    seen_us: int = -1  # its last sign of life
    sent_us: int = -1  # its last frame
    alive: bool | None = None  # by its liveliness token; None: never had one
    track: list[tuple[float, float, float, float]] = field(default_factory=list)  # t_s, ENU m
    frame: Frame | None = None  # the newest
    tells: bool = False  # what happens to it, in words, on the bus

    @property
    def flying(self) -> bool:
        """In the air, by its own word."""
        return self.report is not None and self.report.in_air


def hearing(agents: Iterable[Watched], range_m: float, t_us: int) -> dict[int, list[int]]:
    """By receiver, ascending ids: who is in radio range of it and sent something lately."""
    placed = sorted((a for a in agents if a.position is not None), key=lambda agent: agent.id)
    if len(placed) < 2:
        return {}
    place = np.array([agent.position for agent in placed])
    reached = Radio(range_m).reaches(place[None, :, :], place[:, None, :])
    recent_us = max(t_us - to_us(RECENT_S), 0)
    reached &= np.array([agent.sent_us >= recent_us for agent in placed])
    np.fill_diagonal(reached, False)
    ids = np.array([agent.id for agent in placed])
    return {agent.id: ids[row].tolist() for agent, row in zip(placed, reached, strict=True)}


def point_of(past: PastPoint) -> Point:
    """A second of the past."""

    def known(number: float | None) -> float:
        return nan if number is None else number

    return Point(
        past.t_us,
        known(past.coverage),
        known(past.entropy),
        known(past.uncertainty),
        past.declared,
        past.found,
        known(past.separation_m),
        past.bytes_sent,
        past.bytes_heard,
        past.frames_sent,
        past.frames_heard,
    )
