from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.flocking.starling import behaviours, goals, space, spring
from planners.flocking.starling.behaviours import (
    DISPERSAL,
    ESCAPE,
    FREE,
    GATHERING,
    RETURN,
    Surroundings,
    behave,
)
from planners.flocking.starling.near import nearest, seen, unit
from planners.flocking.starling.rules import StarlingRules
from planners.terrain import Terrain

RULES = replace(StarlingRules(), explore=0.0)
PRINTED = replace(RULES, signs="printed")
AIM = np.array([5000.0, 0.0, 100.0])
NOBODY = np.zeros((0, 3))


def flock(seed, count, span=100.0):
    rng = np.random.default_rng(seed)
    position = rng.uniform(0.0, span, (count, 3)) + np.array((0.0, 0.0, 100.0))
    return position, rng.uniform(-10.0, 10.0, (count, 3)) + np.array((50.0, 0.0, 0.0))


def decided(position, velocity, rules=RULES, intruders=NOBODY, danger=False, alarm=False):
    count = len(position)
    near = nearest(position, velocity, seen(position, rules.perception_m), rules.neighbours)
    centre = np.broadcast_to(position.mean(axis=0), position.shape)
    flags = np.full(count, danger), np.full(count, alarm)
    around = Surroundings(AIM, centre, intruders, *flags)
    chance, noise = np.full(count, 0.5), np.zeros((count, 3))
    return behave(position, velocity, near, around, chance, noise, rules)


def pair(distance):
    """Two on the x axis with equal velocities."""
    position = np.array([[0.0, 0.0, 100.0], [distance, 0.0, 100.0]])
    return position, np.tile([50.0, 0.0, 0.0], (2, 1))


def test_the_seven_nearest_visible_ones_count():
    position = np.zeros((12, 3))
    position[:, 0] = np.arange(12) * 20.0
    near = nearest(position, position, seen(position, 260.0), 7)
    assert sorted(near.index[0].tolist()) == [1, 2, 3, 4, 5, 6, 7]
    far = nearest(position, position, seen(position, 45.0), 7)
    assert far.there[0].sum() == 2
    assert np.isinf(far.distance[0][2:]).all()


def test_a_ridge_hides_neighbours():
    heights = np.zeros((11, 11))
    heights[5] = 100.0
    ridge = Terrain(0.0, 0.0, 10.0, heights)
    position = np.array([[20.0, 50.0, 50.0], [80.0, 50.0, 50.0], [80.0, 60.0, 150.0]])
    visible = seen(position, 260.0, ridge)
    assert not visible[0, 1]
    assert visible[1, 2]
    assert (visible == visible.T).all()
    assert not visible.diagonal().any()


@pytest.mark.parametrize(
    ("distance", "mode"), [(20.0, DISPERSAL), (50.0, FREE), (69.0, FREE), (100.0, GATHERING)]
)
def test_the_behaviour_is_by_the_distance_to_the_centre(distance, mode):
    _, modes = decided(*pair(distance))
    assert (modes == mode).all()


def test_gathering_closes_and_dispersal_parts():
    wish, _ = decided(*pair(100.0))
    assert wish[0, 0] == pytest.approx(RULES.gather * 30.0)  # Eq. (4)
    assert wish[1, 0] == pytest.approx(-RULES.gather * 30.0)
    wish, _ = decided(*pair(20.0))
    assert wish[0, 0] == pytest.approx(-RULES.gather * 15.0)  # Eq. (5)


def test_who_is_far_from_the_flock_returns_before_anything_but_escape():
    position, velocity = flock(1, 9, 40.0)
    position[0] += (-400.0, 0.0, 0.0)
    wish, mode = decided(position, velocity)
    assert mode[0] == RETURN
    assert wish[0] @ (position.mean(axis=0) - position[0]) > 0.0
    _, danger = decided(position, velocity, replace(RULES, cluster_danger_m=900.0), danger=True)
    assert danger[0] != RETURN
    intruder = position[:1] + np.array((50.0, 0.0, 0.0))
    _, fleeing = decided(position, velocity, intruders=intruder)
    assert fleeing[0] == ESCAPE


def test_escape_is_away_and_as_printed_into_the_danger():
    position, velocity = flock(2, 5)
    intruders = np.array([[-2000.0, 0.0, 100.0], [160.0, 50.0, 150.0]])
    wish, mode = decided(position, velocity, intruders=intruders)
    towards = unit(intruders[1] - position)
    assert (mode == ESCAPE).all()
    assert np.allclose(wish, -RULES.escape * towards)
    into, _ = decided(position, velocity, PRINTED, intruders=intruders)
    assert (np.einsum("ij,ij->i", into, towards) > 0.0).all()


def test_an_intruder_out_of_perception_is_not_seen():
    position, velocity = flock(2, 5)
    _, mode = decided(position, velocity, intruders=np.array([[2000.0, 0.0, 100.0]]))
    assert (mode != ESCAPE).all()


def test_danger_widens_the_flock_and_alarm_spreads_it():
    assert (decided(*pair(100.0), danger=True)[1] == FREE).all()
    assert (decided(*pair(50.0), alarm=True)[1] == DISPERSAL).all()


def test_learning_takes_the_nearest_to_the_target_oftenest_and_the_best_learns_nothing():
    position = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [-10.0, 0.0, 0.0]])
    velocity = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    near = nearest(position, velocity, seen(position, 260.0), 7)
    aim = np.array([20.0, 0.0, 0.0])  # 10 m from the second, 30 m from the third
    chance = np.random.default_rng(0).uniform(size=4000)
    drawn = [
        behaviours.learning(position, velocity, near, aim, np.full(3, part), RULES)[0]
        for part in chance
    ]
    share = np.mean([wish[0] > 0.0 for wish in drawn])
    assert share == pytest.approx(0.75, abs=0.03)  # 1/10 of 1/10 + 1/30
    best = behaviours.learning(position, velocity, near, aim, np.full(3, 0.5), RULES)[1]
    assert (best == 0.0).all()
    printed = behaviours.learning(position, velocity, near, aim, np.full(3, 0.5), PRINTED)
    assert (printed == 0.0).all()  # shares of the order of 1e-3: nobody is drawn


@settings(max_examples=25)
@given(st.integers(0, 1000), st.integers(1, 12))
def test_names_do_not_matter(seed, count):
    position, velocity = flock(seed, count, 200.0)
    order = np.random.default_rng(seed).permutation(count)
    wish, mode = decided(position, velocity)
    other, others = decided(position[order], velocity[order])
    assert np.allclose(wish[order], other)
    assert (mode[order] == others).all()


@settings(max_examples=25)
@given(st.integers(0, 1000), st.floats(-3.0, 3.0))
def test_turned_about_the_vertical_it_decides_the_same(seed, angle):
    position, velocity = flock(seed, 6)
    cos, sin = np.cos(angle), np.sin(angle)
    spin = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    near = nearest(position, velocity, seen(position, 260.0), 7)
    turned = nearest(position @ spin.T, velocity @ spin.T, seen(position, 260.0), 7)
    for rule in (spring.half_spring, spring.dodge):
        wish = rule(velocity, near, RULES)
        assert np.allclose(wish @ spin.T, rule(velocity @ spin.T, turned, RULES))


def test_flocks_in_a_batch_are_those_alone():
    position, velocity = zip(*(flock(seed, 9) for seed in range(3)), strict=True)
    both = nearest(np.array(position), np.array(velocity), seen(np.array(position), 260.0), 7)
    for run in range(3):
        one = nearest(position[run], velocity[run], seen(position[run], 260.0), 7)
        assert np.allclose(one.mean(one.offset), both.mean(both.offset)[run])
        assert np.allclose(
            spring.half_spring(velocity[run], one, RULES),
            spring.half_spring(np.array(velocity), both, RULES)[run],
        )


@pytest.mark.parametrize(("distance", "sign"), [(20.0, -1), (45.0, 0), (80.0, 1)])
def test_the_half_spring_repels_holds_and_attracts(distance, sign):
    position, velocity = pair(distance)
    near = nearest(position, velocity, seen(position, 260.0), 7)
    wish = spring.half_spring(velocity, near, RULES)
    assert np.sign(wish[0, 0]) == sign
    assert np.allclose(wish[0], -wish[1])  # what one gains the other loses
    assert np.allclose(spring.half_spring(velocity, near, PRINTED), -wish)


def test_the_half_spring_matches_velocities():
    position, velocity = pair(45.0)
    velocity[1] += (0.0, 5.0, 0.0)
    near = nearest(position, velocity, seen(position, 260.0), 7)
    assert spring.half_spring(velocity, near, RULES)[0, 1] == pytest.approx(RULES.damp * 5.0)


def test_one_from_behind_is_dodged_and_one_that_leaves_is_not():
    position = np.array([[0.0, 0.0, 100.0], [60.0, 4.0, 100.0]])
    velocity = np.array([[90.0, 0.0, 0.0], [50.0, 0.0, 0.0]])
    near = nearest(position, velocity, seen(position, 260.0), 7)
    wish = spring.dodge(velocity, near, RULES)
    assert wish[0, 1] < -1.0
    assert wish[1, 1] > 1.0
    leaving = nearest(position, velocity[::-1], seen(position, 260.0), 7)
    assert (spring.dodge(velocity[::-1], leaving, RULES) == 0.0).all()


def test_head_on_both_turn_to_their_right():
    position = np.array([[0.0, 0.0, 100.0], [150.0, 0.0, 100.0]])
    velocity = np.array([[50.0, 0.0, 0.0], [-50.0, 0.0, 0.0]])
    near = nearest(position, velocity, seen(position, 260.0), 7)
    wish = spring.dodge(velocity, near, RULES)
    assert wish[0, 1] < 0.0 < wish[1, 1]


def test_a_message_goes_one_hop_an_update_and_keeps_its_age():
    count = 5
    chain = np.eye(count, k=1, dtype=bool) | np.eye(count, k=-1, dtype=bool)
    age = np.full(count, np.inf)
    first = np.arange(count) == 0
    age = space.heard(age, first, chain, 0.1)
    assert np.isfinite(age).tolist() == [True, False, False, False, False]
    for hop in range(1, count):
        age = space.heard(age, np.zeros(count, bool), chain, 0.1)
        assert np.isfinite(age).sum() == hop + 1
    assert np.allclose(age, 0.1 * (count - 1))  # the source's age, not the receiver's


def test_the_goals_of_equation_one():
    position = np.array([[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 40.0, 0.0]])
    same = np.tile([50.0, 0.0, 0.0], (3, 1))
    assert goals.polarisation(same) == pytest.approx(1.0)
    assert goals.speed_spread(same) == pytest.approx(0.0)
    assert goals.cohesion(position) == pytest.approx(40.0)
    assert goals.separation(position) == pytest.approx(30.0)
    assert goals.polarisation(np.array([[1.0, 0, 0], [-1.0, 0, 0]])) == pytest.approx(0.0)
    assert np.isinf(goals.separation(position[:1]))


def test_groups_are_chains_of_links():
    line = np.zeros((6, 3))
    line[:, 0] = (0.0, 50.0, 100.0, 300.0, 350.0, 1000.0)
    assert goals.groups(line, 60.0) == 3
    assert goals.groups(line[::-1], 60.0) == 3
    assert goals.groups(line, 2000.0) == 1
    assert goals.groups(line[[0, 3, 1, 4, 2, 5]], 60.0) == 3
