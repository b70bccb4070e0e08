"""When what an agent hears and sees gets into its map."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.types import GoTo, Reading
from tests.uavbridge.agent.point_vehicle import PointVehicle
from tests.uavbridge.agent.test_flight import STEP_US, FlyTo, Run, plan_of
from uavbridge.agent.agent import Agent
from uavbridge.agent.effects import Inputs
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.phases import Phase
from uavbridge.bus.wire import DELTA, Frame

HERE = (0.0, 0.0, 0.0)
CELLS = st.tuples(st.integers(0, 2), st.integers(0, 2))
LOOKS = st.lists(st.tuples(CELLS, st.booleans()), max_size=2)


def frame(sender, looks, t_us):
    """What another agent tells of its looks."""
    teller = Mapping(replace(plan_of(None), agent=sender))
    for cell, detected in looks:
        teller.observe(Reading(t_us, cell, detected))
    rule, told = teller._plan.rule.code, teller.tell(0).cells
    return Frame(DELTA, sender, t_us // STEP_US, t_us, HERE, HERE, b"", rule, told)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(LOOKS, LOOKS), min_size=25, max_size=45), st.integers(0, 9))
def test_a_planner_is_shown_all_that_came_in_the_order_of_its_coming(ticks, number):
    planner = FlyTo(GoTo(np.array([500.0, 500.0, 40.0])))
    plan = replace(plan_of(planner), agent=number)
    run, wanted = Run(plan).until(Phase.SEARCH), Mapping(plan)
    for heard, seen in ticks:
        frames = (frame(10, heard, run.t_us),) if heard else ()
        readings = tuple(Reading(run.t_us, *look) for look in seen)
        if frames:
            wanted.merge(frames)
        for reading in readings:
            wanted.observe(reading)
        decided = len(planner.views)
        run.step(frames=frames, readings=readings)
        for view in planner.views[decided:]:
            assert np.array_equal(view.belief, wanted.belief.probability)
    assert planner.views


def test_a_team_that_hears_at_one_time_merges_one_after_the_other():
    team = [Agent(replace(plan_of(FlyTo(None)), agent=number)) for number in range(16)]
    vehicle = PointVehicle((100, 100, 0))
    merged = []
    for tick in range(1, 11):
        t_us = tick * STEP_US
        frames = (frame(99, [((4, 4), True)], STEP_US),) if tick == 1 else ()
        for agent in team:
            agent.step(Inputs(t_us=t_us, state=vehicle.state, frames=frames))
        merged.append(sum(bool(agent.mapping.belief.seen[4, 4]) for agent in team))
    assert max(np.diff([0, *merged])) == 2
    assert merged[-1] == 16
