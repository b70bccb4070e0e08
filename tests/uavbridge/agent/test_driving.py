"""One agent whose vehicle drives, and one that follows terrain, from start to end."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, radians

import numpy as np
import pytest

from planners.terrain import mountains
from planners.types import FlyVelocity, GoTo
from tests.uavbridge.agent.point_vehicle import PointVehicle
from tests.uavbridge.agent.test_flight import ENVELOPE, FlyTo, Run, answered, plan_of
from uavbridge.agent.orders import Order, Verb
from uavbridge.agent.phases import Phase
from uavbridge.vehicle.api import Disarm, Follow, LandHere, TakeOff

HILLS = mountains(np.random.default_rng(4), (0.0, 0.0, 1000.0, 1000.0), radians(35))
EAST = FlyTo(FlyVelocity(np.array([6.0, 0.0, 2.0])))


def rover(planner, **changes):
    envelope = replace(ENVELOPE, drives=True, separation_m=3.0)
    plan = plan_of(planner, drives=True, envelope=envelope, start=(100.0, 100.0, 0.0), **changes)
    return Run(plan, PointVehicle((100, 100, 0), kind="rover"))


def test_a_drive_from_start_to_end():
    run = rover(EAST).until(Phase.SEARCH)
    for _ in range(300):
        run.step()
        assert run.vehicle.state.position[2] == 0.0
    assert run.vehicle.state.position[0] > 250.0
    assert run.agent.flight.distance_m == pytest.approx(run.vehicle.state.position[0] - 100, abs=2)
    run.step(orders=(Order(Verb.RETURN),))
    run.until(Phase.DONE, 200)
    assert run.phases == [
        *(Phase.CONNECT, Phase.ARM, Phase.START, Phase.SEARCH, Phase.HOME, Phase.PARK, Phase.DONE)
    ]
    assert hypot(*(run.vehicle.state.position[:2] - 100)) < 4.0
    assert not run.vehicle.state.armed
    assert not any(isinstance(one, TakeOff | LandHere) for one in run.vehicle.commands)
    assert run.agent.flight.failure == ""


def test_a_rover_that_the_mission_takes_for_something_else_drives_too():
    run = Run(plan_of(EAST), PointVehicle((100, 100, 0), kind="rover")).until(Phase.SEARCH)
    assert Phase.START in run.phases
    run.step(orders=(Order(Verb.LAND),))
    assert run.agent.phase is Phase.PARK
    run.until(Phase.DONE)


def test_orders_to_a_rover():
    run = rover(EAST).until(Phase.SEARCH)
    assert answered(run, Verb.GOTO, position=(150.0, 120.0, float("nan"))).ok
    for _ in range(300):
        run.step()
    assert hypot(*(run.vehicle.state.position[:2] - (150, 120))) < 1.0
    assert answered(run, Verb.RESUME).ok
    assert answered(run, Verb.LAND).ok
    run.until(Phase.DONE)
    assert any(isinstance(one, Disarm) for one in run.vehicle.commands)


def test_a_rover_that_gets_nowhere_parks_and_says_so():
    run = rover(EAST).until(Phase.SEARCH)
    for _ in range(200):
        run.step()
    run.step(orders=(Order(Verb.RETURN),))
    run.vehicle._velocity = lambda state: np.zeros(3)  # its wheels spin
    run.until(Phase.DONE, 120)
    assert "no nearer to home" in run.agent.flight.failure


def test_a_rover_that_does_not_set_out_is_parked():
    run = rover(EAST)
    run.vehicle = PointVehicle((100, 100, 0), refusal="Not now", refuses=Follow, kind="rover")
    run.until(Phase.DONE, 150)
    assert run.agent.flight.failure == "start failed: Follow refused: Not now"
    assert not run.vehicle.state.armed


@pytest.mark.parametrize(
    "setpoint",
    [FlyVelocity(np.array([6.0, 4.0, 0.0])), GoTo(np.array([800.0, 700.0, 30.0]))],
)
def test_heights_are_those_above_the_ground(setpoint):
    start = (100.0, 100.0)
    ground = float(HILLS.height_at(start))
    envelope = replace(ENVELOPE, terrain=HILLS, climb_m_s=5.0, sink_m_s=4.0)
    plan = plan_of(
        FlyTo(setpoint),
        terrain=HILLS,
        envelope=envelope,
        start=(*start, ground + 30.0),
        return_height_m=40.0,
    )
    run = Run(plan, PointVehicle((*start, ground))).until(Phase.SEARCH)
    heights = []
    for _ in range(900):
        run.step()
        place = run.vehicle.state.position
        heights.append(place[2] - float(HILLS.height_at(place)))
    assert np.mean(heights) == pytest.approx(30.0, abs=3.0)
    assert min(heights) > ENVELOPE.altitude_min_m
    assert max(heights) < 50.0
    run.step(orders=(Order(Verb.RETURN),))
    run.until(Phase.DONE, 500)
    assert hypot(*(run.vehicle.state.position[:2] - start)) < 3.0
    assert not run.vehicle.state.armed
