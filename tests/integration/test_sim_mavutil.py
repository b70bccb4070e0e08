"""The simulator and pymavlink's high-level calls, on both faces."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from pymavlink import mavutil

from tests.integration.simulator import simulator

pytestmark = pytest.mark.integration
HOME = 47.397742, 8.545594


@contextmanager
def connected(*arguments: str) -> Iterator[Any]:
    """A vehicle that has been heard."""
    with simulator(*arguments) as sim:
        link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{sim.port}", source_system=255)
        try:
            assert link.wait_heartbeat(timeout=10)
            yield link
        finally:
            link.close()


def until(link: Any, name: str, accept: Callable[[Any], bool], within_s: float = 15.0) -> Any:
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        message = link.recv_match(type=name, blocking=True, timeout=1.0)
        if message is not None and accept(message):
            return message
    raise AssertionError(f"no such {name}")


def accepted(link: Any, command: int) -> None:
    assert until(link, "COMMAND_ACK", lambda ack: ack.command == command).result == 0


def upload(link: Any, rows: list[tuple[int, int, float, float, float]]) -> None:
    link.waypoint_clear_all_send()
    until(link, "MISSION_ACK", lambda _: True)
    link.waypoint_count_send(len(rows))
    for _ in rows:
        asked = link.recv_match(
            type=["MISSION_REQUEST", "MISSION_REQUEST_INT"], blocking=True, timeout=5
        )
        command, frame, north_m, height_m, param1 = rows[asked.seq]
        link.mav.mission_item_int_send(
            *(link.target_system, 1, asked.seq, frame, command, 0, 1, param1, 0, 0, 0),
            *(round((HOME[0] + north_m / 111_170) * 1e7), round(HOME[1] * 1e7), height_m),
        )
    assert until(link, "MISSION_ACK", lambda _: True).type == 0


def test_arducopter_guided_and_auto():
    with connected("--autopilot", "ardupilot", "--speed", "15") as link:
        assert link.mode_mapping()["GUIDED"] == 4
        link.mav.request_data_stream_send(link.target_system, 1, 0, 4, 1)
        until(link, "EKF_STATUS_REPORT", lambda report: report.flags == 831)
        link.param_fetch_one("WPNAV_SPEED")
        until(link, "PARAM_VALUE", lambda value: value.param_id == "WPNAV_SPEED")
        assert link.params["WPNAV_SPEED"] == 1000.0
        link.param_set_send("RTL_ALT", 1200)
        until(link, "PARAM_VALUE", lambda value: value.param_value == 1200.0)
        upload(link, [(16, 0, 0, 488, 0), (22, 3, 0, 10, 0), (16, 3, 25, 12, 0), (20, 3, 0, 0, 0)])
        link.waypoint_request_list_send()
        assert until(link, "MISSION_COUNT", lambda _: True).count == 4

        link.set_mode("GUIDED")
        until(link, "HEARTBEAT", lambda _: link.flightmode == "GUIDED")
        link.arducopter_arm()
        link.motors_armed_wait()
        link.mav.command_long_send(link.target_system, 1, 22, 0, 0, 0, 0, 0, 0, 0, 10)
        accepted(link, 22)
        until(link, "GLOBAL_POSITION_INT", lambda place: place.relative_alt > 9500)
        link.set_mode_auto()
        until(link, "HEARTBEAT", lambda _: link.flightmode == "AUTO")
        until(link, "MISSION_ITEM_REACHED", lambda reached: reached.seq == 2)
        link.set_mode_rtl()
        until(link, "HEARTBEAT", lambda _: link.flightmode == "RTL")
        link.motors_disarmed_wait()
        assert link.location().lat == pytest.approx(HOME[0], abs=1e-5)


def test_ardurover_drives():
    with connected("--autopilot", "ardupilot", "--kind", "rover", "--speed", "15") as link:
        assert link.mode_mapping()["HOLD"] == 4
        link.mav.request_data_stream_send(link.target_system, 1, 0, 4, 1)
        until(link, "EKF_STATUS_REPORT", lambda report: report.flags == 831)
        link.set_mode("GUIDED")
        until(link, "HEARTBEAT", lambda _: link.flightmode == "GUIDED")
        link.arducopter_arm()
        link.motors_armed_wait()
        link.mav.set_position_target_local_ned_send(
            0, link.target_system, 1, 1, 0xDF8, 15, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0
        )
        until(link, "LOCAL_POSITION_NED", lambda place: abs(place.x - 15) < 1.0)
        link.set_mode("HOLD")
        until(link, "HEARTBEAT", lambda _: link.flightmode == "HOLD")
        until(link, "VFR_HUD", lambda hud: hud.groundspeed < 0.05)
        link.arducopter_disarm()
        link.motors_disarmed_wait()


def test_px4_modes_and_mission():
    with connected("--speed", "8") as link:
        assert "TAKEOFF" in link.mode_mapping()
        until(link, "SYS_STATUS", lambda status: status.onboard_control_sensors_health >> 28 & 1)
        link.param_fetch_all()
        until(link, "PARAM_VALUE", lambda value: value.param_index == value.param_count - 1)
        upload(link, [(22, 3, 0, 10, 0), (16, 3, 25, 12, 0), (21, 3, 25, 0, 0)])
        link.set_mode_px4("MISSION", 4, 4)
        accepted(link, 176)
        link.arducopter_arm()
        link.motors_armed_wait()
        until(link, "MISSION_ITEM_REACHED", lambda reached: reached.seq == 1)
        link.motors_disarmed_wait()
        assert link.location().lat == pytest.approx(HOME[0] + 25 / 111_170, abs=2e-5)
