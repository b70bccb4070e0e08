"""One decision of robots that search in mountains: join, tell, move.

Zhou 2023, sections 3 and 4.1-4.2, decentralised: a robot knows its own sensors and
what it heard of robots within d_com, no more.

Rules of a suballiance, as the paper's section 3.2 leaves their exchange open:

1. A robot that hears a target answers to one (Eqs. 5, 6), stays with it while it hears it,
   and tells so, with its signal: class I.
2. Of the class I robots of a target that told so last step, the one that ranks first leads.
   It ranks those that it heard, class I robots and free ones (``rank_members``), and tells
   the first N_m: the roster.
3. Only who is on the roster of the last step works as a member; so membership never exceeds
   N_m where messages arrive. Before there is a roster, class I robots among the first N_m do.
4. Who is left out answers to another target that it hears, or roams.
5. Found targets are told on by everyone, and dissolve their suballiances.

The velocity is that of Eqs. (7), (8) for those who roam and of Eq. (9) for members.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from planners.search.mountain.alliance import rank_members, respond
from planners.search.mountain.params import MountainParams
from planners.search.mountain.state import (
    Array,
    Draws,
    Heard,
    Messages,
    Robots,
    Sensed,
    length,
)
from planners.types import F64, I64, Bools


@dataclass(frozen=True, slots=True)
class Rules:
    """Parameters in metres a step."""

    params: MountainParams
    speed_m: float  # Vm
    stall_m: float
    repel_m: float

    @staticmethod
    def of(params: MountainParams, radio_m: float, step_s: float) -> Rules:
        speed, stall = params.speed_m_s * step_s, params.stall_m_s * step_s
        return Rules(params, speed, stall, params.repel_m(radio_m))


def decide(
    ids: I64, robots: Robots, sensed: Sensed, heard: Heard, draws: Draws, rules: Rules
) -> tuple[F64, Robots]:
    """Expected velocities V_e (..., 3) in m a step, and what the robots keep.

    Args:
        ids: (...) of the deciding robots.
        robots: what they kept.
        sensed: their own sensors, now.
        heard: messages of the last step, their own included.
        draws: random numbers.
        rules: parameters.

    Returns:
        V_e, and the memory; its ``told`` is what they tell in this step. Its velocity is
        still the last one: ``replace`` it by the one that is driven.
    """
    offset = sensed.position[..., None, :] - heard.position
    distance = length(offset)
    robots, answering = _escape(robots, rules)
    found = _found(robots, sensed, heard)
    task, first, waited = _answer(ids, robots, sensed, heard, draws, found, answering)
    task, member = _join(ids, robots, distance, heard, task, first, found, answering, rules)
    robots, told = _remember(robots, sensed, heard, task, first, member, found, rules)
    leads, roster = _lead(ids, task, first, heard, rules)
    told = replace(told, free=answering & ~first, leads=leads, roster=roster)
    after = replace(robots, member=member, waited=waited, told=told)
    expected = np.where(
        member[..., None],
        _swarm(sensed.position, after, draws, rules),
        _roam(ids, offset, distance, robots.velocity, heard, draws, rules),
    )
    return expected, after


def _escape(robots: Robots, rules: Rules) -> tuple[Robots, Bools]:
    """Members that stalled roam for a while; which robots answer to targets."""
    rest = np.maximum(robots.rest - 1, 0)
    if rules.params.escape == "roam":
        stalled = robots.member & (length(robots.velocity) < rules.stall_m)
        rest = np.where(stalled, rules.params.rest_steps, rest)
    answering: Bools = rest == 0
    return replace(robots, rest=rest), answering


def _found(robots: Robots, sensed: Sensed, heard: Heard) -> Bools:
    """Targets (..., T) known to be found: reached, or told of."""
    known = heard.known.astype(np.float32)[..., None, :]
    told = np.matmul(known, heard.messages.found.astype(np.float32))[..., 0, :] > 0.0
    return np.asarray(robots.told.found | sensed.arrived | told)


def _answer(
    ids: I64,
    robots: Robots,
    sensed: Sensed,
    heard: Heard,
    draws: Draws,
    found: Bools,
    answering: Bools,
) -> tuple[I64, Bools, I64]:
    """Rule 1: the target answered to (...), whether it is heard, and since when that is told."""
    audible = sensed.heard & ~found & answering[..., None]
    old = robots.told.task
    stays = robots.told.first & _at(audible, old)
    leader = _leader(heard, old)
    left_out = stays & (robots.waited >= 2) & leader.exists & ~leader.lists(ids)
    if sensed.heard.shape[-1]:
        target = np.arange(sensed.heard.shape[-1])
        others = audible & ~(left_out[..., None] & (target == old[..., None]))
        audible = np.where(others.any(axis=-1)[..., None], others, audible)
    drawn = respond(sensed.strength, audible, draws.target)
    task = np.where(stays & ~(left_out & (drawn != old)), old, drawn)
    first: Bools = task >= 0
    same = first & robots.told.first & (task == old)
    return task, first, np.where(same, robots.waited + 1, first.astype(np.int64))


def _join(
    ids: I64,
    robots: Robots,
    distance: F64,
    heard: Heard,
    task: I64,
    first: Bools,
    found: Bools,
    answering: Bools,
    rules: Rules,
) -> tuple[I64, Bools]:
    """Rules 3 and 4: the task (...) of class II robots too, and who works as a member."""
    leader = _leader(heard, task)
    early = _among_first(ids, heard, task, rules.params.members)
    member = first & np.where(leader.exists, leader.lists(ids), early)
    invited, nearest = _invited(ids, robots, distance, heard, found, answering & ~first)
    return np.where(invited, nearest, task), member | invited


def _remember(
    robots: Robots,
    sensed: Sensed,
    heard: Heard,
    task: I64,
    first: Bools,
    member: Bools,
    found: Bools,
    rules: Rules,
) -> tuple[Robots, Messages]:
    """R* and g* of Eq. (9), from the step of joining on."""
    now = np.where(first, _at(sensed.strength, task), -np.inf)
    goes_on = member & robots.member & (task == robots.told.task)
    best, place = _better(
        np.where(goes_on, robots.told.best, -np.inf),
        robots.told.best_place,
        np.where(member, now, -np.inf),
        sensed.position,
    )
    only_now = rules.params.escape == "current"
    shared, shared_place = _better(
        np.where(goes_on & (not only_now), robots.shared, -np.inf),
        robots.shared_place,
        now if only_now else best,
        sensed.position if only_now else place,
    )
    said = heard.messages
    value, places = (said.strength, heard.position) if only_now else (said.best, said.best_place)
    mine = heard.known & (said.task == task[..., None]) & (said.first | ~np.asarray(only_now))
    others = np.where(mine, value, -np.inf)
    top = others.argmax(axis=-1)
    shared, shared_place = _better(
        shared, shared_place, _pick(others, top), _pick_place(places, top, others.shape)
    )
    told = replace(
        robots.told,
        task=task,
        first=first,
        strength=np.where(first, now, 0.0),
        best=best,
        best_place=place,
        found=found,
    )
    return replace(robots, shared=shared, shared_place=shared_place), told


def _lead(ids: I64, task: I64, first: Bools, heard: Heard, rules: Rules) -> tuple[Bools, I64]:
    """Rule 2: who leads (...), and the rosters (..., N_m) of those who do."""
    said, size = heard.messages, rules.params.members
    shape = heard.known.shape
    class_1 = heard.known & said.first & (said.task == task[..., None]) & first[..., None]
    top = np.where(class_1, said.strength, -np.inf).argmax(axis=-1)
    leads = class_1.any(axis=-1) & (_pick(np.broadcast_to(heard.ids, shape), top) == ids)
    roster = np.full((*ids.shape, size), -1, dtype=np.int64)
    if not leads.any():
        return leads, roster
    rows: tuple[Any, ...] = np.nonzero(leads)
    whole = np.broadcast_to(heard.position, (*shape, 3))[rows]
    of = {name: np.broadcast_to(getattr(said, name), shape)[rows] for name in _SAID}
    mine, one = class_1[rows], task[rows][:, None]
    class_2 = heard.known[rows] & ~of["first"] & of["free"]
    class_2 &= (of["task"] == -1) | (of["task"] == one)
    offset = whole[:, :, None] - whole[:, None]
    distance = np.where(mine[:, None], length(offset), np.inf)
    link = distance.argmin(axis=-1)
    order = rank_members(
        mine,
        of["strength"],
        np.take_along_axis(distance, link[..., None], axis=-1)[..., 0],
        np.take_along_axis(of["strength"], link, axis=-1),
        mine | class_2,
    )[:, :size]
    chosen = np.take_along_axis(np.broadcast_to(heard.ids, shape)[rows], order, axis=-1)
    usable = np.take_along_axis(mine | class_2, order, axis=-1)
    roster[(*rows, slice(chosen.shape[-1]))] = np.where(usable, chosen, -1)
    return leads, roster


_SAID = ("task", "first", "free", "strength")


def _swarm(position: F64, robots: Robots, draws: Draws, rules: Rules) -> F64:
    """Eq. (9). A robot without a best place of its own is not pulled by one."""
    p = rules.params
    axes = 3 if p.escape == "current" else 1
    velocity = robots.velocity
    own = np.where(np.isfinite(robots.told.best)[..., None], robots.told.best_place, position)
    shared = np.where(np.isfinite(robots.shared)[..., None], robots.shared_place, position)
    wish = p.inertia * velocity
    wish = wish + p.own_pull * draws.own[..., :axes] * (own - position)
    wish = wish + p.shared_pull * draws.shared[..., :axes] * (shared - position)
    return np.asarray(velocity + (wish - velocity) * p.response)


def _roam(
    ids: I64,
    offset: F64,
    distance: F64,
    velocity: F64,
    heard: Heard,
    draws: Draws,
    rules: Rules,
) -> F64:
    """Eqs. (7) and (8): away from the two nearest; onwards where there are none."""
    near = heard.known & (heard.ids != ids[..., None]) & (distance <= rules.repel_m)
    distance = np.where(near & (distance > 0.0), distance, np.inf)
    force = np.zeros_like(velocity)
    for _ in range(min(2, distance.shape[-1])):
        pick = distance.argmin(axis=-1)[..., None]
        far = np.take_along_axis(distance, pick, axis=-1)
        arm = np.take_along_axis(offset, pick[..., None], axis=-2)[..., 0, :]
        force += arm / far**3  # eq. (7); an infinite distance adds nothing
        np.put_along_axis(distance, pick, np.inf, axis=-1)
    angle = 2.0 * np.pi * draws.heading
    any_way = np.stack((np.cos(angle), np.sin(angle), np.zeros_like(angle)), axis=-1)
    onwards = np.where((velocity[..., :2] != 0.0).any(axis=-1)[..., None], velocity, any_way)
    way = np.where((force[..., :2] != 0.0).any(axis=-1)[..., None], force, onwards)
    return np.asarray(way * (rules.speed_m / length(way))[..., None])  # eq. (8)


@dataclass(frozen=True, slots=True, eq=False)
class _Leader:
    exists: Bools  # (...)
    roster: I64  # (..., N_m)

    def lists(self, ids: I64) -> Bools:
        return np.asarray((self.roster == ids[..., None]).any(axis=-1))


def _leader(heard: Heard, task: I64) -> _Leader:
    """The leader of a target (...) by the messages heard: the strongest, should there be two."""
    said = heard.messages
    leads = heard.known & said.leads & (said.task == task[..., None]) & (task >= 0)[..., None]
    top = np.where(leads, said.strength, -np.inf).argmax(axis=-1)
    size = said.roster.shape[-1]
    roster = np.broadcast_to(said.roster, (*leads.shape, size))
    mine = np.take_along_axis(roster, top[..., None, None], axis=-2)[..., 0, :]
    return _Leader(leads.any(axis=-1), mine)


def _among_first(ids: I64, heard: Heard, task: I64, members: int) -> Bools:
    """Whether a robot (...) told its task last step and is among the first N_m of those."""
    said = heard.messages
    told = heard.known & said.first & (said.task == task[..., None])
    self_ = told & (heard.ids == ids[..., None])
    own = np.where(self_, said.strength, -np.inf).max(axis=-1)[..., None]
    level = (said.strength == own) & (heard.ids < ids[..., None])
    ahead = (told & ((said.strength > own) | level)).sum(axis=-1)
    return np.asarray(self_.any(axis=-1) & (ahead < members))


def _invited(
    ids: I64, robots: Robots, distance: F64, heard: Heard, found: Bools, may: Bools
) -> tuple[Bools, I64]:
    """Class II robots (...) that a roster lists, and for which target: their own, or nearest's."""
    said = heard.messages
    lists = heard.known & said.leads & may[..., None]
    if not lists.any():
        return np.zeros(ids.shape, np.bool_), robots.told.task
    lists &= (said.roster == ids[..., None, None]).any(axis=-1)
    task = np.broadcast_to(said.task, lists.shape)
    if found.shape[-1]:
        lists &= ~np.take_along_axis(found, np.maximum(task, 0), axis=-1)
    stays = said.task == robots.told.task[..., None]
    pick = np.where(lists, np.where(stays, -1.0, distance), np.inf).argmin(axis=-1)
    return np.asarray(lists.any(axis=-1)), _pick(task, pick)


def _better(value: F64, place: F64, other: F64, there: F64) -> tuple[F64, F64]:
    higher = other > value
    return np.where(higher, other, value), np.where(higher[..., None], there, place)


def _pick(values: Array, column: I64) -> Array:
    return np.asarray(np.take_along_axis(values, column[..., None], axis=-1)[..., 0])


def _pick_place(places: F64, column: I64, shape: tuple[int, ...]) -> F64:
    whole = np.broadcast_to(places, (*shape, 3))
    return np.asarray(np.take_along_axis(whole, column[..., None, None], axis=-2)[..., 0, :])


def _at(values: Array, task: I64) -> Array:
    """Values (..., T) at the robots' tasks; 0 or False without one."""
    if not values.shape[-1]:
        return np.zeros(task.shape, values.dtype)
    mine = _pick(values, np.maximum(task, 0))
    return np.where(task >= 0, mine, np.zeros((), values.dtype))
