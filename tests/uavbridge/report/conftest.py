import numpy as np
import pytest

from planners.grid import Grid
from uavbridge.report.result import AgentResult, Event, MissionResult, Series, TargetResult


@pytest.fixture(scope="session")
def flown() -> MissionResult:
    """A made-up mission of three agents over ten minutes."""
    rng = np.random.default_rng(1)
    grid = Grid(0.0, 0.0, 100.0, 10, 10)
    t_s = np.arange(0.0, 600.0, 20.0)
    coverage = np.minimum(t_s / 500.0, 0.96)
    separation = 20.0 + 10.0 * np.sin(t_s / 30.0)
    separation[:2] = np.nan
    steps = rng.normal(0.0, 30.0, (3, 30, 3)).cumsum(axis=1) + 500.0
    belief = rng.beta(1.0, 30.0, grid.shape)
    belief[2, 7] = 0.99
    return MissionResult(
        mission="demo",
        seed=7,
        clock="stepped",
        duration_s=600.0,
        wall_s=12.5,
        reached_goal=True,
        grid=grid,
        series=Series(
            t_s,
            coverage,
            100.0 - 80.0 * coverage,
            50.0 - 30.0 * coverage,
            (t_s > 80).astype(np.int64),
            separation,
        ),
        tracks={agent + 1: steps[agent] for agent in range(3)},
        belief=belief,
        seen=rng.random(grid.shape) < 0.96,
        coverage=0.96,
        uncertainty=21.2,
        entropy=23.2,
        targets=(TargetResult((2, 7), 81.0, 3, (251.0, 733.0)), TargetResult((8, 8))),
        false_targets=((4, 4),),
        agents=tuple(
            AgentResult(i, "landed", 2500.0, 600, 900, 90_000, 160_000) for i in (1, 2, 3)
        ),
        min_separation_m=10.0,
        coverage_goal=0.9,
        separation_limit_m=5.0,
        events=(Event(81.0, "declares cell 2,7", 3), Event(500.0, "goal reached")),
        failures=("agent 2: link lost",),
        mission_text='name = "demo"\n',
        versions={"uavbridge": "0.1.0"},
        repeat="uavbridge launch mission.toml --seed 7",
        digest="ab" * 32,
        out="runs/demo",
    )
