r"""One update of a whole flock (Chen 2023, Eq. 11 and Fig. 5).

    v_k' = K_a a + K_v v_s' + K_route (V u(i -> w_i) - v) + dodge                 (11), and ours

The paper's sum has no term for the desired speed nor for the way: with strict priorities an
aircraft that gathers or disperses has no steering. Both are in the third term, in all modes. Its
point w_i lies as far beside the way as a share of the aircraft's offset from the flock, less in
danger, so that the flock flies abreast where it can and in a narrow formation where it must. The
ground comes last, as a danger that is seen ahead (``ridge``). High ground beside an aircraft and
ground ahead make the space a danger space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.flocking.starling import ridge, space, spring
from planners.flocking.starling.behaviours import ESCAPE, Surroundings, behave
from planners.flocking.starling.near import nearest, seen, unit
from planners.flocking.starling.ridge import Watch
from planners.flocking.starling.rules import StarlingRules
from planners.flocking.starling.wing import Wing
from planners.terrain import Terrain
from planners.types import F64, I64, Bools


@dataclass(frozen=True, slots=True, eq=False)
class Flock:
    """Where the aircraft are, how they move, and what they have heard of disturbances."""

    position: F64  # (..., n, 3) m
    velocity: F64  # (..., n, 3) m/s
    danger_s: F64  # (..., n) since the last disturbance known; inf: none
    alarm_s: F64  # (..., n) the same for intruders

    @staticmethod
    def of(position: F64, velocity: F64) -> Flock:
        """Undisturbed."""
        quiet = np.full(position.shape[:-1], np.inf)
        return Flock(position, velocity, quiet, quiet)


@dataclass(frozen=True, slots=True, eq=False)
class Update:
    """What the aircraft decide."""

    acceleration: F64  # (..., n, 3) m/s^2
    mode: I64  # (..., n) of ``behaviours``; ESCAPE too where the ground is escaped from
    danger_s: F64
    alarm_s: F64
    visible: Bools  # (..., n, n)


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """What does not change during a flight."""

    rules: StarlingRules
    wing: Wing
    watch: Watch
    terrain: Terrain | None
    wide: Terrain | None  # the same, widened by the distance at which ground disturbs
    aim: F64  # (..., 3) m


def update(
    flock: Flock,
    towards: F64,
    intruders: F64,
    chance: F64,
    noise: F64,
    setting: Setting,
    step_s: float,
    visible: Bools | None = None,
) -> Update:
    """One decision of every aircraft.

    Args:
        flock: now.
        towards: (..., n, 3) m, points on each one's way.
        intruders: (..., m, 3) m.
        chance: (..., n) uniform in [0, 1).
        noise: (..., n, 3) standard normal.
        setting: rules, limits, terrain and aim.
        step_s: time since the last decision.
        visible: (..., n, n) who sees whom, when known already.
    """
    rules, position, velocity = setting.rules, flock.position, flock.velocity
    if visible is None:
        visible = seen(position, rules.perception_m, setting.terrain)
    near = nearest(position, velocity, visible, rules.neighbours)
    centre = position.mean(axis=-2, keepdims=True)
    around = Surroundings(
        setting.aim,
        np.broadcast_to(centre, position.shape),
        intruders,
        flock.danger_s <= rules.safe_s,
        flock.alarm_s <= rules.safe_s,
    )
    wish, mode = behave(position, velocity, near, around, chance, noise, rules)
    alarmed = mode == ESCAPE
    speed = np.where(alarmed, setting.wing.fastest_m_s, rules.speed_m_s)[..., None]
    wish = rules.behaviour * wish + rules.single * spring.half_spring(velocity, near, rules)
    kept = np.where(around.danger, rules.abreast_danger, rules.abreast)[..., None]
    way = unit(towards + kept * (position - centre) - position)
    wish = wish + rules.route * (speed * way - velocity)
    wish = wish + spring.dodge(velocity, near, rules)
    disturbed: Bools = np.asarray(alarmed)
    if setting.terrain is not None:
        wish, blocked = ridge.avoid(
            position, velocity, wish, setting.terrain, setting.wing, setting.watch
        )
        mode = np.where(blocked, ESCAPE, mode)
        disturbed = alarmed | blocked
    if setting.wide is not None:
        above = position[..., 2] - setting.wide.height_at(position)
        disturbed = disturbed | (above < setting.watch.clearance_m)
    return Update(
        wish,
        mode,
        space.heard(flock.danger_s, disturbed, visible, step_s),
        space.heard(flock.alarm_s, alarmed, visible, step_s),
        visible,
    )
