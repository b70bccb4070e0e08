r"""What keeps single aircraft apart: the half-spring (Chen 2023, Eq. 10), and looking ahead.

    v_s' = sum_j K_spring (d_ij - R_spring) u(i -> j) + K_vs (v_j - v_i)          (10)
    R_spring = R_e below R_e, R_m above R_m, d_ij between (no force)

DEVIATION: the signs as printed attract below R_e and drive the velocities apart;
``signs = "printed"`` has them so. K_spring is smaller beyond R_m (``pull``) than within R_e
(``spring``): with seven neighbours the sum of the pulls would hide the push of one.

Added, the paper has nothing: ``dodge``, away from where a neighbour will be at the closest
approach. With speeds from 40 to 100 m/s on one heading, R_e is passed within a second.
"""

from __future__ import annotations

import numpy as np

from planners.flocking.starling.near import Near, unit
from planners.flocking.starling.rules import StarlingRules
from planners.types import F64


def half_spring(velocity: F64, near: Near, rules: StarlingRules) -> F64:
    """Eq. (10): accelerations (..., n, 3) m/s^2."""
    distance = np.where(near.there, near.distance, rules.repel_m)
    pushed = rules.spring * np.minimum(distance - rules.repel_m, 0.0)
    pulled = rules.pull * np.maximum(distance - rules.hold_m, 0.0)
    along = unit(near.offset) * (pushed + pulled)[..., None]
    matched = rules.damp * (near.velocity - velocity[..., None, :])
    each = np.where(near.there[..., None], along + matched, 0.0)
    total = each.sum(axis=-2)
    return np.asarray(-total if rules.signs == "printed" else total)


def dodge(velocity: F64, near: Near, rules: StarlingRules) -> F64:
    """Accelerations (..., n, 3) m/s^2 away from closest approaches below R_e."""
    relative = near.velocity - velocity[..., None, :]
    speed2 = (relative * relative).sum(axis=-1)
    closing = -(near.offset * relative).sum(axis=-1)
    when = np.clip(closing / np.where(speed2 > 1e-9, speed2, np.inf), 0.0, rules.anticipate_s)
    miss = near.offset + relative * when[..., None]
    distance = np.sqrt((miss * miss).sum(axis=-1))
    # Head on there is no way to miss by: both turn to their own right and part.
    aside = np.cross(near.offset, (0.0, 0.0, 1.0))
    direction = np.where((distance > 1.0)[..., None], -unit(miss), unit(aside))
    urgency = np.maximum(1.0 - distance / max(rules.repel_m, 1e-9), 0.0)
    urgency = urgency * (1.0 - when / rules.anticipate_s)
    counted = near.there & (closing > 0.0)
    each = np.where(counted[..., None], direction * urgency[..., None], 0.0)
    return np.asarray(rules.dodge * each.sum(axis=-2))
