"""The planner flies what the kernels decide, step by step; limits, silence, columns."""

import numpy as np
import pytest

from planners import registry
from planners.grid import Grid
from planners.pheromone.detect import DetectRule
from planners.pheromone.keeper import Box, Keeper, KeeperLaw, reaches
from planners.pheromone.words import (
    ASK,
    OBSTACLE,
    PATH,
    TARGET,
    Word,
    decode_local,
    decode_query,
    decode_word,
    encode_local,
    encode_word,
)
from planners.search.pheromone.detection import PHEROMONE
from planners.types import Answer, FlyVelocity, GoTo, Neighbours, Scenario, View
from uavbridge.experiments.shao import ground, world

SIZE, CELL_M = 18, 20.0
GRID = Grid(0.0, 0.0, CELL_M, SIZE, SIZE)


def word_of(goal, number):
    """What an agent makes of a planner's goal for whoever keeps the maps."""
    cells = {edit.layer: edit.cells for edit in goal.edits}
    none = np.zeros((0, 2), np.int64)
    return Word(
        number, (0, 0), 0, cells.get(PATH, none), cells.get(OBSTACLE, none), cells.get(TARGET, none)
    )  # fmt: skip


class Fixed:
    """A generator that gives the numbers it was given."""

    def __init__(self, numbers):
        self.numbers = numbers

    def random(self, count):
        assert count == len(self.numbers)
        return self.numbers


def views(made, cells, tick, answers, targets_seen):
    columns = np.argwhere(made.obstacles[0])
    belief = np.zeros(GRID.shape)
    for column, row in targets_seen:
        belief[column, row] = 1.0
    for agent, cell in enumerate(cells):
        near = np.hypot(*(columns - cell).T) <= 4.0
        sight = np.concatenate((GRID.centre_of(columns[near]), np.ones((near.sum(), 1))), axis=1)
        yield View(
            tick * 10**6, tick, agent, np.array([*GRID.centre_of(cell), 40.0]), np.zeros(3),
            float(made.headings[0, agent]) * np.pi / 4.0, Neighbours.none(), belief, belief > 0.0,
            answers=answers.get(agent, ()), obstacles=sight,
        )  # fmt: skip


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_planner_steps_as_the_kernels_do(seed):
    n, steps, period = 3, 120, 30
    rule = DetectRule(random_share=0.25)
    generators = [np.random.default_rng([seed, 7])]
    made = ground.draw(generators, SIZE, 4, n, 0.12, "anywhere")
    course = world.simulate(made, generators, world.World(period=period, rule=rule), steps)
    draws = world.Draws([np.random.default_rng([seed, 7])], n)
    ground.draw(draws._generators, SIZE, 4, n, 0.12, "anywhere")  # the same numbers before
    case = Scenario(GRID, tuple(range(n)), np.full((n, 3), 40.0), 1.0)
    values = {"random_share": 0.25, "clearance_m": 5.0, "capture": 0.05}
    planner = registry.bind(PHEROMONE, case, values)
    keeper = Keeper(GRID.shape, KeeperLaw(period=period))
    memories, answers, found = {}, {}, 0
    state = next(course)
    cells = state.cells[0].copy()
    targets = [tuple(cell) for cell in made.targets[0].tolist()]
    for tick in range(steps):
        numbers = draws.next()[0]
        goals = {}
        for agent, view in enumerate(views(made, cells, tick, answers, targets)):
            memory = memories.get(agent) or planner.init(view)
            goals[agent], memories[agent] = planner.plan(view, memory, Fixed(numbers[agent]))
            keeper.hear(agent, word_of(goals[agent], tick))
        keeper.update()
        answers = {}
        for agent, goal in goals.items():
            cell, radius = decode_query(goal.asks[0].data)
            told = encode_local(keeper.local(cell, radius))
            answers[agent] = (Answer(ASK, told, 0.0),)
        cells = np.array([memories[agent].cell for agent in range(n)])
        state = next(course)
        assert cells.tolist() == state.cells[0].tolist(), tick
        assert [memories[agent].heading for agent in range(n)] == state.heading[0].tolist()
        np.testing.assert_allclose(keeper.field.target, state.field.target[0], atol=1e-12)
        np.testing.assert_allclose(keeper.field.obstacle, state.field.obstacle[0], atol=1e-12)
        np.testing.assert_allclose(keeper.field.path, state.field.path[0], atol=1e-12)
        found = int((state.found_at >= 0).sum())
    assert found >= 2
    assert state.answered


def test_cells_are_passed_without_a_stop_and_columns_avoided():
    case = Scenario(GRID, (1,), np.array([[30.0, 30.0, 40.0]]), 0.5)
    planner = registry.bind(PHEROMONE, case, {"speed_m_s": 8.0})
    position, memory, speeds, nearest = case.starts[0].copy(), None, [], np.inf
    columns = np.array([[150.0, 150.0, 25.0], [230.0, 90.0, 30.0], [90.0, 250.0, 15.0]])
    belief = np.zeros(GRID.shape)
    velocity = np.zeros(3)
    for tick in range(600):
        sight = columns[np.hypot(*(columns[:, :2] - position[:2]).T) < 80.0 + columns[:, 2]]
        view = View(
            tick * 500_000, tick, 1, position, velocity, 0.0, Neighbours.none(), belief,
            belief > 0.0, obstacles=sight,
        )  # fmt: skip
        memory = memory or planner.init(view)
        goal, memory = planner.plan(view, memory, np.random.default_rng([3, tick]))
        assert isinstance(goal.setpoint, FlyVelocity)
        velocity = goal.setpoint.velocity
        speeds.append(np.hypot(*velocity[:2]))
        position = position + velocity * 0.5
        apart = np.hypot(*(columns[:, :2] - position[:2]).T) - columns[:, 2]
        nearest = min(nearest, apart.min())
        assert GRID.contains(position)
    assert min(speeds) > 7.9
    assert nearest > 0.0


@pytest.mark.parametrize(("likely", "visited"), [(0.8, False), (0.99, True)])
def test_a_likely_target_is_gone_to_and_counts_as_visited_once_it_is_sure(likely, visited):
    case = Scenario(GRID, (1,), np.array([[50.0, 50.0, 40.0]]), 1.0)
    planner = registry.bind(PHEROMONE, case, {"random_share": 1.0})
    belief = np.full(GRID.shape, 0.05)
    belief[4, 4] = likely  # two diagonal steps away
    memory, told, position = None, [], case.starts[0]
    for tick in range(2):
        view = View(
            tick * 1_000_000, tick, 1, position, np.zeros(3), 0.0, Neighbours.none(), belief,
            belief > 0.5,
        )  # fmt: skip
        memory = memory or planner.init(view)
        goal, memory = planner.plan(view, memory, np.random.default_rng(tick))
        told += [edit.layer for edit in goal.edits]
        position = np.array([*GRID.centre_of(memory.cell), 40.0])
    assert memory.cell == (4, 4)
    assert (TARGET in told) == visited


def test_a_uav_walled_in_stays():
    case = Scenario(GRID, (1,), np.array([[50.0, 50.0, 40.0]]), 1.0)
    planner = registry.bind(PHEROMONE, case, {})
    ring = [(c, r) for c in (1, 2, 3) for r in (1, 2, 3) if (c, r) != (2, 2)]
    columns = np.array([[*GRID.centre_of(cell), 2.0] for cell in ring])
    nothing = np.zeros(GRID.shape)
    view = View(
        0, 0, 1, case.starts[0], np.zeros(3), 0.0, Neighbours.none(), nothing, nothing > 0,
        obstacles=columns,
    )  # fmt: skip
    goal, _ = planner.plan(view, planner.init(view), np.random.default_rng(0))
    assert isinstance(goal.setpoint, GoTo)
    assert goal.note == "walled in"


def test_words_and_answers_survive_the_wire_and_nonsense_does_not():
    draw = np.random.default_rng(5)
    cells = draw.integers(0, 18, (3, 2))
    word = decode_word(encode_word(Word(9, (3, 4), 4, cells[:1], cells, cells[:0])))
    assert (word.number, word.cell, word.radius) == (9, (3, 4), 4)
    assert word.obstacles.tolist() == cells.tolist()
    keeper = Keeper(GRID.shape, KeeperLaw(), Box(0, 0, 9, 9))
    keeper.hear(1, Word(0, (0, 0), 0, cells[:1], np.array([[3, 5]]), np.array([[4, 4]])))
    keeper.update()
    local = keeper.local((7, 4), 4)
    back = decode_local(encode_local(local))
    for name in ("target", "obstacle", "path"):
        np.testing.assert_array_equal(
            getattr(back, name)[back.known], getattr(local, name)[local.known]
        )
    assert back.closed.tolist() == local.closed.tolist()
    assert (back.marks.tolist(), back.due.tolist()) == ([[4, 4]], [False])
    assert not back.known.all()
    for data in (b"", b"L", b"W123", encode_word(word)[:-1], encode_local(local) + b"x"):
        assert decode_word(data) is None or decode_local(data) is None
        assert decode_local(data) is None


def test_a_word_that_comes_twice_counts_once():
    word = Word(4, (5, 5), 0, np.array([[5, 5]]), np.zeros((0, 2), int), np.zeros((0, 2), int))
    once, twice = (Keeper((12, 12), KeeperLaw()) for _ in range(2))
    for keeper, times in ((once, 1), (twice, 3)):
        assert [keeper.hear(2, word) for _ in range(times)] == [True] + [False] * (times - 1)
        keeper.update()
    np.testing.assert_array_equal(once.field.path, twice.field.path)


def test_tiles_together_are_the_one_map():
    law = KeeperLaw(period=20)
    boxes = [Box(0, 0, 9, 8), Box(9, 0, 18, 8), Box(0, 8, 9, 18), Box(9, 8, 18, 18)]
    whole = Keeper(GRID.shape, law)
    tiles = [Keeper(GRID.shape, law, box) for box in boxes]
    draw = np.random.default_rng(8)
    for number in range(60):
        for uav in range(4):
            place = draw.integers(0, 18, (1, 2))
            stones = draw.integers(0, 18, (int(draw.random() < 0.1), 2))
            seen = draw.integers(0, 18, (int(draw.random() < 0.2), 2))
            word = Word(number, (0, 0), 0, place, stones, seen)
            whole.hear(uav, word)
            for tile in tiles:
                if reaches(word, tile.tile, law, GRID.shape):
                    tile.hear(uav, word)
        for keeper in (whole, *tiles):
            keeper.update()
        for one in tiles:
            for other in tiles:
                if one is not other:
                    patch = one.margin_of(other.tile)
                    assert other.take(patch)
    for tile in tiles:
        own = tile.tile.slices
        for (_, all_of_it), (_, part) in zip(whole.layers(), tile.layers(), strict=True):
            np.testing.assert_allclose(part[own], all_of_it[own], rtol=1e-9, atol=1e-15)
        local, expected = tile.local((8, 9), 4), whole.local((8, 9), 4)
        np.testing.assert_allclose(local.path[local.known], expected.path[local.known])
