"""An agent's map under every merge rule."""

import numpy as np
import pytest

from planners.belief.merge import MERGE_RULES, SensorModel
from planners.grid import Grid
from planners.types import Reading, Scenario
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.wire import DELTA, Frame
from uavbridge.safety.envelope import Envelope

GRID = Grid(0, 0, 100, 4, 4)
SECOND = 1_000_000


def mapping(agent, merge):
    scenario = Scenario(GRID, (1, 2, 3), np.zeros((3, 3)), tick_s=1.0)
    return Mapping(
        AgentPlan(
            agent=agent,
            seed=1,
            scenario=scenario,
            planner=None,
            rule=MERGE_RULES[merge],
            sensor=SensorModel(0.9, 0.2),
            prior=np.full(GRID.shape, 0.5),
            envelope=Envelope(0, 0, 400, 400, 15, 100),
            start=(0.0, 0.0, 40.0),
            return_height_m=20.0,
            duration_s=100.0,
        )
    )


def frame(sender, cells, t_us, merge):
    zero = (0.0, 0.0, 0.0)
    return Frame(DELTA, sender, 1, t_us, zero, zero, b"", MERGE_RULES[merge].code, cells)


@pytest.mark.parametrize("merge", MERGE_RULES)
def test_agents_share_what_they_saw(merge):
    mine, theirs = mapping(1, merge), mapping(2, merge)
    theirs.observe(Reading(SECOND, (2, 3), True))
    told = theirs.tell(0).cells
    mine.merge([frame(2, told, SECOND, merge)])
    alone = merge == "uncoordinated"
    assert mine.belief.seen[2, 3] != alone
    assert (mine.belief.probability[2, 3] > 0.5) != alone
    assert bool(mine.tell(0).cells) != alone  # what was learnt is told on
    assert mine.unreadable == 0


@pytest.mark.parametrize(("merge", "looks"), [("sensed-data", 3), ("counts", 3), ("ogmm", 3)])
def test_a_cell_is_declared_from_what_several_saw(merge, looks):
    mine = mapping(1, merge)
    others = [mapping(agent, merge) for agent in range(2, 2 + looks)]
    for second, other in enumerate(others):
        other.observe(Reading(second * SECOND, (1, 1), True))
    frames = [frame(o._plan.agent, o.tell(0, whole=True).cells, 9 * SECOND, merge) for o in others]
    mine.merge(frames)
    assert mine.declared == {5: 9 * SECOND}


def test_frames_heard_together_are_averaged_together():
    mine = mapping(1, "average")
    others = [mapping(2, "average"), mapping(3, "average")]
    mine.observe(Reading(0, (0, 0), False))
    own = mine.belief.probability[0, 0]
    for second, other in enumerate(others, 1):
        other.observe(Reading(second * SECOND, (0, 0), second == 1))
    values = [other.belief.probability[0, 0] for other in others]
    mine.merge(
        [frame(o._plan.agent, o.tell(0, whole=True).cells, 9 * SECOND, "average") for o in others]
    )
    assert mine.belief.probability[0, 0] == pytest.approx((own + sum(values)) / 3, abs=1e-6)


def test_frames_of_another_rule_and_broken_cells_are_counted():
    mine = mapping(1, "counts")
    mine.merge([frame(2, b"", 0, "average"), frame(3, b"123", 0, "counts")])
    assert mine.unreadable == 2
