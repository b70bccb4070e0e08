"""A mission in real time, or real time times a factor: UDP, zenoh, two processes.

The simulation runs in a child process and knows the targets; this one hosts the
router, the agents and the judge. Both count mission time from the same moment
of the machine's monotonic clock. The loop is the stepped one but for waiting:
links and mailboxes are drained when a control tick is due, and nothing blocks.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import replace
from types import MappingProxyType
from typing import TypeAlias

from planners.planner import Planner
from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.security import LAUNCHER, ROUTER
from uavbridge.bus.zenoh_bus import Router, ZenohBus
from uavbridge.clock import SECOND_US, LedClock, PacedClock
from uavbridge.config import Mission
from uavbridge.errors import UavbridgeError
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.udp import UdpLink
from uavbridge.mavlink.urls import open_link
from uavbridge.recording.recorder import Recorder
from uavbridge.runner import assemble, keeping
from uavbridge.runner.control import (
    AHEAD_US,
    LEAD_US,
    Flown,
    Progress,
    build_host,
    logged,
)
from uavbridge.runner.crew import Crew
from uavbridge.runner.drivers import driver_of
from uavbridge.runner.earlier import Earlier
from uavbridge.runner.fitness import Attached
from uavbridge.runner.host import AgentHost
from uavbridge.runner.judge import Judge
from uavbridge.runner.leased import Leased
from uavbridge.runner.nets import NetNotes
from uavbridge.runner.payloads import Payloads
from uavbridge.runner.places import places_of
from uavbridge.runner.router import RouterProcess
from uavbridge.runner.simulation import Reached, Simulation
from uavbridge.runner.stand_down import stand_down
from uavbridge.runner.ticks import Ticks
from uavbridge.vehicle.api import Vehicle
from uavbridge.vehicle.mavlink import MavlinkVehicle

BRIEFED_IN_S = 1.5  # from the briefing of other processes to mission start

Aside: TypeAlias = Callable[[str], AbstractContextManager[None]]

_log = logging.getLogger(__name__)


def fly_paced(
    mission: Mission,
    planner: Planner,
    *,
    recorder: Recorder,
    progress: Progress,
    stop: Callable[[], bool],
    tell: Callable[[str], None] = _log.info,
    aside: Aside | None = None,
    attached: Mapping[int, Attached] = MappingProxyType({}),
    earlier: Earlier | None = None,
) -> Flown:
    """Fly a whole mission.

    Args:
        mission: with targets.
        planner: bound to the mission's scenario.
        recorder: gets everything.
        progress: called after every control tick.
        stop: asked at every tick; True calls all home.
        tell: is told what people need to know at the start.
        aside: entered with the router's endpoint, left at the end.
        attached: vehicles of agents with endpoints that were found already.
        earlier: what was flown of this mission before; it goes on from there.

    Raises:
        BusError: no router, or its port is in use; the message names the key.
        LinkError: a port is in use; likewise.
    """
    others = mission.apart()
    plans = _plans(mission, planner, earlier)
    with ExitStack() as stack:
        endpoint = mission.bus.router
        if endpoint is None:
            with _about("bus.listen"):
                router = _router(mission, bool(others))
            stack.callback(router.close)
            endpoint = router.endpoint
        identity = assemble.identity_of(mission, LAUNCHER)

        def session() -> ZenohBus:
            return stack.enter_context(ZenohBus(endpoint, mission.name, identity=identity))

        with _about("bus.router"):
            bus = session()
        tell(f"zenoh router {endpoint}, keys uavbridge/{mission.name}/**")
        if aside is not None:
            stack.enter_context(aside(endpoint))
        team = [a for a in mission.scenario().team if mission.endpoint(a) is None]
        shared = None if mission.bus.router is None else (endpoint, mission.name)
        leased = stack.enter_context(Leased(team, shared))
        links: dict[int, Link] = {}
        for place, plan in enumerate(plans):
            known = attached.get(plan.agent)
            links[plan.agent] = known.link if known else _link(mission, plan.agent, place, leased)
            stack.callback(links[plan.agent].close)
        simulated = {agent: _port(links.get(agent)) for agent in team}
        simulation = stack.enter_context(
            Simulation(mission, simulated, endpoint, systems=leased.systems, lingers=bool(others))
        )
        judge = Judge(mission, session(), recorder)
        spoken = simulation.ready()
        crew = None
        if others:
            found = {
                agent: _spoken_to(mission, agent, spoken, leased) for agent in others & {*spoken}
            }
            crew = stack.enter_context(Crew(mission, others, session(), recorder, found))
            crew.start(endpoint)
            missing = crew.wait(stop)
            if missing:
                tell(f"agents {', '.join(map(str, sorted(missing)))} are not there; flying without")
        paced = simulation.start() if crew is None else simulation.start(in_s=BRIEFED_IN_S)
        if crew is not None:
            crew.begin(paced.now_us)
        clock = LedClock(paced, Reached(bus), lead_us=LEAD_US) if simulated else paced
        vehicles = {
            agent: driver_of(
                mission,
                logged(mission, link, agent, recorder, clock),
                agent,
                attached,
                leased.systems.get(agent),
            )
            for agent, link in links.items()
        }
        host = build_host(mission, plans, vehicles, bus, recorder)
        elsewhere = {a: v for a, v in vehicles.items() if mission.endpoint(a) is not None}
        progress = _with_payloads(mission, session, progress)
        progress = _with_places(mission, session, progress, recorder.epoch_ns)
        progress = _with_notes(NetNotes(elsewhere, recorder), progress)
        began_us = _go_on(earlier, paced, host, judge, vehicles) if earlier else 0
        ticks = Ticks(clock, paced, began_us)
        _loop(ticks, bus, host, crew, judge, simulation, progress, stop)
        stand_down(elsewhere, paced, tell)
        return Flown(judge, host, ticks.kept)


def _loop(
    ticks: Ticks,
    bus: ZenohBus,
    host: AgentHost,
    crew: Crew | None,
    judge: Judge,
    simulation: Simulation,
    progress: Progress,
    stop: Callable[[], bool],
) -> None:
    """Control ticks until the judge sees the end."""
    simulation.allow(AHEAD_US)
    while not judge.ended(ticks.t_us):
        t_us = ticks.wait()
        if host.seats:
            host.step(t_us, late_s=ticks.late_s)
        if crew is not None:
            host.events.extend(crew.poll(t_us))
            judge.dead = crew.dead
        if stop():
            judge.stop(t_us)
        if not bus.connected:
            judge.miss(t_us)
        judge.step(t_us)
        progress(t_us, judge, host)
        simulation.check()
        simulation.allow(t_us + AHEAD_US if crew is None else crew.allowed_us(t_us))
        ticks.done()
    kept = ticks.kept
    if kept.left_out:
        _log.warning(
            "%d control ticks were left out: the machine is too slow for this speed", kept.left_out
        )


def _plans(mission: Mission, planner: Planner, earlier: Earlier | None) -> list[AgentPlan]:
    """Of the agents that fly in this process."""
    others = mission.apart()
    plans = [
        plan
        for plan in assemble.agent_plans(mission.for_agents(), planner)
        if plan.agent not in others
    ]
    if earlier is None:
        return plans
    return [replace(plan, resumes=True, home=earlier.homes.get(plan.agent)) for plan in plans]


def _go_on(
    earlier: Earlier,
    clock: PacedClock,
    host: AgentHost,
    judge: Judge,
    vehicles: Mapping[int, Vehicle],
) -> int:
    """Everybody knows what was known; the mission time to begin at."""
    for seat in host.seats:
        seat.agent.remember(earlier.frames.get(seat.agent.plan.agent, []))
    for agent, settings in earlier.nets.items():
        vehicle = vehicles.get(agent)
        if isinstance(vehicle, MavlinkVehicle):
            vehicle.net.before = dict(settings)
    began_us = (earlier.t_us // SECOND_US + 1) * SECOND_US
    told = [frame for frames in earlier.frames.values() for frame in frames]
    judge.join(sorted(told, key=lambda frame: frame.t_us), began_us)
    clock.epoch_ns -= int(began_us * 1000 / clock.speed)
    return began_us


def _with_notes(notes: NetNotes, progress: Progress) -> Progress:
    """What the autopilots had set before is written down."""

    def note(t_us: int, judge: Judge, host: AgentHost) -> None:
        notes.step(t_us)
        progress(t_us, judge, host)

    return note


def _with_payloads(
    mission: Mission, session: Callable[[], ZenohBus], progress: Progress
) -> Progress:
    """Vehicles that are not simulated have simulated payloads, unless the mission says no."""
    team = mission.scenario().team
    agents = tuple(agent for agent in team if mission.endpoint(agent) is not None)
    if not agents or not mission.sensor.simulated:
        return progress
    payloads = Payloads(mission, agents, session())

    def sense(t_us: int, judge: Judge, host: AgentHost) -> None:
        payloads.step(t_us)
        progress(t_us, judge, host)

    return sense


def _with_places(
    mission: Mission, session: Callable[[], ZenohBus], progress: Progress, run: int
) -> Progress:
    """The launcher hosts the mission's place agents, and tells those elsewhere the run."""
    table = mission.stigmergy()
    if table is None or table.form == "copies":
        return progress
    bus = session()
    keeping.tell_run(bus, run)
    keepers = places_of(mission, bus)
    if keepers is None:
        return progress
    hosted = keepers

    def keep(t_us: int, judge: Judge, host: AgentHost) -> None:
        hosted.step(t_us)
        progress(t_us, judge, host)

    return keep


def _router(mission: Mission, alone: bool) -> Router | RouterProcess:
    """In a process of its own where the agents are, too: it must not die with this one."""
    if not alone:
        return Router(mission.bus.listen)
    return RouterProcess(mission.bus.listen, assemble.identity_of(mission, ROUTER))


def _port(link: Link | None) -> int:
    """Where a simulated vehicle speaks to; 0: it waits to be spoken to."""
    return link.port if isinstance(link, UdpLink) else 0


def _spoken_to(mission: Mission, agent: int, ports: Mapping[int, int], leased: Leased) -> str:
    """Where another process finds an agent's simulated vehicle."""
    system = leased.systems.get(agent, agent)
    vehicle = "" if system == agent else f"#{system}"
    return f"udpout:{mission.simulator.host}:{ports[agent]}{vehicle}"


def _link(mission: Mission, agent: int, place: int, leased: Leased) -> Link:
    url = mission.endpoint(agent)
    if url is not None:
        with _about(f"endpoint of agent {agent}"):
            return open_link(url, agent)
    ports = mission.simulator.ports
    with _about("simulator.ports"):
        port = 0 if ports == "auto" else leased.keep(ports + place)
        return UdpLink.bind(mission.simulator.host, port, leased.systems.get(agent, agent))


@contextmanager
def _about(key: str) -> Iterator[None]:
    """Errors within name the mission file's key."""
    try:
        yield
    except UavbridgeError as error:
        raise error.at(key) from None
