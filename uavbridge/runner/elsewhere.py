"""Agents of a mission in a process of their own: ``uavbridge agent``.

The loop is that of every other runner; clock and vehicles come from the launcher's briefing.
It needs the launcher only to begin: an agent that lost it flies on by its mission's own rules.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from planners.planner import Planner
from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.security import Identity
from uavbridge.bus.wire import Frame, decode
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import SECOND_US, LedClock, PacedClock, pause, to_us, wall_date
from uavbridge.config import Mission, parse, to_toml
from uavbridge.config.connect import with_endpoints
from uavbridge.config.radio import radio_of
from uavbridge.errors import ConfigError, UavbridgeError
from uavbridge.mavlink.urls import open_link, parse_url
from uavbridge.recording.parts import begun
from uavbridge.recording.reader import Recording
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import MissionRecord
from uavbridge.runner import assemble
from uavbridge.runner.attach import attach
from uavbridge.runner.briefing import Agreement, Briefing, agree, wait_for
from uavbridge.runner.control import LEAD_US, build_host, logged
from uavbridge.runner.drivers import driver_of
from uavbridge.runner.fitness import Attached
from uavbridge.runner.folder import as_flown
from uavbridge.runner.following import Following
from uavbridge.runner.host import AgentHost
from uavbridge.runner.outcome import versions
from uavbridge.runner.pace import Pace
from uavbridge.runner.simulation import Reached
from uavbridge.runner.stand_down import stand_down
from uavbridge.runner.succession import give_way, refuse_twins
from uavbridge.runner.ticks import CONTROL_US, Ticks
from uavbridge.vehicle.api import Vehicle

# Of a machine, not of the mission: these may differ from the launcher's.
_OWN = frozenset({"agents", "bus", "clock", "headless", "json", "out", "recording"}) | {
    "security",
    "simulator",
    "targets",
}

FIRST_TRUTH_S = 1.0  # wall time for a simulation to tell where its vehicles are
_LOOK_S = 0.02

_log = logging.getLogger(__name__)


def fly_elsewhere(
    mission: Mission,
    agents: Sequence[int],
    planner: Callable[[Mission], Planner],
    *,
    router: str,
    endpoints: Mapping[int, str],
    folder: Path | None,
    identity: Identity | None = None,
    wait_s: float,
    stop: Callable[[], bool],
    tell: Callable[[str], None] = _log.info,
) -> tuple[str, ...]:
    """Fly some agents of a mission that a launcher elsewhere leads.

    Args:
        mission: as its file says here; what differs from the launcher's is an error.
        agents: ids of those flown here.
        planner: binds the mission's planner.
        router: zenoh endpoint.
        endpoints: where the vehicles are, by agent; the others are the launcher's simulated ones.
        folder: for the recording; None: none. Where an earlier process of these agents left
            one, they go on: a vehicle that flies is theirs, and they know what they told others.
        identity: of this session, where the router asks for one.
        wait_s: how long to wait for router and launcher.
        stop: asked at every tick; True calls these agents home.
        tell: is told what people need to know.

    Returns:
        What went wrong, a line each.

    Raises:
        BusError: no router, or no launcher, within ``wait_s``; another process has the agents.
        ConfigError: the launcher flies another mission, or has not these agents.
        LinkError: a port is in use.
    """
    with ExitStack() as stack:
        bus = stack.enter_context(ZenohBus(router, mission.name, wait_s=wait_s, identity=identity))
        here = Pace(bus, agents)
        tell(f"agents {_listed(agents)}: router {router}, waiting for the mission to begin")
        if emulated := radio_of(mission).words():
            tell(f"radio emulated: {emulated}")
        told = wait_for(bus, lambda _: True, wait_s=wait_s)
        refuse_twins(bus, mission.name, agents)
        _compare(mission, told)
        before = _before(mission, folder)
        mission = with_endpoints(mission, endpoints)
        found = attach(mission, resumes=before is not None, agents=agents, tell=tell)
        attached = stack.enter_context(found).vehicles
        recorder = stack.enter_context(_recorder(mission, folder, before))
        plans = [
            replace(plan, resumes=before is not None)
            for plan in assemble.agent_plans(mission.for_agents(), planner(mission))
            if plan.agent in agents
        ]
        aboard = _board(stack, mission, plans, bus, recorder, told, attached)
        if before is not None:
            _remind(aboard.host, before, agents)
        wait_for(bus, lambda b: b.t_us is not None, wait_s=wait_s, meanwhile=_waiting(here, stop))
        agreed = agree(bus)
        tell(_told(agreed))
        following = stack.enter_context(Following(bus, aboard.paced, agreed))
        _fly(aboard, bus, following, here, stop)
        stand_down({agent: aboard.vehicles[agent] for agent in attached}, aboard.paced, tell)
        return tuple(
            f"agent {seat.agent.plan.agent}: {seat.agent.flight.failure}"
            for seat in aboard.host.seats
            if seat.agent.flight.failure
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Aboard:
    """Agents with their vehicles, and what they go by."""

    host: AgentHost
    vehicles: Mapping[int, Vehicle]
    paced: PacedClock
    reached: Reached  # how far the simulation is
    clock: LedClock


def _board(
    stack: ExitStack,
    mission: Mission,
    plans: Sequence[AgentPlan],
    bus: ZenohBus,
    recorder: Recorder,
    told: Briefing,
    attached: Mapping[int, Attached],
) -> _Aboard:
    """Links, vehicles and agents; the links are closed with the stack."""
    own = [plan.agent for plan in plans if plan.agent not in attached]
    urls = {agent: _simulated(agent, told) for agent in own}
    links = {agent: found.link for agent, found in attached.items()}
    links |= {agent: open_link(url, agent) for agent, url in urls.items()}
    systems = {agent: parse_url(url).system for agent, url in urls.items()}
    for link in links.values():
        stack.callback(link.close)
    paced, reached = PacedClock(mission.speed), Reached(bus)
    clock = LedClock(paced, reached, lead_us=LEAD_US, led=lambda: bus.connected)
    vehicles = {
        agent: driver_of(
            mission,
            logged(mission, links[agent], agent, recorder, clock),
            agent,
            attached,
            systems.get(agent),
        )
        for agent in sorted(links)
    }
    host = build_host(mission, plans, vehicles, bus, recorder)
    return _Aboard(host, vehicles, paced, reached, clock)


def _before(mission: Mission, folder: Path | None) -> Recording | None:
    """What an earlier process of these agents wrote down before it died.

    Raises:
        ConfigError: the folder holds something else.
    """
    if folder is None or not begun(folder):
        return None
    before = Recording(folder)
    if before.mission_name != mission.name:
        raise ConfigError(f"--out: {folder} holds a recording of {before.mission_name} already")
    return before


def _remind(host: AgentHost, before: Recording, agents: Sequence[int]) -> None:
    """Agents know again what they told others before their process died."""
    sent = _sent(before, agents)
    for seat in host.seats:
        seat.agent.remember(sent[seat.agent.plan.agent])


def _sent(before: Recording, agents: Sequence[int]) -> dict[int, list[Frame]]:
    """The frames that each agent sent."""
    topics = {f"air/{agent}": agent for agent in agents}
    sent: dict[int, list[Frame]] = {agent: [] for agent in agents}
    for message in before.messages():
        agent = topics.get(message.topic)
        frame = None if agent is None else decode(message.data)
        if agent is not None and frame is not None:
            sent[agent].append(frame)
    return sent


def _recorder(mission: Mission, folder: Path | None, before: Recording | None) -> Recorder:
    recorder = Recorder(
        folder,
        mission_name=mission.name,
        epoch_ns=before.epoch_ns if before else int(wall_date().timestamp()) * SECOND_US * 1000,
        mcap=mission.recording.mcap,
        part=max(before.parts) + 1 if before else 1,
    )
    text = to_toml(as_flown(mission))
    recorder.record("mission", 0, MissionRecord(text, mission.seed, mission.clock, versions()))
    return recorder


def _now_us(paced: PacedClock, reached: Reached) -> int:
    """Mission time: that of the simulation, where there is one and it is late."""
    until_us = paced.now_us() + to_us(paced.speed * FIRST_TRUTH_S)
    while not (simulated_us := reached()) and paced.now_us() < until_us:
        pause(_LOOK_S)
    return max(simulated_us or paced.now_us(), 0)


def _fly(
    aboard: _Aboard, bus: ZenohBus, following: Following, here: Pace, stop: Callable[[], bool]
) -> None:
    """Control ticks until the agents have landed, or given up."""
    host, ended_us = aboard.host, None
    first_us = _now_us(aboard.paced, aboard.reached) // CONTROL_US * CONTROL_US
    ticks = Ticks(aboard.clock, aboard.paced, first_us)
    while ended_us is None or ticks.t_us <= ended_us:
        t_us = ticks.wait()
        if ticks.leapt:
            give_way(bus, [seat.agent.plan.agent for seat in host.seats], ticks.late_s)
        if stop():
            host.call_home()
        following.step()
        host.clocks = following.clocks
        host.step(t_us, late_s=ticks.late_s)
        here.tell(t_us)
        if host.ended and ended_us is None:
            # with a last report, which tells all that they have heard and recorded; one may be lost
            ended_us = (t_us // SECOND_US + 2) * SECOND_US
        ticks.done()
    here.tell(-1)  # nobody need wait for these agents any more


def _waiting(here: Pace, stop: Callable[[], bool]) -> Callable[[], bool]:
    """Says that these agents are there, and asks whether to wait on."""

    def look() -> bool:
        here.tell(-1)
        return stop()

    return look


def _simulated(agent: int, told: Briefing) -> str:
    """Where the launcher simulates an agent's vehicle. Raises UavbridgeError."""
    url = told.vehicles.get(str(agent))
    if url is None:
        raise UavbridgeError(
            f"agent {agent}: no vehicle; give --connect or an endpoint in the mission, or have "
            "the launcher simulate it (bus.remote)"
        )
    return url


def _compare(mission: Mission, told: Briefing) -> None:
    """Raises ConfigError naming the first key that the launcher has otherwise."""
    here = _shared(mission)
    there = _shared(parse(told.mission, "the launcher's mission"))
    for key in sorted(here.keys() | there.keys()):
        if here.get(key) != there.get(key):
            raise ConfigError(
                f"{key}: {here.get(key)!r} in the mission here, "
                f"{there.get(key)!r} in the one that the launcher flies"
            )


def _shared(mission: Mission) -> dict[str, object]:
    plain = mission.for_agents().plain()
    flat: dict[str, object] = {}
    for key, value in plain.items():
        if key in _OWN:
            continue
        if isinstance(value, dict):
            flat.update({f"{key}.{part}": inner for part, inner in value.items()})
        else:
            flat[key] = value
    return flat


def _listed(agents: Sequence[int]) -> str:
    return ", ".join(map(str, agents))


def _told(agreed: Agreement) -> str:
    return (
        f"mission time agreed within {agreed.error_s * 1e3:.1f} ms; this machine's date is "
        f"{agreed.date_offset_s * 1e3:+.1f} ms off the launcher's"
    )
