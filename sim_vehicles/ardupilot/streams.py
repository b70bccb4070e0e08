"""The messages that ArduPilot streams, and the groups that ground stations ask for."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Final

import numpy as np

from sim_vehicles.codec import mav
from sim_vehicles.sensor_streams import SENSOR_FILLS
from sim_vehicles.streams import FILLS as _COMMON
from sim_vehicles.streams import Fill, Readings, Record

_READY_FLAGS: Final = 831  # the EKF's, with GPS
_UNREADY_FLAGS: Final = 167
_STICKS: Final = (1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800)  # nobody touches them


def _estimate(out: Record, now: Readings) -> None:
    gps = now.snapshot.sensors_health[now.rows] & mav.MAV_SYS_STATUS_SENSOR_GPS
    out["flags"] = np.where(gps, _READY_FLAGS, _UNREADY_FLAGS)
    out["velocity_variance"] = 0.02
    out["pos_horiz_variance"] = 0.02
    out["pos_vert_variance"] = 0.01
    out["compass_variance"] = 0.02


def _navigation(out: Record, now: Readings) -> None:
    states, asked, rows = now.snapshot.states, now.snapshot.setpoints, now.rows
    away = np.nan_to_num(asked.position[rows] - states.position[rows])
    out["nav_roll"] = np.degrees(states.roll[rows])
    out["nav_pitch"] = np.degrees(states.pitch[rows])
    heading = np.rint(np.degrees(now.yaw))
    bearing = np.rint(np.degrees(np.arctan2(away[:, 0], away[:, 1])))
    out["nav_bearing"] = np.where(away[:, :2].any(axis=1), bearing, heading)
    out["target_bearing"] = out["nav_bearing"]
    out["wp_dist"] = np.minimum(np.rint(np.hypot(away[:, 0], away[:, 1])), 0xFFFF)
    out["alt_error"] = away[:, 2]


def _sticks(out: Record, now: Readings) -> None:
    out["time_boot_ms"] = now.boot_ms
    out["chancount"] = len(_STICKS)
    out["chan1_raw:chan18_raw"][:, : len(_STICKS)] = _STICKS
    out["rssi"] = 255


def _memory(out: Record, now: Readings) -> None:
    out["freemem"] = 0xFFFF
    out["freemem32"] = 131072


def _power(out: Record, now: Readings) -> None:
    out["Vcc"] = 5000


def _second_attitude(out: Record, now: Readings) -> None:
    states, rows = now.snapshot.states, now.rows
    out["roll"] = states.roll[rows]
    out["pitch"] = states.pitch[rows]
    out["yaw"] = (now.yaw + pi) % (2 * pi) - pi
    out["altitude"] = now.geodetic[:, 2] / 1e3
    out["lat:lng"] = now.geodetic[:, :2]


FILLS: Final[Mapping[str, Fill]] = {
    **_COMMON,
    **SENSOR_FILLS,
    "EKF_STATUS_REPORT": _estimate,
    "NAV_CONTROLLER_OUTPUT": _navigation,
    "RC_CHANNELS": _sticks,
    "MEMINFO": _memory,
    "POWER_STATUS": _power,
    "AHRS2": _second_attitude,
}

INTERVALS_US: Final[Mapping[str, int]] = {"HEARTBEAT": 1_000_000}
"""Nothing else is sent unasked."""

DATA_STREAMS: Final[Mapping[int, tuple[str, tuple[str, ...]]]] = {
    mav.MAV_DATA_STREAM_RAW_SENSORS: ("SR0_RAW_SENS", ("SCALED_PRESSURE",)),
    mav.MAV_DATA_STREAM_EXTENDED_STATUS: (
        "SR0_EXT_STAT",
        (
            *("SYS_STATUS", "POWER_STATUS", "MEMINFO", "MISSION_CURRENT", "GPS_RAW_INT"),
            *("NAV_CONTROLLER_OUTPUT", "POSITION_TARGET_GLOBAL_INT"),
        ),
    ),
    mav.MAV_DATA_STREAM_RC_CHANNELS: ("SR0_RC_CHAN", ("SERVO_OUTPUT_RAW", "RC_CHANNELS")),
    mav.MAV_DATA_STREAM_POSITION: ("SR0_POSITION", ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED")),
    mav.MAV_DATA_STREAM_EXTRA1: ("SR0_EXTRA1", ("ATTITUDE", "AHRS2")),
    mav.MAV_DATA_STREAM_EXTRA2: ("SR0_EXTRA2", ("VFR_HUD",)),
    mav.MAV_DATA_STREAM_EXTRA3: (
        "SR0_EXTRA3",
        ("SYSTEM_TIME", "BATTERY_STATUS", "EKF_STATUS_REPORT", "VIBRATION"),
    ),
}
"""By MAV_DATA_STREAM: the parameter that holds the rate, Hz, and the messages."""
