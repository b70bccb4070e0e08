"""The tables of a mission file: one frozen struct each, keys with their limits and a line of doc.

The same annotations check a file, make the JSON schema, and fill docs/reference/mission_file.md.
"""

from __future__ import annotations

from math import inf
from typing import Annotated, Literal, TypeAlias

from msgspec import Meta, Struct, field

LEAST_FRAME_BYTES = 128.0  # room for a position, a probe and a cell
MAX_VEHICLES = 250  # MAVLink system ids 1..250; 251..255 are for ground stations

Point: TypeAlias = tuple[float, float]
Probability = Annotated[float, Meta(gt=0.0, lt=1.0)]
Kind: TypeAlias = Literal["multirotor", "rover", "plane"]
AgentId = Annotated[int, Meta(ge=1, le=MAX_VEHICLES)]
Port = Annotated[int, Meta(ge=1024, le=65535)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Delay = Annotated[float, Meta(ge=0.0, le=60.0)]
Rate = Annotated[float, Meta(ge=1.0)]


class Table(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What all tables have in common: no unknown keys, no changes."""


class Home(Table, frozen=True):
    """Where the origin of the local frame lies on the Earth."""

    latitude_deg: Annotated[float, Meta(ge=-89.0, le=89.0, description="WGS 84")] = 47.397742
    longitude_deg: Annotated[float, Meta(ge=-180.0, le=180.0, description="WGS 84")] = 8.545594
    altitude_m: Annotated[
        float, Meta(ge=-500.0, le=9000.0, description="of the ground, above sea level")
    ] = 488.0


class Area(Table, frozen=True):
    """The search area: a grid of square cells, in metres east and north of home."""

    cell_m: Annotated[float, Meta(gt=0.0, le=1e5, description="side of a cell")]
    columns: Annotated[int, Meta(ge=1, le=2000, description="cells from west to east")]
    rows: Annotated[int, Meta(ge=1, le=2000, description="cells from south to north")]
    west_m: Annotated[float, Meta(ge=-1e5, le=1e5, description="x of the western edge")] = 0.0
    south_m: Annotated[float, Meta(ge=-1e5, le=1e5, description="y of the southern edge")] = 0.0


class Fleet(Table, frozen=True):
    """The vehicles and where they take off."""

    starts: Annotated[
        tuple[Point, ...],
        Meta(description="[x, y] of each vehicle in m, by ascending id; missing ones are placed"),
    ] = ()
    kind: Annotated[Kind, Meta(description="what the vehicles are")] = "multirotor"
    altitude_m: Annotated[
        float, Meta(gt=0.0, description="search altitude above home, or above the terrain")
    ] = 40.0
    in_air: Annotated[
        bool, Meta(description="simulated vehicles start flying there, and end the mission so")
    ] = False
    heading_deg: Annotated[
        float,
        Meta(ge=-360.0, le=360.0, description="where simulated ones look at the start; 90: east"),
    ] = 0.0
    spacing_m: Annotated[
        float, Meta(gt=0.0, description="distance between starts that are placed automatically")
    ] = 50.0
    model: Annotated[
        Literal["multirotor", "perfect", "six-dof", "guidance"],
        Meta(description="vehicle model of the simulator; planes have the last two"),
    ] = "multirotor"


class Agent(Table, frozen=True):
    """What is particular to one agent."""

    id: Annotated[AgentId, Meta(description="agent id, also its MAVLink system id")]
    start: Annotated[Point | None, Meta(description="[x, y] in m, instead of fleet.starts")] = None
    kind: Annotated[Kind | None, Meta(description="instead of fleet.kind")] = None
    altitude_m: Annotated[
        float | None, Meta(description="search altitude, instead of fleet.altitude_m")
    ] = None
    endpoint: Annotated[
        str | None,
        Meta(description='MAVLink endpoint such as "udpin:127.0.0.1:14550"; absent: simulated'),
    ] = None


class Sensor(Table, frozen=True):
    """The payload sensor of every agent (Khan 2014, Eq. (1))."""

    p: Annotated[Probability, Meta(description="P(detection | target in the cell)")] = 0.9
    q: Annotated[Probability, Meta(description="P(detection | no target in the cell)")] = 0.05
    period_s: Annotated[
        float,
        Meta(
            ge=0.0,
            le=86400.0,
            description="0: one reading on entering a cell; else one a period inside too",
        ),
    ] = 0.0
    reach_m: Annotated[
        float,
        Meta(ge=0.0, le=1e4, description="cells so near to the vehicle's own are read with it"),
    ] = 0.0
    sight_m: Annotated[
        float,
        Meta(gt=0.0, le=1e5, description="how far obstacles that are not known before are seen"),
    ] = 100.0
    simulated: Annotated[
        bool,
        Meta(
            description="vehicles that are not simulated look from where they say that they are; "
            "false: detectors of your own publish on obs/<agent> for them"
        ),
    ] = True


class Expected(Table, frozen=True):
    """Where a target is expected, rightly or not: a bump of the map at the start."""

    position: Annotated[Point, Meta(description="[x, y] in m")]
    weight: Annotated[float, Meta(gt=0.0, description="its importance, alpha of Eq. (2)")] = 1.0


class Belief(Table, frozen=True):
    """The map that every agent keeps."""

    prior: Annotated[
        Probability,
        Meta(description="P(target) of a cell at the start, where no target is expected"),
    ] = 0.5
    expected: Annotated[
        tuple[Expected, ...],
        Meta(description="where targets are expected (Liu 2022, Eqs. (1)-(2)); none: P is prior"),
    ] = ()
    sigma_m: Annotated[
        float, Meta(gt=0.0, description="standard deviation of an expected target's place")
    ] = 50.0
    peak: Annotated[
        Probability, Meta(description="P of the likeliest cell, where targets are expected")
    ] = 0.8
    update: Annotated[
        Literal["bayes", "liu"],
        Meta(description="what a reading does: Khan 2014, Eq. (1), or Liu 2022, Eqs. (4)-(5)"),
    ] = "bayes"
    merge: Annotated[str, Meta(description="rule by which received cells are merged")] = (
        "belief-update"
    )
    threshold: Annotated[
        Probability, Meta(description="a target is declared in a cell above this probability")
    ] = 0.95


class Target(Table, frozen=True):
    """A true target. Only the simulated world knows it."""

    position: Annotated[Point, Meta(description="[x, y] in m, inside the area")]


class RadioLink(Table, frozen=True, rename={"sender": "from", "receiver": "to"}):
    """What is different on some links; an absent key is as in [radio]."""

    sender: Annotated[AgentId | None, Meta(description="agent id; absent: every agent")] = None
    receiver: Annotated[AgentId | None, Meta(description="agent id; absent: every agent")] = None
    range_m: Annotated[float | None, Meta(description="as in [radio]")] = None
    loss: Annotated[Share | None, Meta(description="as in [radio]")] = None
    burst_enter: Annotated[Share | None, Meta(description="as in [radio]")] = None
    burst_leave: Annotated[Share | None, Meta(description="as in [radio]")] = None
    burst_loss: Annotated[Share | None, Meta(description="as in [radio]")] = None
    delay_s: Annotated[Delay | None, Meta(description="as in [radio]")] = None
    jitter_s: Annotated[Delay | None, Meta(description="as in [radio]")] = None
    bytes_per_s: Annotated[Rate | None, Meta(description="bandwidth of this link alone")] = None


class Radio(Table, frozen=True):
    """The emulated radio between agents."""

    range_m: Annotated[
        float, Meta(gt=0.0, description="inf, the default: everybody hears everybody")
    ] = inf
    loss: Annotated[Share, Meta(description="probability that a frame is lost, each by itself")] = (
        0.0
    )
    burst_enter: Annotated[
        Share,
        Meta(description="probability a tick that a burst of losses begins (Gilbert-Elliott)"),
    ] = 0.0
    burst_leave: Annotated[
        Share, Meta(description="probability a tick that it ends; mean length 1 / burst_leave")
    ] = 0.1
    burst_loss: Annotated[
        Share, Meta(description="probability that a frame is lost during a burst")
    ] = 1.0
    delay_s: Annotated[Delay, Meta(description="time that every frame takes")] = 0.0
    jitter_s: Annotated[Delay, Meta(description="and at most so much more, uniformly")] = 0.0
    bytes_per_s: Annotated[Rate, Meta(description="bandwidth of each sender; inf: unlimited")] = inf
    queue_s: Annotated[
        Delay, Meta(description="so long a frame may wait for bandwidth; then it is lost")
    ] = 2.0
    links: Annotated[
        tuple[RadioLink, ...],
        Meta(
            description="[[radio.links]]: from, to (agent ids; absent: all) and any of the keys "
            "above but queue_s; of two for one link the later one counts"
        ),
    ] = ()
    frame_bytes: Annotated[
        float,
        Meta(ge=LEAST_FRAME_BYTES, description="the most that a frame may have; inf: no limit"),
    ] = 1200.0
    keyframe_s: Annotated[
        float,
        Meta(
            gt=0.0,
            description="time between two frames with all that is known; inf: who lacks something "
            "asks for it",
        ),
    ] = inf


class Safety(Table, frozen=True):
    """What no setpoint may violate, whatever the planner says."""

    separation: Annotated[bool, Meta(description="keep vehicles apart")] = True
    separation_m: Annotated[float, Meta(gt=0.0, description="distance kept between vehicles")] = (
        10.0
    )
    beacon_range_m: Annotated[
        float, Meta(gt=0.0, description="range of the position beacon that separation relies on")
    ] = 200.0
    fence_margin_m: Annotated[
        float, Meta(ge=0.0, description="how far the fence lies outside the area")
    ] = 50.0
    altitude_min_m: Annotated[
        float, Meta(ge=0.0, description="above home, or above the terrain")
    ] = 15.0
    altitude_max_m: Annotated[
        float, Meta(gt=0.0, description="above home, or above the terrain")
    ] = 120.0
    speed_m_s: Annotated[float, Meta(gt=0.0, le=100.0, description="horizontal speed limit")] = 10.0
    slowest_m_s: Annotated[
        float, Meta(ge=10.0, le=60.0, description="slowest that planes fly: they can not stop")
    ] = 22.0
    climb_m_s: Annotated[float, Meta(gt=0.0, le=20.0, description="climb limit")] = 3.0
    sink_m_s: Annotated[float, Meta(gt=0.0, le=20.0, description="sink limit")] = 1.5
    setpoint_loss_s: Annotated[
        float,
        Meta(
            ge=0.5,
            le=60.0,
            description="a vehicle elsewhere that gets no setpoints for so long holds by itself",
        ),
    ] = 2.0
    link_loss_s: Annotated[
        float,
        Meta(
            ge=2.0,
            le=120.0,
            description="a vehicle elsewhere that does not hear us for so long returns by itself",
        ),
    ] = 10.0


class Wind(Table, frozen=True):
    """Steady wind and gusts in the simulation."""

    east_m_s: Annotated[float, Meta(ge=-30.0, le=30.0, description="towards east")] = 0.0
    north_m_s: Annotated[float, Meta(ge=-30.0, le=30.0, description="towards north")] = 0.0
    up_m_s: Annotated[float, Meta(ge=-10.0, le=10.0, description="upwards")] = 0.0
    gust_m_s: Annotated[float, Meta(ge=0.0, le=15.0, description="standard deviation")] = 0.0


class Bus(Table, frozen=True):
    """Where the agents' bus lives (paced missions only)."""

    listen: Annotated[
        str, Meta(description='endpoint of the embedded router, "auto": a free port on loopback')
    ] = "auto"
    router: Annotated[
        str | None, Meta(description="endpoint of an external router; then none is embedded")
    ] = None
    agents_per_process: Annotated[
        int,
        Meta(
            ge=0,
            le=MAX_VEHICLES,
            description="agents in each child process; 0: all in the launcher's own",
        ),
    ] = 0
    remote: Annotated[
        tuple[AgentId, ...],
        Meta(description="agents that `uavbridge agent` flies, here or on other machines"),
    ] = ()
    wait_s: Annotated[
        float, Meta(ge=0.0, le=86400.0, description="how long to wait for those agents at start")
    ] = 60.0


class Security(Table, frozen=True):
    """Who may take part, and do what (docs/how_to/secure_the_bus.md)."""

    keys: Annotated[
        str | None,
        Meta(description="folder made by `uavbridge keys new`; absent: whoever comes may do all"),
    ] = None


class Simulator(Table, frozen=True):
    """The simulated vehicles."""

    step_s: Annotated[float, Meta(ge=0.001, le=0.1, description="of the integration")] = 0.02
    host: Annotated[
        str, Meta(description="address at which agents of other processes find their vehicles")
    ] = "127.0.0.1"
    ports: Annotated[
        Literal["auto"] | Port,
        Meta(description='UDP ports of the vehicles: first of a row, or "auto": free ones'),
    ] = "auto"
    endurance: Annotated[
        float,
        Meta(
            gt=0.0,
            le=1e6,
            description="capacity of the batteries, times that of the vehicle model;"
            " a multirotor's lasts 20 minutes",
        ),
    ] = 1.0
    parameters: Annotated[
        dict[str, float], Meta(description="autopilot parameters, such as MPC_XY_VEL_MAX")
    ] = field(default_factory=dict)


class Mavlink(Table, frozen=True):
    """The links to vehicles that are not simulated."""

    driver: Annotated[
        Literal["uavbridge", "mavsdk"],
        Meta(description="what drives them: our own client, or MAVSDK 4 (multirotors only)"),
    ] = "uavbridge"
    signing_keys: Annotated[
        str | None,
        Meta(description="file of MAVLink 2 signing keys; then what is not signed is refused"),
    ] = None


class Recording(Table, frozen=True):
    """What is written to the output folder beside summary and report."""

    mcap: Annotated[bool, Meta(description="mission.mcap with all that happened")] = True
    tlog: Annotated[bool, Meta(description="one MAVLink .tlog a vehicle")] = True
    foxglove: Annotated[
        bool, Meta(description="also what Foxglove shows by itself: poses, map, scene, log")
    ] = True
    part_mb: Annotated[
        float,
        Meta(ge=0.0, description="a new mission-N.mcap after so many MB; 0: never"),
    ] = 256.0
    part_min: Annotated[
        float, Meta(ge=0.0, description="and after so many minutes of mission time; 0: never")
    ] = 0.0
