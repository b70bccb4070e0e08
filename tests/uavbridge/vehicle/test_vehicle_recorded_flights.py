"""The client on the bytes of recorded flights: what it reads in them, and what it would send."""

from __future__ import annotations

import lzma
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_vehicles.codec import Counts, Encoder, decode
from sim_vehicles.geodesy import Geodetic
from uavbridge.mavlink.ardupilot import ARDUCOPTER, ARDUPLANE, ARDUROVER
from uavbridge.mavlink.commands import Commands, Order
from uavbridge.mavlink.flavour import Flavour
from uavbridge.mavlink.identity import COMPONENT, SYSTEM
from uavbridge.mavlink.link import memory_pair
from uavbridge.mavlink.px4 import Px4
from uavbridge.mavlink.scout import Scout
from uavbridge.recording.tlog import frame_length
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Follow,
    Mode,
    Refused,
    ReturnHome,
    Said,
    SetVelocity,
    TakeOff,
    VehicleEvent,
)
from uavbridge.vehicle.mavlink import MavlinkVehicle

FLIGHTS = Path(__file__).parents[2] / "data" / "flights"
CANBERRA = Geodetic(-35.3632620, 149.1652370, 584.09)
ZURICH = Geodetic(47.397742, 8.545594, 489.4)
STATION = 255


def frames(name: str) -> list[tuple[float, bytes]]:
    """(seconds since the first, frame) of a recording."""
    data = lzma.decompress((FLIGHTS / f"{name}.tlog.xz").read_bytes())
    found, at = [], 0
    while at + 8 < len(data):
        (date_us,) = struct.unpack_from(">Q", data, at)
        size = frame_length(data, at + 8)
        found.append((date_us, data[at + 8 : at + 8 + size]))
        at += 8 + size
    first_us = found[0][0]
    return [((date_us - first_us) / 1e6, frame) for date_us, frame in found]


def sender(frame: bytes) -> int:
    return decode(frame, Counts())[0].system


class Tape:
    """A recorded vehicle, played to the client."""

    def __init__(
        self,
        name: str,
        system: int,
        origin: Geodetic,
        source: tuple[int, int] = (SYSTEM, COMPONENT),
    ) -> None:
        near, self.far = memory_pair()
        self.vehicle = MavlinkVehicle(near, system, origin=origin, source=source)
        self.events: list[VehicleEvent] = []
        self._frames = [(t_s, f) for t_s, f in frames(name) if sender(f) != STATION]
        self._at = 0

    def play(self, until_s: float) -> MavlinkVehicle:
        """Everything up to a time of the recording."""
        while self._at < len(self._frames) and self._frames[self._at][0] <= until_s:
            t_s, frame = self._frames[self._at]
            self.far.send(frame)
            self.events += self.vehicle.advance(round(t_s * 1e6))
            self._at += 1
        return self.vehicle

    @property
    def said(self) -> list[str]:
        return [event.text for event in self.events if isinstance(event, Said)]


def test_copter_waits_for_its_estimator_and_flies() -> None:
    tape = Tape("arducopter-4.6.3", 1, CANBERRA)
    state = tape.play(12.0).state
    assert "its estimator (EKF) has no position yet" in state.waiting_for
    assert any("Accels inconsistent" in reason for reason in state.waiting_for)
    assert not state.has_position
    state = tape.play(30.0).state
    assert state.waiting_for
    assert (state.mode, state.mode_text, state.kind) == (Mode.OFFBOARD, "GUIDED", "multirotor")
    state = tape.play(43.0).state
    assert state.waiting_for == ()
    assert not state.armed
    state = tape.play(46.0).state
    assert state.armed
    state = tape.play(78.0).state  # 20 s after the step to 30 m north, 10 m high
    np.testing.assert_allclose(state.position, (0.0, 30.0, 10.0), atol=0.3)
    assert state.in_air
    state = tape.play(98.0).state
    np.testing.assert_allclose(state.position, (30.0, 30.0, 10.0), atol=0.3)
    state = tape.play(106.0).state
    np.testing.assert_allclose(state.velocity, (0.0, 5.05, 0.0), atol=0.2)
    assert tape.play(160.0).state.mode is Mode.RETURN
    state = tape.play(300.0).state
    assert not state.armed
    assert not state.in_air
    assert "SIM Hit ground at 0.499910 m/s" in tape.said
    assert tape.vehicle.counts.garbage == 0


def test_px4_is_ready_at_once_and_tells_of_its_return() -> None:
    tape = Tape("px4-1.17.0-sih", 7, ZURICH)
    state = tape.play(5.0).state
    assert state.waiting_for == ()
    assert (state.mode, state.mode_text) == (Mode.HOLD, "AUTO.LOITER")
    assert tape.play(8.0).state.mode is Mode.TAKEOFF
    assert tape.play(8.0).state.in_air
    assert tape.play(26.0).state.mode is Mode.OFFBOARD
    state = tape.play(120.0).state
    assert state.position[2] == pytest.approx(15.0, abs=1.5)
    state = tape.play(125.0).state
    assert (state.mode, state.mode_text) == (Mode.RETURN, "AUTO.RTL")
    assert "RTL: start return at 520 m (30 m above destination)" in tape.said
    assert not tape.play(300.0).state.armed


def test_a_rover_that_set_its_home_too_early_is_as_high_as_its_gps_says() -> None:
    scout = Scout(3, Encoder(SYSTEM, COMPONENT))
    for t_s, frame in frames("ardurover-4.6.3"):
        if sender(frame) != STATION and t_s < 40.0:
            scout.hear(frame, round(t_s * 1e6))
    assert scout.home is not None
    assert scout.home.altitude_m == pytest.approx(0.14)
    assert scout.start is not None
    assert scout.start.altitude_m == pytest.approx(584.0, abs=1.0)


def test_rover_and_plane_are_told_apart() -> None:
    tape = Tape("ardurover-4.6.3", 3, CANBERRA)
    state = tape.play(35.0).state
    assert state.kind == "rover"
    assert not state.has_position  # it says where it is from 10 s on, 584 m too low
    state = tape.play(69.0).state
    assert state.armed
    np.testing.assert_allclose(state.position[:2], (0.0, 30.0), atol=1.0)
    assert state.position[2] == pytest.approx(0.0, abs=0.5)
    assert tape.play(140.0).state.mode is Mode.RETURN
    tape = Tape("arduplane-4.6.3", 4, CANBERRA)
    state = tape.play(6.0).state
    assert state.kind == "plane"
    assert not state.has_position  # 0.0002 degrees from nowhere, before its GPS has a fix
    assert tape.play(22.0).state.mode is Mode.TAKEOFF
    state = tape.play(60.0).state
    assert (state.mode, state.in_air) == (Mode.OFFBOARD, True)
    assert np.linalg.norm(state.velocity[:2]) == pytest.approx(23.4, abs=1.0)
    assert np.hypot(state.position[0] + 77.0, state.position[1] - 510.0) < 130.0


def station(name: str, kind: str, number: int | None = None) -> list[Any]:
    """What the recorded ground station sent, and the vehicle accepted."""
    messages = [decode(f, Counts())[0].message for _, f in frames(name) if sender(f) == STATION]
    return [m for m in messages if m.msgname == kind and (number is None or m.command == number)]


def sent(flavour: Flavour, command: Command, system: int) -> list[Any]:
    """What we send for a command."""
    commands = Commands(Encoder(SYSTEM, COMPONENT), system)
    orders = [step for step in flavour.plan(command).steps if isinstance(step, Order)]
    return [decode(commands.frame(order), Counts())[0].message for order in orders]


def body(message: Any) -> dict[str, Any]:
    """Fields that matter to the vehicle."""
    fields = dict(zip(message._fields, message, strict=True))
    return {name: value for name, value in fields.items() if name != "confirmation"}


@pytest.mark.parametrize(
    ("name", "flavour", "system", "command", "number"),
    [
        ("arducopter-4.6.3", ARDUCOPTER, 1, Arm(), 400),
        ("arducopter-4.6.3", ARDUCOPTER, 1, TakeOff(10.0), 176),
        ("arducopter-4.6.3", ARDUCOPTER, 1, TakeOff(10.0), 22),
        ("arducopter-4.6.3", ARDUCOPTER, 1, Follow(), 176),
        ("arducopter-4.6.3", ARDUCOPTER, 1, ReturnHome(), 176),
        ("px4-1.17.0-sih", Px4(), 7, Arm(), 400),
        ("px4-1.17.0-sih", Px4(), 7, Follow(), 176),
        ("px4-1.17.0-sih", Px4(), 7, ReturnHome(), 176),
        ("ardurover-4.6.3", ARDUROVER, 3, Follow(), 176),
        ("ardurover-4.6.3", ARDUROVER, 3, ReturnHome(), 176),
        ("arduplane-4.6.3", ARDUPLANE, 4, TakeOff(50.0), 176),
        ("arduplane-4.6.3", ARDUPLANE, 4, Follow(), 176),
        ("arduplane-4.6.3", ARDUPLANE, 4, ReturnHome(), 176),
    ],
)
def test_we_ask_as_the_recorded_station_did(
    name: str, flavour: Flavour, system: int, command: Command, number: int
) -> None:
    ours = [body(m) for m in sent(flavour, command, system) if m.command == number]
    theirs = [body(m) for m in station(name, "COMMAND_LONG", number)]
    assert ours
    assert all(each in theirs for each in ours)


@pytest.mark.parametrize(
    ("name", "system", "origin", "until_s"),
    [("arducopter-4.6.3", 1, CANBERRA, 99.0), ("px4-1.17.0-sih", 7, ZURICH, 70.0)],
)
def test_a_velocity_is_sent_as_the_recorded_station_sent_it(
    name: str, system: int, origin: Geodetic, until_s: float
) -> None:
    tape = Tape(name, system, origin)
    vehicle = tape.play(until_s)
    tape.far.receive()
    vehicle.do(SetVelocity(np.array([0.0, 5.0, 0.0])), round(until_s * 1e6))
    (packet,) = decode(tape.far.receive()[0], Counts())
    ours = packet.message
    theirs = [
        m for m in station(name, "SET_POSITION_TARGET_LOCAL_NED") if m.vx == 5.0 and m.vy == 0.0
    ]
    assert theirs
    for field in ("type_mask", "coordinate_frame", "target_system", "target_component"):
        assert getattr(ours, field) == getattr(theirs[0], field)
    np.testing.assert_allclose((ours.vx, ours.vy, ours.vz), (5.0, 0.0, 0.0), atol=0.01)


def test_a_refusal_is_told_in_the_autopilots_words() -> None:
    """As recorded: failed, and why in a text beside it."""
    tape = Tape("arducopter-4.6.3", 1, CANBERRA, source=(STATION, 190))
    tape.play(3.6)
    tape.vehicle.do(Arm(), 3_600_000)
    tape.vehicle.advance(3_640_000)
    vehicle = tape.play(5.5)
    refused = [event for event in tape.events if isinstance(event, Refused)]
    assert [event.command for event in refused] == [Arm()]
    assert refused[0].reason.startswith("failed: ")
    assert "Arm: Accels inconsistent" in refused[0].reason
    assert not vehicle.state.armed


def test_places_far_ahead_stand_for_a_planes_velocity() -> None:
    tape = Tape("arduplane-4.6.3", 4, CANBERRA)
    vehicle = tape.play(60.0)
    tape.far.receive()

    def placed(velocity: tuple[float, float, float], t_s: float) -> Any:
        vehicle.do(SetVelocity(np.array(velocity)), round(t_s * 1e6))
        packets = [p for data in tape.far.receive() for p in decode(data, Counts())]
        return packets[0].message if packets else None

    theirs = station("arduplane-4.6.3", "COMMAND_INT", 192)[0]
    ours = placed((20.0, 0.0, 0.0), 60.0)
    assert (ours.command, ours.param1, ours.target_system) == (192, theirs.param1, 4)
    assert ours.param2 == 0  # in GUIDED alone: no mode is taken from a pilot
    assert ours.z == pytest.approx(CANBERRA.altitude_m + vehicle.state.position[2], abs=1.0)
    assert ours.y > theirs.y + 30_000  # far to the east
    assert placed((20.0, 0.0, 0.0), 60.1) is None
    assert placed((0.0, 20.0, 0.0), 60.2) is None
    assert placed((0.0, 20.0, 0.0), 61.2).x > ours.x + 30_000
    tape.play(120.0)  # RTL
    tape.far.receive()
    assert placed((0.0, 20.0, 0.0), 120.1) is None
