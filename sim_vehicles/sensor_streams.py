"""What telemetry tells of sensors, servos and targets: seldom asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from sim_vehicles.codec import mav
from sim_vehicles.streams import Fill, Readings, Record, quaternion

_POSITION_ONLY: Final = 65016
_SEA_LEVEL_HPA: Final = 1013.25
_SCALE_M: Final = 44330.0  # of the international barometric formula
_POWER: Final = 5.255


def _target(out: Record, now: Readings) -> None:
    asked, rows = now.snapshot.setpoints, now.rows
    here = now.snapshot.states.position[rows]
    wanted = asked.position[rows]
    places = now.wire_geodetic(np.where(np.isnan(wanted), here, wanted))
    out["time_boot_ms"] = now.boot_ms
    out["coordinate_frame"] = mav.MAV_FRAME_GLOBAL
    out["type_mask"] = _POSITION_ONLY
    out["lat_int:lon_int"] = places[:, :2]
    out["alt"] = places[:, 2] / 1e3


def _servos(out: Record, now: Readings) -> None:
    out["time_usec"] = now.t_us & 0xFFFFFFFF
    power = np.rint(1000 + 1000 * now.snapshot.states.thrust[now.rows])
    out["servo1_raw:servo8_raw"][:, :4] = power[:, np.newaxis]


def _vibration(out: Record, now: Readings) -> None:
    out["time_usec"] = now.t_us


def _pressure(out: Record, now: Readings) -> None:
    altitude = now.geodetic[:, 2] / 1e3
    out["time_boot_ms"] = now.boot_ms
    out["press_abs"] = _SEA_LEVEL_HPA * (1.0 - altitude / _SCALE_M) ** _POWER
    out["temperature"] = np.rint((15.0 - 0.0065 * altitude) * 100.0)


def _odometry(out: Record, now: Readings) -> None:
    states, rows = now.snapshot.states, now.rows
    ahead, side = np.cos(now.yaw), np.sin(now.yaw)
    north, east, down = now.velocity.T
    out["time_usec"] = now.t_us
    out["x:z"] = now.local
    out["q"] = quaternion(states.roll[rows], states.pitch[rows], now.yaw)
    out["vx:yawspeed"][:, 0] = north * ahead + east * side
    out["vx:yawspeed"][:, 1] = east * ahead - north * side
    out["vx:yawspeed"][:, 2] = down
    out["vx:yawspeed"][:, 3:] = now.rates
    out["pose_covariance"] = np.nan
    out["velocity_covariance"] = np.nan
    out["frame_id"] = mav.MAV_FRAME_LOCAL_NED
    out["child_frame_id"] = mav.MAV_FRAME_BODY_FRD
    out["estimator_type"] = mav.MAV_ESTIMATOR_TYPE_AUTOPILOT


SENSOR_FILLS: Final[Mapping[str, Fill]] = {
    "POSITION_TARGET_GLOBAL_INT": _target,
    "SERVO_OUTPUT_RAW": _servos,
    "VIBRATION": _vibration,
    "SCALED_PRESSURE": _pressure,
    "ODOMETRY": _odometry,
}
"""As ``sim_vehicles.streams.FILLS``."""
