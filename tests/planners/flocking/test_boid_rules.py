"""Reynolds' rules one by one."""

import numpy as np
import pytest

from planners.flocking import boids

HERE = np.zeros(2)
OTHERS = np.array([[60.0, 0.0], [0.0, 200.0], [500.0, 0.0]])
ALL = np.ones(3, bool)


def test_separation_leads_away_from_the_close_only():
    assert boids.separation(HERE, OTHERS, ALL, 120.0) == pytest.approx([-0.5, 0.0])


def test_cohesion_leads_to_the_centre_of_the_near():
    near = boids.within(HERE, OTHERS, ALL, 300.0)
    assert near.tolist() == [True, True, False]
    assert boids.cohesion(HERE, OTHERS, near, 300.0) == pytest.approx([0.1, 1 / 3])


def test_alignment_leads_to_the_mean_velocity():
    theirs = np.array([[10.0, 0.0], [0.0, 10.0], [99.0, 99.0]])
    near = np.array([True, True, False])
    assert boids.alignment(np.array([5.0, 0.0]), theirs, near, 10.0) == pytest.approx([0.0, 0.5])


def test_nobody_near_changes_nothing():
    nobody = np.zeros(3, bool)
    for rule in (boids.separation, boids.alignment, boids.cohesion):
        assert rule(HERE, OTHERS, nobody, 100.0).tolist() == [0.0, 0.0]
