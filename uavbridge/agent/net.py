"""What an autopilot is told to hold to on its own, should the bridge fall silent."""

from __future__ import annotations

from math import hypot

from uavbridge.agent.plan import AgentPlan
from uavbridge.safety.half_space import Vector
from uavbridge.vehicle.api import Net

MARGIN_M = 20.0  # from what the bridge allows to where the autopilot's own net begins
LEAST_RETURN_M = 5.0  # above home


def net_of(plan: AgentPlan, home: Vector, take_off_m: float) -> Net:
    """Fence, return height and patience around a home (ENU m); over terrain above all of it."""
    way, terrain = plan.envelope.holding(home), plan.terrain
    x, y, z = home
    highest_m = 0.0 if terrain is None else float(terrain.heights.max())
    corners = [(e, n) for e in (way.west_m, way.east_m) for n in (way.south_m, way.north_m)]
    setpoint_loss_s, link_loss_s = plan.net or (0.0, 0.0)
    return Net(
        fence_radius_m=max(hypot(e - x, n - y) for e, n in corners) + MARGIN_M,
        fence_height_m=highest_m + way.altitude_max_m - z + MARGIN_M,
        return_height_m=max(highest_m + plan.return_height_m - z, LEAST_RETURN_M),
        setpoint_loss_s=setpoint_loss_s,
        link_loss_s=link_loss_s,
        take_off_m=take_off_m,
    )
