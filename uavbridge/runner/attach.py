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

import numpy as np
from msgspec.structs import replace

from sim_vehicles.clock import unix_us
from sim_vehicles.codec import Encoder
from sim_vehicles.codec.signing import Keyring, Seal, read_keys
from sim_vehicles.geodesy import Geodetic, to_enu
from uavbridge.clock import PacedClock, pause, to_us
from uavbridge.config import Mission
from uavbridge.config.tables import Home
from uavbridge.errors import ConfigError, UavbridgeError, VehicleError
from uavbridge.mavlink.hub import Hub
from uavbridge.mavlink.identity import COMPONENT, SYSTEM
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.scout import Scout, Survey
from uavbridge.mavlink.urls import Endpoint, open_hub, parse_url
from uavbridge.runner import assemble

HEARTBEAT_S = 10.0  # wall time in which a vehicle must be heard
PLACE_S = 90.0  # and know where it is: ArduPilot takes 40 s from power-on
WATCH_S = 2.0  # listened at least: to notice twins, and how fast clocks run
FARTHEST_M = 5000.0
CLEAR_M = 5.0  # over the highest home, below the lowest height flown at
DEEPEST_M = 50.0  # a home below the mission's: above it heights over ground would be far more
_LOOK_S = 0.02
_TELL_US = to_us(10.0)
_SAME_SPEED = 1.5  # clocks that differ by less go at one speed


@dataclass(frozen=True, slots=True, eq=False)
class Attached:
    """One agent's vehicle."""

    agent: int
    endpoint: Endpoint
    system: int
    link: Link
    scout: Scout | None  # None: never heard

    @property
    def where(self) -> str:
        """Endpoint and system, for messages."""
        return f"{self.endpoint.place}, system {self.system}"


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


def check_twins(
    mission: Mission, vehicles: dict[int, Attached], surveys: dict[Endpoint, Survey]
) -> None:
    """No system id twice: on one port, on two, or with one that we simulate. Or VehicleError."""
    sources: dict[int, list[str]] = {}
    for survey in surveys.values():
        for scout in survey.vehicles:
            sources.setdefault(scout.system, []).extend(sources_of(survey.hub, scout.system))
    for attached in vehicles.values():
        found = sources.get(attached.system, [])
        if len(found) > 1:
            raise VehicleError(
                f"two vehicles have system id {attached.system}: {' and '.join(found)}"
            )
    simulated = {m.id for m in mission.team() if mission.endpoint(m.id) is None}
    for attached in vehicles.values():
        if attached.scout is not None and attached.system in simulated:
            raise VehicleError(
                f"two vehicles have system id {attached.system}: {attached.endpoint.place} and the "
                f"simulated one of agent {attached.system}"
            )


def sources_of(hub: Hub, system: int) -> list[str]:
    """Where a system is heard from; more than one: two vehicles with one id."""
    peer = hub.peers.get(system)
    if peer is None or peer.address is None:
        return [hub.name]
    addresses = sorted(peer.rivals) or [peer.address]
    return [f"{hub.name} from {host}:{port}" for host, port in addresses]


def adopt(
    mission: Mission, vehicles: dict[int, Attached], adopt_home: bool, adopt_speed: bool
) -> Mission:
    """The mission with the first vehicle's home, and as fast as their clocks go."""
    home, speed = mission.home, mission.speed
    if adopt_home:
        first = next(iter(vehicles.values()))
        place = None if first.scout is None else first.scout.home or first.scout.here
        if place is None:
            raise VehicleError(f"agent {first.agent}: no home position from {first.where}")
        home = Home(
            latitude_deg=place.latitude_deg,
            longitude_deg=place.longitude_deg,
            altitude_m=place.altitude_m,
        )
    rates = [a.scout.rate for a in vehicles.values() if a.scout and a.scout.rate]
    if adopt_speed and rates:
        speed = _round(float(np.median(rates)))
    return replace(mission, home=home, speed=speed)


def _round(rate: float) -> float:
    """The speed that was asked of a simulator whose clock goes at this rate."""
    return 1.0 if 1 / _SAME_SPEED < rate < _SAME_SPEED else float(f"{rate:.2g}")


def check(attached: Attached, mission: Mission, *, resumes: bool = False) -> None:
    """Raises VehicleError if this vehicle can not fly this mission."""
    scout, subject = attached.scout, f"agent {attached.agent} ({attached.where})"
    if scout is None:
        return
    flavour = scout.telemetry.flavour
    if isinstance(flavour, str):
        raise VehicleError(f"{subject}: {flavour}")
    if mission.mavlink.driver == "mavsdk" and flavour.kind != "multirotor":
        raise VehicleError(f"{subject}: is a {flavour.kind}; mavlink.driver: mavsdk flies none")
    if scout.telemetry.in_air and not resumes:
        raise VehicleError(f"{subject}: is in the air already; --resume goes on with a mission")
    if scout.signs and mission.mavlink.signing_keys is None:
        raise VehicleError(f"{subject}: obeys only those with its key: give --signing-keys FILE")
    place = scout.home or scout.here
    if place is None:
        return
    east, north, up = offset(place, mission)
    away_m = float(np.hypot(east, north))
    if away_m > FARTHEST_M:
        raise VehicleError(
            f"{subject}: its home is {away_m / 1000:.1f} km from the mission's, more than "
            f"{FARTHEST_M / 1000:g} km: set [home] to {place.latitude_deg:.6f}, "
            f"{place.longitude_deg:.6f}, or leave the mission out"
        )
    highest_m = mission.safety.altitude_min_m - CLEAR_M
    if not -DEEPEST_M <= up <= highest_m:
        raise VehicleError(
            f"{subject}: its home is {abs(up):.0f} m {'above' if up > 0 else 'below'} the "
            f"mission's ({place.altitude_m:.0f} m and {mission.home.altitude_m:g} m above the "
            f"sea), so heights would not be safe: set home.altitude_m"
        )


def offset(place: Geodetic, mission: Mission) -> tuple[float, float, float]:
    """Metres east, north and up of the mission's origin."""
    where = to_enu(
        place.latitude_deg, place.longitude_deg, place.altitude_m, assemble.origin(mission)
    )
    east, north, up = where.tolist()
    return east, north, up


def check_speed(vehicles: dict[int, Attached], mission: Mission) -> None:
    """Raises ConfigError where the mission's speed is not that of a vehicle's clock."""
    for attached in vehicles.values():
        rate = None if attached.scout is None else attached.scout.rate
        if rate is None or rate <= 0:
            continue
        if not 1 / _SAME_SPEED < rate / mission.speed < _SAME_SPEED:
            raise ConfigError(
                f"speed: the mission goes at {mission.speed:g} times real time, the vehicle of "
                f"agent {attached.agent} at {rate:.2g}: give --speed {_round(rate):g}"
            )


def _echo(attached: Attached, mission: Mission) -> str:
    scout = attached.scout
    if scout is None:
        return f"agent {attached.agent}: {attached.where}: not heard"
    firmware = "" if scout.firmware is None else f" {scout.firmware}"
    text = f"agent {attached.agent}: {attached.where}: {scout.name or 'unknown'}{firmware}"
    place = scout.home or scout.here
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
