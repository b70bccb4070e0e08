"""A mission in real time, or real time times a factor: UDP, zenoh, two processes.

The simulation runs in a child process and knows the targets; this one hosts the
router, the agents and the judge. Both count mission time from the same moment
of the machine's monotonic clock. The loop is the stepped one but for waiting:
links and mailboxes are drained when a control tick is due, and nothing blocks.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TypeAlias

from planners.planner import Planner
from uavbridge.bus.zenoh_bus import Router, ZenohBus
from uavbridge.clock import SECOND_US, Clock, LedClock, to_s
from uavbridge.config import Mission
from uavbridge.errors import UavbridgeError
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.udp import UdpLink
from uavbridge.mavlink.urls import open_link
from uavbridge.recording.recorder import Recorder
from uavbridge.runner import assemble
from uavbridge.runner.control import CONTROL_US, LOOPBACK, Flown, Progress, build_host, logged
from uavbridge.runner.host import AgentHost
from uavbridge.runner.judge import Judge
from uavbridge.runner.simulation import Reached, Simulation
from uavbridge.vehicle.mavlink import MavlinkVehicle

LEAD_US = 2 * CONTROL_US  # so far agents may be ahead of the simulation
AHEAD_US = 3 * CONTROL_US  # and so far the simulation ahead of them
LATE_TICKS = 5  # so many ticks late, the next ones but those on a full second are left out

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

    Raises:
        BusError: no router, or its port is in use; the message names the key.
        LinkError: a port is in use; likewise.
    """
    plans = assemble.agent_plans(mission.for_agents(), planner)
    with ExitStack() as stack:
        endpoint = mission.bus.router
        if endpoint is None:
            with _about("bus.listen"):
                endpoint = stack.enter_context(Router(mission.bus.listen)).endpoint
        with _about("bus.router"):
            bus = stack.enter_context(ZenohBus(endpoint, mission.name))
        tell(f"zenoh router {endpoint}, keys uavbridge/{mission.name}/**")
        if aside is not None:
            stack.enter_context(aside(endpoint))
        links: dict[int, Link] = {}
        for place, plan in enumerate(plans):
            links[plan.agent] = _link(mission, plan.agent, place)
            stack.callback(links[plan.agent].close)
        ports = {agent: link.port for agent, link in links.items() if isinstance(link, UdpLink)}
        simulated = [plan.agent for plan in plans if mission.endpoint(plan.agent) is None]
        simulation = stack.enter_context(
            Simulation(mission, {agent: ports[agent] for agent in simulated}, endpoint)
        )
        judge = Judge(mission, stack.enter_context(ZenohBus(endpoint, mission.name)), recorder)
        paced = simulation.start()
        clock = LedClock(paced, Reached(bus), lead_us=LEAD_US) if simulated else paced
        vehicles = {
            agent: MavlinkVehicle(
                logged(mission, link, agent, recorder, clock),
                agent,
                origin=assemble.origin(mission),
                link_timeout_s=assemble.patience(mission, 3.0),
            )
            for agent, link in links.items()
        }
        host = build_host(mission, plans, vehicles, bus, recorder)
        _loop(clock, host, judge, simulation, progress, stop)
        return Flown(judge, host)


def _loop(
    clock: Clock,
    host: AgentHost,
    judge: Judge,
    simulation: Simulation,
    progress: Progress,
    stop: Callable[[], bool],
) -> None:
    """Control ticks until the judge sees the end."""
    t_us, late = 0, 0
    simulation.allow(AHEAD_US)
    while not judge.ended(t_us):
        clock.wait_until(t_us)
        host.step(t_us, late_s=to_s(clock.now_us() - t_us))
        if stop():
            judge.stop(t_us)
        judge.step(t_us)
        progress(t_us, judge, host)
        simulation.check()
        simulation.allow(t_us + AHEAD_US)
        t_us += CONTROL_US
        while t_us % SECOND_US and clock.now_us() - t_us > LATE_TICKS * CONTROL_US:
            t_us += CONTROL_US
            late += 1
    if late:
        _log.warning("%d control ticks were left out: the machine is too slow for this speed", late)


def _link(mission: Mission, agent: int, place: int) -> Link:
    url = mission.endpoint(agent)
    if url is not None:
        with _about(f"endpoint of agent {agent}"):
            return open_link(url, agent)
    ports = mission.simulator.ports
    with _about("simulator.ports"):
        return UdpLink.bind(LOOPBACK, 0 if ports == "auto" else ports + place, agent)


@contextmanager
def _about(key: str) -> Iterator[None]:
    """Errors within name the mission file's key."""
    try:
        yield
    except UavbridgeError as error:
        raise error.at(key) from None
