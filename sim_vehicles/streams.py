"""What each telemetry message says: states of many vehicles into its wire fields.

A ``Fill`` writes the fields of one message for k vehicles at once. MAVLink's units
(millimetres, 1e-7 degrees, NED) appear here and go no further.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sim_vehicles.codec import mav
from sim_vehicles.dynamics.model import F64, Bools, Setpoints, States
from sim_vehicles.geodesy import LocalGeodesy, ned_from_enu, yaw_ned_from_enu

Ints: TypeAlias = npt.NDArray[np.int64]
Record: TypeAlias = npt.NDArray[Any]
Rows: TypeAlias = slice | Ints

SENSORS: Final[int] = (
    mav.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mav.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mav.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mav.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
    | mav.MAV_SYS_STATUS_SENSOR_GPS
    | mav.MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
    | mav.MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION
    | mav.MAV_SYS_STATUS_SENSOR_YAW_POSITION
    | mav.MAV_SYS_STATUS_SENSOR_Z_ALTITUDE_CONTROL
    | mav.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
    | mav.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
    | mav.MAV_SYS_STATUS_AHRS
    | mav.MAV_SYS_STATUS_SENSOR_BATTERY
    | mav.MAV_SYS_STATUS_PREARM_CHECK
)
"""Health bits of a vehicle with nothing wrong; without the last one it is not ready to arm."""

LOW_CHARGE: Final = 0.15  # PX4's BAT_LOW_THR and BAT_CRIT_THR
CRITICAL_CHARGE: Final = 0.07
_FORWARD_RIGHT_DOWN: Final = np.array([1.0, 1.0, -1.0])
_IGNORE_BITS: Final = np.array([1, 2, 4, 8, 16, 32, 64, 128, 256, 1024, 2048])
_UNKNOWN_U16: Final = 0xFFFF
_WIRE_GEODETIC: Final = np.array([1e7, 1e7, 1e3])  # 1e-7 degrees, mm
_UNIX_START_US: Final = 1_767_225_600_000_000  # 2026-01-01: the same for every run


@dataclass(slots=True, eq=False)
class TelemetrySnapshot:
    """What the vehicles report, at one time. Arrays may be written in place and reused."""

    states: States  # ENU, fleet frame
    setpoints: Setpoints  # what the autopilots ask for now; NaN: not controlled
    armed: Bools  # (n,)
    base_mode: Ints  # (n,) MAV_MODE_FLAG bits; SAFETY_ARMED is added from ``armed``
    custom_mode: Ints  # (n,) the autopilot's own mode number
    system_status: Ints  # (n,) MAV_STATE
    landed_state: Ints  # (n,) MAV_LANDED_STATE
    sensors_present: Ints  # (n,) MAV_SYS_STATUS_SENSOR bits, see SENSORS
    sensors_health: Ints  # (n,) MAV_SYS_STATUS_SENSOR bits
    autopilot: Ints  # (n,) MAV_AUTOPILOT
    vehicle_type: Ints  # (n,) MAV_TYPE
    mission_item: Ints  # (n,) current mission item
    mission_count: Ints  # (n,) items of the stored mission
    gps_lost: Bools | None = None  # (n,) the receiver has failed; None: of nobody


@dataclass(eq=False)
class Readings:
    """A snapshot of some vehicles, in the units of the wire where many messages need them."""

    t_us: int
    snapshot: TelemetrySnapshot
    rows: Rows  # which vehicles
    geodesy: LocalGeodesy  # of the fleet frame
    starts: F64  # (n, 3) ENU m: where each vehicle's own local frame is zero
    homes: F64  # (n, 3) ENU m

    @property
    def boot_ms(self) -> int:
        """Milliseconds since start, as the 32 bits of the wire."""
        return self.t_us // 1000 & 0xFFFFFFFF

    @cached_property
    def local(self) -> F64:
        """Position (k, 3), NED m from each vehicle's start."""
        return ned_from_enu(self.snapshot.states.position[self.rows] - self.starts[self.rows])

    @cached_property
    def velocity(self) -> F64:
        """Velocity (k, 3), NED m/s."""
        return ned_from_enu(self.snapshot.states.velocity[self.rows])

    @cached_property
    def speed(self) -> F64:
        """Horizontal speed (k,), m/s."""
        return np.hypot(self.velocity[:, 0], self.velocity[:, 1])

    @cached_property
    def yaw(self) -> F64:
        """Yaw (k,) from north, clockwise, -pi..pi."""
        return yaw_ned_from_enu(self.snapshot.states.yaw[self.rows])

    @property
    def rates(self) -> F64:
        """Body rates (k, 3), rad/s about forward, right, down."""
        rates: F64 = self.snapshot.states.rates[self.rows] * _FORWARD_RIGHT_DOWN
        return rates

    @cached_property
    def heading_cdeg(self) -> F64:
        """Heading (k,) in hundredths of a degree, 0..35999."""
        return np.rint(self.yaw * (18000 / pi)) % 36000

    @cached_property
    def geodetic(self) -> F64:
        """Position (k, 3): latitude and longitude in 1e-7 degrees, altitude in mm, whole."""
        return self.wire_geodetic(self.snapshot.states.position[self.rows])

    def wire_geodetic(self, enu: F64) -> F64:
        """Latitude and longitude in 1e-7 degrees, altitude in mm (k, 3) of ENU m (k, 3)."""
        places: F64 = np.rint(self.geodesy.to_geodetic(enu) * _WIRE_GEODETIC)
        return places

    @cached_property
    def charge(self) -> F64:
        """Battery charge (k,), 0..1."""
        return self.snapshot.states.battery[self.rows]


Fill: TypeAlias = Callable[[Record, Readings], None]


def _heartbeat(out: Record, now: Readings) -> None:
    snapshot, rows = now.snapshot, now.rows
    out["custom_mode"] = snapshot.custom_mode[rows]
    out["type"] = snapshot.vehicle_type[rows]
    out["autopilot"] = snapshot.autopilot[rows]
    armed = snapshot.armed[rows] * mav.MAV_MODE_FLAG_SAFETY_ARMED
    out["base_mode"] = snapshot.base_mode[rows] | armed
    out["system_status"] = snapshot.system_status[rows]
    out["mavlink_version"] = 3


def _attitude(out: Record, now: Readings) -> None:
    states, rows = now.snapshot.states, now.rows
    out["time_boot_ms"] = now.boot_ms
    values = out["roll:yawspeed"]
    values[:, 0] = states.roll[rows]
    values[:, 1] = states.pitch[rows]
    values[:, 2] = now.yaw
    values[:, 3:] = now.rates


def quaternion(roll: F64, pitch: F64, yaw: F64) -> F64:
    """Attitude (k, 4) as w, x, y, z from north, east, down."""
    halves = (roll / 2, pitch / 2, yaw / 2)
    (cr, cp, cy), (sr, sp, sy) = map(np.cos, halves), map(np.sin, halves)
    return np.stack(
        (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ),
        axis=-1,
    )


def _attitude_quaternion(out: Record, now: Readings) -> None:
    states, rows = now.snapshot.states, now.rows
    out["time_boot_ms"] = now.boot_ms
    values = out["q1:yawspeed"]
    values[:, :4] = quaternion(states.roll[rows], states.pitch[rows], now.yaw)
    values[:, 4:] = now.rates


def _local_position(out: Record, now: Readings) -> None:
    out["time_boot_ms"] = now.boot_ms
    values = out["x:vz"]
    values[:, :3] = now.local
    values[:, 3:] = now.velocity


def _global_position(out: Record, now: Readings) -> None:
    out["time_boot_ms"] = now.boot_ms
    places = out["lat:relative_alt"]
    places[:, :3] = now.geodetic
    heights = now.snapshot.states.position[now.rows, 2] - now.homes[now.rows, 2]
    places[:, 3] = np.rint(heights * 1e3)
    out["vx:vz"] = np.rint(now.velocity * 100)
    out["hdg"] = now.heading_cdeg


def _gps_raw(out: Record, now: Readings) -> None:
    out["time_usec"] = now.t_us
    out["fix_type"] = mav.GPS_FIX_TYPE_3D_FIX
    if now.snapshot.gps_lost is not None:
        out["fix_type"][now.snapshot.gps_lost[now.rows]] = mav.GPS_FIX_TYPE_NO_FIX
    out["lat:alt"] = now.geodetic
    out["alt_ellipsoid"] = now.geodetic[:, 2]
    out["eph"] = 70  # dilution of precision, in hundredths
    out["epv"] = 100
    out["vel"] = np.rint(now.speed * 100)
    course = np.arctan2(now.velocity[:, 1], now.velocity[:, 0])
    out["cog"] = np.rint(course * (18000 / pi)) % 36000
    out["satellites_visible"] = 14
    out["h_acc"] = 500  # mm
    out["v_acc"] = 800
    out["vel_acc"] = 100


def _system_status(out: Record, now: Readings) -> None:
    snapshot, rows = now.snapshot, now.rows
    out["onboard_control_sensors_present"] = snapshot.sensors_present[rows]
    out["onboard_control_sensors_enabled"] = snapshot.sensors_present[rows]
    out["onboard_control_sensors_health"] = snapshot.sensors_health[rows]
    out["load"] = 250  # per mille
    out["voltage_battery"] = np.rint(snapshot.states.voltage[rows] * 1e3)
    out["current_battery"] = np.rint(snapshot.states.current[rows] * 1e2)
    out["battery_remaining"] = np.rint(now.charge * 100)


def _battery(out: Record, now: Readings) -> None:
    states, rows = now.snapshot.states, now.rows
    out["battery_function"] = mav.MAV_BATTERY_FUNCTION_ALL
    out["type"] = mav.MAV_BATTERY_TYPE_LIPO
    out["temperature"] = 0x7FFF  # unknown
    out["voltages"] = _UNKNOWN_U16
    out["voltages"][:, 0] = np.rint(states.voltage[rows] * 1e3)  # the whole pack
    out["current_battery"] = np.rint(states.current[rows] * 1e2)
    out["current_consumed"] = -1
    out["energy_consumed"] = -1
    out["battery_remaining"] = np.rint(now.charge * 100)
    out["charge_state"] = np.select(
        [now.charge > LOW_CHARGE, now.charge > CRITICAL_CHARGE],
        [mav.MAV_BATTERY_CHARGE_STATE_OK, mav.MAV_BATTERY_CHARGE_STATE_LOW],
        mav.MAV_BATTERY_CHARGE_STATE_CRITICAL,
    )


def _extended_state(out: Record, now: Readings) -> None:
    out["landed_state"] = now.snapshot.landed_state[now.rows]


def _system_time(out: Record, now: Readings) -> None:
    out["time_unix_usec"] = _UNIX_START_US + now.t_us
    out["time_boot_ms"] = now.boot_ms


def _vfr_hud(out: Record, now: Readings) -> None:
    airspeed = now.snapshot.states.airspeed[now.rows]
    out["airspeed"] = np.where(np.isnan(airspeed), now.speed, airspeed)
    out["groundspeed"] = now.speed
    out["heading"] = now.heading_cdeg // 100
    out["throttle"] = np.rint(now.snapshot.states.thrust[now.rows] * 100)
    out["alt"] = now.geodetic[:, 2] / 1e3
    out["climb"] = -now.velocity[:, 2]


def _altitude(out: Record, now: Readings) -> None:
    heights = now.snapshot.states.position[now.rows, 2]
    out["time_usec"] = now.t_us
    out["altitude_monotonic"] = now.geodetic[:, 2] / 1e3
    out["altitude_amsl"] = now.geodetic[:, 2] / 1e3
    out["altitude_local"] = -now.local[:, 2]
    out["altitude_relative"] = heights - now.homes[now.rows, 2]
    out["altitude_terrain"] = np.nan
    out["bottom_clearance"] = heights - now.snapshot.states.ground[now.rows]


def _home(out: Record, now: Readings) -> None:
    homes = now.homes[now.rows]
    out["time_usec"] = now.t_us
    out["latitude:altitude"] = now.wire_geodetic(homes)
    out["x:z"] = ned_from_enu(homes - now.starts[now.rows])
    out["q"][:, 0] = 1.0


def _global_origin(out: Record, now: Readings) -> None:
    out["time_usec"] = now.t_us
    out["latitude:altitude"] = now.wire_geodetic(now.starts[now.rows])


def _mission_current(out: Record, now: Readings) -> None:
    out["seq"] = now.snapshot.mission_item[now.rows]
    out["total"] = now.snapshot.mission_count[now.rows]


def _position_target(out: Record, now: Readings) -> None:
    asked, rows = now.snapshot.setpoints, now.rows
    values = np.full((len(out), 11), np.nan)  # accelerations are never asked for
    values[:, :3] = ned_from_enu(asked.position[rows] - now.starts[rows])
    values[:, 3:6] = ned_from_enu(asked.velocity[rows])
    values[:, 9] = yaw_ned_from_enu(asked.yaw[rows])
    values[:, 10] = -asked.yaw_rate[rows]
    out["time_boot_ms"] = now.boot_ms
    out["x:yaw_rate"] = values
    out["coordinate_frame"] = mav.MAV_FRAME_LOCAL_NED
    out["type_mask"] = np.isnan(values) @ _IGNORE_BITS


FILLS: Final[dict[str, Fill]] = {
    "HEARTBEAT": _heartbeat,
    "SYS_STATUS": _system_status,
    "SYSTEM_TIME": _system_time,
    "GPS_RAW_INT": _gps_raw,
    "ATTITUDE": _attitude,
    "ATTITUDE_QUATERNION": _attitude_quaternion,
    "LOCAL_POSITION_NED": _local_position,
    "GLOBAL_POSITION_INT": _global_position,
    "MISSION_CURRENT": _mission_current,
    "GPS_GLOBAL_ORIGIN": _global_origin,
    "VFR_HUD": _vfr_hud,
    "POSITION_TARGET_LOCAL_NED": _position_target,
    "ALTITUDE": _altitude,
    "BATTERY_STATUS": _battery,
    "HOME_POSITION": _home,
    "EXTENDED_SYS_STATE": _extended_state,
}
"""Every message that can be streamed or requested here."""

DEFAULT_INTERVALS_US: Final[dict[str, int]] = {
    "HEARTBEAT": 1_000_000,
    "ATTITUDE": 100_000,
    "LOCAL_POSITION_NED": 100_000,
    "GLOBAL_POSITION_INT": 100_000,
    "SYS_STATUS": 500_000,
    "BATTERY_STATUS": 500_000,
    "EXTENDED_SYS_STATE": 500_000,
    "GPS_RAW_INT": 500_000,
    "VFR_HUD": 500_000,
    "SYSTEM_TIME": 1_000_000,
    "MISSION_CURRENT": 1_000_000,
    "HOME_POSITION": 2_000_000,
}
"""Sent unasked, microseconds of simulated time between two."""
