"""Which driver flies a vehicle."""

from __future__ import annotations

from uavbridge.config import Mission
from uavbridge.mavlink.link import Link
from uavbridge.runner import assemble
from uavbridge.vehicle.api import Vehicle
from uavbridge.vehicle.mavlink import MavlinkVehicle


def driver_of(mission: Mission, link: Link, agent: int, system: int) -> Vehicle:
    """The vehicle of an agent, behind its link.

    Args:
        mission: names the driver of vehicles that are not simulated.
        link: to it.
        agent: whose it is.
        system: its MAVLink system id.

    Raises:
        ConfigError: the driver is not installed.
    """
    origin = assemble.origin(mission)
    timeout_s = assemble.patience(mission, 3.0)
    if mission.endpoint(agent) is None or mission.mavlink.driver == "uavbridge":
        return MavlinkVehicle(link, system, origin=origin, link_timeout_s=timeout_s)
    from uavbridge.vehicle.mavsdk.vehicle import MavsdkVehicle

    return MavsdkVehicle(link, system, origin=origin, link_timeout_s=timeout_s)
