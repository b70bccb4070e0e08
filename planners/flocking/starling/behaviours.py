r"""The five behaviours of a starling, by priority (Chen 2023, section 2.1, Eqs. 2-9).

With C the centre of the nearest neighbours, v_nb their mean velocity, C_a the centre of the
whole flock and u(a -> b) a unit vector:

| priority | behaviour | when | acceleration |
| --- | --- | --- | --- |
| 1 | escape | an intruder is seen | K_a u(d -> i) (7) |
| 2 | return | d_ia > R_a | K_dr (d_ia - R_a) u(i -> C_a) + K_v (K_vr v_nb - v_i) (6) |
| 3 | gathering | d_ic > R_maxl | K_d (d_ic - R_maxl) u(i -> C) + K_v (v_nb - v_i) (4) |
| 3 | dispersal | d_ic < R_minl | K_d (R_minl - d_ic) u(C -> i) (5) |
| 4 | free flight | else | K_l (v_j - v_i) + K_rand dv (9), j drawn by (8); the best: K_rand dv |

| symbol | name |
| --- | --- |
| R_p, R_minl, R_maxl, R_a | ``perception_m``, ``near_m``, ``far_m``, ``cluster_m`` |
| K_d, K_v, K_dr, K_vr | ``gather``, ``match``, ``come_back``, ``come_back_speed`` |
| K_a, K_l, K_rand | ``escape``, ``learn``, ``explore`` |

DEVIATION: Eq. (7) as printed flies into the danger, Eq. (8) as printed does not sum to one;
``signs = "printed"`` has both as printed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.flocking.starling.near import Near, unit
from planners.flocking.starling.rules import StarlingRules
from planners.types import F64, I64, Bools

FREE, GATHERING, DISPERSAL, RETURN, ESCAPE = range(5)
NAMES = ("free", "gathering", "dispersal", "return", "escape")


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What every aircraft knows beside its neighbours."""

    aim: F64  # (..., 3) m, the target
    centre: F64  # (..., n, 3) m, C_a as known to each
    intruders: F64  # (..., m, 3) m; m may be 0
    danger: Bools  # (..., n) the space is not safe
    alarm: Bools  # (..., n) for an intruder's sake


def behave(
    position: F64,
    velocity: F64,
    near: Near,
    around: Surroundings,
    chance: F64,
    noise: F64,
    rules: StarlingRules,
) -> tuple[F64, I64]:
    """Accelerations (..., n, 3) m/s^2 and the behaviours (..., n) they come from.

    Args:
        position: (..., n, 3) m.
        velocity: (..., n, 3) m/s.
        near: the nearest neighbours.
        around: what else is known.
        chance: (..., n) uniform in [0, 1): draws the one that is learnt from.
        noise: (..., n, 3) standard normal: dv of Eq. (9).
        rules: distances and gains.
    """
    centre = near.mean(near.offset)  # Eq. (2), from the aircraft
    distance = np.sqrt((centre * centre).sum(axis=-1))  # d_ic
    matching = np.where(near.some[..., None], near.mean(near.velocity), velocity)  # Eq. (3)
    home = around.centre - position
    away = np.sqrt((home * home).sum(axis=-1))  # d_ia
    reach = np.where(around.danger, rules.cluster_danger_m, rules.cluster_m)  # R_a
    far = rules.far_m + np.where(around.danger, rules.danger_extra_m, 0.0)
    close = rules.near_m + np.where(around.alarm, rules.danger_extra_m, 0.0)
    flee, threatened = escape(position, around.intruders, rules)

    mode = np.full(distance.shape, FREE, np.int64)
    mode[near.some & (distance < close)] = DISPERSAL
    mode[near.some & (distance > far)] = GATHERING
    mode[away > reach] = RETURN
    mode[threatened] = ESCAPE

    to_centre, to_all = unit(centre), unit(home)
    gathering = rules.gather * (distance - far)[..., None] * to_centre
    gathering += rules.match * (matching - velocity)  # Eq. (4)
    dispersal = -rules.gather * (close - distance)[..., None] * to_centre  # Eq. (5)
    back = rules.come_back * (away - reach)[..., None] * to_all
    back += rules.match * (rules.come_back_speed * matching - velocity)  # Eq. (6)
    free = learning(position, velocity, near, around.aim, chance, rules) + rules.explore * noise
    out = np.zeros_like(position)
    choices = (free, gathering, dispersal, back, flee)
    for which, wish in enumerate(choices):
        out = np.where((mode == which)[..., None], wish, out)
    return out, mode


def escape(position: F64, intruders: F64, rules: StarlingRules) -> tuple[F64, Bools]:
    """Eq. (7): accelerations (..., n, 3) from the nearest intruder seen, and who sees one."""
    count = position.shape[-2]
    if not intruders.shape[-2]:
        return np.zeros_like(position), np.zeros((*position.shape[:-2], count), np.bool_)
    offset = position[..., :, None, :] - intruders[..., None, :, :]
    distance = np.sqrt((offset * offset).sum(axis=-1))
    which = np.argmin(distance, axis=-1)[..., None]
    least = np.take_along_axis(distance, which, axis=-1)[..., 0]
    away = np.take_along_axis(offset, which[..., None], axis=-2)[..., 0, :]
    seen = least <= rules.perception_m
    wish = -away if rules.signs == "printed" else unit(away)
    return np.where(seen[..., None], rules.escape * wish, 0.0), np.asarray(seen)


def learning(
    position: F64, velocity: F64, near: Near, aim: F64, chance: F64, rules: StarlingRules
) -> F64:
    """Eqs. (8), (9) without the random part: (..., n, 3), zero for the best placed."""
    own = np.sqrt(((aim[..., None, :] - position) ** 2).sum(axis=-1))
    theirs = np.sqrt(
        ((aim[..., None, None, :] - position[..., None, :] - near.offset) ** 2).sum(-1)
    )
    theirs = np.where(near.there, theirs, np.inf)
    weight = 1.0 / np.maximum(theirs, 1.0)
    best = own <= theirs.min(axis=-1, initial=np.inf)
    if rules.signs == "printed":  # does not sum to one: mostly nobody is drawn
        finite = np.where(near.there, theirs, 0.0).sum(axis=-1, keepdims=True)
        share = weight / np.where(finite > 0.0, finite, np.inf)
    else:
        share = weight / np.maximum(weight.sum(axis=-1, keepdims=True), 1e-300)  # Eq. (8)
    drawn = np.cumsum(share, axis=-1) > chance[..., None]
    some = drawn.any(axis=-1) & ~best
    if not near.there.shape[-1]:
        return np.zeros_like(velocity)
    place = np.argmax(drawn, axis=-1)[..., None, None]
    model = np.take_along_axis(near.velocity, place, axis=-2)[..., 0, :]
    return np.where(some[..., None], rules.learn * (model - velocity), 0.0)
