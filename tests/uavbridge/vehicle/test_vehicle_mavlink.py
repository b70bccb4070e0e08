"""The MAVLink vehicle against hand-made packets: what it says, asks and makes of answers."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_vehicles.codec import Counts, Encoder, decode, mav
from sim_vehicles.geodesy import Geodetic, to_geodetic
from uavbridge.mavlink.link import memory_pair
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Disarm,
    Done,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    Net,
    Refused,
    Said,
    SetNet,
    SetPosition,
    SetVelocity,
    TakeOff,
    VehicleEvent,
)
from uavbridge.vehicle.mavlink import MavlinkVehicle

ORIGIN = Geodetic(47.397742, 8.545594, 488.0)
START = (300.0, -200.0, 12.0)  # where the vehicle's own frame is zero, mission ENU
PX4 = int(mav.MAV_AUTOPILOT_PX4)
ARDUPILOT = int(mav.MAV_AUTOPILOT_ARDUPILOTMEGA)
HOLD, OFFBOARD, LAND, RTL, TAKEOFF = (4, 3), (6, 0), (4, 6), (4, 5), (4, 2)


class Bench:
    """A vehicle, and the other end of its link: packets are made and read by hand."""

    def __init__(self, system: int = 7) -> None:
        link, self.far = memory_pair()
        self.vehicle = MavlinkVehicle(link, system, origin=ORIGIN)
        self.encoder = Encoder(system)
        self.t_us = 0
        self.sent: list[Any] = []
        self.events: list[VehicleEvent] = []

    def say(self, name: str, **fields: Any) -> None:
        self.far.send(self.encoder.pack(name, **fields))

    def heartbeat(
        self, mode: tuple[int, int] = HOLD, *, armed: bool = False, autopilot: int = PX4
    ) -> None:
        self.say(
            "HEARTBEAT",
            type=mav.MAV_TYPE_QUADROTOR,
            autopilot=autopilot,
            base_mode=mav.MAV_MODE_FLAG_SAFETY_ARMED * armed,
            custom_mode=mode[0] << 16 | mode[1] << 24 if autopilot == PX4 else mode[0],
        )

    def origin(self) -> None:
        latitude, longitude, altitude = to_geodetic(np.array(START), ORIGIN)
        self.say(
            "GPS_GLOBAL_ORIGIN",
            latitude=round(float(latitude) * 1e7),
            longitude=round(float(longitude) * 1e7),
            altitude=round(float(altitude) * 1e3),
        )

    def local(self, boot_ms: int = 1000, **fields: float) -> None:
        self.say("LOCAL_POSITION_NED", time_boot_ms=boot_ms, **fields)

    def ready(self) -> Bench:
        self.heartbeat()
        self.origin()
        self.local()
        self.run(0.1)
        return self

    def ack(self, command: int, result: int = 0, **fields: int) -> None:
        self.say("COMMAND_ACK", command=command, result=result, **fields)

    def run(self, duration_s: float, step_s: float = 0.05) -> list[Any]:
        """Let time pass; what was sent meanwhile."""
        sent: list[Any] = []
        for _ in range(round(duration_s / step_s)):
            self.t_us += round(step_s * 1e6)
            self.events += self.vehicle.advance(self.t_us)
            sent += self.read()
        return sent

    def read(self) -> list[Any]:
        new = [p.message for data in self.far.receive() for p in decode(data, Counts())]
        self.sent += new
        return new

    def do(self, command: Command) -> list[Any]:
        self.vehicle.do(command, self.t_us)
        return self.read() + self.run(0.05)

    @property
    def results(self) -> list[VehicleEvent]:
        return [event for event in self.events if not isinstance(event, Said)]


def named(messages: list[Any], name: str) -> list[Any]:
    return [message for message in messages if message.msgname == name]


def commands(messages: list[Any], number: int) -> list[Any]:
    return [message for message in named(messages, "COMMAND_LONG") if message.command == number]


SET_MODE = int(mav.MAV_CMD_DO_SET_MODE)
ARM = int(mav.MAV_CMD_COMPONENT_ARM_DISARM)
SETPOINT = "SET_POSITION_TARGET_LOCAL_NED"


def test_it_shows_itself_once_a_second_before_anybody_answers() -> None:
    bench = Bench()
    heartbeats = named(bench.run(10.0), "HEARTBEAT")
    assert len(heartbeats) == 10
    assert {beat.type for beat in heartbeats} == {mav.MAV_TYPE_GCS}
    assert bench.vehicle.state.waiting_for == ("no heartbeat yet",)
    assert not bench.vehicle.state.link_ok


def test_heights_that_do_not_agree_are_named_before_arming() -> None:
    bench = Bench().ready()
    assert bench.vehicle.state.waiting_for == ()
    latitude, longitude, altitude = to_geodetic(np.array(START), ORIGIN)
    place = {"lat": round(float(latitude) * 1e7), "lon": round(float(longitude) * 1e7)}
    height_mm = round(float(altitude) * 1e3)
    bench.say("GLOBAL_POSITION_INT", time_boot_ms=1000, alt=height_mm + 4_000, **place)
    bench.run(0.1)
    assert bench.vehicle.state.waiting_for == ()
    bench.say("GLOBAL_POSITION_INT", time_boot_ms=1100, alt=height_mm - 47_000, **place)
    bench.run(0.1)
    (reason,) = bench.vehicle.state.waiting_for
    assert reason == "its local and its global position are 47 m apart"


def test_readiness_names_what_is_missing() -> None:
    bench = Bench()
    bench.heartbeat()
    bench.run(0.1)
    waiting = bench.vehicle.state.waiting_for
    assert waiting == ("no position yet", "origin of its local frame not known yet")
    bench.origin()
    bench.local()
    bench.say(
        "SYS_STATUS",
        onboard_control_sensors_present=mav.MAV_SYS_STATUS_PREARM_CHECK,
        onboard_control_sensors_enabled=mav.MAV_SYS_STATUS_PREARM_CHECK,
        battery_remaining=83,
    )
    bench.say("STATUSTEXT", severity=2, text="PreArm: Need Position Estimate")
    bench.run(0.1)
    state = bench.vehicle.state
    assert state.waiting_for == ("pre-arm checks fail: PreArm: Need Position Estimate",)
    assert state.battery == 0.83
    bench.say(
        "SYS_STATUS",
        onboard_control_sensors_present=mav.MAV_SYS_STATUS_PREARM_CHECK,
        onboard_control_sensors_enabled=mav.MAV_SYS_STATUS_PREARM_CHECK,
        onboard_control_sensors_health=mav.MAV_SYS_STATUS_PREARM_CHECK,
    )
    bench.run(0.1)
    assert bench.vehicle.state.waiting_for == ()
    assert Said(2, "PreArm: Need Position Estimate") in bench.events


def test_it_asks_for_what_does_not_come_and_ever_more_seldom() -> None:
    bench = Bench()
    bench.heartbeat()
    asked = []
    for _ in range(60):
        bench.heartbeat()
        asked += bench.run(1.0)
    intervals = commands(asked, mav.MAV_CMD_SET_MESSAGE_INTERVAL)
    wanted = {message.param1: message.param2 for message in intervals}
    assert wanted[mav.MAVLINK_MSG_ID_LOCAL_POSITION_NED] == 100_000
    assert wanted[mav.MAVLINK_MSG_ID_EXTENDED_SYS_STATE] == 500_000
    assert 3 <= len(intervals) / len(wanted) <= 6
    once = {message.param1 for message in commands(asked, mav.MAV_CMD_REQUEST_MESSAGE)}
    assert once == {49, 242}


def test_it_asks_for_nothing_that_comes() -> None:
    bench = Bench().ready()
    asked = []
    bench.say("HOME_POSITION", latitude=473977421, longitude=85455941)
    for step in range(100):
        bench.local(step * 100)
        bench.say("GLOBAL_POSITION_INT", time_boot_ms=step * 100, lat=473977421, lon=85455941)
        bench.say("EXTENDED_SYS_STATE", landed_state=1)
        bench.say("SYS_STATUS")
        asked += bench.run(0.1)
    assert not commands(asked[20:], mav.MAV_CMD_SET_MESSAGE_INTERVAL)


def test_positions_are_in_the_missions_frame() -> None:
    bench = Bench().ready()
    bench.local(1100, x=10.0, y=20.0, z=-5.0, vx=1.0, vy=2.0, vz=-3.0)
    bench.say("ATTITUDE", time_boot_ms=1100, yaw=pi / 2)
    bench.run(0.05)
    state = bench.vehicle.state
    np.testing.assert_allclose(state.position, (320.0, -190.0, 17.0), atol=0.02)
    np.testing.assert_allclose(state.velocity, (2.0, 1.0, 3.0), atol=0.001)
    assert state.heading_rad == pytest.approx(0.0, abs=1e-6)
    assert state.t_us == bench.t_us


def test_the_global_position_serves_until_the_local_frame_is_known() -> None:
    bench = Bench()
    bench.heartbeat()
    latitude, longitude, altitude = to_geodetic(np.array(START), ORIGIN)
    bench.say(
        "GLOBAL_POSITION_INT",
        lat=round(float(latitude) * 1e7),
        lon=round(float(longitude) * 1e7),
        alt=round(float(altitude) * 1e3),
        vx=150,
        vz=-20,
        hdg=9000,
    )
    bench.run(0.05)
    state = bench.vehicle.state
    assert state.has_position
    np.testing.assert_allclose(state.position, START, atol=0.02)
    np.testing.assert_allclose(state.velocity, (0.0, 1.5, 0.2), atol=1e-9)
    assert state.heading_rad == pytest.approx(0.0, abs=1e-6)


def test_the_home_position_gives_the_frame_until_the_origin_does() -> None:
    bench = Bench()
    bench.heartbeat()
    latitude, longitude, altitude = to_geodetic(np.add(START, (0.0, 0.0, 2.0)), ORIGIN)
    bench.say(
        "HOME_POSITION",
        latitude=round(float(latitude) * 1e7),
        longitude=round(float(longitude) * 1e7),
        altitude=round(float(altitude) * 1e3),
        z=-2.0,
    )
    bench.local()
    bench.run(0.05)
    np.testing.assert_allclose(bench.vehicle.state.position, START, atol=0.02)
    assert bench.vehicle.state.waiting_for == ()


def test_a_home_position_does_not_replace_a_known_origin() -> None:
    """PX4's first HOME_POSITION comes before its estimate has settled, metres off."""
    bench = Bench().ready()
    bench.say("HOME_POSITION", latitude=473977384, longitude=85455950, altitude=490495)
    bench.run(0.05)
    np.testing.assert_allclose(bench.vehicle.state.position, START, atol=0.02)


def test_late_and_doubled_positions_change_nothing() -> None:
    bench = Bench().ready()
    bench.local(2000, x=2.0)
    bench.say("ATTITUDE", time_boot_ms=2000, yaw=pi / 2)
    bench.local(2000, x=2.0)
    bench.local(1900, x=1.0)
    bench.say("ATTITUDE", time_boot_ms=1900, yaw=1.0)
    bench.run(0.05)
    assert bench.vehicle.state.position[1] == pytest.approx(START[1] + 2.0, abs=0.02)
    assert bench.vehicle.state.heading_rad == pytest.approx(0.0, abs=1e-6)


def test_nonsense_positions_change_nothing() -> None:
    bench = Bench().ready()
    before = bench.vehicle.state.position
    bench.local(1100, x=float("nan"))
    bench.local(1200, vy=float("inf"))
    bench.say("GPS_GLOBAL_ORIGIN", latitude=2_000_000_000)
    bench.say("ATTITUDE", time_boot_ms=1300, yaw=float("nan"))
    bench.run(0.05)
    np.testing.assert_array_equal(bench.vehicle.state.position, before)
    assert np.isfinite(bench.vehicle.state.heading_rad)


def test_a_restart_is_told_and_waited_for() -> None:
    bench = Bench().ready()
    bench.local(60_000, x=5.0)
    bench.run(0.1)
    bench.heartbeat()
    bench.local(300)
    bench.run(0.1)
    assert Said(4, "system 7 has restarted") in bench.events
    (reason, _) = bench.vehicle.state.waiting_for
    assert reason.startswith("no position yet (it restarted at 0.")
    bench.origin()
    bench.run(0.1)
    assert bench.vehicle.state.waiting_for == ()


def test_two_vehicles_of_one_id_are_noticed() -> None:
    bench = Bench().ready()
    for second in range(1, 6):
        bench.local(90_000 + second * 1000)
        bench.local(second * 1000)
        bench.run(1.0)
        bench.heartbeat()
    bench.run(0.1)
    assert bench.vehicle.state.waiting_for == ("two vehicles seem to use system id 7",)


def test_silence_ends_the_link_and_a_word_mends_it() -> None:
    bench = Bench().ready()
    bench.run(2.9)
    assert bench.vehicle.state.link_ok
    bench.run(0.3)
    assert not bench.vehicle.state.link_ok
    assert bench.vehicle.state.waiting_for[0].startswith("silent for 3.")
    bench.heartbeat()
    bench.run(0.05)
    assert bench.vehicle.state.link_ok


def test_others_on_the_link_are_not_the_vehicle() -> None:
    bench = Bench()
    camera = Encoder(7, 100)
    stranger = Encoder(9)
    station = Encoder(7, 190)
    bench.far.send(camera.pack("HEARTBEAT", type=30, autopilot=mav.MAV_AUTOPILOT_INVALID))
    bench.far.send(station.pack("HEARTBEAT", type=6, autopilot=mav.MAV_AUTOPILOT_INVALID))
    bench.far.send(stranger.pack("HEARTBEAT", type=2, autopilot=PX4))
    bench.run(0.05)
    assert bench.vehicle.state.waiting_for == ("no heartbeat yet",)
    bench.ready()
    bench.far.send(camera.pack("HEARTBEAT", type=30, autopilot=mav.MAV_AUTOPILOT_INVALID))
    bench.far.send(stranger.pack("LOCAL_POSITION_NED", time_boot_ms=5000, x=99.0))
    bench.far.send(camera.pack("LOCAL_POSITION_NED", time_boot_ms=5000, x=99.0))
    bench.run(0.05)
    assert bench.vehicle.state.position[1] == pytest.approx(START[1], abs=0.02)
    assert bench.vehicle.strangers == 4
    assert bench.vehicle.state.mode is Mode.HOLD


def test_the_autopilot_may_be_another_component() -> None:
    bench = Bench()
    bench.encoder = Encoder(7, 5)
    bench.ready()
    assert bench.vehicle.state.waiting_for == ()
    (message,) = commands(bench.do(Arm()), ARM)
    assert message.target_component == 5


def test_an_autopilot_nobody_knows_is_refused_by_name() -> None:
    bench = Bench()
    bench.heartbeat(autopilot=int(mav.MAV_AUTOPILOT_GENERIC))
    bench.run(0.1)
    reason = "autopilot 0 (generic) is not supported: PX4 and ArduPilot are"
    assert bench.vehicle.state.waiting_for == (reason,)
    bench.do(Arm())
    assert bench.results == [Refused(Arm(), reason)]


def test_a_command_before_any_heartbeat_is_refused() -> None:
    bench = Bench()
    bench.do(TakeOff(10.0))
    assert bench.results == [Refused(TakeOff(10.0), "no heartbeat yet")]


def test_arming_is_done_when_the_heartbeat_shows_it() -> None:
    bench = Bench().ready()
    assert len(commands(bench.do(Arm()), ARM)) == 1
    bench.ack(ARM)
    sent = bench.run(0.1)
    assert bench.results == []
    assert [message.param1 for message in commands(sent, mav.MAV_CMD_REQUEST_MESSAGE)] == [0.0]
    bench.heartbeat(armed=True)
    bench.run(0.1)
    assert bench.results == [Done(Arm())]
    assert bench.vehicle.state.armed
    assert not commands(bench.run(5.0), ARM)


def test_an_unanswered_command_is_repeated_then_refused() -> None:
    bench = Bench().ready()
    bench.do(Arm())
    bench.run(10.0)
    assert [message.confirmation for message in commands(bench.sent, ARM)] == list(range(18))
    assert bench.results == [Refused(Arm(), "no answer")]


def test_a_refusal_carries_what_the_autopilot_said() -> None:
    """ArduPilot's texts come after its ack."""
    bench = Bench().ready()
    bench.say("STATUSTEXT", severity=2, text="long ago")
    bench.run(2.0)
    bench.do(Arm())
    bench.ack(ARM, mav.MAV_RESULT_FAILED)
    bench.run(0.1)
    bench.say("STATUSTEXT", severity=2, text="Arm: Accels inconsistent")
    bench.say("STATUSTEXT", severity=6, text="chatter")
    bench.say("STATUSTEXT", severity=2, text="Arm: EKF attitude is bad")
    bench.run(0.5)
    reason = "failed: Arm: Accels inconsistent; Arm: EKF attitude is bad"
    assert bench.results == [Refused(Arm(), reason)]


def test_accepted_but_never_shown_is_refused() -> None:
    bench = Bench().ready()
    bench.heartbeat(armed=True)
    bench.do(LandHere())
    bench.ack(SET_MODE)
    bench.run(6.0)
    reason = "accepted, but not done: mode is AUTO.LOITER, armed True"
    assert bench.results == [Refused(LandHere(), reason)]


def test_landing_that_is_over_at_once_is_done() -> None:
    bench = Bench().ready()
    bench.heartbeat(armed=True)
    bench.run(0.1)
    bench.do(LandHere())
    bench.ack(SET_MODE)
    bench.run(0.1)
    assert bench.results == []
    bench.heartbeat(HOLD, armed=False)
    bench.run(0.1)
    assert bench.results == [Done(LandHere())]


def test_acks_for_other_stations_are_not_ours() -> None:
    bench = Bench().ready()
    bench.do(Arm())
    bench.ack(ARM, mav.MAV_RESULT_DENIED, target_system=255, target_component=190)
    bench.run(0.45)
    assert bench.results == []
    bench.ack(ARM, mav.MAV_RESULT_DENIED, target_system=245, target_component=190)
    bench.run(0.5)
    assert bench.results == [Refused(Arm(), "denied")]


def test_a_later_command_overtakes_an_earlier() -> None:
    bench = Bench().ready()
    bench.do(HoldPosition())
    bench.do(LandHere())
    assert bench.results == [Refused(HoldPosition(), "overtaken by LandHere")]
    bench.do(Arm())
    bench.do(Disarm())
    assert bench.results[1:] == [Refused(Arm(), "overtaken by Disarm")]


def test_take_off_sets_the_height_first() -> None:
    bench = Bench().ready()
    (setting,) = named(bench.do(TakeOff(17.5)), "PARAM_SET")
    assert (setting.param_id, setting.param_value) == ("MIS_TAKEOFF_ALT", 17.5)
    assert not commands(bench.sent, mav.MAV_CMD_NAV_TAKEOFF)
    bench.say("PARAM_VALUE", param_id="MIS_TAKEOFF_ALT", param_value=17.5, param_type=9)
    assert len(commands(bench.run(0.1), mav.MAV_CMD_NAV_TAKEOFF)) == 1
    bench.ack(mav.MAV_CMD_NAV_TAKEOFF)
    bench.heartbeat(TAKEOFF, armed=True)
    bench.run(0.1)
    assert bench.results == [Done(TakeOff(17.5))]


def test_offboard_is_asked_for_only_after_setpoints() -> None:
    bench = Bench().ready()
    bench.vehicle.do(Follow(), bench.t_us)
    first = bench.run(0.25)
    assert len(named(first, SETPOINT)) >= 1
    assert not commands(first, SET_MODE)
    (mode,) = commands(bench.run(0.15), SET_MODE)
    assert (mode.param2, mode.param3) == (6.0, 0.0)
    bench.ack(SET_MODE, mav.MAV_RESULT_DENIED)
    again = bench.run(0.45)
    assert len(commands(again, SET_MODE)) == 1
    assert len(named(again, SETPOINT)) >= 2
    bench.ack(SET_MODE)
    bench.ack(SET_MODE)
    bench.heartbeat(OFFBOARD, armed=True)
    bench.run(0.1)
    assert bench.results == [Done(Follow())]


def test_setpoints_go_out_at_once_repeat_and_stop() -> None:
    bench = Bench().ready()
    bench.vehicle.do(SetVelocity(np.array([1.0, 2.0, 3.0])), bench.t_us)
    (now,) = bench.read()
    assert (now.vx, now.vy, now.vz) == pytest.approx((2.0, 1.0, -3.0), abs=1e-3)
    assert now.type_mask == 0xDC7
    assert now.coordinate_frame == mav.MAV_FRAME_LOCAL_NED
    assert (now.target_system, now.target_component) == (7, 1)
    repeated = named(bench.run(0.5), SETPOINT)
    assert len(repeated) == 2
    assert {(message.vx, message.type_mask) for message in repeated} == {(now.vx, 0xDC7)}
    assert not named(bench.run(3.0), SETPOINT)


def test_setpoints_given_often_are_not_doubled() -> None:
    bench = Bench().ready()
    for _ in range(20):
        bench.vehicle.do(SetVelocity(np.array([1.0, 0.0, 0.0])), bench.t_us)
        bench.run(0.1)
    assert 20 <= len(named(bench.sent, SETPOINT)) <= 22


def test_a_position_goes_out_in_the_vehicles_frame() -> None:
    bench = Bench().ready()
    goal = np.add(START, (30.0, 40.0, 20.0))
    (message,) = named(bench.do(SetPosition(goal, yaw_rad=pi / 2)), SETPOINT)[:1]
    assert (message.x, message.y, message.z) == pytest.approx((40.0, 30.0, -20.0), abs=0.05)
    assert message.yaw == pytest.approx(0.0, abs=1e-6)
    assert message.type_mask == 0x9F8


def test_a_position_is_not_sent_in_a_frame_nobody_knows() -> None:
    bench = Bench()
    bench.heartbeat()
    bench.run(0.1)
    assert not named(bench.do(SetPosition(np.zeros(3))), SETPOINT)


def test_a_phase_flown_by_the_autopilot_ends_the_setpoints() -> None:
    bench = Bench().ready()
    bench.do(SetVelocity(np.array([1.0, 0.0, 0.0])))
    bench.do(HoldPosition())
    assert not named(bench.run(1.0), SETPOINT)


@pytest.mark.parametrize(
    "setpoint",
    [
        SetVelocity(np.array([0.0, np.nan, 0.0])),
        SetPosition(np.array([np.inf, 0.0, 0.0])),
        SetVelocity(np.zeros(3), yaw_rad=float("nan")),
    ],
)
def test_setpoints_that_are_not_finite_are_refused(setpoint: SetVelocity | SetPosition) -> None:
    bench = Bench().ready()
    with pytest.raises(ValueError, match="must be finite"):
        bench.vehicle.do(setpoint, bench.t_us)
    assert not named(bench.read(), SETPOINT)


def test_an_arducopter_takes_off_in_guided() -> None:
    bench = Bench()
    bench.heartbeat((0, 0), autopilot=ARDUPILOT)
    bench.run(0.1)
    assert bench.vehicle.state.mode is Mode.MANUAL
    (mode,) = commands(bench.do(TakeOff(10.0)), SET_MODE)
    assert mode.param2 == 4.0
    bench.ack(SET_MODE)
    (climb,) = commands(bench.run(0.1), mav.MAV_CMD_NAV_TAKEOFF)
    assert climb.param7 == 10.0
    bench.ack(mav.MAV_CMD_NAV_TAKEOFF)
    bench.heartbeat((4, 0), armed=True, autopilot=ARDUPILOT)
    bench.run(0.1)
    assert bench.results == [Done(TakeOff(10.0))]
    assert bench.vehicle.state.mode is Mode.OFFBOARD


@given(st.lists(st.binary(max_size=64), max_size=8), st.integers(0, 39))
def test_any_bytes_are_counted_and_change_nothing(garbage: list[bytes], cut: int) -> None:
    bench = Bench().ready()
    before = bench.vehicle.state
    frame = bench.encoder.pack("LOCAL_POSITION_NED", time_boot_ms=9000, x=77.0, vz=1.0)
    broken = bytearray(frame)
    broken[10 + cut % 20] ^= 0xFF
    for data in (*garbage, frame[:cut], bytes(broken)):
        bench.far.send(data)
    packets = bench.vehicle.counts.packets
    bench.run(0.05)
    counts = bench.vehicle.counts
    assert counts.packets == packets
    assert counts.bad_crc + counts.noise + counts.truncated + counts.unknown > 0
    np.testing.assert_array_equal(bench.vehicle.state.position, before.position)
    assert bench.events == []


def test_every_command_has_exactly_one_result() -> None:
    orders: tuple[Command, ...] = (Arm(), Follow(), HoldPosition(), TakeOff(5.0), Disarm())
    bench = Bench().ready()
    for command in orders * 3:
        bench.vehicle.do(command, bench.t_us)
        bench.run(0.05)
    bench.run(20.0)
    assert len(bench.results) == len(orders) * 3


@pytest.mark.parametrize(
    ("autopilot", "kind", "landed_in", "stands_by_in"),
    [
        (ARDUPILOT, mav.MAV_TYPE_QUADROTOR, 9, 4),
        (ARDUPILOT, mav.MAV_TYPE_FIXED_WING, 10, 5),
        (PX4, mav.MAV_TYPE_QUADROTOR, OFFBOARD[0] << 16, HOLD[0]),
    ],
)
def test_a_vehicle_is_taken_out_of_the_mode_it_landed_in(
    autopilot: int, kind: int, landed_in: int, stands_by_in: int
) -> None:
    bench = Bench()
    fields = {"autopilot": autopilot, "base_mode": 0, "custom_mode": landed_in}
    bench.say("HEARTBEAT", type=kind, **fields)
    bench.run(1.0)
    bench.vehicle.do(SetNet(Net(300.0, 80.0, 30.0)), bench.t_us)
    asked = []
    for _ in range(20):
        for order in commands(bench.run(0.1), SET_MODE):
            asked.append(order.param2)
            bench.ack(SET_MODE)
    assert asked[-1] == stands_by_in
    assert len(asked) == 1 + (kind == mav.MAV_TYPE_FIXED_WING)
