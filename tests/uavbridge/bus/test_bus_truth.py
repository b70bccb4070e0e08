import numpy as np

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
    assert (truth.newest_us, truth.at(0, 1), truth.when(0), truth.nearest(0)) == (None,) * 4


def test_memory_is_bounded_and_time_only_goes_on() -> None:
    truth = track(*((t, float(t)) for t in range(10)))
    truth.add(3, (3, 7), np.ones((2, 3)))
    assert [truth.at(t, 7) is None for t in (5, 6, 9)] == [True, False, False]
    oldest, newest = truth.nearest(0), truth.nearest(99)
    assert oldest is not None
    assert newest is not None
    assert (oldest.t_us, newest.t_us) == (6, 9)
    truth.add(9, (3, 7), np.ones((2, 3)))
    assert truth.at(9, 7) == (1.0, 1.0, 1.0)


def test_when_vehicles_come_or_go_the_last_sample_holds() -> None:
    truth = track((0, 1.0))
    truth.add(100, (3,), [(5.0, 0.0, 0.0)])
    assert truth.at(50, 7) == (1.0, 0.0, 0.0)
    assert truth.at(50, 3) == (0.0, 0.0, 0.0)
    assert truth.at(100, 7) is None


def test_it_follows_the_bus_and_counts_what_it_cannot_read() -> None:
    bus = LocalHub().bus()
    truth = TruthTrack(bus)
    bus.publish("world/truth", encode_truth(Truth(5, (1,), np.ones((1, 3)))))
    bus.publish("world/truth", b"nonsense")
    truth.poll()
    assert truth.at(5, 1) == (1.0, 1.0, 1.0)
    assert truth.rejects.total() == 1
