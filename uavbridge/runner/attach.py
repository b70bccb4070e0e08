"""Vehicles that we did not simulate: found, told apart and checked before anything arms.

Every endpoint of a mission is opened, everybody behind it is listened to, and each agent
gets one of them: the one that its endpoint names, else the one with its own id, else the
next by system id. What would go wrong in the air is an error here.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from sim_vehicles.clock import unix_us
from sim_vehicles.codec import Encoder
from sim_vehicles.codec.signing import Keyring, Seal, read_keys
from uavbridge.clock import PacedClock, pause, to_us
from uavbridge.config import Mission
from uavbridge.errors import ConfigError, UavbridgeError
from uavbridge.mavlink.hub import Hub
from uavbridge.mavlink.identity import COMPONENT, SYSTEM
from uavbridge.mavlink.scout import Survey
from uavbridge.mavlink.urls import Endpoint, open_hub, parse_url
from uavbridge.runner.fitness import (
    Attached,
    adopt,
    check,
    check_speed,
    check_twins,
    offset,
)

HEARTBEAT_S = 10.0  # wall time in which a vehicle must be heard
PLACE_S = 90.0  # and know where it is: ArduPilot takes 40 s from power-on
WATCH_S = 2.0  # listened at least: to notice twins, and how fast clocks run
_LOOK_S = 0.02
_TELL_US = to_us(10.0)


@dataclass(frozen=True, slots=True, eq=False)
class Attachments:
    """The vehicles that are not simulated, and the mission as it is flown with them."""

    mission: Mission
    vehicles: dict[int, Attached] = field(default_factory=dict)


@contextmanager
def attach(
    mission: Mission,
    *,
    adopt_home: bool = False,
    adopt_speed: bool = False,
    resumes: bool = False,
    agents: Collection[int] | None = None,
    tell: Callable[[str], None] = lambda _text: None,
) -> Iterator[Attachments]:
    """Find the vehicles of a mission's endpoints; let go of them in the end.

    Args:
        mission: some of its agents may have endpoints.
        adopt_home: the mission's origin moves to the first vehicle's home.
        adopt_speed: the mission goes as fast as the vehicles' clocks.
        resumes: the mission was flown before: vehicles may be in the air.
        agents: whose vehicles; None: of those that fly in the launcher's own process.
        tell: is told what was found.

    Raises:
        LinkError: an endpoint cannot be opened; the message names its agent.
        VehicleError: they cannot be flown together, or not in this mission.
        ConfigError: the mission's speed is not the vehicles'.
    """
    ends = ends_of(mission, agents)
    if not ends:
        yield Attachments(mission)
        return
    with ExitStack() as stack:
        surveys = open_surveys(ends, stack, keyring_of(mission))
        _wait(ends, surveys, tell)
        vehicles = assign(ends, surveys)
        check_twins(mission, vehicles, surveys)
        mission = adopt(mission, vehicles, adopt_home, adopt_speed)
        for attached in vehicles.values():
            tell(_echo(attached, mission))
            check(attached, mission, resumes=resumes)
        check_speed(vehicles, mission)
        for text in _unused(vehicles, surveys):
            tell(text)
        yield Attachments(mission, vehicles)


def ends_of(mission: Mission, agents: Collection[int] | None = None) -> dict[int, Endpoint]:
    """Where the vehicles are that nobody simulates, by agent; ``agents`` as in ``attach``."""
    team = {member.id for member in mission.team()}
    flown = team - mission.apart() if agents is None else team & set(agents)
    urls = {agent: mission.endpoint(agent) for agent in sorted(flown)}
    return {agent: parse_url(url) for agent, url in urls.items() if url is not None}


def keyring_of(mission: Mission) -> Keyring | None:
    """The keys that links to vehicles are signed with. Raises ConfigError."""
    path = mission.mavlink.signing_keys
    try:
        return None if path is None else read_keys(Path(path))
    except ValueError as fault:
        raise ConfigError(f"mavlink.signing_keys: {fault}") from None


def open_surveys(
    ends: dict[int, Endpoint], stack: ExitStack, keyring: Keyring | None = None
) -> dict[Endpoint, Survey]:
    """Listen at every endpoint, as long as the stack is open.

    Args:
        ends: by agent.
        stack: closes them.
        keyring: keys of the vehicles; None: nothing is signed.

    Raises:
        LinkError: an endpoint cannot be opened; the message names its agent.
    """
    encoder = Encoder(SYSTEM, COMPONENT)
    surveys: dict[Endpoint, Survey] = {}
    for agent, end in ends.items():
        if end.place in surveys:
            continue
        try:
            seal = None if keyring is None else Seal(keyring, unix_us, link=len(surveys))
            hub = open_hub(end.place, seal)
        except UavbridgeError as error:
            raise error.at(f"endpoint of agent {agent}") from None
        stack.callback(hub.close)
        surveys[end.place] = Survey(hub, encoder)
    return surveys


def _wait(
    ends: dict[int, Endpoint],
    surveys: dict[Endpoint, Survey],
    tell: Callable[[str], None],
) -> None:
    """Listen until everybody was heard and knows where it is, or patience ends."""
    wanted = {place: [end for end in ends.values() if end.place == place] for place in surveys}
    clock, told_us = PacedClock(), _TELL_US
    while (t_us := clock.now_us()) < to_us(HEARTBEAT_S + PLACE_S):
        for survey in surveys.values():
            survey.step(t_us)
        waits = [missing(wanted[place], survey) for place, survey in surveys.items()]
        texts = [text for text, _ in waits if text]
        unheard = any(unheard for _, unheard in waits)
        if not texts and t_us > to_us(WATCH_S):
            return
        if unheard and t_us > to_us(HEARTBEAT_S) and len(texts) == sum(u for _, u in waits):
            return  # their agents fail and say so; nobody else is waited for
        if t_us > told_us:
            told_us = t_us + _TELL_US
            tell(f"waiting for {'; '.join(texts)}")
        pause(_LOOK_S)


def missing(wanted: list[Endpoint], survey: Survey) -> tuple[str, bool]:
    """What is waited for behind one endpoint; True: for somebody who was never heard."""
    heard = survey.vehicles
    systems = {scout.system for scout in heard}
    if len(heard) < len(wanted) or any(end.system not in {None, *systems} for end in wanted):
        trouble = survey.hub.trouble or f"{len(heard)} of {len(wanted)} vehicles heard"
        trouble += refusals(survey.hub)
        return f"{survey.hub.name}: {trouble}", True
    named = {end.system for end in wanted}
    blind = [s for s in heard if s.here is None and (None in named or s.system in named)]
    texts = [
        f"{survey.hub.name}, system {scout.system}: no position"
        + "".join(f"; {text}" for _, text in scout.texts[-1:])
        for scout in blind
    ]
    return "; ".join(texts), False


def refusals(hub: Hub) -> str:
    """What a sealed hub did not let in, to be added to a text."""
    if hub.seal is None or not hub.seal.refused.total:
        return ""
    refused = hub.seal.refused
    return (
        f"; refused: {refused.unsigned} unsigned, {refused.wrong} wrongly signed, "
        f"{refused.replayed} replayed frames"
    )


def assign(ends: dict[int, Endpoint], surveys: dict[Endpoint, Survey]) -> dict[int, Attached]:
    """Every agent's vehicle, or at least the link on which it would be heard."""
    vehicles: dict[int, Attached] = {}
    for place, survey in surveys.items():
        agents = [agent for agent, end in ends.items() if end.place == place]
        systems = systems_of({agent: ends[agent].system for agent in agents}, survey)
        for agent in agents:
            system = systems.get(agent, ends[agent].system or agent)
            scout = survey.scouts.get(system) if agent in systems else None
            link = survey.hub.channel(system)
            vehicles[agent] = Attached(agent, ends[agent], system, link, scout)
    return dict(sorted(vehicles.items()))


def systems_of(wanted: dict[int, int | None], survey: Survey) -> dict[int, int]:
    """Which of the systems heard each agent gets; agents without one are left out.

    Args:
        wanted: agents of this endpoint, ascending, and the system that theirs names.
        survey: who was heard there.
    """
    free = [scout.system for scout in survey.vehicles]
    given: dict[int, int] = {}
    for choose in (lambda agent: wanted[agent], lambda agent: None if wanted[agent] else agent):
        for agent in wanted:
            system = choose(agent)
            if agent not in given and system in free:
                given[agent] = system
                free.remove(system)
    for agent, named in wanted.items():
        if agent not in given and named is None and free:
            given[agent] = free.pop(0)
    return given


def _echo(attached: Attached, mission: Mission) -> str:
    scout = attached.scout
    if scout is None:
        return f"agent {attached.agent}: {attached.where}: not heard"
    firmware = "" if scout.firmware is None else f" {scout.firmware}"
    text = f"agent {attached.agent}: {attached.where}: {scout.name or 'unknown'}{firmware}"
    place = scout.start
    if place is None:
        return text + ", no position yet"
    east, north, up = offset(place, mission)
    return text + f", home {east:.0f} m east, {north:.0f} m north, {up:+.1f} m of the origin"


def _unused(vehicles: dict[int, Attached], surveys: dict[Endpoint, Survey]) -> Iterator[str]:
    for place, survey in surveys.items():
        used = {a.system for a in vehicles.values() if a.endpoint.place == place}
        others = [str(s.system) for s in survey.vehicles if s.system not in used]
        if others:
            yield f"{place}: also there, not flown: system {', '.join(others)}"
