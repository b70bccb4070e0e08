"""Which driver flies a vehicle."""

from __future__ import annotations

from collections.abc import Mapping

from uavbridge.config import Mission
from uavbridge.mavlink.hub import HubChannel
from uavbridge.mavlink.link import Link
from uavbridge.runner import assemble
from uavbridge.runner.fitness import Attached
from uavbridge.vehicle.api import Vehicle
from uavbridge.vehicle.mavlink import MavlinkVehicle


def driver_of(
    mission: Mission,
    link: Link,
    agent: int,
    attached: Mapping[int, Attached],
    system: int | None = None,
) -> Vehicle:
    """The vehicle of an agent, behind its link.

    Args:
        mission: names the driver of vehicles that are not simulated.
        link: to it.
        agent: whose it is.
        attached: vehicles that were found.
        system: id of one that was not; None: its agent's number.

    Raises:
        ConfigError: the driver is not installed.
    """
    origin = assemble.origin(mission)
    timeout_s = assemble.patience(mission, 3.0)
    found = attached.get(agent)
    system = found.system if found else system or agent
    if mission.endpoint(agent) is None or mission.mavlink.driver == "uavbridge":
        twins = found.link.twins if found and isinstance(found.link, HubChannel) else tuple
        return MavlinkVehicle(link, system, origin=origin, link_timeout_s=timeout_s, twins=twins)
    from uavbridge.vehicle.mavsdk.vehicle import MavsdkVehicle

    return MavsdkVehicle(link, system, origin=origin, link_timeout_s=timeout_s)
