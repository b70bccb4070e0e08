"""Checks that any planner must pass, ours like anyone's.

``check(kind)`` runs them all and returns what is wrong, an empty list for a
planner that conforms; ``CHECKS`` has them one by one. Each message says what
is wrong and why it matters. In a test suite::

    @pytest.mark.parametrize("name", conformance.CHECKS)
    def test_my_planner(name):
        assert conformance.CHECKS[name](conformance.Trial(MY_KIND)) == []
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planners import registry, trials
from planners.limits import goal_faults
from planners.memory import dumps, loads
from planners.planner import Planner, PlannerKind
from planners.types import Goal, Neighbours, Scenario, View

PAYLOAD_BYTES = 256  # a frame is one datagram, and the map cells need it more
# What a faulty planner may raise; anything else is not its fault.
_FAULTS = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    RuntimeError,
    TypeError,
    ValueError,
)


@dataclass(frozen=True, slots=True)
class Trial:
    """A planner under test, and the parameters it is bound with."""

    kind: PlannerKind
    values: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0

    def bind(self, case: Scenario) -> Planner:
        return registry.bind(self.kind, case, self.values)

    def rng(self, view: View) -> np.random.Generator:
        return np.random.default_rng([self.seed, view.agent, view.tick])


def check(kind: PlannerKind, values: Mapping[str, Any] | None = None, seed: int = 0) -> list[str]:
    """Everything that is wrong with a planner; empty when it conforms.

    Args:
        kind: the planner, as a registry holds it.
        values: parameters to bind it with; the defaults when not given.
        seed: of the made-up views.

    Returns:
        Messages, each beginning with the name of the check that failed.
    """
    trial = Trial(kind, values or {}, seed)
    return [f"{name}: {fault}" for name, one in CHECKS.items() for fault in one(trial)]


def documented(trial: Trial) -> list[str]:
    """Name, summary, and a unit and a line for every parameter."""
    kind = trial.kind
    faults = [f"the {word} is empty" for word in ("name", "summary") if not getattr(kind, word)]
    for part in registry.describe(kind):
        if not part.doc or not part.unit:
            faults.append(
                f"parameter {part.name} has no unit or no line of text: make it with param(...), "
                "mission files and `uavbridge planners` show both"
            )
        if part.kind not in (bool, int, float, str):
            faults.append(
                f"parameter {part.name} is a {part.kind.__name__}: mission files can only say "
                "numbers, texts and true or false"
            )
    return faults


def inputs_unchanged(trial: Trial) -> list[str]:
    """Neither the view nor the memory is written to."""
    case = trials.scenario()
    for _, view, memory, planner in _flight(trial, case):
        before = dumps(view), dumps(memory)
        _plan(trial, planner, view, memory)
        for name, old, new in zip(("view", "memory"), before, (view, memory), strict=True):
            if dumps(new) != old:
                return [
                    f"plan() changed its {name}: other agents, the recorder and a replay read the "
                    "same values; build new ones instead"
                ]
    return []


def repeatable(trial: Trial) -> list[str]:
    """The same view, memory and generator give the same goal and memory."""
    case = trials.scenario()
    again = trial.bind(case)
    for _, view, memory, planner in _flight(trial, case):
        first = _answer(trial, planner, view, memory)
        for second in (
            _answer(trial, planner, view, memory),
            _answer(trial, again, view, memory),
        ):
            if first != second:
                return [
                    "the same view, memory and generator gave two different answers: randomness "
                    "must come from the generator given and what is remembered from the memory, "
                    "or the same seed flies another mission and replay cannot verify it"
                ]
    return []


def inside_limits(trial: Trial) -> list[str]:
    """Setpoints lie in the area, the altitude band and the speed limits, and are finite."""
    case = trials.scenario()
    faults: list[str] = []
    for goal, view, _, _ in _flight(trial, case):
        faults += [f"at tick {view.tick}: {fault}" for fault in goal_faults(goal, view, case)]
    return faults[:3] or _hard(trial, case)


def neighbour_order(trial: Trial) -> list[str]:
    """Rows of neighbours in another order give the same goal."""
    case = trials.scenario()
    shuffle = np.random.default_rng(trial.seed)
    for _, view, memory, planner in _flight(trial, case):
        order = shuffle.permutation(len(view.neighbours))
        other = trials.with_neighbours(view, trials.reordered(view.neighbours, order))
        if _answer(trial, planner, view, memory) != _answer(trial, planner, other, memory):
            return [
                "the order in which neighbours are listed changed the goal: frames arrive in any "
                "order, and a mission would depend on the network's timing; sort by id first"
            ]
    return []


def no_neighbours(trial: Trial) -> list[str]:
    """It flies on when nobody is heard."""
    return _with_others(trial, "nobody heard", lambda heard: Neighbours.none())


def stale_neighbours(trial: Trial) -> list[str]:
    """It flies on when what it heard is an hour old, or a neighbour sits on its own place."""

    def old(heard: Neighbours) -> Neighbours:
        age = np.full(len(heard), 3600.0)
        return Neighbours(heard.ids, heard.position, heard.velocity, age, heard.payloads)

    def garbled(heard: Neighbours) -> Neighbours:
        payloads = tuple(b"\xff\x00?" for _ in heard.ids)
        return Neighbours(heard.ids, heard.position, heard.velocity, heard.age_s, payloads)

    return (
        _with_others(trial, "neighbours an hour old", old)
        + _with_others(trial, "neighbours with a payload of nonsense", garbled)
        + _on_top(trial)
    )


def memory_survives(trial: Trial) -> list[str]:
    """Memory through bytes is the same memory."""
    case = trials.scenario()
    for _, view, memory, planner in _flight(trial, case):
        try:
            data = dumps(memory)
            back = loads(type(memory), data)
        except (TypeError, ValueError) as error:
            return [
                f"memory does not survive a round trip through bytes ({error}): a restarted agent "
                "could not go on; use a frozen dataclass of plain values, tuples and arrays"
            ]
        same_bytes = dumps(back) == data
        if not same_bytes or _answer(trial, planner, view, back) != _answer(
            trial, planner, view, memory
        ):
            return [
                "memory restored from bytes leads to another goal: a restarted agent, or a replay "
                "from the middle of a recording, would fly differently"
            ]
    return []


def small_payload(trial: Trial) -> list[str]:
    """What rides on the beacon is bytes, and few."""
    for goal, view, _, _ in _flight(trial, trials.scenario()):
        payload: object = goal.payload
        if not isinstance(payload, bytes):
            return [f"the payload is a {type(payload).__name__}: the radio carries bytes"]
        if len(payload) > PAYLOAD_BYTES:
            return [
                f"the payload has {len(payload)} bytes at tick {view.tick}, over "
                f"{PAYLOAD_BYTES}: a frame is one datagram and the map's cells have to fit too"
            ]
    return []


def any_team(trial: Trial) -> list[str]:
    """Any number of agents, one included, and any of them."""
    faults = []
    for size in trials.TEAMS:
        case = trials.scenario(agents=size)
        for agent in sorted({case.team[0], case.team[-1]}):
            found = _tried(trial, case, agent)
            faults += [f"agent {agent} in a team of {size}: {fault}" for fault in found]
    return faults[:3]


def any_grid(trial: Trial) -> list[str]:
    """Any grid, a single cell included, at other ticks and origins."""
    faults = []
    for grid in trials.GRIDS:
        for tick_s in (0.2, 2.0):
            case = trials.scenario(grid, 3, tick_s)
            found = _tried(trial, case, 2)
            where = f"grid of {grid.columns} x {grid.rows} cells of {grid.cell_m:g} m"
            faults += [f"{where}, tick {tick_s:g} s: {fault}" for fault in found]
    return faults[:3]


Check = Callable[[Trial], list[str]]


def _guarded(one: Check) -> Check:
    """The check, with what the planner raises turned into a message."""

    def guarded(trial: Trial) -> list[str]:
        try:
            return one(trial)
        except _FAULTS as error:
            return [
                f"raised {type(error).__name__}: {error}; an agent whose planner raises must hold "
                "its place and is lost to the search"
            ]

    return guarded


CHECKS: Mapping[str, Check] = {
    one.__name__: _guarded(one)
    for one in (
        documented,
        inputs_unchanged,
        repeatable,
        inside_limits,
        neighbour_order,
        no_neighbours,
        stale_neighbours,
        memory_survives,
        small_payload,
        any_team,
        any_grid,
    )
}


def _plan(trial: Trial, planner: Planner, view: View, memory: Any) -> tuple[Goal, Any]:
    return planner.plan(view, memory, trial.rng(view))


def _answer(trial: Trial, planner: Planner, view: View, memory: Any) -> bytes:
    goal, after = _plan(trial, planner, view, memory)
    return dumps((goal.setpoint, goal.payload, goal.edits, goal.asks, goal.note, after))


def _flight(
    trial: Trial, case: Scenario, agent: int = 3, ticks: int = 40
) -> Iterator[tuple[Goal, View, Any, Planner]]:
    """Goals, the views and memories they were decided on, and the planner, tick by tick."""
    planner, answers = trial.bind(case), trials.Answers()
    memory: Any = None
    for view in trials.Flight(case, agent, trial.seed, ticks).views(answers):
        if view.tick == 0:
            memory = planner.init(view)
        goal, after = _plan(trial, planner, view, memory)
        answers.setpoint = goal.setpoint
        yield goal, view, memory, planner
        memory = after


def _hard(trial: Trial, case: Scenario, agent: int = 3) -> list[str]:
    """Faults on views at the edge of what may happen."""
    planner = trial.bind(case)
    faults = []
    for words, view in trials.hard_views(case, agent, trial.seed):
        goal, _ = _plan(trial, planner, view, planner.init(view))
        faults += [f"{words}: {fault}" for fault in goal_faults(goal, view, case)]
    return faults[:3]


def _tried(trial: Trial, case: Scenario, agent: int) -> list[str]:
    faults = []
    for goal, view, _, _ in _flight(trial, case, agent, 15):
        faults += goal_faults(goal, view, case)
    return faults[:1] or _hard(trial, case, agent)[:1]


def _with_others(trial: Trial, words: str, change: Callable[[Neighbours], Neighbours]) -> list[str]:
    case = trials.scenario()
    for _, view, memory, planner in _flight(trial, case):
        other = trials.with_neighbours(view, change(view.neighbours))
        goal, _ = _plan(trial, planner, other, memory)
        faults = goal_faults(goal, other, case)
        if faults:
            return [f"{words}: {faults[0]}"]
    return []


def _on_top(trial: Trial) -> list[str]:
    case = trials.scenario()
    for _, view, memory, planner in _flight(trial, case, ticks=3):
        heard = view.neighbours
        place = np.repeat(view.position[None], len(heard), axis=0)
        same = Neighbours(heard.ids, place, heard.velocity * 0.0, heard.age_s, heard.payloads)
        goal, _ = _plan(trial, planner, trials.with_neighbours(view, same), memory)
        faults = goal_faults(goal, view, case)
        if faults:
            return [f"neighbours on its own place: {faults[0]}"]
    return []
