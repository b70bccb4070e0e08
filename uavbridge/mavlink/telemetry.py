"""What one vehicle's messages say, kept as plain numbers until somebody looks.

Hundreds of messages arrive for every look, so a handler does no more than store;
``state`` turns what is stored into the mission's frame and units.
"""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, dist, isfinite, nan, radians
from typing import Any, Final

import numpy as np

from sim_vehicles.codec import mav
from sim_vehicles.geodesy import Geodetic, to_enu
from uavbridge.mavlink.flavour import Flavour, flavour_of
from uavbridge.mavlink.landings import Runway
from uavbridge.mavlink.local_frame import LocalFrame, heading_to_yaw, shifted
from uavbridge.vehicle.api import Mode, VehicleState

_ARMED: Final = int(mav.MAV_MODE_FLAG_SAFETY_ARMED)
_NO_AUTOPILOT: Final = int(mav.MAV_AUTOPILOT_INVALID)
_PREARM: Final = int(mav.MAV_SYS_STATUS_PREARM_CHECK)
_ACTIVE: Final = int(mav.MAV_STATE_ACTIVE)
_UNDEFINED: Final = int(mav.MAV_LANDED_STATE_UNDEFINED)
_AIRBORNE: Final = frozenset(
    {
        int(mav.MAV_LANDED_STATE_IN_AIR),
        int(mav.MAV_LANDED_STATE_TAKEOFF),
        int(mav.MAV_LANDED_STATE_LANDING),
    }
)
_NO_HEADING: Final = 65535
_ABSOLUTE: Final = int(mav.ESTIMATOR_POS_HORIZ_ABS)
_CONSTANT: Final = int(mav.ESTIMATOR_CONST_POS_MODE)
_REORDERED_MS: Final = 2000  # older than this is not a late datagram but another boot


class Telemetry:
    """Newest knowledge of one autopilot.

    Args:
        mission: where the mission's ENU frame has its origin.
    """

    def __init__(self, mission: Geodetic) -> None:
        self._mission = mission
        self.handlers: Final[dict[str, Callable[[Any, int], None]]] = {
            "HEARTBEAT": self._heartbeat,
            "LOCAL_POSITION_NED": self._local_position,
            "GLOBAL_POSITION_INT": self._global_position,
            "ATTITUDE": self._attitude,
            "SYS_STATUS": self._sys_status,
            "EXTENDED_SYS_STATE": self._extended_state,
            "GPS_GLOBAL_ORIGIN": self._global_origin,
            "HOME_POSITION": self._home_position,
            "EKF_STATUS_REPORT": self._estimate,
        }
        """What to do with a message (message, mission time in microseconds), by its name."""
        self.restarts_us: list[int] = []
        """Mission times at which the vehicle's own clock went back."""
        self.heartbeats = 0
        self.flavour: Flavour | str = "no heartbeat yet"
        """The make of autopilot, or why there is none to speak to."""
        self._forget()

    def _forget(self) -> None:
        """Know nothing, as before the first message."""
        self._boot_ms = self._local_ms = self._global_ms = self._attitude_ms = -1
        self._local: tuple[float, float, float, float, float, float] | None = None
        self._global: tuple[int, int, int, int, int, int] | None = None
        self.position_us = 0
        """When the newest position came, mission time."""
        self._heading_rad = 0.0
        self._has_attitude = False
        self._landed = _UNDEFINED
        self._active = False
        self.battery = nan
        self.armed = False
        self.mode = Mode.UNKNOWN
        self.mode_text = ""
        self.checks_failed = False
        self.estimate_ok: bool | None = None
        """The autopilot trusts its position; None: it does not tell."""
        self.frame: LocalFrame | None = None
        self.frame_exact = False
        """The frame's origin was told as such, not concluded from the home position."""
        self.has_home = False
        self._home: Geodetic | None = None
        self._set_out_rad: float | None = None  # heading at which it was armed

    @property
    def has_position(self) -> bool:
        """Some position is known, and the autopilot trusts it."""
        if self.estimate_ok is False:
            return False
        return (self._local is not None and self.frame is not None) or self._global is not None

    @property
    def disagreement_m(self) -> float:
        """How far apart its local and its global position are, in one frame; 0: only one is known.

        They are told in frames of their own: where they differ, home or height of one is wrong.
        """
        if self._local is None or self._global is None or self.frame is None:
            return 0.0
        lat, lon, alt = self._global[:3]
        told = to_enu(lat * 1e-7, lon * 1e-7, alt * 1e-3, self._mission)
        return dist(told.tolist(), self.frame.to_mission(*self._local[:3]))

    @property
    def in_air(self) -> bool:
        """Off the ground."""
        if self._landed == _UNDEFINED:  # not told yet: ArduPilot's status is active in flight
            return self.armed and self._active
        return self._landed in _AIRBORNE

    def _late(self, boot_ms: int, newest_ms: int, t_us: int) -> bool:
        """True: older than what is known. Notices a restart, after which nothing is known."""
        if boot_ms > self._boot_ms:
            self._boot_ms = boot_ms
        elif boot_ms < self._boot_ms - _REORDERED_MS:
            self._forget()
            self._boot_ms = boot_ms
            self.restarts_us.append(t_us)
            return False
        return boot_ms < newest_ms

    def _heartbeat(self, message: Any, t_us: int) -> None:
        if message.autopilot == _NO_AUTOPILOT:
            return
        self.heartbeats += 1
        flavour = self.flavour = flavour_of(message.autopilot, message.type)
        armed = bool(message.base_mode & _ARMED)
        if armed and not self.armed and self.heartbeats > 1:
            self._set_out_rad = self._heading_rad
        self.armed = armed
        self._active = message.system_status == _ACTIVE
        if not isinstance(flavour, str):
            self.mode, self.mode_text = flavour.mode(message.custom_mode)

    def _local_position(self, m: Any, t_us: int) -> None:
        if self._late(m.time_boot_ms, self._local_ms, t_us):
            return
        values = (m.x, m.y, m.z, m.vx, m.vy, m.vz)
        if not isfinite(sum(values)):
            return
        self._local_ms = m.time_boot_ms
        self._local = values
        self.position_us = t_us

    def _global_position(self, m: Any, t_us: int) -> None:
        if self._late(m.time_boot_ms, self._global_ms, t_us):
            return
        if not _on_earth(m.lat, m.lon) or (m.lat == 0 and m.lon == 0):  # 0, 0: no fix yet
            return
        self._global_ms = m.time_boot_ms
        self._global = (m.lat, m.lon, m.alt, m.vx, m.vy, m.vz)
        if self._local is None:
            self.position_us = t_us
        if not self._has_attitude and m.hdg != _NO_HEADING:
            self._heading_rad = radians(m.hdg / 100.0)

    def _attitude(self, m: Any, t_us: int) -> None:
        if self._late(m.time_boot_ms, self._attitude_ms, t_us) or not isfinite(m.yaw):
            return
        self._attitude_ms = m.time_boot_ms
        self._has_attitude = True
        self._heading_rad = m.yaw

    def _sys_status(self, m: Any, t_us: int) -> None:
        if 0 <= m.battery_remaining <= 100:
            self.battery = m.battery_remaining / 100.0
        checked = m.onboard_control_sensors_present & m.onboard_control_sensors_enabled & _PREARM
        self.checks_failed = bool(checked & ~m.onboard_control_sensors_health)

    def _estimate(self, m: Any, t_us: int) -> None:
        self.estimate_ok = bool(m.flags & _ABSOLUTE) and not m.flags & _CONSTANT

    def _extended_state(self, m: Any, t_us: int) -> None:
        self._landed = m.landed_state

    def _global_origin(self, m: Any, t_us: int) -> None:
        if not _on_earth(m.latitude, m.longitude):
            return
        origin = Geodetic(m.latitude * 1e-7, m.longitude * 1e-7, m.altitude * 1e-3)
        self.frame_exact = True
        if self.frame is None or self.frame.local != origin:
            self.frame = LocalFrame(origin, self._mission)

    def _home_position(self, m: Any, t_us: int) -> None:
        if not _on_earth(m.latitude, m.longitude):
            return
        self._home = home = Geodetic(m.latitude * 1e-7, m.longitude * 1e-7, m.altitude * 1e-3)
        if not isfinite(m.x + m.y + m.z):
            return
        self.has_home = True
        if not self.frame_exact:
            self.frame = LocalFrame(shifted(home, (-m.x, -m.y, -m.z)), self._mission)

    def runway(self) -> Runway:
        """Home, along the heading at which it was armed; else straight on from where it is."""
        here = self._mission
        if self._global is not None:
            here = Geodetic(self._global[0] * 1e-7, self._global[1] * 1e-7, 0.0)
        home = self._home or here
        heading_rad = self._set_out_rad
        if heading_rad is None:
            east, north, _ = to_enu(home.latitude_deg, home.longitude_deg, 0.0, here)
            heading_rad = atan2(east, north)
        return Runway(home, heading_rad)

    def state(
        self, *, link_ok: bool, waiting_for: tuple[str, ...], stale: bool = False
    ) -> VehicleState:
        """All of it, in the mission's frame; ``stale``: no position came for too long."""
        position, velocity = self._motion()
        return VehicleState(
            t_us=self.position_us,
            position=np.array(position),
            velocity=np.array(velocity),
            heading_rad=heading_to_yaw(self._heading_rad),
            mode=self.mode,
            mode_text=self.mode_text,
            armed=self.armed,
            in_air=self.in_air,
            battery=self.battery,
            has_position=self.has_position and not stale,
            link_ok=link_ok,
            waiting_for=waiting_for,
            kind="multirotor" if isinstance(self.flavour, str) else self.flavour.kind,
        )

    def _motion(self) -> tuple[Any, Any]:
        """Position and velocity, ENU, each three numbers."""
        if self._local is not None and self.frame is not None:
            n, e, d, vn, ve, vd = self._local
            return self.frame.to_mission(n, e, d), self.frame.velocity_to_mission(vn, ve, vd)
        if self._global is not None:
            lat, lon, alt, vn, ve, vd = self._global
            position = to_enu(lat * 1e-7, lon * 1e-7, alt * 1e-3, self._mission)
            return position, (ve / 100.0, vn / 100.0, -vd / 100.0)
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


def _on_earth(latitude_1e7: int, longitude_1e7: int) -> bool:
    return abs(latitude_1e7) <= 900_000_000 and abs(longitude_1e7) <= 1_800_000_000
