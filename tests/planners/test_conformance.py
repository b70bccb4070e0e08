"""Every planner conforms, and every check can fail."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from planners.conformance import CHECKS, Trial, check
from planners.planner import PlannerKind, param
from planners.registry import BUILTIN
from planners.types import FlySegment, FlyVelocity, Goal, GoTo


@pytest.mark.parametrize("name", CHECKS)
@pytest.mark.parametrize("planner", BUILTIN)
def test_builtin_planner(planner, name):
    assert CHECKS[name](Trial(BUILTIN[planner])) == []


@pytest.mark.parametrize(
    ("planner", "values"),
    [
        ("esustpm", {"keep": "entered", "escape_ratio": 0.0, "speed_reading": "none"}),
        ("esustpm", {"speed_reading": "component", "boundary": "component", "neighbours": 0}),
        ("esustpm", {"guide_gain": 0.0, "heading_noise_rad": 0.0, "margin_m": 0.0}),
        ("boids-guided", {"keep": "best", "escape_ratio": 0.5, "boundary": "component"}),
        ("mower", {"along": "east", "inset_cells": 0.0}),
        ("sweep", {"pattern": "snake-and-back", "entry": "nearest"}),
        ("sweep", {"pattern": "snake-and-jump"}),
        ("sweep", {"pattern": "columns-and-rows"}),
        ("random", {"hold_s": 5.0}),
    ],
)
def test_other_readings_conform_too(planner, values):
    assert check(BUILTIN[planner], values) == []


@dataclass(frozen=True)
class NoParams:
    pass


def kind_of(planner, params=NoParams):
    return PlannerKind("bad", "a planner with one fault", params, lambda case, _: planner(case))


class Good:
    """Flies to the middle."""

    def __init__(self, case):
        self.case = case
        west, south, east, north = case.grid.bounds
        self.middle = np.array(((west + east) / 2, (south + north) / 2, 50.0))

    def init(self, view):
        return None

    def plan(self, view, memory, rng):
        return Goal(GoTo(self.middle)), memory


def test_the_model_of_the_bad_planners_is_good():
    assert check(kind_of(Good)) == []


class WritesView(Good):
    def plan(self, view, memory, rng):
        view.belief.setflags(write=True)
        view.belief[0, 0] += 0.1
        return super().plan(view, memory, rng)


class WritesReadOnlyView(Good):
    def plan(self, view, memory, rng):
        view.position[0] = 0.0
        return super().plan(view, memory, rng)


class WritesMemory(Good):
    def init(self, view):
        return np.zeros(3)

    def plan(self, view, memory, rng):
        memory += 1.0
        return super().plan(view, memory.copy(), rng)


class OwnRandomness(Good):
    def __init__(self, case):
        super().__init__(case)
        self.rng = np.random.default_rng()

    def plan(self, view, memory, rng):
        return Goal(FlyVelocity(np.array((0.0, 0.0, 1e-3 * self.rng.random())))), memory


class HiddenHistory(Good):
    calls = 0

    def plan(self, view, memory, rng):
        self.calls += 1
        return Goal(GoTo(self.middle), note=str(self.calls)), memory


class TooFast(Good):
    def plan(self, view, memory, rng):
        away = np.sign(self.middle - view.position) * (30.0, 0.0, 0.0)
        return Goal(FlyVelocity(away)), memory


class TooSteep(Good):
    def plan(self, view, memory, rng):
        return Goal(FlyVelocity(np.array((0.0, 0.0, -9.0)))), memory


class LeavesArea(Good):
    def plan(self, view, memory, rng):
        return Goal(GoTo(self.middle + np.array((5000.0, 0.0, 0.0)))), memory


class FliesOverTheEdge(Good):
    def plan(self, view, memory, rng):
        return Goal(FlyVelocity(np.array((-9.0, 0.0, 0.0)))), memory


class TooHigh(Good):
    def plan(self, view, memory, rng):
        high = self.middle + np.array((0.0, 0.0, 500.0))
        return Goal(FlySegment(self.middle, high)), memory


class Impatient(Good):
    def plan(self, view, memory, rng):
        return Goal(GoTo(self.middle, speed_m_s=99.0)), memory


class NotANumber(Good):
    def plan(self, view, memory, rng):
        return Goal(GoTo(self.middle * np.nan)), memory


class NoHeading(Good):
    def plan(self, view, memory, rng):
        return Goal(GoTo(self.middle, yaw_rad=np.nan)), memory


class OtherSetpoint(Good):
    def plan(self, view, memory, rng):
        return Goal("north"), memory


class FollowsFirstRow(Good):
    def plan(self, view, memory, rng):
        first = tuple(view.neighbours.ids[:1].tolist())
        return Goal(GoTo(self.middle), note=str(first)), memory


class NeedsCompany(Good):
    def plan(self, view, memory, rng):
        view.neighbours.ids.min()
        return super().plan(view, memory, rng)


class TrustsOldNews(Good):
    def plan(self, view, memory, rng):
        heard = view.neighbours
        mean = (heard.velocity * heard.age_s[:, None]).sum(axis=0) / 3600.0
        speed = 10.0 if len(heard) and heard.age_s.max() > 60.0 else 1.0
        return Goal(FlyVelocity(mean * speed * 100.0 * (speed > 1.0))), memory


class ReadsPayloads(Good):
    def plan(self, view, memory, rng):
        [payload.decode() for payload in view.neighbours.payloads]
        return super().plan(view, memory, rng)


class CollidesOnPaper(Good):
    def plan(self, view, memory, rng):
        away = view.position - view.neighbours.position
        gap = np.sqrt((away**2).sum(axis=-1))
        with np.errstate(all="ignore"):
            unit = (away / gap[:, None]).sum(axis=0)
        limited = np.clip(unit * (1.0, 1.0, 0.0), -0.1, 0.1)
        return Goal(FlyVelocity(limited)), memory


class ListMemory(Good):
    def init(self, view):
        return [1, 2]


@dataclass(frozen=True, eq=False)
class Stamped:
    count: int

    def __post_init__(self):
        object.__setattr__(self, "born", id(self))


class HidesInMemory(Good):
    def init(self, view):
        return Stamped(0)

    def plan(self, view, memory, rng):
        return Goal(GoTo(self.middle), note=str(memory.born)), memory


class Chatty(Good):
    def plan(self, view, memory, rng):
        return replace(super().plan(view, memory, rng)[0], payload=bytes(5000)), memory


class Texts(Good):
    def plan(self, view, memory, rng):
        return replace(super().plan(view, memory, rng)[0], payload="hello"), memory


class TeamOfTen(Good):
    def plan(self, view, memory, rng):
        self.case.starts[9]
        return super().plan(view, memory, rng)


class SquareOnly(Good):
    def plan(self, view, memory, rng):
        view.belief[5, 5]
        return super().plan(view, memory, rng)


@dataclass(frozen=True)
class Undocumented:
    gain: float = 1.0


@dataclass(frozen=True)
class ListParameter:
    gains: tuple = param((1.0,), unit="1", doc="several")


BAD = [
    ("inputs_unchanged", WritesView, "changed its view"),
    ("inputs_unchanged", WritesReadOnlyView, "read-only"),
    ("inputs_unchanged", WritesMemory, "changed its memory"),
    ("repeatable", OwnRandomness, "generator given"),
    ("repeatable", HiddenHistory, "remembered"),
    ("inside_limits", TooFast, "speed 30.00 m/s"),
    ("inside_limits", TooSteep, "climb -9.00 m/s"),
    ("inside_limits", LeavesArea, "outside the area"),
    ("inside_limits", FliesOverTheEdge, "leaves the area"),
    ("inside_limits", TooHigh, "height 550.0 m"),
    ("inside_limits", Impatient, "speed 99.0 m/s"),
    ("inside_limits", NotANumber, "not three finite numbers"),
    ("inside_limits", NoHeading, "yaw nan"),
    ("inside_limits", OtherSetpoint, "setpoint is a str"),
    ("neighbour_order", FollowsFirstRow, "sort by id"),
    ("no_neighbours", NeedsCompany, "raised ValueError"),
    ("stale_neighbours", TrustsOldNews, "hour old"),
    ("stale_neighbours", ReadsPayloads, "raised UnicodeDecodeError"),
    ("stale_neighbours", CollidesOnPaper, "own place"),
    ("memory_survives", ListMemory, "cannot hold a list"),
    ("memory_survives", HidesInMemory, "restored from bytes"),
    ("small_payload", Chatty, "5000 bytes"),
    ("small_payload", Texts, "is a str"),
    ("any_team", TeamOfTen, "raised IndexError"),
    ("any_grid", SquareOnly, "raised IndexError"),
]


@pytest.mark.parametrize(("name", "planner", "words"), BAD)
def test_a_bad_planner_fails_its_check(name, planner, words):
    found = CHECKS[name](Trial(kind_of(planner)))
    assert found
    assert words in found[0]


@pytest.mark.parametrize("params", [Undocumented, ListParameter])
def test_parameters_must_be_documented_and_plain(params):
    assert CHECKS["documented"](Trial(kind_of(Good, params)))
    assert CHECKS["documented"](Trial(replace(kind_of(Good), summary="")))


def test_every_check_has_a_planner_that_fails_it():
    assert {name for name, *_ in BAD} | {"documented"} == set(CHECKS)
