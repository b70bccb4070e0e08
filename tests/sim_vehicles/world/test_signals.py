"""Receivers of target signals."""

from __future__ import annotations

from math import radians

import numpy as np
import numpy.typing as npt
import pytest

from planners.terrain import Terrain, mountains
from sim_vehicles.world.signals import ReceiverSpec, SignalHeard, SignalReceiver

TARGETS = np.array([[100.0, 100.0], [300.0, 100.0]])


def law(
    distance: npt.NDArray[np.float64], noise: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    return 1e4 / distance**2 + 0.0 * noise


def receiver(
    vehicles: int = 1,
    terrain: Terrain | None = None,
    *,
    period_s: float = 1.0,
    silent_when_found: bool = True,
) -> SignalReceiver:
    spec = ReceiverSpec(law, period_s=period_s, silent_when_found=silent_when_found)
    generators = [np.random.default_rng(number) for number in range(vehicles)]
    return SignalReceiver(TARGETS, terrain, spec, generators)


def test_strength_falls_with_the_distance_and_ends() -> None:
    heard = receiver(3).listen(0, np.array([[100.0, 150.0, 0.0], [200, 100, 0], [600, 100, 0]]))
    assert heard == [
        SignalHeard(0, 0, 4.0, False),
        SignalHeard(1, 0, 1.0, False),
        SignalHeard(1, 1, 1.0, False),
    ]


def test_signals_come_once_a_period() -> None:
    one, here = receiver(period_s=2.0), np.array([[100.0, 150.0, 0.0]])
    times = range(0, 5_000_000, 100_000)
    assert [t_us for t_us in times if one.listen(t_us, here)] == [0, 2_000_000, 4_000_000]


def test_one_above_has_arrived_too() -> None:
    (heard,) = receiver().listen(0, np.array([[104.0, 100.0, 30.0]]))
    assert heard.arrived
    assert heard.strength == pytest.approx(1e4 / (30**2 + 4**2))


@pytest.mark.parametrize("silent", [True, False])
def test_a_target_that_was_found_falls_silent(silent: bool) -> None:
    one = receiver(2, silent_when_found=silent)
    both = np.array([[100.0, 109.0, 0.0], [100.0, 150.0, 0.0]])
    assert [heard.vehicle for heard in one.listen(0, both)] == [0, 1]
    later = one.listen(1_000_000, both)
    assert [(heard.vehicle, heard.arrived) for heard in later][:1] == [(0, True)]
    assert len(later) == (1 if silent else 2)


def test_distances_on_mountains_are_those_in_space() -> None:
    hills = mountains(np.random.default_rng(3), (0.0, 0.0, 400.0, 400.0), radians(40))
    x, y = 100.0, 160.0
    place = np.array([[x, y, hills.height_at((x, y))]])
    target = np.array([100.0, 100.0, hills.height_at((100.0, 100.0))])
    (heard, *_) = receiver(terrain=hills).listen(0, place)
    assert heard.strength == pytest.approx(1e4 / ((place[0] - target) ** 2).sum())


def test_a_vehicle_draws_alike_whoever_else_flies() -> None:
    noisy = ReceiverSpec(lambda distance, noise: noise)
    here = np.array([[100.0, 150.0, 0.0], [100.0, 140.0, 0.0]])

    def strengths(rows: list[int]) -> list[float]:
        generators = [np.random.default_rng(row) for row in rows]
        one = SignalReceiver(TARGETS, None, noisy, generators)
        heard = [part for t_us in (0, 10**6) for part in one.listen(t_us, here[rows])]
        return [part.strength for part in heard if part.vehicle == len(rows) - 1]

    assert strengths([1]) == strengths([0, 1])
