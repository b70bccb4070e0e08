"""From a mission file's values to plans for agents, vehicles and the simulated world."""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot, pi, radians
from pathlib import Path
from types import MappingProxyType
from zlib import crc32

import numpy as np

from planners.belief.merge import MERGE_RULES, SensorModel
from planners.planner import Planner, PlannerKind
from planners.registry import bind
from planners.search.mountain import signal
from planners.terrain import Terrain
from planners.types import F64
from sim_vehicles.dynamics.wind import WindSpec
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.world.obstacles import ObstacleDetector
from sim_vehicles.world.payload import CellSensor, CellSensorSpec
from sim_vehicles.world.signals import ReceiverSpec, SignalReceiver
from uavbridge import plugins
from uavbridge.agent.plan import SIMULATED, AgentPlan, return_heights
from uavbridge.bus.messages import Obstacle
from uavbridge.bus.screening import OLD_S, Bounds
from uavbridge.bus.security import Identity
from uavbridge.bus.tiles import Tiling
from uavbridge.config import Mission
from uavbridge.config.ground import Ground
from uavbridge.config.radio import radio_of
from uavbridge.config.tables import LEAST_FRAME_BYTES, Kind, Point
from uavbridge.errors import ConfigError
from uavbridge.rng import stream
from uavbridge.safety.envelope import Braking, Envelope

ROVER_BRAKING = Braking(brake_m_s2=2.0, latency_s=1.0)  # it has to turn before it drives away
LAYER_CLEARANCE = 1.2  # between return heights, in separation distances
HICCUP_S = 0.5  # wall time for which a busy machine may hold up a process
WIRE_S = 0.03  # wall time from a position to the setpoint that answers it, on a busy machine
MOST_OFFBOARD_LOSS_S = 60.0  # the most that it may be
OFFBOARD_LOSS_S = 1.0  # COM_OF_LOSS_T as PX4 has it


def origin(mission: Mission) -> Geodetic:
    """Where the mission's frame lies on the Earth."""
    home = mission.home
    return Geodetic(home.latitude_deg, home.longitude_deg, home.altitude_m)


def patience(mission: Mission, duration_s: float) -> float:
    """A time-out in mission time, but never so short in wall time that a hiccup trips it."""
    speed = mission.speed if mission.clock == "paced" else 0.0
    return max(duration_s, HICCUP_S * speed)


def wire_delay(mission: Mission) -> float:
    """Mission time (s) that sockets and processes add to a setpoint's way in a paced run."""
    return WIRE_S * mission.speed if mission.clock == "paced" else 0.0


def identity_of(mission: Mission, name: str) -> Identity | None:
    """The credentials of one part of a mission; None where none are asked for.

    Raises:
        ConfigError: they are not there.
    """
    keys = mission.security.keys
    return None if keys is None else Identity(Path(keys) / name)


def planner_of(mission: Mission, kind: PlannerKind | None = None) -> Planner:
    """The mission's planner, bound to its scenario.

    Raises:
        ConfigError: there is no such planner, a parameter is wrong, or it cannot be bound.
    """
    known = plugins.planners() if kind is None else {kind.name: kind}
    name = mission.planner if kind is None else kind.name
    if name not in known:
        raise ConfigError(f"planner: there is no {name!r}; known are {', '.join(sorted(known))}")
    scenario = mission.scenario()
    try:
        return bind(known[name], scenario, mission.parameters)
    except ValueError as fault:
        raise ConfigError(f"parameters: {fault}") from fault
    except Exception as fault:
        raise ConfigError(f"planner {name}: {type(fault).__name__}: {fault}") from fault


def sensor_model(mission: Mission) -> SensorModel:
    """What the agents believe of their payload sensor."""
    return SensorModel(mission.sensor.p, mission.sensor.q, mission.belief.update)


def envelope_of(mission: Mission, kind: Kind = "multirotor") -> Envelope:
    """What the safety filter enforces for vehicles of a kind."""
    west, south, east, north = mission.grid.bounds
    s = mission.safety
    margin = s.fence_margin_m
    drives = kind == "rover"
    braking = ROVER_BRAKING if drives else Braking()
    return Envelope(
        west_m=west - margin,
        south_m=south - margin,
        east_m=east + margin,
        north_m=north + margin,
        altitude_min_m=s.altitude_min_m,
        altitude_max_m=s.altitude_max_m,
        speed_m_s=s.speed_m_s,
        climb_m_s=s.climb_m_s,
        separation_m=s.separation_m if s.separation else 0.0,
        braking=Braking(braking.brake_m_s2, braking.latency_s + wire_delay(mission)),
        sink_m_s=s.sink_m_s,
        terrain=mission.terrain(),
        drives=drives,
        columns=tuple((*o.position, o.radius_m + o.clearance_m) for o in mission.obstacles),
        steepest_rad=pi / 2 if mission.ground is None else mission.ground.alpha_rad,
        slowest_m_s=s.slowest_m_s if kind == "plane" else 0.0,
    )


def mission_mark(mission: Mission) -> int:
    """A number of 16 bits by which frames of another mission are told apart."""
    area, name = mission.area, f"{mission.name} {mission.seed} {mission.belief.merge}"
    return crc32(f"{name} {area.columns} {area.rows} {area.cell_m}".encode()) & 0xFFFF


def _frame_bytes(mission: Mission) -> float:
    """What an agent may send a tick, by the mission's word and its radio's bandwidth."""
    radio = mission.radio
    return min(radio.frame_bytes, max(LEAST_FRAME_BYTES, radio.bytes_per_s * mission.tick))


def agent_plans(mission: Mission, planner: Planner) -> list[AgentPlan]:
    """A plan for each agent, ascending ids. Nothing in it knows the targets."""
    scenario = mission.scenario()
    terrain, ground = mission.terrain(), mission.ground or Ground()
    members = mission.team()
    envelopes = {kind: envelope_of(mission, kind) for kind in {m.kind for m in members}}
    clearance = LAYER_CLEARANCE * mission.safety.separation_m
    heights = return_heights(len(scenario.team), envelope_of(mission), clearance)
    return [
        AgentPlan(
            agent=member.id,
            seed=mission.seed,
            scenario=scenario,
            planner=planner,
            rule=MERGE_RULES[mission.belief.merge],
            sensor=sensor_model(mission),
            prior=mission.prior(),
            envelope=envelopes[member.kind],
            start=(*member.start, _height(terrain, member.start) + member.altitude_m),
            return_height_m=height,
            duration_s=mission.duration,
            terrain=terrain,
            drives=member.kind == "rover",
            climb_rad=ground.beta_rad,
            sensing_m=ground.sensing_m,
            mission_mark=mission_mark(mission),
            frame_bytes=_frame_bytes(mission),
            keyframe_s=mission.radio.keyframe_s,
            aloft=mission.fleet.in_air and mission.endpoint(member.id) is None,
            endpoint=mission.endpoint(member.id) or SIMULATED,
            net=_net(mission, member.id),
            ready_timeout_s=patience(mission, 60.0),
            retry_s=patience(mission, 2.0),
            silence_s=patience(mission, 5.0),
        )
        for member, height in zip(members, heights, strict=True)
    ]


def _height(terrain: Terrain | None, place: Point) -> float:
    """Of the ground, m."""
    return 0.0 if terrain is None else float(terrain.height_at(place))


def _net(mission: Mission, agent: int) -> tuple[float, float] | None:
    """When the autopilot of a vehicle that we do not simulate is to act on its own."""
    if mission.endpoint(agent) is None:
        return None
    safety = mission.safety
    return patience(mission, safety.setpoint_loss_s), patience(mission, safety.link_loss_s)


def fleet_of(
    mission: Mission, agents: tuple[int, ...], systems: Mapping[int, int] = MappingProxyType({})
) -> Fleet:
    """The simulated vehicles of some agents, at their starts.

    Args:
        mission: what is flown.
        agents: whose vehicles.
        systems: system ids of those that have others than their agents' numbers.
    """
    members = {member.id: member for member in mission.team()}
    terrain, w = mission.terrain(), mission.wind
    return Fleet(
        [
            VehicleSpec(
                system=systems.get(agent, agent),
                start=(*members[agent].start, _height(terrain, members[agent].start)),
                yaw_rad=pi / 2 - radians(mission.fleet.heading_deg),
                kind=members[agent].kind,
                in_air_m=members[agent].altitude_m if mission.fleet.in_air else None,
            )
            for agent in agents
        ],
        origin=origin(mission),
        terrain=terrain,
        model=mission.fleet.model,
        seed=mission.seed,
        wind=WindSpec((w.east_m_s, w.north_m_s, w.up_m_s), w.gust_m_s),
        step_s=mission.simulator.step_s,
        endurance=mission.simulator.endurance,
        parameters={
            "COM_OF_LOSS_T": min(patience(mission, OFFBOARD_LOSS_S), MOST_OFFBOARD_LOSS_S),
            **_alone(mission, terrain),
            **mission.simulator.parameters,
        },
    )


def _alone(mission: Mission, terrain: Terrain | None) -> dict[str, float]:
    """Autopilots that come home by themselves, as nobody gives way for others then: above them."""
    if any(member.kind != "multirotor" for member in mission.team()):
        return {}
    highest_m = 0.0 if terrain is None else float(terrain.heights.max() - terrain.heights.min())
    return {"RTL_RETURN_ALT": highest_m + mission.safety.altitude_max_m, "RTL_CONE_ANG": 0.0}


def sensor_of(mission: Mission, agents: tuple[int, ...]) -> CellSensor:
    """The payload sensors of some agents, over the true targets."""
    spec = CellSensorSpec(
        p=mission.sensor.p,
        q=mission.sensor.q,
        period_s=mission.sensor.period_s,
        height_min_m=mission.safety.altitude_min_m / 2,
        reach_m=mission.sensor.reach_m,
    )
    generators = [stream(mission.seed, "sensor", agent) for agent in agents]
    return CellSensor(mission.grid, _targets(mission), spec, generators)


def receiver_of(mission: Mission, agents: tuple[int, ...]) -> SignalReceiver | None:
    """The signal receivers of some agents; None without ``[signals]``."""
    given = mission.signals
    if given is None:
        return None

    def strength(distance: F64, noise: F64) -> F64:
        scaled = noise * given.noise
        return signal(distance, scaled, given.attenuation, given.power, given.range_m)

    spec = ReceiverSpec(
        strength, given.range_m, given.arrival_m, given.period_s, given.silent_when_found
    )
    generators = [stream(mission.seed, "signal", agent) for agent in agents]
    return SignalReceiver(_targets(mission), mission.terrain(), spec, generators)


def detector_of(mission: Mission, agents: tuple[int, ...]) -> ObstacleDetector | None:
    """The obstacle detectors of some agents; None where all columns are known before."""
    hidden = mission.columns(known=False)
    return ObstacleDetector(hidden, mission.sensor.sight_m, len(agents)) if len(hidden) else None


def hidden_of(mission: Mission) -> list[Obstacle]:
    """The columns in the order of the detectors, as they are told of."""
    hidden = [each for each in mission.obstacles if not each.known]
    return [
        Obstacle(number, *each.position, each.radius_m, each.clearance_m)
        for number, each in enumerate(hidden)
    ]


def _targets(mission: Mission) -> F64:
    return np.array([target.position for target in mission.targets]).reshape(-1, 2)


def radio_tiling(mission: Mission) -> Tiling:
    """Tiles of the planners' radio."""
    return Tiling.of(radio_of(mission).longest_m, mission.safety.speed_m_s)


def bounds_of(mission: Mission) -> Bounds:
    """What an honest agent of the mission may send."""
    safety = mission.safety
    return Bounds(
        team=frozenset(mission.scenario().team),
        mission=mission_mark(mission),
        most_bytes=mission.radio.frame_bytes,
        area=mission.grid.bounds,
        speed_m_s=hypot(safety.speed_m_s, safety.climb_m_s),
        old_s=patience(mission, OLD_S),
    )


def beacon_tiling(mission: Mission) -> Tiling:
    """Tiles of the separation beacon."""
    return Tiling.of(mission.safety.beacon_range_m, mission.safety.speed_m_s)
