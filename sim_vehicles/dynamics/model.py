"""The vehicle model seam: setpoints in, states out, all vehicles at once.

Frame: local ENU metres with the origin at the fleet's home; yaw from east,
counter-clockwise; roll right wing down, pitch nose up (body frame forward,
left, up would give the other signs: these are what people read).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from planners.terrain import Terrain

F64: TypeAlias = npt.NDArray[np.float64]
Bools: TypeAlias = npt.NDArray[np.bool_]


@dataclass(slots=True, eq=False)
class States:
    """What the vehicles do now. Written in place by the model's ``step``."""

    position: F64  # (n, 3) ENU m
    velocity: F64  # (n, 3) ENU m/s, over ground
    roll: F64  # (n,) rad
    pitch: F64  # (n,) rad
    yaw: F64  # (n,) rad
    rates: F64  # (n, 3) rad/s: roll, pitch, yaw
    thrust: F64  # (n,) share of the largest, 0..1
    battery: F64  # (n,) charge left, 0..1
    current: F64  # (n,) A
    voltage: F64  # (n,) V
    on_ground: Bools  # (n,) touches the ground
    ground: F64  # (n,) ENU m: height of the ground under it
    airspeed: F64  # (n,) m/s; NaN where nothing measures it
    endurance: F64  # (n,) capacity of the battery, times that of the model

    @staticmethod
    def at(position: F64, yaw: F64) -> States:
        """At rest with a full battery: position (n, 3), yaw (n,)."""
        n = len(position)
        zero = np.zeros(n)
        return States(
            position=np.array(position, dtype=np.float64),
            velocity=np.zeros((n, 3)),
            roll=zero.copy(),
            pitch=zero.copy(),
            yaw=np.array(yaw, dtype=np.float64),
            rates=np.zeros((n, 3)),
            thrust=zero.copy(),
            battery=np.ones(n),
            current=zero.copy(),
            voltage=np.zeros(n),
            on_ground=np.ones(n, dtype=np.bool_),
            ground=zero.copy(),
            airspeed=np.full(n, np.nan),
            endurance=np.ones(n),
        )


@dataclass(slots=True, eq=False)
class Setpoints:
    """What the autopilots ask for. NaN: this part is not controlled.

    Position and velocity together mean: go to the position with the velocity
    fed forward. ``max_speed``, ``max_up`` and ``max_down`` bound what a position
    error may ask for; model limits hold besides.
    """

    position: F64  # (n, 3) ENU m
    velocity: F64  # (n, 3) ENU m/s
    yaw: F64  # (n,) rad
    yaw_rate: F64  # (n,) rad/s
    max_speed: F64  # (n,) m/s, horizontal
    max_up: F64  # (n,) m/s
    max_down: F64  # (n,) m/s
    motors: Bools  # (n,) spinning; where False the vehicle falls, or rests
    radius: F64  # (n,) m, of circles of those that cannot stop; positive: counter-clockwise
    attitude: F64  # (n, 3) of aircraft: roll, pitch (rad), throttle 0..1; before all else

    @staticmethod
    def idle(n: int) -> Setpoints:
        """Motors off, nothing asked."""
        return Setpoints(
            position=np.full((n, 3), np.nan),
            velocity=np.full((n, 3), np.nan),
            yaw=np.full(n, np.nan),
            yaw_rate=np.full(n, np.nan),
            max_speed=np.full(n, np.inf),
            max_up=np.full(n, np.inf),
            max_down=np.full(n, np.inf),
            motors=np.zeros(n, dtype=np.bool_),
            radius=np.full(n, np.nan),
            attitude=np.full((n, 3), np.nan),
        )


class VehicleModel(Protocol):
    """Dynamics with their inner loops, batched over vehicles."""

    @property
    def states(self) -> States:
        """Current states; the same object for the life of the model."""
        ...

    def step(self, setpoints: Setpoints, wind: F64, dt_s: float) -> None:
        """Advance all vehicles by ``dt_s`` in the wind (n, 3) ENU m/s."""
        ...


class MakeModel(Protocol):
    """Makes the dynamics of n vehicles."""

    def __call__(
        self, position: F64, yaw: F64, /, *, terrain: Terrain | None = None
    ) -> VehicleModel:
        """At rest at position (n, 3) ENU m and yaw (n,) rad; no terrain: level ground at 0."""
        ...
