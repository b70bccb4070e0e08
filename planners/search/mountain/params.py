"""Parameters of the search in mountains: Zhou 2023, Table 2, and the readings that are open.

| symbol | name |
| --- | --- |
| Vm | ``speed_m_s`` |
| beta | ``climb_rad`` |
| d_com, d_tar | ``Scenario.radio_range_m``, ``detection_m`` |
| N_m | ``members`` |
| n_phi, Delta l | ``directions``, ``lattice_m`` |
| c_1, c_2, omega, lambda | ``own_pull``, ``shared_pull``, ``inertia``, ``response`` |

alpha, d_0, m and Q belong to the world, not to the planner; d_obs is never needed, as
Theta looks no further than one step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from planners.planner import param

BETA_RAD = math.radians(30.0)


@dataclass(frozen=True, slots=True)
class MountainParams:
    """Table 2, and what the paper leaves open."""

    speed_m_s: float = param(10.0, unit="m/s", doc="Vm, speed when roaming, at most", low=0.1)
    climb_rad: float = param(
        BETA_RAD, unit="rad", doc="beta, steepest climb; 30 degrees", low=0.0, high=1.5
    )
    detection_m: float = param(100.0, unit="m", doc="d_tar, range of the target sensor", low=0.0)
    members: int = param(6, unit="1", doc="N_m, most members of a suballiance", low=1, high=16)
    own_pull: float = param(1.0, unit="1", doc="c_1, pull of the own best place", low=0.0)
    shared_pull: float = param(1.2, unit="1", doc="c_2, pull of the suballiance's best", low=0.0)
    inertia: float = param(0.5, unit="1", doc="omega, weight of the velocity", low=0.0)
    response: float = param(0.1, unit="1", doc="lambda, share of a change made in a step", low=0.0)
    directions: int = param(360, unit="1", doc="n_phi, headings that are tried", low=4, high=3600)
    lattice_m: float = param(1.0, unit="m", doc="Delta l, spacing of obstacle points", low=0.01)
    repel: str = param(
        "far",
        unit="-",
        doc="range of virtual forces: min(d_com, d_tar), or min(d_com, 2 d_tar)",
        choices=("near", "far"),
    )
    boundary: str = param(
        "reflect",
        unit="-",
        doc="at the boundary the part that crosses is turned, or cut",
        choices=("reflect", "clip"),
    )
    escape: str = param(
        "roam",
        unit="-",
        doc="against the stall of Eq. (9): roam anew, best of this step only, or none (literal)",
        choices=("roam", "current", "none"),
    )
    stall_m_s: float = param(0.5, unit="m/s", doc="members slower than this have stalled", low=0.0)
    rest_steps: int = param(5, unit="1", doc="steps that a stalled member roams", low=1)
    forget_s: float = param(5.0, unit="s", doc="neighbours not heard for longer are gone", low=0.0)

    def repel_m(self, radio_m: float) -> float:
        """Range of the virtual forces: before Fig. 2 ("near"), or after it ("far")."""
        return min(radio_m, self.detection_m * (1.0 if self.repel == "near" else 2.0))
