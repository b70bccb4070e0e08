"""Vehicles of one craft: their dynamics, autopilots and MAVLink sides, batched."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Final

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.ardupilot.pilot import ArduPilot
from sim_vehicles.ardupilot.plane import ArduPlane
from sim_vehicles.autopilot import Autopilot
from sim_vehicles.codec import Counts, decode
from sim_vehicles.craft import Craft
from sim_vehicles.dynamics import F64, States, Wind
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.modes import Mode
from sim_vehicles.params import Parameters
from sim_vehicles.protocol import requests
from sim_vehicles.protocol.endpoint import Endpoint, Services
from sim_vehicles.protocol.services import HANDLERS, go_on
from sim_vehicles.report import Report
from sim_vehicles.status import Said, Shown
from sim_vehicles.telemetry import Telemetry
from sim_vehicles.winged.pilot import Px4Plane

_TICK_S: Final = 0.1  # of the autopilots' navigation and timers
_LONGEST: Final = 1400  # bytes of a datagram made of several
PILOTS: Final[Mapping[tuple[str, str], type[Autopilot]]] = {
    ("px4", "multirotor"): Autopilot,
    ("px4", "rover"): Autopilot,
    ("px4", "plane"): Px4Plane,
    ("ardupilot", "multirotor"): ArduPilot,
    ("ardupilot", "rover"): ArduPilot,
    ("ardupilot", "plane"): ArduPlane,
}


@dataclass(frozen=True, slots=True)
class VehicleSpec:
    """One vehicle as it is before it is switched on.

    Attributes:
        system: MAVLink system id, 1..255.
        start: ENU m, on the ground: home, and zero of the vehicle's own local frame. Over
            terrain its height is the terrain's, whatever is said here.
        yaw_rad: from east, counter-clockwise.
        kind: what it is: "multirotor", "rover" or "plane".
        in_air_m: it starts armed, holding at this height above ``start``; None: on the ground.
        autopilot: which make it speaks as: "px4" or "ardupilot".
    """

    system: int
    start: tuple[float, float, float]
    yaw_rad: float = pi / 2
    kind: str = "multirotor"
    in_air_m: float | None = None
    autopilot: str = "px4"


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What the vehicles of a fleet have in common.

    Attributes:
        origin: where the fleet frame (ENU) is zero.
        model: name of the vehicle model, where the craft has it.
        seed: of start-up times.
        step_s: of the dynamics.
        parameters: of the autopilots, other than the defaults.
        terrain: the ground; None: level, at height 0.
        endurance: capacity of the batteries, times that of the model.
    """

    origin: Geodetic
    model: str
    seed: int
    step_s: float
    parameters: Mapping[str, float]
    terrain: Terrain | None
    endurance: float


class Squad:
    """Vehicles of one craft on simulated time; rows as in ``specs``.

    Args:
        craft: what they are.
        specs: the vehicles.
        around: what they share with the rest of the fleet.
        wind: at each of them.

    Raises:
        ValueError: a parameter is unknown or out of range.
    """

    def __init__(
        self, craft: Craft, specs: Sequence[VehicleSpec], around: Surroundings, wind: Wind
    ) -> None:
        self.craft = craft
        self.systems = tuple(spec.system for spec in specs)
        self.now_us = 0
        n = len(specs)
        starts = _starts(specs, around.terrain)
        heights = np.array([spec.in_air_m or 0.0 for spec in specs])
        place = starts + heights[:, np.newaxis] * (0.0, 0.0, 1.0)
        make = craft.models.get(around.model) or next(iter(craft.models.values()))
        yaw = np.array([spec.yaw_rad for spec in specs])
        self._model = make(place, yaw, terrain=around.terrain)
        self._model.states.endurance[:] = around.endurance
        self._wind = wind
        self._step_us = round(around.step_s * 1e6)
        self._step_s = self._step_us * 1e-6
        self._tick_us = max(round(_TICK_S * 1e6) // self._step_us, 1) * self._step_us

        table = Parameters(craft.parameters, n, hidden=craft.hidden, derive=craft.derive)
        table.override(around.parameters)
        for i, system in enumerate(self.systems):
            table.set(i, craft.flavour.id_parameter, system)
        self.pilot = PILOTS[craft.autopilot, craft.kind](
            craft,
            self.systems,
            self._model.states,
            table,
            starts=starts,
            flying=np.array([spec.in_air_m is not None for spec in specs], dtype=np.bool_),
            seed=around.seed,
            altitude_m=around.origin.altitude_m,
        )
        face = craft.flavour
        self.telemetry = Telemetry(
            self.systems, around.origin, starts, fills=face.fills, intervals_us=face.intervals_us
        )
        self.pilot.status.home = self.telemetry.homes  # one array: telemetry tells of it
        self.report = Report(self.pilot)
        services = Services(self.pilot, self.telemetry, self.report, around.origin)
        self.endpoints = tuple(
            Endpoint(i, services, encoder) for i, encoder in enumerate(self.telemetry.encoders)
        )
        for stream, (name, _) in face.data_streams.items():
            for i in table.column(name).nonzero()[0].tolist():
                requests.set_group(self.endpoints[i], stream)
        self._busy: set[int] = set()
        self._fresh: set[int] = set()  # who has something to send
        self._stale = False  # what was asked for may have changed what telemetry reports
        self.counts = tuple(Counts() for _ in specs)

    @property
    def states(self) -> States:
        """The truth, live: fleet frame, one vehicle a row."""
        return self._model.states

    @property
    def mode_names(self) -> tuple[str, ...]:
        """(n,) as the autopilots call them."""
        modes = self.craft.modes
        return tuple(modes[Mode(mode)].name for mode in self.pilot.status.mode.tolist())

    def advance(self, until_us: int) -> None:
        """Let time pass, in whole steps, as far as ``until_us`` allows."""
        step_us, step_s = self._step_us, self._step_s
        pilot, telemetry, snapshot = self.pilot, self.telemetry, self.report.snapshot
        setpoints = pilot.setpoints
        pilot.legs.heed()
        if self._stale:
            self._stale = False
            self.report.update()
        while self.now_us + step_us <= until_us:
            self._model.step(setpoints, self._wind.step(step_s), step_s)
            self.now_us += step_us
            pilot.now_us = self.now_us
            if self.now_us % self._tick_us == 0:
                self._tick()
            for i, datagram in telemetry.build(self.now_us, snapshot):
                self.endpoints[i].out.append(datagram)
                self._fresh.add(i)

    def _tick(self) -> None:
        self.pilot.tick(self.now_us)
        self.report.update()
        self._tell()
        for i in sorted(self._busy):
            go_on(self.endpoints[i])
            self._fresh.add(i)
            if not self.endpoints[i].busy:
                self._busy.discard(i)

    def _tell(self) -> None:
        for news in self.pilot.told():
            endpoint = self.endpoints[news.vehicle]
            if isinstance(news, Said):
                endpoint.say(news.severity, news.text)
            elif isinstance(news, Shown):
                endpoint.show(news.message)
            else:
                endpoint.send("MISSION_ITEM_REACHED", seq=news.step)
                self.report.plan(news.vehicle)
            self._fresh.add(news.vehicle)

    def receive(self, row: int, datagram: bytes) -> None:
        """A datagram came in at the socket of the vehicle of ``row``; it acts on it at once."""
        packets = decode(datagram, self.counts[row])
        if not packets:
            return
        endpoint = self.endpoints[row]
        for packet in packets:
            endpoint.handle(packet, HANDLERS)
        if self.pilot.status.told:
            self._tell()
        if endpoint.busy:
            self._busy.add(row)
        if endpoint.out:
            self._fresh.add(row)
            self._stale = True

    def transmit(self) -> list[tuple[int, bytes]]:
        """Datagrams (row, bytes) due since the last call, each vehicle's in order."""
        datagrams: list[tuple[int, bytes]] = []
        for i in sorted(self._fresh):
            out = self.endpoints[i].out
            if len(out) == 1:
                datagrams.append((i, out[0]))
            else:
                datagrams.extend((i, datagram) for datagram in _joined(out))
            out.clear()
        self._fresh.clear()
        return datagrams


def _starts(specs: Sequence[VehicleSpec], terrain: Terrain | None) -> F64:
    """(n, 3) ENU m, on the terrain."""
    starts = np.array([spec.start for spec in specs], dtype=np.float64).reshape(len(specs), 3)
    if terrain is not None:
        starts[:, 2] = terrain.height_at(starts)
    return starts


def _joined(frames: list[bytes]) -> list[bytes]:
    """Frames in as few datagrams as their length allows."""
    joined: list[bytes] = []
    start, size = 0, 0
    for at, frame in enumerate(frames):
        if size and size + len(frame) > _LONGEST:
            joined.append(b"".join(frames[start:at]))
            start, size = at, 0
        size += len(frame)
    if size:
        joined.append(b"".join(frames[start:]))
    return joined
