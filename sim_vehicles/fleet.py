"""A fleet of simulated vehicles: time and datagrams in, datagrams out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import chain
from math import inf
from typing import Final

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.autopilot import Autopilot
from sim_vehicles.codec import Counts
from sim_vehicles.crafts import AUTOPILOTS, CRAFTS, KINDS, MODEL_NAMES
from sim_vehicles.dynamics import F64, Bools, States, Wind, WindSpec
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.squad import Squad, Surroundings, VehicleSpec

__all__ = ["Fleet", "Truth", "VehicleSpec"]

_WIND_STREAM: Final = 1


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """What the vehicles really do; arrays are copies."""

    t_us: int
    systems: tuple[int, ...]
    position: F64  # (n, 3) ENU m
    velocity: F64  # (n, 3) ENU m/s
    armed: Bools  # (n,)
    in_air: Bools  # (n,)
    modes: tuple[str, ...]  # the autopilots' names


class Fleet:
    """Vehicles, their autopilots and their MAVLink sides, all on simulated time.

    Vehicles of one kind and autopilot are one batch, a ``Squad``.

    Args:
        specs: the vehicles.
        origin: where the fleet frame (ENU) is zero.
        model: name of the vehicle model, of ``MODEL_NAMES``; kinds that do not have it take
            their usual one.
        seed: of gusts and of start-up times.
        wind: None: calm.
        step_s: of the dynamics.
        parameters: of the autopilots, other than the defaults; each takes those it has.
        terrain: the ground; None: level, at height 0.
        endurance: capacity of the batteries, times that of the model.

    Raises:
        ValueError: no such model, kind or parameter, a start in the air without ``in_air_m``, or
            batteries of no capacity.
    """

    def __init__(
        self,
        specs: Sequence[VehicleSpec],
        *,
        origin: Geodetic,
        model: str = "multirotor",
        seed: int = 0,
        wind: WindSpec | None = None,
        step_s: float = 0.02,
        parameters: Mapping[str, float] | None = None,
        terrain: Terrain | None = None,
        endurance: float = 1.0,
    ) -> None:
        if not 0.0 < endurance < inf:
            raise ValueError(f"endurance must be a positive number, not {endurance}")
        if model not in MODEL_NAMES:
            raise ValueError(f"model must be one of {', '.join(MODEL_NAMES)}, not {model}")
        _check(specs, terrain)
        self.specs = tuple(specs)
        self.systems = tuple(spec.system for spec in specs)
        around = Surroundings(origin, model, seed, step_s, parameters or {}, terrain, endurance)
        rows: dict[tuple[str, str], list[int]] = {}
        for index, spec in enumerate(specs):
            rows.setdefault((spec.autopilot, spec.kind), []).append(index)
        self.squads = tuple(
            Squad(
                CRAFTS[which],
                [specs[index] for index in members],
                around,
                Wind(wind or WindSpec(), len(members), _gusts(seed, number)),
            )
            for number, (which, members) in enumerate(rows.items())
        )
        for name in parameters or {}:
            if not any(name in squad.pilot.parameters for squad in self.squads):
                raise ValueError(f"the autopilot has no parameter {name}")
        self._rows = tuple(rows.values())  # of each squad
        seats = {
            index: (squad, row)
            for squad, members in zip(self.squads, self._rows, strict=True)
            for row, index in enumerate(members)
        }
        self._seats = tuple(seats[index] for index in range(len(specs)))
        self.counts: tuple[Counts, ...] = tuple(squad.counts[row] for squad, row in self._seats)
        self._only = self.squads[0] if len(self.squads) == 1 else None
        self._states = self.squads[0].states
        if self._only is None:
            self._states = States.at(np.zeros((len(specs), 3)), np.zeros(len(specs)))

    @property
    def now_us(self) -> int:
        """Simulated time."""
        return self.squads[0].now_us

    @property
    def pilot(self) -> Autopilot:
        """The autopilots of a fleet that is all of one kind.

        Raises:
            ValueError: it is of several kinds: ask ``seat``.
        """
        if self._only is None:
            raise ValueError("a mixed fleet has several autopilots")
        return self._only.pilot

    @property
    def states(self) -> States:
        """The truth, in the fleet frame, one vehicle a row.

        Live where all are of one kind: the model's own arrays. Of a mixed fleet it is
        what was true when asked for, in arrays that the next call writes to again.
        """
        if self._only is None:
            for squad, rows in zip(self.squads, self._rows, strict=True):
                for each in fields(States):
                    getattr(self._states, each.name)[rows] = getattr(squad.states, each.name)
        return self._states

    def seat(self, index: int) -> tuple[Squad, int]:
        """The squad of vehicle ``index``, and its row there."""
        return self._seats[index]

    def advance(self, until_us: int) -> None:
        """Let time pass, in whole steps, as far as ``until_us`` allows."""
        for squad in self.squads:
            squad.advance(until_us)

    def receive(self, index: int, datagram: bytes) -> None:
        """A datagram came in at vehicle ``index``'s own socket; it acts on it at once."""
        squad, row = self._seats[index]
        squad.receive(row, datagram)

    def transmit(self) -> list[tuple[int, bytes]]:
        """Datagrams (vehicle index, bytes) due since the last call, each vehicle's in order."""
        if self._only is not None:
            return self._only.transmit()
        return [
            (rows[row], datagram)
            for squad, rows in zip(self.squads, self._rows, strict=True)
            for row, datagram in squad.transmit()
        ]

    def truth(self) -> Truth:
        """What is really so, for a simulated world to work on."""
        states = self.states
        armed = np.zeros(len(self.specs), dtype=np.bool_)
        names = [squad.mode_names for squad in self.squads]
        modes = dict(zip(chain(*self._rows), chain(*names), strict=True))
        for squad, rows in zip(self.squads, self._rows, strict=True):
            armed[rows] = squad.pilot.status.armed
        return Truth(
            t_us=self.now_us,
            systems=self.systems,
            position=states.position.copy(),
            velocity=states.velocity.copy(),
            armed=armed,
            in_air=~states.on_ground,
            modes=tuple(modes[index] for index in range(len(self.specs))),
        )


def _gusts(seed: int, number: int) -> np.random.Generator:
    """The gusts of one squad."""
    return np.random.default_rng((seed, _WIND_STREAM, number) if number else (seed, _WIND_STREAM))


def _check(specs: Sequence[VehicleSpec], terrain: Terrain | None) -> None:
    if not specs:
        raise ValueError("a fleet needs a vehicle")
    for spec in specs:
        if spec.kind not in KINDS:
            raise ValueError(f"vehicle {spec.system}: there is no kind {spec.kind}")
        if spec.autopilot not in AUTOPILOTS:
            raise ValueError(f"vehicle {spec.system}: there is no autopilot {spec.autopilot}")
        if (spec.autopilot, spec.kind) not in CRAFTS:
            raise ValueError(
                f"vehicle {spec.system}: there is no {spec.kind} with {spec.autopilot}"
            )
        if spec.in_air_m is None and terrain is None and spec.start[2] > 0:
            raise ValueError(f"vehicle {spec.system} starts {spec.start[2]} m above the ground")
        if spec.in_air_m is not None and not spec.in_air_m > 0:
            raise ValueError(f"vehicle {spec.system}: in_air_m must be positive")
        if spec.in_air_m is not None and spec.kind == "rover":
            raise ValueError(f"vehicle {spec.system}: a rover does not start in the air")
