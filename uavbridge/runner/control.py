"""What the stepped and the paced runner share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.air import Air, SafetyBeacons
from uavbridge.bus.api import Bus
from uavbridge.bus.channel import HOLD_S
from uavbridge.bus.truth import TruthTrack
from uavbridge.clock import Clock
from uavbridge.config import Mission
from uavbridge.config.radio import radio_of
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.middleware import TlogLink
from uavbridge.radio.radio import Radio
from uavbridge.recording.recorder import Recorder
from uavbridge.runner import assemble, places
from uavbridge.runner.host import AgentHost, HeardNotes
from uavbridge.runner.judge import Judge
from uavbridge.runner.ticks import CONTROL_US, Punctuality
from uavbridge.vehicle.api import Vehicle

LEAD_US = 2 * CONTROL_US  # so far agents may be ahead of the simulation
AHEAD_US = 3 * CONTROL_US  # and so far the simulation ahead of them

Progress: TypeAlias = Callable[[int, Judge, AgentHost], None]


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """A mission that is over."""

    judge: Judge
    host: AgentHost
    kept: Punctuality | None = None  # how well time was kept, where it was real


def build_host(
    mission: Mission,
    plans: Sequence[AgentPlan],
    vehicles: Mapping[int, Vehicle],
    bus: Bus,
    recorder: Recorder,
) -> AgentHost:
    """The agents of this process on a bus, each with a radio and a separation beacon."""
    agents = [plan.agent for plan in plans]
    bounds = assemble.bounds_of(mission)
    beacon = Radio(mission.safety.beacon_range_m, mission.seed)
    truth = TruthTrack(bus)
    heard = HeardNotes()
    air = Air(
        bus,
        radio_of(mission),
        agents,
        assemble.radio_tiling(mission),
        truth,
        bounds=bounds,
        log=heard.note,
        hold_s=assemble.patience(mission, HOLD_S),
    )
    return AgentHost(
        plans,
        vehicles,
        bus=bus,
        air=air,
        beacons=SafetyBeacons(
            bus, beacon, agents, assemble.beacon_tiling(mission), truth, bounds=bounds
        ),
        recorder=recorder,
        heard=heard,
        service=places.service_of(mission, bus, air, truth),
    )


def logged(mission: Mission, link: Link, agent: int, recorder: Recorder, clock: Clock) -> Link:
    """The link with everything that passes written to the vehicle's .tlog, if wanted."""
    if not mission.recording.tlog:
        return link
    log = recorder.tlog(agent)
    return TlogLink(link, lambda t_us, _direction, data: log.write(t_us, data), clock.now_us)
