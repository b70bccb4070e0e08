"""A fleet of simulated vehicles: time and datagrams in, datagrams out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Final

import numpy as np

from sim_vehicles.autopilot import Autopilot
from sim_vehicles.codec import Counts, decode
from sim_vehicles.dynamics import F64, MODELS, Bools, States, Wind, WindSpec
from sim_vehicles.flavour import PX4
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.modes import MODES, Mode
from sim_vehicles.params import Parameters
from sim_vehicles.protocol.endpoint import Endpoint, Services
from sim_vehicles.protocol.services import HANDLERS, go_on
from sim_vehicles.report import Report
from sim_vehicles.status import Said
from sim_vehicles.telemetry import Telemetry

_TICK_S: Final = 0.1  # of the autopilots' navigation and timers
_LONGEST: Final = 1400  # bytes of a datagram made of several
_WIND_STREAM: Final = 1


@dataclass(frozen=True, slots=True)
class VehicleSpec:
    """One vehicle as it is before it is switched on.

    Attributes:
        system: MAVLink system id, 1..255.
        start: ENU m, on the ground: home, and zero of the vehicle's own local frame.
        yaw_rad: from east, counter-clockwise.
        kind: what it is; "multirotor".
        in_air_m: it starts armed, holding at this height above ``start``; None: on the ground.
    """

    system: int
    start: tuple[float, float, float]
    yaw_rad: float = pi / 2
    kind: str = "multirotor"
    in_air_m: float | None = None


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

    Args:
        specs: the vehicles.
        origin: where the fleet frame (ENU) is zero.
        model: name of the vehicle model, of ``sim_vehicles.dynamics.MODELS``.
        seed: of gusts and of start-up times.
        wind: None: calm.
        step_s: of the dynamics.
        parameters: of the autopilots, other than the defaults.

    Raises:
        ValueError: no such model, kind or parameter, or a start in the air without ``in_air_m``.
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
    ) -> None:
        if model not in MODELS:
            raise ValueError(f"model must be one of {', '.join(sorted(MODELS))}, not {model}")
        _check(specs)
        self.specs = tuple(specs)
        self.systems = tuple(spec.system for spec in specs)
        self.now_us = 0
        n = len(self.specs)
        starts = np.array([spec.start for spec in specs], dtype=np.float64).reshape(n, 3)
        heights = np.array([spec.in_air_m or 0.0 for spec in specs])
        place = starts + heights[:, np.newaxis] * (0.0, 0.0, 1.0)
        self._model = MODELS[model](place, np.array([spec.yaw_rad for spec in specs]))
        rng = np.random.default_rng((seed, _WIND_STREAM))
        self._wind = Wind(wind or WindSpec(), n, rng)
        self._step_us = round(step_s * 1e6)
        self._step_s = self._step_us * 1e-6
        self._tick_us = max(round(_TICK_S * 1e6) // self._step_us, 1) * self._step_us

        table = Parameters(PX4.table, n, parameters)
        for i, system in enumerate(self.systems):
            table.set(i, "MAV_SYS_ID", system)
        self.pilot = Autopilot(
            self.systems,
            self._model.states,
            table,
            starts=starts,
            flying=np.array([spec.in_air_m is not None for spec in specs], dtype=np.bool_),
            seed=seed,
            altitude_m=origin.altitude_m,
        )
        self._telemetry = Telemetry(self.systems, origin, starts)
        self.pilot.status.home = self._telemetry.homes  # one array: telemetry tells of it
        self._report = Report(self.pilot, PX4)
        services = Services(self.pilot, self._telemetry, self._report, PX4, origin)
        self._endpoints = tuple(
            Endpoint(i, services, encoder) for i, encoder in enumerate(self._telemetry.encoders)
        )
        self._busy: set[int] = set()
        self._fresh: set[int] = set()  # who has something to send
        self._stale = False  # what was asked for may have changed what telemetry reports
        self.counts = tuple(Counts() for _ in specs)

    @property
    def states(self) -> States:
        """The truth, live: fleet frame, one vehicle a row."""
        return self._model.states

    def advance(self, until_us: int) -> None:
        """Let time pass, in whole steps, as far as ``until_us`` allows."""
        step_us, step_s = self._step_us, self._step_s
        pilot, telemetry, snapshot = self.pilot, self._telemetry, self._report.snapshot
        setpoints = pilot.setpoints
        pilot.legs.heed()
        if self._stale:
            self._stale = False
            self._report.update()
        while self.now_us + step_us <= until_us:
            self._model.step(setpoints, self._wind.step(step_s), step_s)
            self.now_us += step_us
            pilot.now_us = self.now_us
            if self.now_us % self._tick_us == 0:
                self._tick()
            for i, datagram in telemetry.build(self.now_us, snapshot):
                self._endpoints[i].out.append(datagram)
                self._fresh.add(i)

    def _tick(self) -> None:
        self.pilot.tick(self.now_us)
        self._report.update()
        self._tell()
        for i in sorted(self._busy):
            go_on(self._endpoints[i])
            self._fresh.add(i)
            if not self._endpoints[i].busy:
                self._busy.discard(i)

    def _tell(self) -> None:
        for news in self.pilot.told():
            endpoint = self._endpoints[news.vehicle]
            if isinstance(news, Said):
                endpoint.say(news.severity, news.text)
            else:
                endpoint.send("MISSION_ITEM_REACHED", seq=news.step)
                self._report.plan(news.vehicle)
            self._fresh.add(news.vehicle)

    def receive(self, index: int, datagram: bytes) -> None:
        """A datagram came in at vehicle ``index``'s own socket; it acts on it at once."""
        packets = decode(datagram, self.counts[index])
        if not packets:
            return
        endpoint = self._endpoints[index]
        for packet in packets:
            endpoint.handle(packet, HANDLERS)
        if self.pilot.status.told:
            self._tell()
        if endpoint.busy:
            self._busy.add(index)
        if endpoint.out:
            self._fresh.add(index)
            self._stale = True

    def transmit(self) -> list[tuple[int, bytes]]:
        """Datagrams (vehicle index, bytes) due since the last call, each vehicle's in order."""
        datagrams: list[tuple[int, bytes]] = []
        for i in sorted(self._fresh):
            out = self._endpoints[i].out
            if len(out) == 1:
                datagrams.append((i, out[0]))
            else:
                datagrams.extend((i, datagram) for datagram in _joined(out))
            out.clear()
        self._fresh.clear()
        return datagrams

    def truth(self) -> Truth:
        """What is really so, for a simulated world to work on."""
        states, status = self._model.states, self.pilot.status
        return Truth(
            t_us=self.now_us,
            systems=self.systems,
            position=states.position.copy(),
            velocity=states.velocity.copy(),
            armed=status.armed.copy(),
            in_air=~states.on_ground,
            modes=tuple(MODES[Mode(mode)].name for mode in status.mode.tolist()),
        )


def _check(specs: Sequence[VehicleSpec]) -> None:
    if not specs:
        raise ValueError("a fleet needs a vehicle")
    for spec in specs:
        if spec.kind != "multirotor":
            raise ValueError(f"vehicle {spec.system}: there is no kind {spec.kind}")
        if spec.in_air_m is None and spec.start[2] > 0:
            raise ValueError(f"vehicle {spec.system} starts {spec.start[2]} m above the ground")
        if spec.in_air_m is not None and not spec.in_air_m > 0:
            raise ValueError(f"vehicle {spec.system}: in_air_m must be positive")


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
