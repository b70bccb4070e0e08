import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from planners import conformance, registry
from planners.flocking.starling import goals, message
from planners.flocking.starling.message import Told
from planners.grid import Grid
from planners.memory import dumps
from planners.search.starling import STARLING
from planners.terrain import Terrain
from planners.types import Limits, Neighbours, Scenario, View

ages = st.floats(0.0, 1e4, width=32) | st.just(math.inf)
points = st.lists(
    st.tuples(*[st.floats(-1e5, 1e5, width=32)] * 3), min_size=2, max_size=message.POINTS
)


@given(st.integers(0, 9), ages, ages, st.integers(0, 10**12), st.integers(0, 99), points)
def test_a_message_survives_the_way(leg, danger, alarm, planned, planner, way):
    told = Told(leg, danger, alarm, planned, planner, np.array(way))
    data = message.encode(told)
    assert len(data) <= conformance.PAYLOAD_BYTES
    assert dumps(message.decode(data)) == dumps(told)


@settings(max_examples=200)
@given(st.binary(max_size=80) | st.binary(min_size=20, max_size=60).map(lambda b: b"\x01" + b))
def test_any_bytes_are_a_message_or_none(data):
    told = message.decode(data)
    assert np.isfinite(told.way).all()
    assert told.danger_s >= 0.0


def test_the_latest_leg_and_the_newest_way_win():
    way = np.zeros((2, 3))
    assert Told(leg=1).rank > Told(0, planned_us=5, planner=1, way=way).rank
    assert Told(0, planned_us=6, planner=1, way=way).rank > Told(0, planned_us=5, planner=9).rank


def flight(ground, seconds, count=6):
    """Positions (k, n, 3), notes and legs of a team that flies what it wants."""
    grid = Grid(0.0, 0.0, 100.0, 20, 10)
    team = tuple(range(1, count + 1))
    starts = np.array([[80.0 + 40.0 * (i % 2), 300.0 + 45.0 * i, 60.0] for i in range(count)])
    limits = Limits(speed_m_s=20.0, climb_m_s=6.0, altitude_max_m=150.0)
    case = Scenario(grid, team, starts, 0.5, limits)
    planner = registry.bind(STARLING, case, {"aim_north": 0.5})
    position, velocity = starts.copy(), np.tile([20.0, 0.0, 0.0], (count, 1))
    memories, payloads = [None] * count, [b""] * count
    track, legs = [], []
    belief, seen = np.zeros(grid.shape), np.zeros(grid.shape, bool)
    for tick in range(round(seconds / 0.5)):
        wanted, told = velocity.copy(), list(payloads)
        for row, agent in enumerate(team):
            others = [i for i in range(count) if i != row]
            heard = Neighbours(
                np.array(team)[others],
                position[others],
                velocity[others],
                np.zeros(count - 1),
                tuple(payloads[i] for i in others),
            )
            heading = math.atan2(velocity[row, 1], velocity[row, 0])
            view = View(
                tick * 500_000, tick, agent, position[row], velocity[row], heading, heard,
                belief, seen, terrain=ground.around(position[row], 500.0),
            )  # fmt: skip
            if tick == 0:
                memories[row] = planner.init(view)
            rng = np.random.default_rng([7, agent, tick])
            goal, memories[row] = planner.plan(view, memories[row], rng)
            wanted[row], told[row] = goal.setpoint.velocity, goal.payload
        position, velocity, payloads = position + wanted * 0.5, wanted, told
        track.append(position)
        legs.append([memory.told.leg for memory in memories])
    return np.array(track), np.array(legs)


def test_a_team_passes_a_hill_together():
    x, y = np.meshgrid(np.arange(101) * 20.0, np.arange(51) * 20.0, indexing="ij")
    heights = 400.0 * np.exp(-0.5 * (((x - 800.0) / 120.0) ** 2 + ((y - 500.0) / 160.0) ** 2))
    ground = Terrain(0.0, 0.0, 20.0, heights)
    track, _ = flight(ground, 70.0, 4)
    assert track[-1, :, 0].min() > 1000.0
    assert (track[..., 2] - ground.height_at(track)).min() > 15.0
    assert goals.separation(track).min() > 10.0
    assert goals.groups(track[-1], 120.0) == 1


def test_at_the_aim_all_turn_back():
    ground = Terrain(0.0, 0.0, 1000.0, np.zeros((3, 2)))
    track, legs = flight(ground, 115.0, 3)
    assert track[:, :, 0].max() > 1650.0
    assert (legs[-1] == 1).all()
    assert (np.diff(track[-6:, :, 0], axis=0) < 0.0).all()
