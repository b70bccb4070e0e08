from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic

ORIGIN = Geodetic(47.397742, 8.545594, 489.4)
OFFBOARD, AUTO = (6.0, 0.0), 4.0


class Station:
    """A ground station in memory, speaking pymavlink to one vehicle of a fleet."""

    def __init__(self, fleet: Fleet, index: int = 0, *, component: int = 190) -> None:
        self.fleet, self.index = fleet, index
        self.system = fleet.systems[index]
        self.mav = mavlink.MAVLink(None, 255, component)
        self.received: list[Any] = []
        self.stream: Callable[[], None] | None = None  # called every 0.1 s while flying
        self.drop: Callable[[], bool] = lambda: False  # whether a datagram from the vehicle is lost

    def send(self, message: Any) -> None:
        self.fleet.receive(self.index, message.pack(self.mav))

    def collect(self) -> list[Any]:
        """Messages that came since the last call; all of them stay in ``received``."""
        fresh: list[Any] = []
        for index, datagram in self.fleet.transmit():
            if index != self.index or self.drop():
                continue
            parser = mavlink.MAVLink(None)
            fresh.extend(parser.parse_buffer(datagram) or [])
        assert not [each for each in fresh if each.get_type() == "BAD_DATA"]
        self.received.extend(fresh)
        return fresh

    def fly(self, seconds: float, until: Callable[[], bool] | None = None) -> float:
        """Let time pass; returns how long it took until ``until`` came true."""
        begin = self.fleet.now_us
        while self.fleet.now_us - begin < seconds * 1e6 - 1:
            if self.stream is not None:
                self.stream()
            self.fleet.advance(self.fleet.now_us + 100_000)
            self.collect()
            if until is not None and until():
                return (self.fleet.now_us - begin) / 1e6
        assert until is None, f"not so within {seconds} s: {self.texts[-5:]}, {self.mode}"
        return seconds

    def command(self, command: int, *params: float) -> int:
        """Send a COMMAND_LONG; the result in its acknowledgement."""
        seven = [*params, *[0.0] * (7 - len(params))]
        self.send(
            mavlink.MAVLink_command_long_message(self.system, 1, command, 0, *map(float, seven))
        )
        return self.acknowledged(command)

    def command_int(self, command: int, *params: float, frame: int = 0, **place: Any) -> int:
        four = [*params, *[0.0] * (4 - len(params))]
        self.send(
            mavlink.MAVLink_command_int_message(
                self.system, 1, frame, command, 0, 0, *map(float, four), **place
            )
        )
        return self.acknowledged(command)

    def acknowledged(self, command: int) -> int:
        acks = [each for each in self.collect() if each.get_type() == "COMMAND_ACK"]
        assert len(acks) == 1
        assert acks[0].command == command
        assert (acks[0].target_system, acks[0].target_component) == (255, self.mav.srcComponent)
        return int(acks[0].result)

    def newest(self, name: str) -> Any:
        return next((each for each in reversed(self.received) if each.get_type() == name), None)

    def all(self, name: str) -> list[Any]:
        return [each for each in self.received if each.get_type() == name]

    @property
    def texts(self) -> list[str]:
        """STATUSTEXTs, chunks joined."""
        texts: list[str] = []
        for each in self.all("STATUSTEXT"):
            if each.chunk_seq:
                texts[-1] += each.text
            else:
                texts.append(each.text)
        return texts

    def param(self, name: str, value: float) -> None:
        self.fleet.pilot.parameters.set(self.index, name, value)

    # -- shortcuts ----------------------------------------------------------------

    def mode_to(self, main: float, sub: float = 0.0) -> int:
        return self.command(mavlink.MAV_CMD_DO_SET_MODE, 1, main, sub)

    def arm(self) -> int:
        return self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)

    def disarm(self) -> int:
        return self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)

    def get_ready(self) -> None:
        """Skip the wait for the position estimate."""
        self.fleet.pilot.status.ready_us[:] = 0
        self.fly(0.1)

    def setpoint(
        self,
        position: tuple[float, float, float] | None = None,
        velocity: tuple[float, float, float] | None = None,
        *,
        frame: int = mavlink.MAV_FRAME_LOCAL_NED,
        yaw: float | None = None,
    ) -> None:
        mask = 0x1C0 | 0x800 | (0 if position else 7) | (0 if velocity else 0x38)
        mask |= 0x400 if yaw is None else 0
        self.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                0, self.system, 1, frame, mask,
                *(position or (0, 0, 0)), *(velocity or (0, 0, 0)), 0, 0, 0, yaw or 0.0, 0.0,
            )
        )  # fmt: skip

    @property
    def position(self) -> np.ndarray:
        return self.fleet.states.position[self.index]

    @property
    def velocity(self) -> np.ndarray:
        return self.fleet.states.velocity[self.index]

    @property
    def mode(self) -> str:
        return self.fleet.truth().modes[self.index]

    @property
    def armed(self) -> bool:
        return bool(self.fleet.truth().armed[self.index])


@pytest.fixture
def station() -> Callable[..., Station]:
    """Makes a station with a fleet of one (or ``count``) behind it."""

    def make(
        *,
        model: str = "perfect",
        count: int = 1,
        in_air_m: float | None = None,
        kind: str = "multirotor",
        autopilot: str = "px4",
        **options: Any,
    ) -> Station:
        specs = [
            VehicleSpec(
                i + 1, (10.0 * i, 0.0, 0.0), kind=kind, in_air_m=in_air_m, autopilot=autopilot
            )
            for i in range(count)
        ]
        return Station(Fleet(specs, origin=ORIGIN, model=model, **options))

    return make
