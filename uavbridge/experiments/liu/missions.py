"""Liu's search through the whole system in lockstep: autopilots, MAVLink, radio, safety filter.

The paper's numbers stay: its starts, its sensor (never wrong, P_d and P_f in the
map alone), its cycles of a second. What differs beside the flight: every agent
has a map of its own and merges what it hears, vehicles are kept apart, and the
figures are those of the union of all maps. The vehicles take off first; cycle 0
is when the last of them has begun to search, and their start cells are read by then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from planners.types import F64, I64
from sim_vehicles.world.payload import CellSensor, CellSensorSpec
from uavbridge.agent.phases import Phase
from uavbridge.bus.api import Bus
from uavbridge.clock import SECOND_US
from uavbridge.config import Mission
from uavbridge.config.tables import Area, Belief, Fleet, Recording, Safety, Target
from uavbridge.config.tables import Sensor as SensorTable
from uavbridge.experiments.liu.methods import Method, method
from uavbridge.experiments.liu.setting import GRID, Cell, LiuParams
from uavbridge.experiments.liu.world import Course
from uavbridge.recording.recorder import Recorder
from uavbridge.rng import stream
from uavbridge.runner.judge import Judge
from uavbridge.runner.stepped import fly_stepped

_SPEED_M_S = 15.0  # above what the vehicles can do: the method's own limit holds
_MARGIN_M = 5.0
_SEARCHING = Phase.SEARCH.value
_LONG_S = 80_000.0


class CycleJudge(Judge):
    """Lets a mission search for a number of cycles, whatever it has found, and ends it there.

    Args:
        mission: with the true targets.
        bus: its session.
        cycles: seconds of search.
    """

    def __init__(self, mission: Mission, bus: Bus, cycles: int) -> None:
        super().__init__(mission, bus)
        self.began_us: int | None = None  # when all searched
        self._cycles = cycles
        self._size = len(mission.scenario().team)

    @property
    def goal_reached(self) -> bool:
        """Never: the search goes on."""
        return False

    def step(self, t_us: int) -> None:
        super().step(t_us)
        if self.began_us is None and t_us % SECOND_US == 0:
            searching = sum(each.phase == _SEARCHING for each in self.reports.values())
            self.began_us = t_us if searching == self._size else None

    def ended(self, t_us: int) -> bool:
        over = self.began_us is not None and t_us > self.began_us + self._cycles * SECOND_US
        return over or super().ended(t_us)


def mission_of(
    name: str,
    params: LiuParams,
    searcher: Method,
    seed: int,
    targets: Sequence[Cell],
    belief: Belief | None = None,
) -> Mission:
    """The paper's setting as a mission; ``belief``: another start of the maps."""
    inside = GRID.clip(searcher.scenario.starts[:, :2], _MARGIN_M)  # on the edge is half outside
    starts = tuple((float(x), float(y)) for x, y in inside)
    centres = GRID.centre_of(np.array(targets).reshape(-1, 2))
    return Mission(
        name=f"liu-{name}",
        area=Area(cell_m=GRID.cell_m, columns=GRID.columns, rows=GRID.rows),
        seed=seed % 2**32,
        planner=name,
        clock="stepped",
        duration=_LONG_S,
        coverage_goal=1.0,
        fleet=Fleet(starts=starts, altitude_m=50.0),
        sensor=SensorTable(p=params.p_d, q=params.p_f),
        belief=belief or belief_of(params),
        targets=tuple(Target(position=(float(x), float(y))) for x, y in centres),
        safety=Safety(speed_m_s=_SPEED_M_S),
        recording=Recording(mcap=False, tlog=False),
    )


def belief_of(params: LiuParams, **start: Any) -> Belief:
    """The agents' maps; ``start``: other keys of the mission's [belief]."""
    given: dict[str, Any] = {
        "prior": params.prior,
        "update": params.update,
        "threshold": params.threshold,
    }
    return Belief(**{**given, **start})


def fly(
    name: str,
    params: LiuParams,
    seeds: I64,
    targets: Sequence[Cell],
    belief: Belief | None = None,
) -> Course:
    """Missions of one method, one after the other; arguments as of ``mission_of``."""
    flown = [_fly(name, params, int(seed), targets, belief) for seed in seeds]
    return Course(**{part: np.stack([one[part] for one in flown]) for part in flown[0]})


def _fly(
    name: str, params: LiuParams, seed: int, targets: Sequence[Cell], belief: Belief | None
) -> dict[str, Any]:
    searcher = method(name, params, flown=True)
    mission = mission_of(name, params, searcher, seed, targets, belief)
    bound = replace(searcher, scenario=mission.scenario())  # type: ignore[type-var]
    with Recorder(None, mission_name=mission.name, epoch_ns=0, mcap=False) as recorder:
        flown = fly_stepped(
            mission,
            bound.planner(),
            recorder=recorder,
            progress=lambda _t_us, _judge, _host: None,
            stop=lambda: False,
            sensor=_never_wrong(mission),
            judge_of=lambda one, bus, _recorder: CycleJudge(one, bus, params.cycles),
        )
    judge = flown.judge
    assert isinstance(judge, CycleJudge)
    return _course(judge, params.cycles, targets)


def _never_wrong(mission: Mission) -> CellSensor:
    """Readings as Algorithm 1 takes them."""
    truth = np.array([target.position for target in mission.targets]).reshape(-1, 2)
    agents = mission.scenario().team
    draws = [stream(mission.seed, "sensor", agent) for agent in agents]
    spec = CellSensorSpec(p=1.0, q=0.0, height_min_m=mission.safety.altitude_min_m / 2.0)
    return CellSensor(mission.grid, truth, spec, draws)


def _course(judge: CycleJudge, cycles: int, targets: Sequence[Cell]) -> dict[str, Any]:
    """The fields of ``Course`` for one run, without the leading axis."""
    began = judge.began_us
    if began is None:
        raise RuntimeError(f"mission {judge.mission.name}: not all vehicles came to search")
    samples = [one for one in judge.samples if one.t_us >= began][: cycles + 1]
    visited = np.array([round(one.coverage * GRID.size) for one in samples])
    found = [_cycle(judge, cell, began, cycles) for cell in targets]
    covered = np.flatnonzero(visited == GRID.size)
    return {
        "visited": visited,
        "uncertainty": np.array([one.uncertainty for one in samples]),
        "entropy": np.array([one.entropy for one in samples]),
        "found": np.array(found, dtype=np.int64),
        "covered": np.int64(covered[0] if len(covered) else -1),
        "stopped": np.int64(-1),
        "belief": judge.union.probability,
        "seen": judge.union.seen,
        "tracks": _tracks(judge, cycles),
    }


def _cycle(judge: CycleJudge, cell: Cell, began_us: int, cycles: int) -> int:
    """Cycle at which a cell was declared, -1: not."""
    declared = judge.declared.get(cell)
    if declared is None:
        return -1
    cycle = max(0, -(-(declared.t_us - began_us) // SECOND_US))
    return cycle if cycle <= cycles else -1


def _tracks(judge: CycleJudge, cycles: int) -> F64:
    """Positions (cycles + 1, agents, 2) m."""
    team = judge.mission.scenario().team
    tracks = [np.array(judge.tracks[agent])[-(cycles + 1) :, :2] for agent in team]
    return np.stack(tracks, axis=1)
