"""What the single values of a mission cannot show: how they fit together."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from math import hypot, isfinite, isnan
from typing import Any

from planners.belief.merge import MERGE_RULES
from planners.planner import PlannerKind
from planners.registry import bind, describe
from planners.terrain import Terrain
from sim_vehicles.crafts import CRAFTS
from sim_vehicles.params import Parameters
from uavbridge.config.field_error import FieldError, KeyPath
from uavbridge.config.ground_rules import check_covers, check_ground, check_on_ground
from uavbridge.config.mission import Mission
from uavbridge.config.pheromones import check_pheromones
from uavbridge.config.radio import check_radio
from uavbridge.config.starts import Member
from uavbridge.errors import ConfigError
from uavbridge.mavlink.urls import parse_url

_MAY_BE_INFINITE = {
    ("radio", "range_m"),
    ("radio", "frame_bytes"),
    ("radio", "bytes_per_s"),
    ("radio", "keyframe_s"),
    ("safety", "beacon_range_m"),
}
_ENDPOINT = re.compile(r"(tcp|udp|tls|quic|ws|unixsock-stream)/\S+")
_LAST_PORT = 65535
_FARTHEST_M = 1e9  # beyond it no area reaches, and a cell's number is no whole number any more


def check(mission: Mission, planners: Mapping[str, PlannerKind]) -> None:
    """Hold a mission against all rules.

    Raises:
        FieldError: the first one broken.
    """
    _numbers(mission.plain(), ())
    _probabilities(mission)
    _agents(mission)
    terrain = check_ground(mission)
    team = _team(mission, terrain)
    _altitudes(mission, team)
    _starts(mission, team)
    _planes(mission, team)
    _targets(mission)
    if terrain is not None:
        starts = zip(_start_keys(mission, team), [member.start for member in team], strict=True)
        check_on_ground(mission, terrain, list(starts))
    _endpoints(mission)
    check_pheromones(mission)
    check_radio(mission, [member.id for member in team])
    _remote(mission, team)
    _simulation(mission)
    _known(("belief", "merge"), "merge rule", mission.belief.merge, MERGE_RULES)
    _planner(mission, planners)


def _remote(mission: Mission, team: tuple[Member, ...]) -> None:
    known = {member.id for member in team}
    for index, agent in enumerate(mission.bus.remote):
        if agent not in known:
            raise FieldError(("bus", "remote", index), "is not in the team", agent)


def _numbers(value: Any, path: KeyPath) -> None:
    if isinstance(value, float) and not isfinite(value):
        if isnan(value) or path not in _MAY_BE_INFINITE:
            raise FieldError(path, "must be a finite number", value)
    elif isinstance(value, dict):
        for key, part in value.items():
            _numbers(part, (*path, key))
    elif isinstance(value, list):
        for index, part in enumerate(value):
            _numbers(part, (*path, index))


def _probabilities(mission: Mission) -> None:
    sensor, belief = mission.sensor, mission.belief
    if not sensor.q < sensor.p:
        raise FieldError(("sensor", "q"), f"must be below p = {sensor.p:g}", sensor.q)
    if not belief.threshold > belief.prior:
        what = f"must be above prior = {belief.prior:g}"
        raise FieldError(("belief", "threshold"), what, belief.threshold)
    if belief.expected and not belief.prior <= belief.peak < belief.threshold:
        what = f"must lie from prior = {belief.prior:g} to below threshold = {belief.threshold:g}"
        raise FieldError(("belief", "peak"), what, belief.peak)


def _agents(mission: Mission) -> None:
    seen: set[int] = set()
    for index, agent in enumerate(mission.agents):
        if agent.id in seen:
            raise FieldError(("agents", index, "id"), "is there twice", agent.id)
        seen.add(agent.id)


def _team(mission: Mission, terrain: Terrain | None) -> tuple[Member, ...]:
    try:
        return mission.team()
    except ValueError as error:
        if terrain is not None:
            check_covers(mission, terrain)
        raise FieldError(("vehicles",), str(error), mission.vehicles) from None


def _altitudes(mission: Mission, team: tuple[Member, ...]) -> None:
    low, high = mission.safety.altitude_min_m, mission.safety.altitude_max_m
    if not low < high:
        raise FieldError(
            ("safety", "altitude_max_m"), f"must be above altitude_min_m = {low:g}", high
        )
    for member in team:
        if member.kind != "rover" and not low <= member.altitude_m <= high:
            path = _agent_key(mission, member.id, "altitude_m") or ("fleet", "altitude_m")
            what = f"must be in the band {low:g} to {high:g} m that [safety] allows"
            raise FieldError(path, what, member.altitude_m)


def _agent_key(mission: Mission, number: int, key: str) -> KeyPath | None:
    """Path of a key that [[agents]] sets for an agent."""
    for index, agent in enumerate(mission.agents):
        if agent.id == number and getattr(agent, key) is not None:
            return ("agents", index, key)
    return None


def _start_keys(mission: Mission, team: tuple[Member, ...]) -> Iterator[KeyPath]:
    """Where each member's start comes from."""
    for place, member in enumerate(team):
        given = place < len(mission.fleet.starts)
        yield _agent_key(mission, member.id, "start") or (
            ("fleet", "starts", place) if given else ("fleet", "spacing_m")
        )


def _planes(mission: Mission, team: tuple[Member, ...]) -> None:
    safety = mission.safety
    if any(member.kind == "plane" for member in team) and safety.slowest_m_s >= safety.speed_m_s:
        what = f"must be below speed_m_s = {safety.speed_m_s:g}: planes can not stop"
        raise FieldError(("safety", "slowest_m_s"), what, safety.slowest_m_s)
    if mission.fleet.in_air and any(member.kind == "rover" for member in team):
        raise FieldError(("fleet", "in_air"), "is not for rovers")


def _starts(mission: Mission, team: tuple[Member, ...]) -> None:
    west, south, east, north = mission.grid.bounds
    margin, separation = mission.safety.fence_margin_m, mission.safety.separation_m
    paths = list(_start_keys(mission, team))
    for place, (member, path) in enumerate(zip(team, paths, strict=True)):
        x, y = member.start
        if not (west - margin <= x <= east + margin and south - margin <= y <= north + margin):
            what = f"lies outside the fence, {margin:g} m around the area"
            raise FieldError(path, what, member.start)
        for other in team[:place]:
            above = member.altitude_m - other.altitude_m if mission.fleet.in_air else 0.0
            distance = hypot(x - other.start[0], y - other.start[1], above)
            if distance < separation:
                what = (
                    f"agents {other.id} and {member.id} start {distance:g} m apart, "
                    f"closer than safety.separation_m = {separation:g}"
                )
                raise FieldError(path, what)


def _targets(mission: Mission) -> None:
    for index, target in enumerate(mission.targets):
        far = max(map(abs, target.position)) > _FARTHEST_M
        if far or not mission.grid.contains(target.position):
            west, south, east, north = mission.grid.bounds
            what = f"lies outside the area, x {west:g} to {east:g}, y {south:g} to {north:g}"
            raise FieldError(("targets", index, "position"), what, target.position)


def _endpoints(mission: Mission) -> None:
    bus = mission.bus
    for key, endpoint in (("listen", bus.listen), ("router", bus.router)):
        if endpoint is None or (key == "listen" and endpoint == "auto"):
            continue
        if not _ENDPOINT.fullmatch(endpoint):
            what = "must be a zenoh endpoint such as tcp/127.0.0.1:7447"
            raise FieldError(("bus", key), what, endpoint)
    for index, agent in enumerate(mission.agents):
        if agent.endpoint is not None:
            try:
                parse_url(agent.endpoint)
            except ConfigError as error:
                raise FieldError(("agents", index, "endpoint"), str(error)) from None
            if mission.clock == "stepped":
                what = f"stepped time has no vehicles elsewhere, as agent {agent.id}'s"
                raise FieldError(("clock",), what)


def _simulation(mission: Mission) -> None:
    simulator, safety = mission.simulator, mission.safety
    if simulator.ports != "auto" and simulator.ports + mission.vehicles - 1 > _LAST_PORT:
        what = f"leaves no ports for {mission.vehicles} vehicles"
        raise FieldError(("simulator", "ports"), what, simulator.ports)
    for name, value in simulator.parameters.items():
        _autopilot_parameter(name, value)
    if not safety.beacon_range_m > safety.separation_m:
        what = f"must be above separation_m = {safety.separation_m:g}"
        raise FieldError(("safety", "beacon_range_m"), what, safety.beacon_range_m)


def _autopilot_parameter(name: str, value: float) -> None:
    path = ("simulator", "parameters", name)
    tables = [craft.parameters for craft in CRAFTS.values() if craft.autopilot == "px4"]
    having = [table for table in tables if any(one.name == name for one in table)]
    if not having:
        names = sorted({one.name for table in tables for one in table})
        near = get_close_matches(name.upper(), names, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise FieldError(path, f"the autopilot has no such parameter{hint}")
    try:
        for table in having:
            Parameters(table, 1, {name: value})
    except ValueError as error:
        raise FieldError(path, str(error).removeprefix(f"parameter {name} ")) from None


def _known(path: KeyPath, noun: str, name: str, known: Mapping[str, object]) -> None:
    if name not in known:
        near = get_close_matches(name, list(known), n=1)
        hint = f"did you mean {near[0]}? " if near else ""
        got = () if name == path[-1] else (name,)
        raise FieldError(path, f"no such {noun}; {hint}known: {', '.join(sorted(known))}", *got)


def _planner(mission: Mission, planners: Mapping[str, PlannerKind]) -> None:
    _known(("planner",), "planner", mission.planner, planners)
    kind = planners[mission.planner]
    known = {parameter.name: parameter for parameter in describe(kind)}
    for name, value in mission.parameters.items():
        path = ("parameters", name)
        _known(path, f"parameter of planner {kind.name}", name, known)
        _bind(path, kind, mission, {name: value})
    _bind(("parameters",), kind, mission, mission.parameters)


def _bind(path: KeyPath, kind: PlannerKind, mission: Mission, values: dict[str, Any]) -> None:
    try:
        bind(kind, mission.scenario(), values)
    except ValueError as error:
        what = str(error).removeprefix(f"planner {kind.name}: ")
        raise FieldError(path, what.removeprefix(f"parameter {path[-1]} ")) from None
