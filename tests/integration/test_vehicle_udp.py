"""Vehicles of the simulator in another process, over real sockets."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from sim_vehicles.geodesy import Geodetic
from uavbridge.clock import PacedClock
from uavbridge.mavlink.hub import Hub
from uavbridge.mavlink.udp import UdpGate, UdpLink
from uavbridge.mavlink.urls import open_link
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Done,
    Follow,
    LandHere,
    Refused,
    SetPosition,
    TakeOff,
    VehicleEvent,
)
from uavbridge.vehicle.mavlink import MavlinkVehicle

pytestmark = pytest.mark.integration
LOCALHOST = "127.0.0.1"
HOME = Geodetic(47.397742, 8.545594, 488.0)
SPEED = 10.0
TICK_US = 50_000


@contextmanager
def simulator(*options: str) -> Iterator[None]:
    """``python -m sim_vehicles`` until the block ends."""
    command = [sys.executable, "-m", "sim_vehicles", "--json", "--speed", str(SPEED)]
    command += ["--start-system", "1", "--duration", "1000", *options]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait(10)


class Bridge:
    """Some vehicles on one clock."""

    def __init__(self, *vehicles: MavlinkVehicle) -> None:
        self.vehicles = vehicles
        self.clock = PacedClock(SPEED)
        self.t_us = 0
        self.events: list[tuple[int, VehicleEvent]] = []

    def step(self) -> None:
        self.t_us = max(self.t_us + TICK_US, self.clock.now_us())
        self.clock.wait_until(self.t_us)
        for vehicle in self.vehicles:
            self.events += [(vehicle.system, event) for event in vehicle.advance(self.t_us)]

    def until(self, condition: Callable[[], bool], limit_s: float = 200.0) -> None:
        end_us = self.t_us + limit_s * 1e6
        while not condition():
            states = [vehicle.state for vehicle in self.vehicles]
            assert self.t_us < end_us, f"not in time: {states}, {self.events}"
            self.step()

    def ready(self) -> None:
        self.until(lambda: all(not vehicle.state.waiting_for for vehicle in self.vehicles))

    def do(self, command: Command) -> None:
        """All vehicles at once, each with its result."""
        seen = len(self.events)
        for vehicle in self.vehicles:
            vehicle.do(command, self.t_us)

        def results() -> list[tuple[int, VehicleEvent]]:
            return [(s, e) for s, e in self.events[seen:] if isinstance(e, Done | Refused)]

        self.until(lambda: len(results()) == len(self.vehicles))
        wanted = [(vehicle.system, Done(command)) for vehicle in self.vehicles]
        assert sorted(results(), key=lambda pair: pair[0]) == wanted


def test_a_flight_over_udp() -> None:
    link = UdpLink.bind(LOCALHOST, 0)
    vehicle = MavlinkVehicle(link, 1, origin=HOME)
    with simulator("--port", str(link.port)):
        bridge = Bridge(vehicle)
        bridge.ready()
        bridge.do(Arm())
        bridge.do(TakeOff(6.0))
        bridge.until(lambda: vehicle.state.position[2] > 5.5)
        bridge.do(Follow())
        goal = vehicle.state.position + np.array([8.0, -6.0, 2.0])

        def there() -> bool:
            vehicle.do(SetPosition(goal), bridge.t_us)
            return bool(np.linalg.norm(vehicle.state.position - goal) < 0.5)

        bridge.until(there)
        bridge.do(LandHere())
        bridge.until(lambda: not vehicle.state.armed)
        assert not vehicle.state.in_air
        assert vehicle.counts.garbage == 0
        assert link.peer.rivals == frozenset()
    bridge.until(lambda: not vehicle.state.link_ok)
    vehicle.close()


def test_three_vehicles_on_one_port() -> None:
    hub = Hub(UdpGate(LOCALHOST, 0), "here")
    vehicles = [MavlinkVehicle(hub.channel(system), system, origin=HOME) for system in (1, 2, 3)]
    with simulator("--count", "3", "--ports", "shared", "--port", str(hub.port)):
        bridge = Bridge(*vehicles)
        bridge.ready()
        bridge.do(Arm())
        assert all(vehicle.state.armed for vehicle in vehicles)
        assert sum(vehicle.strangers for vehicle in vehicles) == 0
        places = np.array([vehicle.state.position for vehicle in vehicles])
        apart = np.linalg.norm(places[:, np.newaxis] - places, axis=2)[np.triu_indices(3, 1)]
        assert apart.min() == pytest.approx(10.0, abs=0.5)
    hub.close()


def test_a_vehicle_over_tcp_that_starts_after_us() -> None:
    with socket.create_server((LOCALHOST, 0)) as free:
        port = free.getsockname()[1]
    vehicle = MavlinkVehicle(open_link(f"tcp:{LOCALHOST}:{port}"), 1, origin=HOME)
    bridge = Bridge(vehicle)
    bridge.step()
    assert vehicle.state.waiting_for == ("no heartbeat yet",)
    with simulator("--tcp", "--port", str(port)):
        bridge.ready()
        bridge.do(Arm())
    vehicle.close()
