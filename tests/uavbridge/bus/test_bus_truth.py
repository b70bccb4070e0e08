import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavbridge.bus.local import LocalHub
from uavbridge.bus.messages import Truth, encode_truth
from uavbridge.bus.truth import TruthTrack


def track(*samples: tuple[int, float]) -> TruthTrack:
    truth = TruthTrack(memory=4)
    for t_us, x in samples:
        truth.add(t_us, (3, 7), [(0.0, 0.0, 0.0), (x, 0.0, 0.0)])
    return truth


def test_between_two_samples_it_interpolates_and_outside_it_knows_nothing() -> None:
    truth = track((100, 0.0), (200, 10.0))
    assert [truth.at(t, 7) for t in (100, 150, 200)] == [(x, 0.0, 0.0) for x in (0.0, 5.0, 10.0)]
    assert [truth.at(t, 7) for t in (99, 201)] == [None, None]
    assert truth.at(150, 8) is None
    assert truth.newest_us == 200


def test_empty_it_knows_nothing() -> None:
    truth = TruthTrack()
    assert (truth.newest_us, truth.at(0, 1), truth.ids) == (None, None, ())
    with pytest.raises(LookupError):
        truth.when(np.array([0]))


def test_many_times_at_once_are_as_one_by_one() -> None:
    truth = track((100, 0.0), (200, 10.0), (500, -20.0))
    times = np.array([500, 100, 90, 120, 200, 350, 600])
    positions, inside = truth.when(times)
    assert positions[:, 1, 0].tolist() == [-20.0, 0.0, 0.0, 2.0, 10.0, -5.0, -20.0]
    assert inside.tolist() == [True, True, False, True, True, True, False]
    assert np.all(positions[:, 0] == 0.0)


def test_memory_is_bounded_and_time_only_goes_on() -> None:
    truth = track(*((t, float(t)) for t in range(11)))
    truth.add(3, (3, 7), np.ones((2, 3)))
    assert [truth.at(t, 7) is None for t in (3, 7, 10)] == [True, False, False]
    truth.add(10, (3, 7), np.ones((2, 3)))
    assert truth.at(10, 7) == (1.0, 1.0, 1.0)
    assert truth.newest_us == 10


def test_other_vehicles_begin_a_new_memory() -> None:
    truth = track((0, 1.0))
    truth.add(100, (3,), [(5.0, 0.0, 0.0)])
    assert (truth.ids, truth.at(100, 3), truth.at(50, 3)) == ((3,), (5.0, 0.0, 0.0), None)
    assert truth.at(100, 7) is None


def test_it_follows_the_bus_and_counts_what_it_cannot_read() -> None:
    bus = LocalHub().bus()
    truth = TruthTrack(bus)
    bus.publish("world/truth", encode_truth(Truth(5, (1,), np.ones((1, 3)))))
    bus.publish("world/truth", b"nonsense")
    bus.publish("world/truth", encode_truth(Truth(90, (1,), np.zeros((1, 3)))))
    truth.poll(50)
    assert truth.at(5, 1) == (1.0, 1.0, 1.0)
    assert truth.newest_us == 5
    assert truth.rejects["future"] == 1
    assert truth.rejects.total() == 2


@given(st.lists(st.integers(0, 40), min_size=1, max_size=30), st.integers(-3, 45))
def test_two_at_one_time_are_as_all_at_many_times(stamps: list[int], t_us: int) -> None:
    track, rng = TruthTrack(memory=4), np.random.default_rng(len(stamps))
    for stamp in sorted(stamps):
        track.add(stamp, (3, 5, 8), rng.normal(0, 100, (3, 3)))
    positions, inside = track.when(np.array([t_us]))
    five, none, known = track.two(t_us, 5, 4)
    assert none is None
    assert known == bool(inside[0])
    assert list(five or ()) == positions[0, 1].tolist()
    assert list(track.two(t_us, 4, 8)[1] or ()) == positions[0, 2].tolist()
