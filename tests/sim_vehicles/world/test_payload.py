"""The payload sensor: when it reads, and how often it is right."""

import numpy as np
import pytest

from planners.grid import Grid
from sim_vehicles.world.payload import CellSensor, CellSensorSpec

GRID = Grid(0, 0, 100, 10, 10)


PLAIN = CellSensorSpec()


def sensor(spec=PLAIN, targets=((450, 550),), vehicles=1, seed=1):
    streams = [np.random.default_rng([seed, i]) for i in range(vehicles)]
    return CellSensor(GRID, np.array(targets, dtype=float), spec, streams)


def at(*points):
    return np.array([(x, y, 40.0) for x, y in points])


def test_one_reading_on_entering_a_cell_and_none_while_staying():
    payload = sensor()
    assert [s.cell for s in payload.look(0, at((50, 50)))] == [(0, 0)]
    assert payload.look(100_000, at((99, 99))) == []
    assert [s.cell for s in payload.look(200_000, at((101, 99)))] == [(1, 0)]
    assert [s.cell for s in payload.look(300_000, at((99, 99)))] == [(0, 0)]


def test_with_a_period_it_reads_again_while_staying():
    payload = sensor(CellSensorSpec(period_s=1.0))
    looks = [len(payload.look(t * 100_000, at((50, 50)))) for t in range(31)]
    assert sum(looks) == 4
    assert [t for t, n in enumerate(looks) if n] == [0, 10, 20, 30]


def test_nothing_is_seen_from_the_ground_or_outside():
    payload = sensor()
    assert payload.look(0, np.array([[50.0, 50.0, 1.0]])) == []
    assert payload.look(1, at((-1, 50))) == []
    assert payload.look(2, at((50, 1001))) == []
    assert len(payload.look(3, at((50, 50)))) == 1


def test_leaving_the_area_and_coming_back_to_the_same_cell_is_no_new_entry():
    payload = sensor()
    payload.look(0, at((5, 50)))
    payload.look(1, at((-5, 50)))
    assert payload.look(2, at((5, 50))) == []


@pytest.mark.parametrize(("target", "rate"), [(True, 0.9), (False, 0.05)])
def test_it_is_right_as_often_as_it_should(target, rate):
    payload = sensor(targets=((450, 550),) if target else ())
    hits = reads = 0
    for t in range(4000):
        seen = payload.look(t, at((450, 550) if t % 2 else (350, 550)))
        hits += sum(s.detected for s in seen if s.cell == (4, 5))
        reads += sum(s.cell == (4, 5) for s in seen)
    assert reads == 2000
    assert hits / reads == pytest.approx(rate, abs=4 * np.sqrt(rate * (1 - rate) / reads))


def test_readings_of_one_vehicle_do_not_depend_on_the_others():
    alone, both = sensor(vehicles=1), sensor(vehicles=2)
    path = [(450 + 100 * (t % 2), 550) for t in range(200)]
    mine = [alone.look(t, at(p)) for t, p in enumerate(path)]
    ours = [both.look(t, at(p, (50 + t, 50))) for t, p in enumerate(path)]
    assert [s for look in mine for s in look] == [
        s for look in ours for s in look if s.vehicle == 0
    ]
