"""One contract for every way to a vehicle: in process, and over MAVLink with all its troubles.

The far side is the simulator. Heights, places and times are checked against its truth.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from planners.types import F64
from sim_vehicles.codec import Encoder, mav
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic, to_enu, to_geodetic
from uavbridge.mavlink.link import Link, memory_pair
from uavbridge.mavlink.middleware import LossyLink
from uavbridge.rng import stream
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Disarm,
    Done,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    Refused,
    ReturnHome,
    Said,
    SetPosition,
    SetVelocity,
    TakeOff,
    Vehicle,
    VehicleEvent,
)
from uavbridge.vehicle.direct import DirectVehicle
from uavbridge.vehicle.mavlink import MavlinkVehicle

ORIGIN = Geodetic(47.397742, 8.545594, 488.0)
START = (420.0, -310.0, 0.0)  # far from the mission's origin
TICK_US = 50_000


class Crossed:
    """Doubles and reorders what comes from the far side."""

    def __init__(self, link: Link, seed: int) -> None:
        self._link, self._rng = link, stream(seed, "crossed")
        self._late: list[bytes] = []

    def send(self, data: bytes) -> None:
        self._link.send(data)
        if self._rng.random() < 0.3:
            self._link.send(data)

    def receive(self) -> list[bytes]:
        heard, self._late = self._late, []
        for data in self._link.receive():
            heard += [data] * (1 + (self._rng.random() < 0.3))
        if heard and self._rng.random() < 0.3:
            self._late = [heard.pop(0)]
        order = self._rng.permutation(len(heard))
        return [heard[place] for place in order]

    def close(self) -> None:
        self._link.close()


class Noisy:
    """Adds garbage to what comes, cuts it short, flips its bits, both ways."""

    def __init__(self, link: Link, seed: int) -> None:
        self._link, self._rng = link, stream(seed, "noisy")

    def _spoiled(self, data: bytes) -> list[bytes]:
        drawn = self._rng.random()
        if drawn < 0.1:
            return [data[: len(data) // 2]]
        if drawn < 0.2:
            return [self._rng.bytes(40), data]
        if drawn < 0.3:
            broken = bytearray(data)
            broken[int(self._rng.integers(len(data)))] ^= 0x55
            return [bytes(broken)]
        if drawn < 0.4:
            return [self._rng.bytes(7) + data + b"\xfd\xff"]
        return [data]

    def send(self, data: bytes) -> None:
        for spoiled in self._spoiled(data):
            self._link.send(spoiled)

    def receive(self) -> list[bytes]:
        return [spoiled for data in self._link.receive() for spoiled in self._spoiled(data)]

    def close(self) -> None:
        self._link.close()


class Flight:
    """A vehicle of the simulator, the way to it, and time."""

    def __init__(self, kind: str, *, start: tuple[float, float, float] = START) -> None:
        self.fleet = Fleet([VehicleSpec(7, start)], origin=ORIGIN, model="perfect", step_s=0.05)
        near, self.far = memory_pair()
        self.near: Link = near
        wrap: dict[str, Callable[[], Link]] = {
            "mavlink": lambda: near,
            "lossy": lambda: LossyLink(near, 0.3, stream(3, "loss")),
            "crossed": lambda: Crossed(near, 4),
            "noisy": lambda: Noisy(near, 5),
        }
        self.vehicle: Vehicle
        if kind == "direct":
            self.vehicle = DirectVehicle(self.fleet, 0)
        else:
            self.vehicle = MavlinkVehicle(wrap[kind](), 7, origin=ORIGIN)
        self.cut = False
        self.t_us = 0
        self.events: list[VehicleEvent] = []

    @property
    def truth(self) -> F64:
        """Where it really is: (3,) ENU m."""
        return self.fleet.states.position[0]

    def step(self) -> None:
        self.t_us += TICK_US
        self.fleet.advance(self.t_us)
        for _, datagram in self.fleet.transmit():
            if not self.cut:
                self.far.send(datagram)
        self.events += self.vehicle.advance(self.t_us)
        for datagram in self.far.receive():
            if not self.cut:
                self.fleet.receive(0, datagram)

    def run(self, duration_s: float, *repeated: Command) -> None:
        """Let time pass; setpoints are given anew at 10 Hz."""
        for tick in range(round(duration_s * 1e6) // TICK_US):
            if tick % 2 == 0:
                for command in repeated:
                    self.vehicle.do(command, self.t_us)
            self.step()

    def until(self, condition: Callable[[], bool], limit_s: float = 60.0) -> None:
        end_us = self.t_us + limit_s * 1e6
        while not condition():
            assert self.t_us < end_us, f"not in time: {self.vehicle.state}, {self.events}"
            self.step()

    def do(self, command: Command, limit_s: float = 20.0) -> VehicleEvent:
        """Ask and wait for the result."""
        self.vehicle.do(command, self.t_us)
        seen = len(self.events)

        def results() -> list[VehicleEvent]:
            return [event for event in self.events[seen:] if isinstance(event, Done | Refused)]

        self.until(lambda: bool(results()), limit_s)
        (result,) = results()
        assert result.command == command
        return result

    def ready(self) -> Flight:
        self.until(lambda: not self.vehicle.state.waiting_for and self.vehicle.state.has_position)
        return self

    def fly(self, height_m: float = 15.0) -> Flight:
        """Up, and following setpoints."""
        self.ready()
        assert self.do(Arm()) == Done(Arm())
        assert self.do(TakeOff(height_m)) == Done(TakeOff(height_m))
        self.until(lambda: abs(self.vehicle.state.position[2] - height_m) < 0.5)
        self.until(lambda: self.vehicle.state.mode is Mode.HOLD)
        assert self.do(Follow()) == Done(Follow())
        return self


GOOD = ("direct", "mavlink")
ALL = (*GOOD, "lossy", "crossed", "noisy")


@pytest.fixture(params=GOOD)
def flight(request: pytest.FixtureRequest) -> Flight:
    return Flight(request.param)


@pytest.fixture(params=ALL)
def rough(request: pytest.FixtureRequest) -> Flight:
    return Flight(request.param)


class TestEveryVehicle:
    def test_says_what_it_waits_for_until_it_is_ready(self, flight: Flight) -> None:
        flight.run(1.2)
        assert flight.vehicle.state.waiting_for
        flight.ready()
        state = flight.vehicle.state
        assert state.link_ok
        assert not state.armed
        assert not state.in_air
        assert state.mode is Mode.HOLD
        assert state.battery == pytest.approx(1.0, abs=0.02)
        np.testing.assert_allclose(state.position, flight.truth, atol=0.1)
        assert state.heading_rad == pytest.approx(flight.fleet.states.yaw[0], abs=0.01)

    def test_refused_arming_says_why(self, flight: Flight) -> None:
        flight.ready()
        flight.fleet.states.battery[0] = 0.05
        flight.run(1.0)
        assert flight.vehicle.state.waiting_for
        result = flight.do(Arm())
        assert isinstance(result, Refused)
        assert "low battery" in result.reason
        assert not flight.vehicle.state.armed

    def test_arms_and_disarms(self, flight: Flight) -> None:
        flight.ready()
        assert flight.do(Arm()) == Done(Arm())
        assert flight.vehicle.state.armed
        assert flight.vehicle.state.waiting_for == ()
        assert flight.do(Disarm()) == Done(Disarm())
        assert not flight.vehicle.state.armed

    def test_a_whole_flight(self, rough: Flight) -> None:
        """Up, along, to a place, hold, home, down: over every kind of link."""
        flight = rough.fly(15.0)
        assert flight.vehicle.state.in_air
        assert flight.truth[2] == pytest.approx(15.0, abs=0.6)
        before = flight.truth.copy()
        flight.run(4.0, SetVelocity(np.array([3.0, -2.0, 0.0])))
        moved = flight.truth - before
        assert moved[0] > 6.0
        assert moved[1] < -4.0
        np.testing.assert_allclose(flight.vehicle.state.velocity[:2], (3.0, -2.0), atol=0.4)
        goal = np.add(START, (-20.0, 15.0, 22.0))
        flight.run(20.0, SetPosition(goal))
        np.testing.assert_allclose(flight.truth, goal, atol=0.3)
        assert flight.do(HoldPosition()) == Done(HoldPosition())
        assert flight.vehicle.state.mode is Mode.HOLD
        flight.run(3.0)
        np.testing.assert_allclose(flight.truth, goal, atol=0.5)
        assert flight.do(ReturnHome()) == Done(ReturnHome())
        flight.until(lambda: not flight.vehicle.state.armed, 180.0)
        assert np.linalg.norm(flight.truth[:2] - START[:2]) < 1.5
        assert not flight.vehicle.state.in_air

    def test_lands_where_it_is(self, flight: Flight) -> None:
        flight.fly(8.0)
        flight.run(3.0, SetVelocity(np.array([3.0, 0.0, 0.0])))
        assert flight.do(LandHere()) == Done(LandHere())
        there = flight.truth.copy()
        flight.until(lambda: not flight.vehicle.state.armed)
        assert np.linalg.norm(flight.truth[:2] - there[:2]) < 8.0
        assert flight.truth[2] == pytest.approx(0.0, abs=0.2)

    def test_setpoints_stop_and_the_autopilot_acts(self, flight: Flight) -> None:
        flight.fly()
        flight.run(2.0, SetVelocity(np.array([2.0, 0.0, 0.0])))
        flight.run(0.9)
        assert flight.vehicle.state.mode is Mode.OFFBOARD
        flight.run(2.5)
        assert flight.vehicle.state.mode is Mode.RETURN

    def test_a_slow_planner_keeps_offboard_alive(self, flight: Flight) -> None:
        flight.fly()
        for _ in range(5):
            flight.vehicle.do(SetVelocity(np.array([1.0, 0.0, 0.0])), flight.t_us)
            flight.run(1.0)
        assert flight.vehicle.state.mode is Mode.OFFBOARD

    def test_turns_to_a_yaw(self, flight: Flight) -> None:
        flight.fly()
        flight.run(6.0, SetVelocity(np.zeros(3), yaw_rad=-2.0))
        assert flight.fleet.states.yaw[0] == pytest.approx(-2.0, abs=0.1)
        assert flight.vehicle.state.heading_rad == pytest.approx(-2.0, abs=0.1)

    def test_nothing_that_is_not_finite_is_flown(self, flight: Flight) -> None:
        flight.ready()
        with pytest.raises(ValueError, match="finite"):
            flight.vehicle.do(SetVelocity(np.array([np.nan, 0.0, 0.0])), flight.t_us)

    @pytest.mark.parametrize("height_m", [float("nan"), float("inf"), 0.0, -5.0, 1e39])
    def test_no_height_no_take_off(self, flight: Flight, height_m: float) -> None:
        flight.ready()
        flight.vehicle.do(TakeOff(height_m), flight.t_us)
        flight.run(0.5)
        (result,) = [event for event in flight.events if isinstance(event, Done | Refused)]
        assert isinstance(result, Refused)
        assert "no height to take off to" in result.reason
        assert flight.vehicle.state.mode is Mode.HOLD


class TestOverMavlink:
    def test_two_origins(self) -> None:
        """The mission's home is neither the vehicle's nor the simulator's, nor as high."""
        flight = Flight("mavlink", start=(250.0, 640.0, 0.0))
        mission = Geodetic(47.395, 8.552, 455.0)
        near, flight.far = memory_pair()
        flight.vehicle = MavlinkVehicle(near, 7, origin=mission)
        flight.ready()

        def true_place() -> F64:
            return to_enu(*to_geodetic(flight.truth, ORIGIN), mission)

        np.testing.assert_allclose(flight.vehicle.state.position, true_place(), atol=0.15)
        assert flight.vehicle.state.position[2] > 30.0
        flight.do(Arm())
        flight.do(TakeOff(12.0))
        flight.until(lambda: flight.truth[2] > 11.5)
        flight.do(Follow())
        goal = np.add(true_place(), (-120.0, 90.0, 15.0))
        flight.run(40.0, SetPosition(goal))
        np.testing.assert_allclose(true_place(), goal, atol=0.3)
        np.testing.assert_allclose(flight.vehicle.state.position, true_place(), atol=0.3)

    def test_silence_is_noticed_and_the_vehicle_helps_itself(self) -> None:
        flight = Flight("mavlink").fly()
        flight.cut = True
        flight.run(2.5)
        assert flight.vehicle.state.link_ok
        flight.run(1.0)
        assert not flight.vehicle.state.link_ok
        assert flight.vehicle.state.waiting_for[0].startswith("silent")
        assert flight.do(HoldPosition()) == Refused(HoldPosition(), "no answer")
        flight.cut = False
        flight.run(2.0)
        assert flight.vehicle.state.link_ok
        assert flight.vehicle.state.mode is Mode.RETURN

    def test_texts_are_told(self) -> None:
        flight = Flight("mavlink").ready()
        flight.do(Arm())
        assert Said(6, "Armed by external command") in flight.events

    def test_garbage_is_counted_on_both_sides(self) -> None:
        flight = Flight("noisy").ready()
        flight.run(5.0)
        assert isinstance(flight.vehicle, MavlinkVehicle)
        assert flight.vehicle.counts.garbage > 0
        assert flight.vehicle.counts.packets > 100
        assert flight.fleet.counts[0].garbage > 0

    def test_bytes_may_come_one_by_one_in_whole_frames_or_all_at_once(self) -> None:
        """Frames of several systems and of nobody in one datagram."""
        flight = Flight("mavlink").ready()
        other = Encoder(8).pack("LOCAL_POSITION_NED", time_boot_ms=1, x=99.0, z=-99.0)
        heartbeat = Encoder(8).pack("HEARTBEAT", type=2, autopilot=mav.MAV_AUTOPILOT_PX4)
        flight.far.send(other + heartbeat + b"\x00\xfd" + other)
        flight.run(0.2)
        np.testing.assert_allclose(flight.vehicle.state.position, flight.truth, atol=0.1)

    def test_the_same_seed_gives_the_same_bytes(self) -> None:
        def sent() -> list[bytes]:
            flight = Flight("mavlink")
            heard: list[bytes] = []
            original = flight.near.send
            flight.near.send = lambda data: (heard.append(data), original(data))[1]  # type: ignore[method-assign]
            flight.fly()
            return heard

        assert sent() == sent()
