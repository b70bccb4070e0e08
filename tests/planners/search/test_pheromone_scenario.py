"""Leader and followers go to the region, then all detect: point vehicles, one keeper of maps."""

import numpy as np
import pytest

from planners import registry
from planners.grid import Grid
from planners.pheromone.keeper import Keeper, KeeperLaw
from planners.pheromone.law import FieldLaw, SpreadLaw
from planners.pheromone.words import ASK, OBSTACLE, PATH, TARGET, Word, decode_query, encode_local
from planners.search.pheromone.scenario import PHEROMONE_SCENARIO, THERE, region_of
from planners.types import Answer, Neighbours, Scenario, View

GRID = Grid(-100.0, 50.0, 20.0, 20, 20)
TICK_S = 0.5
COLUMNS = np.array([[120.0, 300.0, 25.0], [200.0, 330.0, 20.0], [150.0, 400.0, 25.0]])
STARTS = np.array([[-60.0, 90.0], [-85.0, 70.0], [-60.0, 65.0], [-90.0, 100.0]])


class Flight:
    """The team flown as points that obey at once; who is heard, and what is told."""

    def __init__(self, values=None, silent=(), keeps=True):
        self.case = Scenario(
            GRID, (1, 2, 3, 4), np.concatenate((STARTS, np.full((4, 1), 40.0)), axis=1), TICK_S
        )
        self.planner = registry.bind(PHEROMONE_SCENARIO, self.case, values or {})
        west, south, east, north = region_of(self.case, self.planner.params.region)
        centre = ((west + east) // 2, (south + north) // 2)
        slow = FieldLaw(target=SpreadLaw(evaporation=0.05))
        self.keeper = Keeper(GRID.shape, KeeperLaw(slow, 200, sources=(centre,)))
        for _ in range(150):
            self.keeper.update()
        self.centre = GRID.centre_of(centre)
        self.targets = np.array(
            [(west + 2, south + 3), (east - 3, north - 2), (east - 4, south + 5)]
        )
        self.place, self.velocity = self.case.starts.copy(), np.zeros((4, 3))
        self.memory, self.answers = [None] * 4, [()] * 4
        self.payload = [b""] * 4
        self.silent, self.keeps = silent, keeps
        self.tracks, self.notes, self.visited = [], [], set()

    def fly(self, ticks):
        for tick in range(ticks):
            goals = [self._plan(agent, tick) for agent in range(4)]
            for agent, goal in enumerate(goals):
                self._tell(agent, goal, tick)
            self.keeper.update()
            self.answers = [self._told(goal) for goal in goals]
            for agent, goal in enumerate(goals):
                if agent not in self.silent or tick < 40:
                    self.velocity[agent] = goal.setpoint.velocity
                    self.payload[agent] = goal.payload
                else:
                    self.velocity[agent] = 0.0
            self.place += self.velocity * TICK_S
            self.tracks.append(self.place.copy())
            self.notes.append([goal.note for goal in goals])
        return np.array(self.tracks)

    def _plan(self, agent, tick):
        others = [
            i for i in range(4) if i != agent and not (i in self.silent and tick >= 40) and tick > 0
        ]
        heard = Neighbours(
            np.array(others, np.int64) + 1, self.place[others], self.velocity[others],
            np.full(len(others), 0.1), tuple(self.payload[i] for i in others),
        )  # fmt: skip
        belief = np.zeros(GRID.shape)
        near = np.hypot(*(GRID.centre_of(self.targets) - self.place[agent, :2]).T) < 80.0
        belief[tuple(self.targets[near].T)] = 1.0
        sight = np.hypot(*(COLUMNS[:, :2] - self.place[agent, :2]).T) < 120.0
        view = View(
            round(tick * TICK_S * 1e6), tick, agent + 1, self.place[agent].copy(),
            self.velocity[agent].copy(), 0.0, heard, belief, belief > 0.0,
            answers=self.answers[agent], obstacles=COLUMNS[sight],
        )  # fmt: skip
        if self.memory[agent] is None:
            self.memory[agent] = self.planner.init(view)
        rng = np.random.default_rng([agent, tick])
        goal, self.memory[agent] = self.planner.plan(view, self.memory[agent], rng)
        return goal

    def _tell(self, agent, goal, tick):
        cells = {edit.layer: edit.cells for edit in goal.edits}
        none = np.zeros((0, 2), np.int64)
        visits = cells.get(TARGET, none)
        self.visited |= {tuple(cell) for cell in visits.tolist()}
        path, seen = cells.get(PATH, none), cells.get(OBSTACLE, none)
        self.keeper.hear(agent, Word(tick, (0, 0), 0, path, seen, visits))

    def _told(self, goal):
        if not goal.asks or not self.keeps:
            return ()
        cell, radius = decode_query(goal.asks[0].data)
        return (Answer(ASK, encode_local(self.keeper.local(cell, radius)), 0.0),)


def apart(track, point):
    return np.hypot(*(track[..., :2] - point).transpose(-1, *range(track.ndim - 1)))


@pytest.mark.parametrize("keeps", [True, False])
def test_the_leader_brings_all_to_the_region_and_then_all_detect(keeps):
    flight = Flight(keeps=keeps)
    tracks = flight.fly(460)
    first = next(i for i, notes in enumerate(flight.notes) if notes[0].startswith("detects"))
    assert first < 260
    assert apart(tracks[first], flight.centre).max() < 250.0
    assert all(note.startswith("detects") for note in flight.notes[-1])
    assert flight.payload == [THERE] * 4
    assert flight.visited == {tuple(cell) for cell in flight.targets.tolist()}
    leading = apart(tracks[20:first], COLUMNS[0, :2])[:, 0]
    assert leading.min() > COLUMNS[0, 2]
    pairs = tracks[30:first, 1:, None] - tracks[30:first, None, 1:]
    distance = np.hypot(pairs[..., 0], pairs[..., 1]) + np.where(np.eye(3), 1e9, 0.0)
    assert np.median(distance.min(axis=(1, 2))) > 10.0
    west, south, _, _ = region_of(flight.case, 0.5)
    corner = GRID.centre_of((west, south)) - 10.0
    assert (tracks[-100:, :, :2] > corner - 1.0).all(), "detection stays in the region"


def test_the_next_one_leads_when_the_leader_is_silent():
    flight = Flight(silent=(0,))
    flight.fly(300)
    assert flight.notes[30][1] == "follows 1"
    assert any(notes[1] == "leads" for notes in flight.notes)
    assert flight.notes[-1][1].startswith("detects")


def test_the_printed_form_does_not_keep_followers_apart():
    flight = Flight({"form": "printed"})
    tracks = flight.fly(120)
    assert np.isfinite(tracks).all()
