"""MAVSDK's plugins of one vehicle, in plain values; and the calls that carry commands out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, isnan, nan
from typing import Any

from sim_vehicles.geodesy import Geodetic
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Disarm,
    Follow,
    HoldPosition,
    LandHere,
    RestoreNet,
    ReturnHome,
    SetNet,
    TakeOff,
)
from uavbridge.vehicle.mavsdk.nets import Nets


@dataclass(frozen=True, slots=True)
class Seen:
    """One look at MAVSDK's telemetry."""

    connected: bool
    place: tuple[float, ...]  # local NED m and m/s; empty: not known
    heading_deg: float  # 0: not known
    mode: str
    armed: bool
    in_air: bool
    armable: bool
    battery: float  # 0..1, NaN: not known


class Plugins:
    """MAVSDK's plugins of one system, in plain values."""

    def __init__(self, system: Any, said: Callable[[Any, Any], None]) -> None:
        from mavsdk.plugins import action, offboard, param, telemetry

        self._system = system
        self._offboard_module = offboard
        self._landed_states = telemetry.LandedState
        self.action = action.Action(system)
        self.offboard = offboard.Offboard(system)
        self.telemetry = telemetry.Telemetry(system)
        make = str(system.autopilot_type().name)
        self.is_ardupilot = make == "ARDUPILOT"
        self.nets = Nets(param.Param(system), make)
        self.telemetry.subscribe_status_text(said)

    def look(self) -> Seen:
        """Newest values."""
        telemetry = self.telemetry
        now = telemetry.position_velocity_ned()
        at, speed = now.position, now.velocity
        place = (
            at.north_m, at.east_m, at.down_m,
            speed.north_m_s, speed.east_m_s, speed.down_m_s,
        )  # fmt: skip
        heading_deg = telemetry.attitude_euler().yaw_deg
        battery = telemetry.battery().remaining_percent
        return Seen(
            connected=self._system.is_connected(),
            place=place if all(map(isfinite, place)) else (),
            heading_deg=heading_deg if isfinite(heading_deg) else 0.0,
            mode=telemetry.flight_mode().name,
            armed=telemetry.armed(),
            in_air=telemetry.landed_state()
            not in (self._landed_states.ON_GROUND, self._landed_states.UNKNOWN),
            armable=telemetry.health().is_armable,
            battery=nan if isnan(battery) else battery / 100.0,
        )

    def origin(self) -> Geodetic:
        """Of its local frame. Raises MAVSDK's error while it has none."""
        found = self.telemetry.get_gps_global_origin()
        return Geodetic(found.latitude_deg, found.longitude_deg, found.altitude_m)

    def follow(self, yaw_deg: float) -> None:
        """Switch to the mode that follows setpoints. Raises MAVSDK's error."""
        if not self.offboard.is_active():
            self.velocity(0.0, 0.0, 0.0, yaw_deg)
        self.offboard.start()

    def stand_by(self, yaw_deg: float) -> None:
        """A mode in which it takes off, and arms whatever it landed in."""
        if self.is_ardupilot and not self.telemetry.in_air():
            self.follow(yaw_deg)
        elif not self.telemetry.armed() and self.telemetry.flight_mode().name == "OFFBOARD":
            self.action.hold()

    def velocity(self, n: float, e: float, d: float, yaw_deg: float) -> None:
        """A setpoint in its local frame."""
        self.offboard.set_velocity_ned(self._offboard_module.VelocityNedYaw(n, e, d, yaw_deg))

    def position(self, n: float, e: float, d: float, yaw_deg: float) -> None:
        """A setpoint in its local frame."""
        self.offboard.set_position_ned(self._offboard_module.PositionNedYaw(n, e, d, yaw_deg))


def call_of(plugins: Plugins, command: Command, yaw_deg: float) -> Callable[[], None]:
    """What the worker does for a command; raises MAVSDK's errors."""

    def call() -> None:
        action = plugins.action
        match command:
            case Arm():
                action.arm()  # never arm_force: that disarms
            case Disarm():
                action.disarm()
            case TakeOff(height_m):
                plugins.stand_by(yaw_deg)
                action.set_takeoff_altitude(height_m)
                action.takeoff()
            case Follow():
                plugins.follow(yaw_deg)
            case HoldPosition():
                action.hold()
            case LandHere():
                action.land()
            case ReturnHome():
                action.return_to_launch()
            case SetNet(net):
                plugins.stand_by(yaw_deg)
                plugins.nets.cast(net)
            case RestoreNet():
                plugins.nets.restore()
            case _:
                raise ValueError(f"{command} is no command")

    return call
