"""A mission in lockstep: one process, memory links, as fast as the machine can.

A plain loop over control ticks; what happens at one time has a fixed order:
vehicles, world, agents by id, judge. The bytes are those of a live flight.
"""

from __future__ import annotations

from collections.abc import Callable

from planners.planner import Planner
from sim_vehicles.world.payload import Sensor
from uavbridge.bus.api import Bus
from uavbridge.bus.local import LocalHub
from uavbridge.clock import SteppedClock
from uavbridge.config import Mission
from uavbridge.mavlink.link import memory_pair
from uavbridge.recording.recorder import Recorder
from uavbridge.runner import assemble, places
from uavbridge.runner.control import Flown, Progress, build_host, logged
from uavbridge.runner.judge import Judge
from uavbridge.runner.ticks import CONTROL_US
from uavbridge.runner.world import world_of
from uavbridge.vehicle.mavlink import MavlinkVehicle


def fly_stepped(
    mission: Mission,
    planner: Planner,
    *,
    recorder: Recorder,
    progress: Progress,
    stop: Callable[[], bool],
    sensor: Sensor | None = None,
    judge_of: Callable[[Mission, Bus, Recorder], Judge] = Judge,
) -> Flown:
    """Fly a whole mission.

    Args:
        mission: with targets.
        planner: bound to the mission's scenario.
        recorder: gets everything.
        progress: called after every control tick.
        stop: asked at every tick; True calls all home.
        sensor: looks at the ground; None: the mission's.
        judge_of: makes the judge; the flight is over when it says so.
    """
    hub, clock = LocalHub(), SteppedClock()
    plans = assemble.agent_plans(mission.for_agents(), planner)
    agents = tuple(plan.agent for plan in plans)
    fleet = assemble.fleet_of(mission, agents)
    links = [memory_pair() for _ in agents]
    vehicles = {
        agent: MavlinkVehicle(
            logged(mission, near, agent, recorder, clock), agent, origin=assemble.origin(mission)
        )
        for agent, (near, _) in zip(agents, links, strict=True)
    }
    far_ends = [far for _, far in links]
    world = world_of(mission, fleet, agents, hub.bus(), sensor)
    host = build_host(mission, plans, vehicles, hub.bus(), recorder)
    keepers = places.places_of(mission, hub.bus())
    judge = judge_of(mission, hub.bus(), recorder)
    t_us = 0
    while not judge.ended(t_us):
        clock.wait_until(t_us)
        fleet.advance(t_us)
        for index, datagram in fleet.transmit():
            far_ends[index].send(datagram)
        world.step(t_us)
        host.step(t_us)
        if keepers is not None:
            keepers.step(t_us)
        for index, far in enumerate(far_ends):
            for datagram in far.receive():
                fleet.receive(index, datagram)
        if stop():
            judge.stop(t_us)
        judge.step(t_us)
        progress(t_us, judge, host)
        t_us += CONTROL_US
    return Flown(judge, host)
