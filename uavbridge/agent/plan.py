"""What one agent is given before it flies. There are no targets in it."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians

from planners.belief.merge import MergeRule, SensorModel
from planners.planner import Planner
from planners.terrain import Terrain
from planners.types import F64, Scenario
from uavbridge.safety.envelope import Envelope
from uavbridge.safety.filter import Vector

SIMULATED = "simulated"


@dataclass(frozen=True, slots=True, eq=False)
class AgentPlan:
    """Everything fixed about one agent."""

    agent: int
    seed: int
    scenario: Scenario
    planner: Planner
    rule: MergeRule
    sensor: SensorModel
    prior: F64  # (columns, rows)
    envelope: Envelope
    start: Vector  # where its search begins, ENU m
    return_height_m: float
    duration_s: float  # mission time at which it returns by itself
    terrain: Terrain | None = None  # None: level ground
    drives: bool = False  # its vehicle stays on the ground
    climb_rad: float = radians(30.0)  # steepest slope that such a vehicle drives up
    sensing_m: float = 100.0  # how far around its vehicle the planner knows the terrain
    mission_mark: int = 0  # in every frame
    frame_bytes: float = inf  # the most that a frame may have, but for the planner's payload
    keyframe_s: float = inf  # time between two frames that tell all that is known
    resumes: bool = False  # it flew this mission before: a vehicle in the air is its own
    home: Vector | None = None  # where it took off, if it did before; None: at its start
    aloft: bool = False  # the mission begins and ends in the air
    endpoint: str = SIMULATED  # where its vehicle is, for messages
    net: tuple[float, float] | None = None  # s without setpoints, without link: the autopilot's
    ready_timeout_s: float = 60.0  # to be heard, and then to be ready and armed
    retry_s: float = 2.0  # between two tries of what must be done
    silence_s: float = 5.0  # after which a vehicle counts as lost

    @property
    def low_height_m(self) -> float:
        """Below it only take-offs and landings happen: half the band's lower end."""
        return max(2.5, self.envelope.altitude_min_m / 2)


def return_heights(team: int, envelope: Envelope, clearance_m: float) -> list[float]:
    """A height (m) for each of the team to fly home at, as many different ones as fit the band.

    Neighbouring ids get different heights, ``clearance_m`` apart; where the band
    has fewer of them than the team has members they are used again, and the
    safety filter keeps those apart.
    """
    low, high = envelope.altitude_min_m, envelope.altitude_max_m
    layers = max(1, int((high - low) / clearance_m) + 1)
    return [low + (k % layers) * clearance_m for k in range(team)]
