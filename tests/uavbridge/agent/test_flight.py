"""One agent through a whole mission, on a point vehicle: phases, refusals, orders."""

from dataclasses import replace
from itertools import pairwise
from math import inf

import numpy as np
import pytest

from planners.belief.merge import BeliefUpdate, SensorModel
from planners.grid import Grid
from planners.types import FlyVelocity, Goal, GoTo, Reading, Scenario
from tests.uavbridge.agent.point_vehicle import PointVehicle
from uavbridge.agent.agent import Agent
from uavbridge.agent.effects import Answer, Do, Inputs, Publish, Tell
from uavbridge.agent.obstacles import Sighted
from uavbridge.agent.orders import Order, Verb
from uavbridge.agent.phases import ENDED, NEXT, RETURNING, Phase, check
from uavbridge.agent.plan import AgentPlan, return_heights
from uavbridge.bus.messages import Obstacle
from uavbridge.bus.wire import Beacon
from uavbridge.safety.envelope import Envelope
from uavbridge.vehicle.api import Follow, LandHere, Mode, TakeOff

GRID = Grid(0, 0, 100, 10, 10)
ENVELOPE = Envelope(-50, -50, 1050, 1050, 15, 100)
STEP_US = 100_000


class FlyTo:
    """A planner that wants one thing."""

    def __init__(self, setpoint):
        self.setpoint = setpoint
        self.views = []

    def init(self, view):
        return 0

    def plan(self, view, memory, rng):
        self.views.append(view)
        return Goal(self.setpoint, note=f"decision {memory}"), memory + 1


def plan_of(planner, **changes):
    scenario = Scenario(GRID, (1,), np.array([[100.0, 100.0, 40.0]]), tick_s=1.0)
    plan = AgentPlan(
        agent=1,
        seed=1,
        scenario=scenario,
        planner=planner,
        rule=BeliefUpdate(),
        sensor=SensorModel(),
        prior=np.full(GRID.shape, 0.5),
        envelope=ENVELOPE,
        start=(100.0, 100.0, 40.0),
        return_height_m=30.0,
        duration_s=300.0,
    )
    return replace(plan, **changes)


class Run:
    """Steps an agent and its vehicle together."""

    def __init__(self, plan, vehicle=None):
        self.agent = Agent(plan)
        self.vehicle = vehicle or PointVehicle((100, 100, 0))
        self.t_us = 0
        self.phases = [Phase.CONNECT]
        self.told = []
        self.frames = []
        self.acks = []

    def step(self, **more):
        events = self.vehicle.advance(self.t_us)
        inputs = Inputs(t_us=self.t_us, state=self.vehicle.state, events=events, **more)
        for effect in self.agent.step(inputs):
            if isinstance(effect, Do):
                self.vehicle.do(effect.command, self.t_us)
            elif isinstance(effect, Tell):
                self.told.append(effect)
            elif isinstance(effect, Publish):
                self.frames.append(effect.frame)
            elif isinstance(effect, Answer):
                self.acks.append(effect.ack)
        if self.agent.phase is not self.phases[-1]:
            self.phases.append(self.agent.phase)
        self.t_us += STEP_US

    def until(self, phase, limit_s=200, **more):
        end = self.t_us + limit_s * 1_000_000
        while self.agent.phase is not phase:
            assert self.t_us < end, (self.agent.phase, self.vehicle.state)
            self.step(**more)
        return self


@pytest.mark.parametrize(("battery", "why"), [(0.0, ", its battery is empty"), (0.6, "")])
def test_a_vehicle_that_disarms_in_the_search_has_failed(battery, why):
    run = Run(plan_of(FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))))
    run.until(Phase.SEARCH)
    run.vehicle.stop_motors(battery)
    run.until(Phase.FAILED, 2)
    assert run.told[-1].failure
    assert run.agent.flight.failure == f"vehicle disarmed in phase search{why}"


def test_a_vehicle_that_somebody_has_falls_with_an_empty_battery():
    run = Run(plan_of(FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))))
    run.until(Phase.SEARCH)
    run.vehicle.set_mode(Mode.HOLD)
    run.until(Phase.YIELDED, 2)
    run.vehicle.stop_motors(0.0)
    run.until(Phase.FAILED, 2)
    assert run.agent.flight.failure == "vehicle disarmed in phase yielded, its battery is empty"


def test_a_mission_from_the_ground_to_the_ground():
    planner = FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))
    run = Run(plan_of(planner))
    run.until(Phase.SEARCH)
    for _ in range(1000):
        run.step()
    assert np.linalg.norm(run.vehicle.state.position - (500, 500, 40)) < 2.0
    run.step(orders=(Order(Verb.RETURN),))
    run.until(Phase.DONE, 400)
    assert run.phases == [
        Phase.CONNECT,
        Phase.ARM,
        Phase.TAKEOFF,
        Phase.CLIMB,
        Phase.SEARCH,
        Phase.RISE,
        Phase.HOME,
        Phase.DESCEND,
        Phase.LAND,
        Phase.DONE,
    ]
    home = run.vehicle.state.position
    assert np.hypot(home[0] - 100, home[1] - 100) < 2.5
    assert not run.vehicle.state.armed
    assert run.agent.flight.failure == ""


def test_it_returns_by_itself_at_the_time_limit():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([3.0, 0.0, 0.0]))), duration_s=60.0))
    run.until(Phase.RISE)
    assert 60.0 <= run.t_us / 1e6 < 60.5
    run.until(Phase.DONE)


def test_a_column_that_its_detector_sees_is_kept_off_and_shown_to_the_planner():
    planner = FlyTo(GoTo(np.array([500.0, 100.0, 40.0])))
    run = Run(plan_of(planner)).until(Phase.SEARCH)
    while run.vehicle.state.position[0] < 180.0:
        run.step()
    assert not len(planner.views[-1].obstacles)
    run.step(obstacles=(Obstacle(3, 300.0, 100.0, 20.0, 5.0),))
    least = np.inf
    for _ in range(1500):
        run.step()
        apart = run.vehicle.state.position[:2] - (300.0, 100.0)
        least = min(least, np.hypot(*apart))
    assert planner.views[-1].obstacles.tolist() == [[300.0, 100.0, 20.0]]
    assert 24.0 < least < 40.0
    run.step(orders=(Order(Verb.RETURN),))
    run.until(Phase.DONE, 400)
    assert run.agent.flight.failure == ""


def test_what_is_told_again_of_a_column_takes_the_place_of_what_was_told():
    sighted = Sighted()
    assert sighted.learn([Obstacle(2, 1.0, 1.0, 5.0, 1.0), Obstacle(1, 0.0, 0.0, 3.0, 1.0)])
    assert not sighted.learn([Obstacle(1, 0.0, 0.0, 3.0, 1.0)])
    assert sighted.learn([Obstacle(2, 1.5, 1.0, 4.0, 1.0)])
    assert sighted.columns.tolist() == [[0.0, 0.0, 3.0], [1.5, 1.0, 4.0]]
    assert sighted.kept_off() == ((0.0, 0.0, 4.0), (1.5, 1.0, 5.0))


def test_a_velocity_keeps_the_search_height_and_the_fence():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([9.0, 0.0, 0.0])))))
    run.until(Phase.SEARCH)
    for _ in range(1500):
        run.step()
        assert run.vehicle.state.position[0] < ENVELOPE.east_m + 1.0
        assert abs(run.vehicle.state.position[2] - 40.0) < 3.0
    assert run.vehicle.state.position[0] > 1000


def test_decisions_come_at_the_planners_tick_with_the_readings_since():
    planner = FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))
    run = Run(plan_of(planner)).until(Phase.SEARCH)
    run.step(readings=(Reading(run.t_us, (1, 1), True),))
    first = len(planner.views)
    for _ in range(50):
        run.step()
    assert len(planner.views) - first in (4, 5)
    assert [view.tick for view in planner.views] == list(range(len(planner.views)))
    assert sum(len(view.readings) for view in planner.views) == 1
    view = planner.views[-1]
    assert view.belief[1, 1] == pytest.approx(0.9 / 0.95)
    assert view.seen[1, 1]
    assert view.seen.sum() == 1


@pytest.mark.parametrize(("keyframe_s", "times"), [(inf, {1}), (10.0, {3, 4})])
def test_changed_cells_travel_once_and_all_in_keyframes(keyframe_s, times):
    plan = replace(plan_of(FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))), keyframe_s=keyframe_s)
    run = Run(plan).until(Phase.SEARCH)
    run.frames.clear()
    run.step(readings=(Reading(run.t_us, (1, 1), False), Reading(run.t_us, (2, 2), False)))
    for _ in range(210):
        run.step()
    sizes = [len(frame.cells) // BeliefUpdate().record.itemsize for frame in run.frames]
    assert sorted(set(sizes)) == [0, 2]
    assert sizes.count(2) in times


def test_a_refusal_to_arm_ends_in_failure_that_says_why():
    vehicle = PointVehicle((100, 100, 0), refusal="Compass not calibrated")
    run = Run(plan_of(FlyTo(GoTo(np.zeros(3)))), vehicle).until(Phase.FAILED, 100)
    assert run.agent.flight.failure == "refused to arm: Compass not calibrated"
    assert sum("Compass" in tell.text for tell in run.told) == 2  # refused; failed
    assert not vehicle.state.in_air


@pytest.mark.parametrize(
    ("refuses", "phases"), [(TakeOff, [Phase.FAILED]), (Follow, [Phase.LAND, Phase.DONE])]
)
def test_a_vehicle_that_does_not_take_off_is_brought_down(refuses, phases):
    vehicle = PointVehicle((100, 100, 0), refusal="Not now", refuses=refuses)
    run = Run(plan_of(FlyTo(GoTo(np.zeros(3)))), vehicle).until(phases[-1], 150)
    assert run.phases == [Phase.CONNECT, Phase.ARM, Phase.TAKEOFF, *phases]
    assert "take-off failed" in run.agent.flight.failure
    assert "Not now" in run.agent.flight.failure
    assert sum("refused: Not now" in tell.text and not tell.failure for tell in run.told) == 1
    assert not vehicle.state.in_air


def test_a_vehicle_that_never_answers_ends_in_failure():
    run = Run(plan_of(FlyTo(GoTo(np.zeros(3)))), PointVehicle((0, 0, 0), silent=True))
    run.until(Phase.FAILED, 100)
    assert "never answered" in run.agent.flight.failure


@pytest.mark.parametrize(
    "phase", [Phase.TAKEOFF, Phase.CLIMB, Phase.SEARCH, Phase.HOME, Phase.LAND]
)
def test_a_vehicle_that_falls_silent_in_any_phase_is_given_up(phase):
    run = Run(plan_of(FlyTo(GoTo(np.array([300.0, 100.0, 40.0])))))
    if phase in RETURNING:
        run.until(Phase.SEARCH).step(orders=(Order(Verb.RETURN),))
    run.until(phase)
    run.vehicle.silent = True
    run.until(Phase.FAILED, 10)
    assert "silent" in run.agent.flight.failure


def test_a_pilot_who_takes_the_sticks_has_the_vehicle():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([3.0, 0.0, 0.0]))))).until(Phase.SEARCH)
    run.vehicle.set_mode(Mode.MANUAL)
    run.until(Phase.YIELDED)
    before = len(run.vehicle.commands)
    for _ in range(100):
        run.step()
    assert len(run.vehicle.commands) == before
    assert run.agent.flight.failure


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.RETURN])
def test_a_pilot_who_takes_it_while_it_takes_off_has_it(mode):
    run = Run(plan_of(FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))))
    run.until(Phase.TAKEOFF)
    while run.vehicle.state.position[2] < 3.0:
        run.step()
    run.vehicle.set_mode(mode)
    run.until(Phase.YIELDED, 2)
    commands = len(run.vehicle.commands)
    for _ in range(200):
        run.step()
    assert len(run.vehicle.commands) == commands
    assert run.told[-1].text == f"vehicle went to {mode.value}: yielded"


@pytest.mark.parametrize("mode", [Mode.MANUAL, Mode.HOLD, Mode.OFFBOARD])
def test_a_pilot_who_takes_it_while_it_lands_has_it(mode):
    run = Run(plan_of(FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))))
    run.until(Phase.SEARCH)
    run.step(orders=(Order(Verb.LAND),))
    run.until(Phase.LAND)
    for _ in range(20):
        run.step()
    assert run.vehicle.state.in_air
    run.vehicle.set_mode(mode)
    run.until(Phase.YIELDED, 2)
    commands = len(run.vehicle.commands)
    for _ in range(200):
        run.step()
    assert len(run.vehicle.commands) == commands


def test_a_vehicle_lost_by_our_own_delay_is_taken_back():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([3.0, 0.0, 0.0]))))).until(Phase.SEARCH)
    run.step(late_s=1.2)
    run.vehicle.set_mode(Mode.RETURN)
    for _ in range(60):
        run.step()
    assert run.agent.phase is Phase.SEARCH
    assert run.vehicle.state.mode is Mode.OFFBOARD
    assert run.agent.flight.failure == ""


def test_an_aircraft_that_can_not_land_is_left_circling_over_home():
    why = "its mission has no landing (DO_LAND_START)"
    vehicle = PointVehicle((100, 100, 0), refusal=why, refuses=LandHere, kind="plane")
    run = Run(plan_of(FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))), vehicle)
    run.until(Phase.TAKEOFF)
    while vehicle.state.position[2] < 10.0:
        run.step()
    run.step(orders=(Order(Verb.LAND),))
    run.until(Phase.DONE, 20)
    assert [tell.text for tell in run.told[-2:]] == [
        f"no landing: {why}",
        "circles over home by its autopilot, which is to land it",
    ]
    assert vehicle.state.mode is Mode.RETURN


class Faulty(FlyTo):
    """Decides three times, then fails in its own way."""

    def __init__(self, fault):
        super().__init__(GoTo(np.array([200.0, 200.0, 40.0])))
        self.fault = fault

    def plan(self, view, memory, rng):
        if memory == 3:
            return self.fault()
        return super().plan(view, memory, rng)


def _raise():
    raise KeyError("cells")


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (_raise, "planner raised KeyError: 'cells'"),
        (lambda: (Goal(GoTo(np.array([np.nan, 0.0, 0.0]))), 4), "three finite numbers"),
        (lambda: (Goal(GoTo(np.array([1.0, 0.0]))), 4), "three finite numbers"),
        (lambda: (Goal("north"), 4), "TypeError"),
        (lambda: None, "TypeError"),
    ],
)
def test_whatever_a_planner_does_its_vehicle_comes_home(fault, words):
    run = Run(plan_of(Faulty(fault))).until(Phase.SEARCH).until(Phase.DONE, 400)
    assert words in run.agent.flight.failure
    assert any(tell.failure and words in tell.text for tell in run.told)
    assert np.hypot(*(run.vehicle.state.position[:2] - 100)) < 2.5


def test_pause_and_resume_and_land():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([3.0, 0.0, 0.0]))))).until(Phase.SEARCH)
    run.step(orders=(Order(Verb.PAUSE),))
    assert run.agent.phase is Phase.PAUSE
    for _ in range(80):
        run.step()
    here = run.vehicle.state.position.copy()
    for _ in range(50):
        run.step()
    assert np.linalg.norm(run.vehicle.state.position - here) < 0.5
    run.step(orders=(Order(Verb.RESUME),))
    assert run.agent.phase is Phase.SEARCH
    run.step(orders=(Order(Verb.LAND),))
    run.until(Phase.DONE)
    assert any(isinstance(command, LandHere) for command in run.vehicle.commands)


def answered(run, verb, seconds=10, **more):
    """Give an order and wait for its answer."""
    run.acks.clear()
    run.step(orders=(Order(verb, "me", **more),))
    for _ in range(seconds * 10):
        if run.acks:
            break
        run.step()
    (ack,) = run.acks
    assert (ack.id, ack.agent, ack.verb) == ("me", 1, verb.value)
    return ack


def test_orders_are_answered_with_what_became_of_them():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([3.0, 0.0, 0.0]))))).until(Phase.SEARCH)
    ack = answered(run, Verb.RESUME)
    assert (ack.ok, ack.reason) == (False, "not in phase search")
    assert answered(run, Verb.GOTO, position=(300.0, 200.0, float("nan"))).ok
    for _ in range(500):
        run.step()
    assert np.linalg.norm(run.vehicle.state.position - (300, 200, 40)) < 2.0
    assert answered(run, Verb.RESUME).ok
    assert answered(run, Verb.HOLD).ok
    assert run.vehicle.state.mode is Mode.HOLD
    for _ in range(50):
        run.step()
    assert run.agent.phase is Phase.YIELDED
    assert run.agent.flight.failure == ""
    assert not answered(run, Verb.RETURN).ok
    assert answered(run, Verb.TAKEOVER).ok
    assert run.agent.phase is Phase.SEARCH
    assert run.vehicle.state.mode is Mode.OFFBOARD
    assert answered(run, Verb.ABORT).ok
    run.until(Phase.DONE)


def test_an_order_without_an_id_wants_no_answer():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([3.0, 0.0, 0.0]))))).until(Phase.SEARCH)
    run.step(orders=(Order(Verb.PAUSE),))
    assert run.agent.phase is Phase.PAUSE
    assert run.acks == []


def test_nobody_descends_on_somebody_below():
    run = Run(plan_of(FlyTo(FlyVelocity(np.array([3.0, 0.0, 0.0]))))).until(Phase.SEARCH)
    run.step(orders=(Order(Verb.RETURN),))
    run.until(Phase.HOME)
    for _ in range(400):
        below = Beacon(2, run.t_us, (101.0, 100.0, 12.0), (0.0, 0.0, 0.0))
        run.step(beacons=(below,))
    assert run.agent.phase is Phase.HOME
    run.until(Phase.DONE)


def test_return_heights_differ_and_fit_the_band():
    heights = return_heights(10, ENVELOPE, 12.0)
    assert min(heights) >= ENVELOPE.altitude_min_m
    assert max(heights) <= ENVELOPE.altitude_max_m
    assert len(set(heights)) == 8
    assert all(abs(a - b) >= 12.0 for a, b in pairwise(heights))
    assert return_heights(3, replace(ENVELOPE, altitude_max_m=16.0), 12.0) == [15.0] * 3


def test_the_phase_table_is_closed_and_ends():
    assert set(NEXT) == set(Phase)
    with pytest.raises(RuntimeError, match="no way"):
        check(Phase.DONE, Phase.SEARCH)
    reached, front = set(), {Phase.CONNECT}
    while front:
        reached |= front
        front = {after for phase in front for after in NEXT[phase]} - reached
    assert reached == set(Phase)
    assert all(Phase.FAILED in NEXT[phase] for phase in set(Phase).difference(ENDED))


def test_the_odometer_counts_flight():
    run = Run(plan_of(FlyTo(GoTo(np.array([300.0, 100.0, 40.0]))))).until(Phase.SEARCH)
    for _ in range(600):
        run.step()
    assert 235 < run.agent.flight.distance_m < 260
    assert run.agent.flight.distance_m < inf
